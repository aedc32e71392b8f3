// A stage: the next sixteen entries of a tile's list with their cones and shares; twin of src/method/driver/reach.rs (Lookahead).

// Whether a workgroup keeps a stage in workgroup memory. This is faster on hardware; a software adapter has no such memory.
override STAGED: bool = false;

const STAGE: u32 = 16u;

var<workgroup> staged_entries: array<Entry, STAGE>;
var<workgroup> staged_cones: array<Cone, STAGE>;
var<workgroup> staged_shares: array<vec4<u32>, STAGE>;

// Begins the stage of the entry `first` and returns its end, at most `last`. All threads of a workgroup call this together.
fn stage(first: u32, last: u32, lane: u32) -> u32 {
    let end = min(first + STAGE, last);
    if STAGED {
        workgroupBarrier();
        for (var k = first + lane; k < end; k += THREADS) {
            let entry = entries[k];
            let cone = cones[entry.cone >> ENTRY_SHIFT];
            staged_entries[k - first] = entry;
            staged_cones[k - first] = cone;
            staged_shares[k - first] = shares[cone.index];
        }
        workgroupBarrier();
    }
    return end;
}

// The entry k of the stage that began with `first`.
fn entry_at(k: u32, first: u32) -> Entry {
    if STAGED {
        return staged_entries[k - first];
    }
    return entries[k];
}

// The cone of that entry.
fn cone_at(k: u32, first: u32) -> Cone {
    if STAGED {
        return staged_cones[k - first];
    }
    return cones[entries[k].cone >> ENTRY_SHIFT];
}

// The share of that cone, which the previous pass found.
fn share_at(k: u32, first: u32, cone: Cone) -> vec4<u32> {
    if STAGED {
        return staged_shares[k - first];
    }
    return shares[cone.index];
}
