//! Membership in 64 bits, for readings that reach farther than 1024 cells; twin of `shaders/geometry/cone/wide.wgsl`.
//! The shader takes its 64-bit integers from `shaders/geometry/int64.wgsl`.

use super::Row;
use crate::geometry::layout::*;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

/// Converts a 64-bit magnitude to f32 with the same roundings as the kernels.
#[inline(always)]
fn float(magnitude: u64) -> f32 {
    (magnitude >> 32) as u32 as f32 * 4_294_967_296.0 + magnitude as u32 as f32
}

/// [`super::EdgeFunctions::cone_row`] in 64 bits.
#[inline(always)]
pub fn wide_row<S: Simd>(simd: S, cone: &Cone, v: [i32; 2]) -> Row<S> {
    let ([interior, arc], [d2, across, along]) = wide_cells(cone, v);
    Row {
        interior: mask32x16::from_bitmask(simd, interior),
        arc: mask32x16::from_bitmask(simd, arc),
        d2: f32x16::load_array(simd, d2),
        across: f32x16::load_array(simd, across),
        along: f32x16::load_array(simd, along),
    }
}

/// Classifies a row's cells. Returns bit masks of the cells in the interior and on the arc, and for each cell d²,
/// |cross(axis, v)| and dot(axis, v).
#[inline(never)]
fn wide_cells(cone: &Cone, v: [i32; 2]) -> ([u64; 2], [[f32; TILE]; 3]) {
    let (mut regions, mut numbers) = ([0; 2], [[0.0; TILE]; 3]);
    for k in 0..TILE {
        let at = Wide::of(cone, [v[0] + CELL * k as i32, v[1]]);
        let (interior, arc) = at.regions();
        regions[0] |= u64::from(interior) << k;
        regions[1] |= u64::from(arc) << k;
        numbers[0][k] = float(at.d2 as u64);
        numbers[1][k] = float(at.across.unsigned_abs());
        numbers[2][k] = float(at.along.max(0) as u64);
    }
    (regions, numbers)
}

/// [`super::EdgeFunctions::axis_row`] in 64 bits: bit masks of the cells before the hit and of the hit cell.
#[inline(never)]
pub fn wide_axis_cells(cone: &Cone, v: [i32; 2]) -> [u64; 2] {
    (0..TILE).fold([0; 2], |[interior, arc], k| {
        let (before, hit) = on_axis_wide(cone, [v[0] + CELL * k as i32, v[1]]);
        [interior | u64::from(before) << k, arc | u64::from(hit) << k]
    })
}

/// Membership of one cell in 64 bits. The host uses it for single cells too.
pub(crate) struct Wide {
    inside: bool,
    d2: i64,
    inner: i64,
    outer: i64,
    across: i64,
    along: i64,
}

impl Wide {
    pub(crate) fn of(cone: &Cone, v: [i32; 2]) -> Wide {
        let wide = |a: [i32; 2]| [i64::from(a[0]), i64::from(a[1])];
        let cross = |a: [i64; 2], v: [i64; 2]| a[0] * v[1] - a[1] * v[0];
        let (v, axis, reach) = (wide(v), wide(cone.axis), wide(cone.reach));
        let (across, along) = (cross(axis, v), axis[0] * v[0] + axis[1] * v[1]);
        let left_limit = -i64::from(cone.flags & HALF_OPEN != 0);
        let wedge = cross(wide(cone.left), v) <= left_limit && cross(wide(cone.right), v) >= 0 && along >= 0;
        let band = cone.flags & NARROW_BEAM != 0
            && across.abs() <= i64::from(CELL / 2 * DIRECTION)
            && along >= 0
            && along <= reach[1] * i64::from(DIRECTION);
        Wide {
            inside: wedge || band,
            d2: v[0] * v[0] + v[1] * v[1],
            inner: reach[0] * reach[0],
            outer: reach[1] * reach[1],
            across,
            along,
        }
    }

    /// Whether the cell is in the interior, and whether it is on the arc.
    pub(crate) fn regions(&self) -> (bool, bool) {
        (self.inside && self.d2 < self.inner, self.inside && self.d2 >= self.inner && self.d2 <= self.outer)
    }
}

/// Whether a cell lies on the axis before the hit, and whether it is the hit cell. As in SPEC, c is the axis' larger component.
pub(crate) fn on_axis_wide(cone: &Cone, v: [i32; 2]) -> (bool, bool) {
    let wide = |a: [i32; 2]| [i64::from(a[0]), i64::from(a[1])];
    let (axis, v, range) = (wide(cone.axis), wide(v), i64::from(cone.reach[0]));
    let steep = axis[1].abs() > axis[0].abs();
    let (c, s, a, b) = if steep { (axis[1], axis[0], v[1], v[0]) } else { (axis[0], axis[1], v[0], v[1]) };
    let (half, sign) = (i64::from(CELL / 2), c.signum());
    let side = (b * c - a * s) * sign;
    let on = a * sign >= 0 && side >= -half * c.abs() && side < half * c.abs();
    let past = i64::from(DIRECTION) * a * sign - range * c.abs();
    let half = half * i64::from(DIRECTION);
    (on && past < -half, on && past >= -half && past < half)
}
