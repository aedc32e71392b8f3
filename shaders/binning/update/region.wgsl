// Integer tests of which cells lie in a fan and which on lines; twin of src/binning/update/region.rs.
//
// Points and cells are relative to the sensor. All products fit 32 bits, because no point lies farther away than 512 cells.

// Radius within which a point occupies cells, units: ¾ cell.
const SPOT: i32 = 24;

// Which of four cells of a row lie in a fan; v is the first cell's centre, units from the sensor.
fn in_fan(fan: vec2<u32>, v: vec2<i32>) -> vec4<bool> {
    var inside = vec4<bool>(false);
    let x = v.x + CELL * vec4<i32>(0, 1, 2, 3);
    var a = vec2<i32>(0);
    var left = vec4<i32>(0);
    for (var k = fan.x; k < fan.y; k++) {
        let b = points[k];
        let right = cross_4(b, x, v.y);
        // The ray between two triangles belongs to the next one; the last ray belongs to the fan.
        let limit = select(-1, 0, k + 1u == fan.y);
        inside = inside | in_triangle(a.x * b.y - a.y * b.x, limit, left, right);
        a = b;
        left = right;
    }
    return inside;
}

// Which cells lie in the triangle of the sensor and two vertices a and b, counter-clockwise. left is cross(a, p), right is
// cross(b, p). A triangle without area holds no cell.
fn in_triangle(area: i32, limit: i32, left: vec4<i32>, right: vec4<i32>) -> vec4<bool> {
    let zero = vec4<i32>(0);
    let within = (left >= zero) & (right <= vec4<i32>(limit)) & vec4<bool>(area > 0);
    // cross(b - a, p - a).
    return within & (right - left + area >= zero);
}

fn on_lines(ends: vec2<u32>, v: vec2<i32>) -> vec4<bool> {
    var on = vec4<bool>(false);
    for (var k = ends.x; k < ends.y; k += 2u) {
        on = on | on_line(points[k], points[k + 1u], v);
    }
    return on;
}

// Which cells lie within half a cell of the line along either axis, or within ¾ cell of it if the line is a point.
fn on_line(a: vec2<i32>, b: vec2<i32>, v: vec2<i32>) -> vec4<bool> {
    let d = b - a;
    let x = v.x - a.x + CELL * vec4<i32>(0, 1, 2, 3);
    let y = v.y - a.y;
    if all(d == vec2<i32>(0)) {
        return x * x + y * y <= vec4<i32>(SPOT * SPOT);
    }
    let half = CELL / 2 * (abs(d.x) + abs(d.y));
    let along = dot_4(d, x, y);
    let between = (along >= vec4<i32>(0)) & (along <= vec4<i32>(d.x * d.x + d.y * d.y));
    return between & (abs(cross_4(d, x, y)) <= vec4<i32>(half));
}
