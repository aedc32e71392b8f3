// The order of directions around a pose; twin of src/binning/scan/order.rs.

// The quadrant of a direction, 0 to 3, counter-clockwise from +x. A quadrant includes its first axis, not its last.
fn quarter(v: vec2<i32>) -> u32 {
    let upper = select(2u, select(1u, 0u, v.x > 0 || (v.x == 0 && v.y == 0)), v.x >= 0 || v.y > 0);
    return select(select(3u, 2u, v.x < 0), upper, v.y >= 0);
}

// Whether a beam's bound comes before a cell at v, so that the cell belongs to a later beam.
fn before(beam: u32, v: vec2<i32>) -> bool {
    let direction = beams[beam].bound;
    let bound = quarter(direction);
    let cell = quarter(v);
    let turn = wide_cross(direction, v);
    let level = all(turn == vec2<u32>(0u));
    let later = select(!wide_negative(turn), (beams[beam].id & YIELD) != 0u, level);
    return bound < cell || (bound == cell && later);
}

// The number of beams, from `first` on, whose bounds come before a cell at v, found by bisection between `least` and `most`.
fn place(first: u32, v: vec2<i32>, least: u32, most: u32) -> u32 {
    var low = least;
    var high = most;
    while low < high {
        let middle = (low + high) / 2u;
        if before(first + middle, v) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}
