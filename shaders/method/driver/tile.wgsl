// The cells of a tile in groups of four of a row, a vector each; twin of src/method/driver/reach.rs (Place).
//
// A thread owns 64 / THREADS groups: the host repeats the lines between `each GROUP` and `end` for each. With more groups a thread uses
// an entry that it has read for more cells; with fewer there are more threads.

// Whether tiles that are interior throughout, and entries without an arc, have code of their own. It is false on software adapters,
// which execute all sides of a branch, and in 64 bits.
override SPECIALIZE_TILES: bool = false;

// The first cell of a group.
fn cell_of(tile: Tile, group: u32) -> vec2<u32> {
    return tile.corner + vec2<u32>((group % 4u) * 4u, group / 4u);
}

// Columns of the grid from that cell on; 0 above its last row.
fn columns_of(cell: vec2<u32>) -> i32 {
    return select(0, i32(frame.size.x) - i32(cell.x), cell.y < frame.size.y);
}

// The first of four cells relative to the sensor, units.
fn from_sensor(cone: Cone, cell: vec2<u32>) -> vec2<i32> {
    return CELL * vec2<i32>(cell) + vec2<i32>(CELL / 2) - cone.sensor;
}

// Clears the cells beyond the grid.
fn clip_to_grid(row: ptr<function, Row>, cell: vec2<u32>) {
    let columns = columns_of(cell);
    if SPECIALIZE_TILES && columns >= 4 {
        return;
    }
    clip(row, columns);
}

// Classifies the four cells relative to the cone.
fn look(cone: Cone, cell: vec2<u32>) -> Row {
    var row = look_at_all(cone, cell);
    if (cone.flags & NO_ECHO) != 0u {
        row.arc = vec4<bool>(false);
    }
    return row;
}

// Classifies the four cells, with the arc even for a reading without an echo.
fn look_at_all(cone: Cone, cell: vec2<u32>) -> Row {
    var row = member_row(cone, from_sensor(cone, cell));
    clip_to_grid(&row, cell);
    return row;
}

// Classifies the four cells of a tile whose entry has no arc.
fn look_before(cone: Cone, cell: vec2<u32>) -> Row {
    var row = row_before(cone, from_sensor(cone, cell));
    clip_to_grid(&row, cell);
    return row;
}

// The four cells of a tile that is interior throughout, and lies in the grid.
fn look_inside(cone: Cone, cell: vec2<u32>) -> Row {
    return row_inside(cone, from_sensor(cone, cell));
}
