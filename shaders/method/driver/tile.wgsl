// A tile's cells in groups of four of a row; twin of src/method/driver/reach.rs (Place).
//
// A thread owns 64 / THREADS groups: the lines between `each GROUP` and `end` stand once for each. More groups a thread spread
// the reading of an entry over more cells, fewer use more threads.

// Whether tiles that are interior throughout, and entries without an arc, have code of their own. Software adapters run all sides of a
// branch, and 64 bits have none.
override TOLD_APART: bool = false;

// The first cell of a group.
fn cell_of(tile: Tile, group: u32) -> vec2<u32> {
    return tile.corner + vec2<u32>((group % 4u) * 4u, group / 4u);
}

// How many columns the grid has from that cell on; none beyond its last row.
fn columns_of(cell: vec2<u32>) -> i32 {
    return select(0, i32(frame.size.x) - i32(cell.x), cell.y < frame.size.y);
}

// Where the first of four cells lies from the sensor.
fn from_sensor(cone: Cone, cell: vec2<u32>) -> vec2<i32> {
    return CELL * vec2<i32>(cell) + vec2<i32>(CELL / 2) - cone.sensor;
}

// Leaves out what lies beyond the grid.
fn clip_to_grid(row: ptr<function, Row>, cell: vec2<u32>) {
    let columns = columns_of(cell);
    if TOLD_APART && columns >= 4 {
        return;
    }
    clip(row, columns);
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
    var row = member_row(cone, from_sensor(cone, cell));
    clip_to_grid(&row, cell);
    return row;
}

// The four cells of a tile whose entry has no arc.
fn look_before(cone: Cone, cell: vec2<u32>) -> Row {
    var row = row_before(cone, from_sensor(cone, cell));
    clip_to_grid(&row, cell);
    return row;
}

// The four cells of a tile that is interior throughout, and lies in the grid.
fn look_inside(cone: Cone, cell: vec2<u32>) -> Row {
    return row_inside(cone, from_sensor(cone, cell));
}
