// The snapped cone: which cells a reading frees and which lie on its arc, in integers; twin of src/geometry/cone.rs.
//
// Membership is exact, so it is the same on every backend. Four cells of a row are classified at once.

// Whether a reading of the batch has a narrow beam.
override NARROW_BEAMS: bool = true;

struct Row {
    // Cells in the interior, which the reading frees.
    interior: vec4<bool>,
    // Cells on the reading's arc.
    arc: vec4<bool>,
    // Squared distance from the sensor, units².
    d2: vec4<f32>,
    // |cross(axis, v)|.
    across: vec4<f32>,
    // dot(axis, v).
    along: vec4<f32>,
}

fn cross_4(a: vec2<i32>, x: vec4<i32>, y: i32) -> vec4<i32> {
    return a.x * y - a.y * x;
}

fn dot_4(a: vec2<i32>, x: vec4<i32>, y: i32) -> vec4<i32> {
    return a.x * x + a.y * y;
}

// Whether cells lie between a cone's edges, or in a narrow beam's band.
fn between_edges(cone: Cone, x: vec4<i32>, y: i32, across: vec4<i32>, along: vec4<i32>) -> vec4<bool> {
    let left_limit = -i32((cone.flags & HALF_OPEN) != 0u);
    let zero = vec4<i32>(0);
    let wedge = (cross_4(cone.left, x, y) <= vec4<i32>(left_limit)) & (cross_4(cone.right, x, y) >= zero) & (along >= zero);
    if !NARROW_BEAMS {
        return wedge;
    }
    let narrow = vec4<bool>((cone.flags & NARROW_BEAM) != 0u);
    let band = narrow
        & (abs(across) <= vec4<i32>(CELL / 2 * DIRECTION))
        & (along >= zero)
        & (along <= vec4<i32>(cone.reach.y * DIRECTION));
    return wedge | band;
}

// Classifies four cells, the first with its centre at v from the sensor, units.
fn narrow_row(cone: Cone, v: vec2<i32>) -> Row {
    let inner = cone.reach.x * cone.reach.x;
    let outer = cone.reach.y * cone.reach.y;
    let x = v.x + CELL * vec4<i32>(0, 1, 2, 3);
    let d2 = x * x + v.y * v.y;
    let across = cross_4(cone.axis, x, v.y);
    let along = dot_4(cone.axis, x, v.y);
    let inside = between_edges(cone, x, v.y, across, along);
    var row: Row;
    row.interior = inside & (d2 < vec4<i32>(inner));
    row.arc = inside & (d2 >= vec4<i32>(inner)) & (d2 <= vec4<i32>(outer));
    row.d2 = vec4<f32>(d2);
    row.across = vec4<f32>(abs(across));
    row.along = vec4<f32>(along);
    return row;
}

// narrow_row without the arc, which lies elsewhere or belongs to a reading without an echo.
fn row_before(cone: Cone, v: vec2<i32>) -> Row {
    let x = v.x + CELL * vec4<i32>(0, 1, 2, 3);
    let d2 = x * x + v.y * v.y;
    let across = cross_4(cone.axis, x, v.y);
    let along = dot_4(cone.axis, x, v.y);
    var row: Row;
    row.interior = between_edges(cone, x, v.y, across, along) & (d2 < vec4<i32>(cone.reach.x * cone.reach.x));
    row.d2 = vec4<f32>(d2);
    row.across = vec4<f32>(abs(across));
    row.along = vec4<f32>(along);
    return row;
}

// narrow_row for four cells that are all interior.
fn row_inside(cone: Cone, v: vec2<i32>) -> Row {
    let x = v.x + CELL * vec4<i32>(0, 1, 2, 3);
    var row: Row;
    row.interior = vec4<bool>(true);
    row.d2 = vec4<f32>(x * x + v.y * v.y);
    row.across = vec4<f32>(abs(cross_4(cone.axis, x, v.y)));
    row.along = vec4<f32>(dot_4(cone.axis, x, v.y));
    return row;
}

// HIMM's row: the cells on the acoustic axis before the hit (interior) and the hit cell (arc).
fn narrow_axis_row(cone: Cone, v: vec2<i32>) -> Row {
    let x = v.x + CELL * vec4<i32>(0, 1, 2, 3);
    let y = vec4<i32>(v.y);
    let steep = abs(cone.axis.y) > abs(cone.axis.x);
    let c = select(cone.axis.x, cone.axis.y, steep);
    let s = select(cone.axis.y, cone.axis.x, steep);
    let a = select(x, y, vec4<bool>(steep));
    let b = select(y, x, vec4<bool>(steep));
    let sgn = sign(c);
    let side = (b * c - a * s) * sgn;
    let edge = vec4<i32>(CELL / 2 * abs(c));
    let on = (a * sgn >= vec4<i32>(0)) & (side >= -edge) & (side < edge);
    let past = DIRECTION * a * sgn - vec4<i32>(cone.reach.x * abs(c));
    let half = vec4<i32>(CELL / 2 * DIRECTION);
    var row: Row;
    let before = on & (past < -half);
    let hit = on & (past >= -half) & (past < half);
    // Without an echo the hit cell is interior too.
    let silent = vec4<bool>((cone.flags & NO_ECHO) != 0u);
    row.interior = before | (hit & silent);
    row.arc = hit & !silent;
    return row;
}

// Clears the cells in columns that lie beyond the grid.
fn clip(row: ptr<function, Row>, columns: i32) {
    let within = vec4<i32>(0, 1, 2, 3) < vec4<i32>(columns);
    (*row).interior = (*row).interior & within;
    (*row).arc = (*row).arc & within;
}
