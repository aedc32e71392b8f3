//! Integer tests of which cells lie in a fan and which on lines; twin of `shaders/binning/update/region.wgsl`.
//!
//! Points and cells are relative to the sensor. All products fit 32 bits, because no point lies farther away than 512 cells.
//! The functions work on a tile at a time and visit only the rows that a shape's box meets.

use crate::geometry::cone::STEPS;
use crate::geometry::layout::{CELL, TILE};
use fearless_simd::i32x16;
use fearless_simd::prelude::*;
use std::ops::Range;

/// A bit mask of a tile's cells: a word for each row, a bit for each cell.
pub type Rows = [u32; TILE];

/// Radius within which a point occupies cells, units: ¾ cell.
pub const SPOT: i32 = 24;

/// Distance along an axis from a tile's first cell centre to its last, units.
pub(super) const SPAN: i32 = CELL * (TILE as i32 - 1);

/// The tile's cells in a fan; `v` is the centre of the tile's first cell, units from the sensor.
#[inline(always)]
pub fn in_fan<S: Simd>(simd: S, fan: &[[i32; 2]], v: [i32; 2]) -> Rows {
    let mut inside = [0; TILE];
    for k in 1..fan.len() {
        // The ray between two triangles belongs to the next one; the last ray belongs to the fan.
        let limit = if k + 1 == fan.len() { 0 } else { -1 };
        in_triangle(simd, fan[k - 1], fan[k], limit, v, &mut inside);
    }
    inside
}

/// Adds the cells in the triangle of the sensor, `a` and, counter-clockwise, `b`; it adds none if the triangle has no area.
#[inline(always)]
fn in_triangle<S: Simd>(simd: S, a: [i32; 2], b: [i32; 2], limit: i32, v: [i32; 2], inside: &mut Rows) {
    let area = cross(a, b);
    let e = [b[0] - a[0], b[1] - a[1]];
    let low = [a[0].min(b[0]).min(0), a[1].min(b[1]).min(0)];
    let high = [a[0].max(b[0]).max(0), a[1].max(b[1]).max(0)];
    let rows = met(low, high, v);
    if area <= 0 || rows.is_empty() || most(a, v) < 0 || -most([-b[0], -b[1]], v) > limit || most(e, v) + area < 0 {
        return;
    }
    let x = i32x16::load_array(simd, STEPS) + v[0];
    let columns = [x * -a[1], x * -b[1]];
    for row in rows {
        let y = v[1] + CELL * row as i32;
        let (left, right) = (columns[0] + a[0] * y, columns[1] + b[0] * y);
        let within = left.simd_ge(0) & right.simd_le(limit);
        // cross(b − a, p − a).
        inside[row] |= (within & (right - left + area).simd_ge(0)).to_bitmask() as u32;
    }
}

/// The tile's cells on lines of two ends each; `v` is the centre of the tile's first cell, units from the sensor.
#[inline(always)]
pub fn on_lines<S: Simd>(simd: S, ends: &[[i32; 2]], v: [i32; 2]) -> Rows {
    let mut on = [0; TILE];
    for line in ends.chunks_exact(2) {
        on_line(simd, line[0], line[1], v, &mut on);
    }
    on
}

/// Adds the cells within half a cell of the line along either axis, or within ¾ cell of it if the line is a point.
#[inline(always)]
fn on_line<S: Simd>(simd: S, a: [i32; 2], b: [i32; 2], v: [i32; 2], on: &mut Rows) {
    let d = [b[0] - a[0], b[1] - a[1]];
    let low = [a[0].min(b[0]) - SPOT, a[1].min(b[1]) - SPOT];
    let high = [a[0].max(b[0]) + SPOT, a[1].max(b[1]) + SPOT];
    let x = i32x16::load_array(simd, STEPS) + (v[0] - a[0]);
    let half = CELL / 2 * (d[0].abs() + d[1].abs());
    for row in met(low, high, v) {
        let y = v[1] - a[1] + CELL * row as i32;
        on[row] |= if d == [0, 0] {
            (x * x + y * y).simd_le(SPOT * SPOT).to_bitmask()
        } else {
            let along = x * d[0] + d[1] * y;
            let between = along.simd_ge(0) & along.simd_le(d[0] * d[0] + d[1] * d[1]);
            (between & (x * -d[1] + d[0] * y).abs().simd_le(half)).to_bitmask()
        } as u32;
    }
}

/// The rows of a tile that a box meets; none if the box lies to the left or right of the tile.
#[inline(always)]
fn met(low: [i32; 2], high: [i32; 2], v: [i32; 2]) -> Range<usize> {
    if v[0] > high[0] || v[0] + SPAN < low[0] {
        return 0..0;
    }
    let from = (low[1] - v[1] + CELL - 1).div_euclid(CELL).clamp(0, TILE as i32);
    let to = ((high[1] - v[1]).div_euclid(CELL) + 1).clamp(0, TILE as i32);
    from as usize..to as usize
}

/// The largest cross(a, p) over the cell centres p of a tile.
#[inline(always)]
pub(super) fn most(a: [i32; 2], v: [i32; 2]) -> i32 {
    (a[0] * v[1] + (a[0] * SPAN).max(0)) - (a[1] * v[0] + (a[1] * SPAN).min(0))
}

/// The z component of the cross product.
#[inline(always)]
pub(super) fn cross(a: [i32; 2], b: [i32; 2]) -> i32 {
    a[0] * b[1] - a[1] * b[0]
}
