// Which cells lie in a fan, and which on lines, in integers; twin of src/binning/update/region.rs.
//
// Points and cells count from the sensor. All fits 32 bits: no point lies farther away than 512 cells.

// A point occupies what lies within ¾ cell, units.
const SPOT: i32 = 24;

// Four cells of a row, the first one's centre at v.
fn in_fan(fan: vec2<u32>, v: vec2<i32>) -> vec4<bool> {
    var inside = vec4<bool>(false);
    let x = v.x + CELL * vec4<i32>(0, 1, 2, 3);
    var a = vec2<i32>(0);
    var left = vec4<i32>(0);
    for (var k = fan.x; k < fan.y; k++) {
        let b = points[k];
        let right = cross_4(b, x, v.y);
        // The ray to the next triangle is that one's, the last ray the fan's.
        let limit = select(-1, 0, k + 1u == fan.y);
        inside = inside | in_triangle(a.x * b.y - a.y * b.x, limit, left, right);
        a = b;
        left = right;
    }
    return inside;
}

// The triangle between the sensor and two vertices, counter-clockwise, from its area and what crosses them: cross(a, p),
// cross(b, p). Nothing where it has no area.
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

// Within half a cell of the line along either axis; of a point within ¾ cell.
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
