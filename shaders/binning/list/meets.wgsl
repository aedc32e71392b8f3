// Whether a cone that reaches 1024 cells at most may touch a tile; twin of src/binning/batch/shape.rs.

// Units by which the axis' footprint may exceed its edges.
const SLACK: i32 = 64;

// Flag beside ARC and INSIDE: the cone may touch the tile.
const SOME: u32 = 4u;

// The least and the largest product of a factor and a number between low and high.
fn by(factor: i32, low: i32, high: i32) -> vec2<i32> {
    return select(vec2<i32>(factor * low, factor * high), vec2<i32>(factor * high, factor * low), factor < 0);
}

// The least and the largest cross(a, v) over a tile; the next function does the same for dot(a, v).
fn cross_over(a: vec2<i32>, low: vec2<i32>, high: vec2<i32>) -> vec2<i32> {
    return by(-a.y, low.x, high.x) + by(a.x, low.y, high.y);
}

fn dot_over(a: vec2<i32>, low: vec2<i32>, high: vec2<i32>) -> vec2<i32> {
    return by(a.x, low.x, high.x) + by(a.y, low.y, high.y);
}

fn square(v: vec2<i32>) -> u32 {
    return u32(v.x * v.x) + u32(v.y * v.y);
}

// The flags SOME, ARC and INSIDE of a cone in the tile with the lower left cell `corner`; 0 if they do not meet.
fn meets(cone: Cone, corner: vec2<u32>) -> u32 {
    // The centres of the tile's first and last cells.
    let low = CELL * vec2<i32>(corner) + vec2<i32>(CELL / 2) - cone.sensor;
    let high = low + CELL * (i32(TILE) - 1);
    let half = CELL / 2 * DIRECTION;
    let along = dot_over(cone.axis, low, high);
    let across = cross_over(cone.axis, low, high);
    let axis = (params.flags & AXIS) != 0u;
    let before = select(0, -SLACK * DIRECTION, axis);
    let band = across.x <= half && across.y >= -half && along.y >= before && along.x <= cone.reach.y * DIRECTION;
    if axis {
        return select(0u, SOME | ARC, band);
    }
    let left = cross_over(cone.left, low, high);
    let right = cross_over(cone.right, low, high);
    let wedge = left.x <= 0 && right.y >= 0 && along.y >= 0;
    let near2 = square(max(low, vec2<i32>(0)) + min(high, vec2<i32>(0)));
    let far2 = square(max(abs(low), abs(high)));
    let narrow = (cone.flags & NARROW_BEAM) != 0u;
    if near2 > u32(cone.reach.y * cone.reach.y) || !(wedge || (narrow && band)) {
        return 0u;
    }
    let arc = far2 >= u32(cone.reach.x * cone.reach.x);
    let inside = left.y < 0 && right.x >= 0 && along.x >= 0 && !arc;
    return SOME | select(0u, ARC, arc) | select(0u, INSIDE, inside);
}
