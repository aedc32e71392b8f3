// Each group of cells' part of each reading's evidence on its arc; twin of src/kernels/cpu/walk.rs (weigh).
//
// A kernel of its own because the update needs the whole sum. The threads of a tile never meet: each stores what four
// cells come to, and sum.wgsl adds them up in one order.

@group(0) @binding(5) var<storage, read_write> parts: array<f32>;

@compute @workgroup_size(THREADS)
fn weigh(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    let at = tile.slot * PLANES * 64u + lane;
    // each GROUP
    let cell_GROUP = cell_of(tile, lane + GROUP * THREADS);
    var cells_GROUP = load(at + GROUP * THREADS + 128u);
    // end
    for (var k = tile.entries.x; k < tile.entries.y; k++) {
        let entry = entries[k];
        let cone = cones[entry.cone >> ENTRY_SHIFT];
        // each GROUP
        var row_GROUP = look(cone, cell_GROUP);
        var part_GROUP = vec4<f32>(0.0);
        if any(row_GROUP.interior | row_GROUP.arc) {
            part_GROUP = weigh_cells(cone, row_GROUP, &cells_GROUP);
        }
        if (entry.cone & ARC) != 0u {
            parts[entry.slot * 64u + lane + GROUP * THREADS] = (part_GROUP.x + part_GROUP.y) + (part_GROUP.z + part_GROUP.w);
        }
        // end
    }
}
