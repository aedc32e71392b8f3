// A chunk's lists from those of its blocks; twin of src/binning/batch.rs.
//
// How long each tile's list is, where it begins, then the entries, in log order.

@group(0) @binding(0) var<uniform> lists: Lists;
@group(0) @binding(1) var<storage, read> near: array<Near>;
@group(0) @binding(2) var<storage, read> blocks: array<u32>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read> cones: array<Cone>;
@group(0) @binding(5) var<storage, read_write> tiles: array<Tile>;
@group(0) @binding(6) var<storage, read_write> entries: array<Entry>;

// The block that a tile of the chunk lies in.
fn block_of(at: vec2<u32>) -> u32 {
    return at.y / BLOCK * BLOCKS + at.x / BLOCK;
}

// What a box's cone comes to in a tile of the chunk.
fn flags_of(box: Near, at: vec2<u32>) -> u32 {
    if any(at < box.low) || any(at >= box.high) {
        return 0u;
    }
    let cone = cones[box.cone];
    let corner = TILE * (lists.chunk + at);
    var flags = meets(cone, corner);
    if any(corner + TILE > lists.size) {
        flags &= ~INSIDE;
    }
    if (cone.flags & NO_ECHO) != 0u && (lists.how & ARCS) == 0u {
        flags &= ~ARC;
    }
    return flags;
}

var<workgroup> listed: atomic<u32>;

// A workgroup a tile.
@compute @workgroup_size(WORKERS)
fn measure(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = group.x;
    let at = vec2<u32>(slot % CHUNK, slot / CHUNK);
    if lane == 0u {
        atomicStore(&listed, 0u);
    }
    workgroupBarrier();
    var count = 0u;
    for (var segment = 0u; segment < lists.segments; segment++) {
        let block = segment * BLOCKS * BLOCKS + block_of(at);
        for (var k = lane; k < counts[block]; k += WORKERS) {
            count += select(0u, 1u, flags_of(near[blocks[block * SEGMENT + k]], at) != 0u);
        }
    }
    atomicAdd(&listed, count);
    workgroupBarrier();
    if lane == 0u {
        tiles[slot] = Tile(TILE * (lists.chunk + at), vec2<u32>(0u, atomicLoad(&listed)), slot, array<u32, 3>());
    }
}

const SHARE: u32 = CHUNK * CHUNK / 256u;

var<workgroup> sums: array<u32, 256>;

// One workgroup for all tiles; each thread has as many.
@compute @workgroup_size(256)
fn place(@builtin(local_invocation_index) lane: u32) {
    var own = 0u;
    for (var k = 0u; k < SHARE; k++) {
        own += tiles[lane * SHARE + k].entries.y;
    }
    // Sums of all threads up to each (Hillis & Steele 1986).
    var sum = own;
    for (var step = 1u; step < 256u; step *= 2u) {
        sums[lane] = sum;
        workgroupBarrier();
        if lane >= step {
            sum += sums[lane - step];
        }
        workgroupBarrier();
    }
    var begin_at = sum - own;
    for (var k = 0u; k < SHARE; k++) {
        let count = tiles[lane * SHARE + k].entries.y;
        tiles[lane * SHARE + k].entries = vec2<u32>(begin_at, begin_at + count);
        begin_at += count;
    }
}

// A workgroup a tile, a thread a cone of WORKERS at a time.
@compute @workgroup_size(WORKERS)
fn list(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = group.x;
    let at = vec2<u32>(slot % CHUNK, slot / CHUNK);
    var to = tiles[slot].entries.x;
    begin(lane);
    var turn = 0u;
    for (var segment = 0u; segment < lists.segments; segment++) {
        let block = segment * BLOCKS * BLOCKS + block_of(at);
        let count = counts[block];
        for (var k = 0u; k < count; k += WORKERS) {
            var box: Near;
            var flags = 0u;
            if k + lane < count {
                box = near[blocks[block * SEGMENT + k + lane]];
                flags = flags_of(box, at);
            }
            let place = rank(lane, turn, flags != 0u);
            turn += 1u;
            if flags != 0u {
                let inside = at - box.low;
                let part = box.part + inside.y * (box.high.x - box.low.x) + inside.x;
                entries[to + place.x] = Entry((box.cone << ENTRY_SHIFT) | (flags & (ARC | INSIDE)), part);
            }
            to += place.y;
        }
    }
}
