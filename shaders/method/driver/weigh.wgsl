// Sums each tile's part of each reading's evidence on its arc; twin of src/method/driver/walk.rs (weigh).
//
// It is a separate kernel, because the update needs the whole sum. The evidence of the groups of four cells is added in one fixed order,
// down the tile's four columns of groups, then across: here where a stage is in workgroup memory, else in sum.wgsl, since barriers cost
// a software adapter more than memory does. sum.wgsl adds the tiles.

@group(0) @binding(5) var<storage, read_write> parts: array<f32>;

// The evidence of the tile's 64 groups for each entry of a stage. It is kept as single numbers, since threads that write components
// of one vector race. The stride is 65, so that entries begin in different banks.
const STRIDE: u32 = 65u;
var<workgroup> held: array<f32, STAGE * STRIDE>;

// A row of the tile's groups.
fn groups_of(at: u32) -> vec4<f32> {
    return vec4<f32>(held[at], held[at + 1u], held[at + 2u], held[at + 3u]);
}

fn part_of_tile(at: u32) -> f32 {
    let columns = groups_of(at) + groups_of(at + 4u) + groups_of(at + 8u) + groups_of(at + 12u) + groups_of(at + 16u)
        + groups_of(at + 20u) + groups_of(at + 24u) + groups_of(at + 28u) + groups_of(at + 32u) + groups_of(at + 36u)
        + groups_of(at + 40u) + groups_of(at + 44u) + groups_of(at + 48u) + groups_of(at + 52u) + groups_of(at + 56u)
        + groups_of(at + 60u);
    return (columns.x + columns.y) + (columns.z + columns.w);
}

// The evidence of a group of four cells.
fn part_of_group(cone: Cone, row: Row, cells: ptr<function, CellStates>) -> f32 {
    if any(row.interior | row.arc) {
        let part = weigh_cells(cone, row, cells);
        return (part.x + part.y) + (part.z + part.w);
    }
    return 0.0;
}

@compute @workgroup_size(THREADS)
fn weigh(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    if tile.entries.x == tile.entries.y {
        return;
    }
    let at = tile.slot * PLANES * 64u + lane;
    // each GROUP
    let cell_GROUP = cell_of(tile, lane + GROUP * THREADS);
    var cells_GROUP = load(at + GROUP * THREADS + 128u);
    // end
    var first = tile.entries.x;
    while first < tile.entries.y {
        let end = stage(first, tile.entries.y, lane);
        for (var k = first; k < end; k++) {
            let entry = entry_at(k, first);
            let cone = cone_at(k, first);
            let base = (k - first) * STRIDE + lane;
            if SPECIALIZE_TILES && (entry.cone & INSIDE) != 0u {
                // each GROUP
                _ = part_of_group(cone, look_inside(cone, cell_GROUP), &cells_GROUP);
                // end
            } else if SPECIALIZE_TILES && (entry.cone & ARC) == 0u {
                // each GROUP
                _ = part_of_group(cone, look_before(cone, cell_GROUP), &cells_GROUP);
                // end
            } else {
                // each GROUP
                let part_GROUP = part_of_group(cone, look(cone, cell_GROUP), &cells_GROUP);
                if STAGED {
                    held[base + GROUP * THREADS] = part_GROUP;
                } else if (entry.cone & ARC) != 0u {
                    parts[entry.slot * 64u + lane + GROUP * THREADS] = part_GROUP;
                }
                // end
            }
        }
        if STAGED {
            workgroupBarrier();
            for (var k = first + lane; k < end; k += THREADS) {
                let entry = entry_at(k, first);
                if (entry.cone & ARC) != 0u {
                    parts[entry.slot] = part_of_tile((k - first) * STRIDE);
                }
            }
            // All threads wait here before the next stage's evidence overwrites this one's.
            workgroupBarrier();
        }
        first = end;
    }
}
