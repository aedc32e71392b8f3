// Updates a tile's cells with its list of readings, in log order; twin of src/kernels/cpu/walk.rs (fuse).
//
// A workgroup is a tile; its threads hold their cells' state in registers, so the map is read once and written once a batch.
// Bounds: groups are the chunk's listed tiles, entries those of the tile's list.

@compute @workgroup_size(THREADS)
fn fuse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    let at = tile.slot * PLANES * 64u + lane;
    let one = select(0u, 1u, (frame.mode & COUNT) != 0u);
    // each GROUP
    let cell_GROUP = cell_of(tile, lane + GROUP * THREADS);
    var interior_GROUP = vec4<u32>(0u);
    var arc_GROUP = vec4<u32>(0u);
    var cells_GROUP = load(at + GROUP * THREADS + 128u);
    // end
    for (var k = tile.entries.x; k < tile.entries.y; k++) {
        let entry = entries[k];
        let cone = cones[entry.cone >> ENTRY_SHIFT];
        let share = shares[cone.index];
        // each GROUP
        var row_GROUP = look(cone, cell_GROUP);
        if any(row_GROUP.interior | row_GROUP.arc) {
            interior_GROUP += select(vec4<u32>(0u), vec4<u32>(one), row_GROUP.interior);
            arc_GROUP += select(vec4<u32>(0u), vec4<u32>(one), row_GROUP.arc);
            fuse_cells(cone, row_GROUP, share, &cells_GROUP);
        }
        // end
        if (k - tile.entries.x) % 16u == 15u {
            // each GROUP
            settle(&cells_GROUP);
            // end
        }
    }
    // each GROUP
    state[at + GROUP * THREADS] += interior_GROUP;
    state[at + GROUP * THREADS + 64u] += arc_GROUP;
    settle(&cells_GROUP);
    store(cells_GROUP, at + GROUP * THREADS + 128u);
    // end
}
