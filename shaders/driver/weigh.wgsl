// Sums each reading's evidence on the tile's part of its arc; twin of src/kernels/cpu/walk.rs (weigh).
//
// A kernel of its own because the update needs the whole sum. Evidence is held for eight readings before the tile's threads
// meet: down the columns in row order, then across, so that the order of additions never changes.

const HELD: u32 = 8u;

var<workgroup> evidence: array<vec4<f32>, 512>;
var<workgroup> groups: array<f32, 32>;

// Sums what is held and stores it; slot: where the sum of this lane's reading goes, in the first lanes.
fn reduce(held: u32, lane: u32, slot: u32) {
    workgroupBarrier();
    if lane < held * 4u {
        var sum = vec4<f32>(0.0);
        for (var row = 0u; row < TILE; row++) {
            sum += evidence[(lane / 4u) * 64u + row * 4u + lane % 4u];
        }
        groups[lane] = (sum.x + sum.y) + (sum.z + sum.w);
    }
    workgroupBarrier();
    if lane < held {
        let g = lane * 4u;
        let sum = (groups[g] + groups[g + 1u]) + (groups[g + 2u] + groups[g + 3u]);
        atomicStore(&parts[slot], bitcast<u32>(sum));
    }
}

@compute @workgroup_size(64)
fn weigh(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let tile = tiles[group.x];
    let cell = tile.corner + vec2<u32>((lane % 4u) * 4u, lane / 4u);
    let centre = CELL * vec2<i32>(cell) + vec2<i32>(CELL / 2);
    let columns = select(0, i32(frame.size.x) - i32(cell.x), cell.y < frame.size.y);
    let at = tile.slot * PLANES * 64u + lane;
    var cells = load(at + 128u);
    var held = 0u;
    // Each lane keeps its own: the next reading's never overwrites one that is still to be read.
    var slot = 0u;
    for (var k = tile.entries.x; k < tile.entries.y; k++) {
        let entry = entries[k];
        let cone = cones[entry.cone >> ENTRY_SHIFT];
        var row = member_row(cone, centre - cone.sensor);
        clip(&row, columns);
        if (cone.flags & NO_ECHO) != 0u {
            row.arc = vec4<bool>(false);
        }
        var sum = vec4<f32>(0.0);
        if any(row.interior | row.arc) {
            sum = weigh_cells(cone, row, &cells);
        }
        if (entry.cone & ARC) != 0u {
            evidence[held * 64u + lane] = sum;
            if lane == held {
                slot = entry.slot;
            }
            held += 1u;
            if held == HELD {
                reduce(held, lane, slot);
                held = 0u;
            }
        }
    }
    if held > 0u {
        reduce(held, lane, slot);
    }
}
