// A tile's cells in groups of four of a row; twin of src/kernels/cpu/reach.rs (Place).
//
// A thread owns 64 / THREADS groups: the lines between `each GROUP` and `end` stand once for each. More groups a thread spread
// the reading of an entry over more cells, fewer use more threads.

// The first cell of a group.
fn cell_of(tile: Tile, group: u32) -> vec2<u32> {
    return tile.corner + vec2<u32>((group % 4u) * 4u, group / 4u);
}

// How many columns the grid has from that cell on; none beyond its last row.
fn columns_of(cell: vec2<u32>) -> i32 {
    return select(0, i32(frame.size.x) - i32(cell.x), cell.y < frame.size.y);
}

// The four cells as the cone sees them.
fn look(cone: Cone, cell: vec2<u32>) -> Row {
    var row = look_at_all(cone, cell);
    if (cone.flags & NO_ECHO) != 0u {
        row.arc = vec4<bool>(false);
    }
    return row;
}

// The same, a missing echo's arc too.
fn look_at_all(cone: Cone, cell: vec2<u32>) -> Row {
    var row = member_row(cone, CELL * vec2<i32>(cell) + vec2<i32>(CELL / 2) - cone.sensor);
    clip(&row, columns_of(cell));
    return row;
}
