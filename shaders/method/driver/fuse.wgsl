// Updates a tile's cells with its list of readings, in log order; twin of src/method/driver/walk.rs (fuse).
//
// A workgroup handles one tile. Its threads hold their cells' state in registers, so the map is read once and written once a batch.
// Bounds: groups are the chunk's listed tiles, entries those of the tile's list.

// Applies a reading to four cells.
fn update_cells(
    cone: Cone,
    row: Row,
    share: vec4<u32>,
    counts: ptr<function, array<vec4<u32>, 2>>,
    cells: ptr<function, CellStates>,
) {
    if any(row.interior | row.arc) {
        (*counts)[0] += vec4<u32>(row.interior);
        (*counts)[1] += vec4<u32>(row.arc);
        fuse_cells(cone, row, share, cells);
    }
}

@compute @workgroup_size(THREADS)
fn fuse(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    if tile.entries.x == tile.entries.y {
        return;
    }
    let at = tile.slot * PLANES * 64u + lane;
    let one = select(0u, 1u, (frame.mode & COUNT) != 0u);
    // each GROUP
    let cell_GROUP = cell_of(tile, lane + GROUP * THREADS);
    var counts_GROUP = array<vec4<u32>, 2>(vec4<u32>(0u), vec4<u32>(0u));
    var cells_GROUP = load(at + GROUP * THREADS + 128u);
    // end
    var first = tile.entries.x;
    while first < tile.entries.y {
        let end = stage(first, tile.entries.y, lane);
        for (var k = first; k < end; k++) {
            let entry = entry_at(k, first);
            let cone = cone_at(k, first);
            let share = share_at(k, first, cone);
            if SPECIALIZE_TILES && (entry.cone & INSIDE) != 0u {
                // each GROUP
                update_cells(cone, look_inside(cone, cell_GROUP), share, &counts_GROUP, &cells_GROUP);
                // end
            } else if SPECIALIZE_TILES && (entry.cone & ARC) == 0u {
                // each GROUP
                update_cells(cone, look_before(cone, cell_GROUP), share, &counts_GROUP, &cells_GROUP);
                // end
            } else {
                // each GROUP
                update_cells(cone, look(cone, cell_GROUP), share, &counts_GROUP, &cells_GROUP);
                // end
            }
        }
        first = end;
        // each GROUP
        renormalize(&cells_GROUP);
        // end
    }
    // each GROUP
    state[at + GROUP * THREADS] += one * counts_GROUP[0];
    state[at + GROUP * THREADS + 64u] += one * counts_GROUP[1];
    store(cells_GROUP, at + GROUP * THREADS + 128u);
    // end
}
