//! The order of directions around a pose; twin of `shaders/binning/scan/order.wgsl`.

use crate::geometry::layout::{Beam, YIELD};

/// The quadrant of a direction, 0 to 3, counter-clockwise from +x. A quadrant includes its first axis, not its last.
#[inline(always)]
pub fn quarter([x, y]: [i32; 2]) -> u32 {
    if y >= 0 {
        if x > 0 || (x == 0 && y == 0) {
            0
        } else if y > 0 {
            1
        } else {
            2
        }
    } else if x < 0 {
        2
    } else {
        3
    }
}

/// The cross product, which is exact while its result fits 53 bits.
#[inline(always)]
pub fn cross(a: [i32; 2], v: [i32; 2]) -> f64 {
    f64::from(a[0]) * f64::from(v[1]) - f64::from(a[1]) * f64::from(v[0])
}

/// Whether a beam's bound comes before a cell at `v`, so that the cell belongs to a later beam.
#[inline(always)]
pub fn before(beam: &Beam, v: [i32; 2]) -> bool {
    let (bound, cell) = (quarter(beam.bound), quarter(v));
    let turn = cross(beam.bound, v);
    bound < cell || (bound == cell && (turn > 0.0 || (turn == 0.0 && beam.id & YIELD != 0)))
}

/// The number of beams whose bounds come before a cell at `v`, found by bisection between `low` and `high`.
#[inline(always)]
pub fn place(beams: &[Beam], v: [i32; 2], mut low: u32, mut high: u32) -> u32 {
    while low < high {
        let middle = (low + high) / 2;
        if before(&beams[middle as usize], v) { low = middle + 1 } else { high = middle }
    }
    low
}
