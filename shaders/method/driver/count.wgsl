// Counts the arc cells of each reading; twin of src/method/driver/walk.rs (count).
//
// It is a separate kernel, because the update needs the whole count. Integer atomics give the same sum in any order.

@group(0) @binding(5) var<storage, read_write> parts: array<atomic<u32>>;

@compute @workgroup_size(THREADS)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    var k = tile.entries.x;
    while k < tile.entries.y {
        // A loop rather than a condition: adapters that execute both sides of a branch skip the other entries this way.
        while k < tile.entries.y && (entries[k].cone & ARC) == 0u {
            k += 1u;
        }
        if k < tile.entries.y {
            let cone = cones[entries[k].cone >> ENTRY_SHIFT];
            var cells = 0u;
            // each GROUP
            let row_GROUP = look_at_all(cone, cell_of(tile, lane + GROUP * THREADS));
            cells += dot(select(vec4<u32>(0u), vec4<u32>(1u), row_GROUP.arc), vec4<u32>(1u));
            // end
            if cells > 0u {
                atomicAdd(&parts[cone.index], cells);
            }
        }
        k += 1u;
    }
}
