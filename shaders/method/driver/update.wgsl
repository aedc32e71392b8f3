// Updates that features made of readings: a tile's list of them, in log order; twin of src/method/driver/update.rs.
//
// A kernel of its own, because an update has shapes beside its cone. A workgroup is a tile; its threads hold their cells' state in
// registers. Bounds: groups are the chunk's listed tiles, entries those of the tile's list, points those of an update's shapes.

// What the three sources of an update do to four cells: a code for each cell, and the routine part's row.
struct Contributions {
    code: vec4<u32>,
    row: Row,
}

// Which of four cells, the first one's centre at v, lie in the k-th fan, by the entry's slot.
fn fan(points: vec2<u32>, k: u32, slot: u32, v: vec2<i32>) -> vec4<bool> {
    if (slot & (FULL << k)) != 0u {
        return vec4<bool>(true);
    }
    if (slot & (FAN << k)) == 0u {
        return vec4<bool>(false);
    }
    return in_fan(points, v);
}

// The bits of the code for source k.
fn source(k: u32, occupied: vec4<bool>, freed: vec4<bool>) -> vec4<u32> {
    let none = vec4<u32>(0u);
    return select(select(none, vec4<u32>(FREED << (2u * k)), freed), vec4<u32>(OCCUPIED << (2u * k)), occupied);
}

// The bits of the code for part k: its lines and its fan.
fn part(k: u32, lines: vec2<u32>, points: vec2<u32>, slot: u32, v: vec2<i32>) -> vec4<u32> {
    var occupied = vec4<bool>(false);
    if (slot & (LINES << k)) != 0u {
        occupied = on_lines(lines, v);
    }
    return source(k, occupied, fan(points, k, slot, v));
}

// What an update does to four cells.
fn look_at(cone: Cone, update: Shapes, slot: u32, cell: vec2<u32>) -> Contributions {
    let v = CELL * vec2<i32>(cell) + vec2<i32>(CELL / 2) - cone.sensor;
    var contributions: Contributions;
    contributions.code = part(0u, update.lines[0], update.fans[0], slot, v) | part(1u, update.lines[1], update.fans[1], slot, v);
    if (slot & ROUTINE) != 0u {
        contributions.row = look(cone, cell);
        if (update.flags & FREE_LIMIT) != 0u {
            contributions.row.interior = contributions.row.interior & fan(update.fans[2], 2u, slot, v);
        }
        if (update.flags & ARC_LIMIT) != 0u {
            contributions.row.arc = contributions.row.arc & fan(update.fans[3], 3u, slot, v);
        }
        contributions.code = contributions.code | source(2u, contributions.row.arc, contributions.row.interior);
    }
    contributions.code = select(vec4<u32>(0u), contributions.code, vec4<i32>(0, 1, 2, 3) < vec4<i32>(columns_of(cell)));
    return contributions;
}

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
