// Applies a tile's list of the feature stage's updates, in log order; twin of src/method/driver/update.rs.
//
// It is a separate kernel, because an update has shapes besides its cone. A workgroup is a tile; its threads hold their cells' state in
// registers. Bounds: groups are the chunk's listed tiles, entries those of the tile's list, points those of an update's shapes.

@compute @workgroup_size(THREADS)
fn fuse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    let at = tile.slot * PLANES * 64u + lane;
    let none = vec4<u32>(0u);
    let one = vec4<u32>(select(0u, 1u, (frame.mode & COUNT) != 0u));
    // The occupied bits of all three sources.
    let occupies = vec4<u32>(21u * OCCUPIED);
    // each GROUP
    let cell_GROUP = cell_of(tile, lane + GROUP * THREADS);
    var interior_GROUP = vec4<u32>(0u);
    var arc_GROUP = vec4<u32>(0u);
    var marks_GROUP = vec4<u32>(0u);
    var cells_GROUP = load(at + GROUP * THREADS + 128u);
    // end
    for (var k = tile.entries.x; k < tile.entries.y; k++) {
        let entry = entries[k];
        let cone = cones[entry.cone >> ENTRY_SHIFT];
        let update = shapes[entry.cone >> ENTRY_SHIFT];
        // each GROUP
        let contributions_GROUP = look_at(cone, update, entry.slot, cell_GROUP);
        let member_GROUP = contributions_GROUP.code != none;
        if any(member_GROUP) {
            let on_arc_GROUP = (contributions_GROUP.code & occupies) != none;
            interior_GROUP += select(none, one, member_GROUP & !on_arc_GROUP);
            arc_GROUP += select(none, one, on_arc_GROUP);
            marks_GROUP += select(none, mark(update.number, contributions_GROUP.code), member_GROUP);
            fuse_cells(cone, update.weights, contributions_GROUP.row, contributions_GROUP.code, &cells_GROUP);
        }
        // end
        if (k - tile.entries.x) % 16u == 15u {
            // each GROUP
            renormalize(&cells_GROUP);
            // end
        }
    }
    // each GROUP
    state[at + GROUP * THREADS] += interior_GROUP;
    state[at + GROUP * THREADS + 64u] += arc_GROUP;
    state[at + GROUP * THREADS + 320u] += marks_GROUP;
    renormalize(&cells_GROUP);
    store(cells_GROUP, at + GROUP * THREADS + 128u);
    // end
}
