// The cells that an update reaches: those of its fans and lines, and of its cone; twin of src/binning/update/reach.rs.

// The effect of an update's three sources on four cells: a code for each cell, and the routine part's row.
struct Contributions {
    code: vec4<u32>,
    row: Row,
}

// Which of four cells lie in fan k, decided by the entry's slot where possible; v is the first cell's centre.
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

// Finds the effect of an update on four cells.
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
