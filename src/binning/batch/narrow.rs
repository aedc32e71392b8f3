//! [`Shape::meets`] for 16 tiles of a row at once in 32 bits, for cones that reach 1024 cells at most.

use super::shape::{Extremes, Shape};
use crate::binning::snap::{Footprint, SLACK};
use crate::geometry::layout::*;
use fearless_simd::prelude::*;
use fearless_simd::{i32x16, mask32x16, u32x16};

/// Number of tiles that are tested together.
pub(super) const TILES: usize = 16;

/// Distance from a tile to the next, units.
const EDGE: i32 = CELL * TILE as i32;

/// The columns' part of the least and the largest value of a product over each tile.
type Range<S> = [i32x16<S>; 2];

/// The [`Extremes`] of 16 columns of tiles.
pub(super) struct Columns<S: Simd> {
    left: Range<S>,
    right: Range<S>,
    across: Range<S>,
    along: Range<S>,
    near2: u32x16<S>,
    far2: u32x16<S>,
}

/// Bit masks of a row's tiles: those that a cone may touch, those that its arc may touch, and those that are all interior.
pub(super) struct Met {
    pub(super) some: u32,
    pub(super) arc: u32,
    pub(super) inside: u32,
}

#[inline(always)]
fn by<S: Simd>(low: i32x16<S>, high: i32x16<S>, factor: i64) -> Range<S> {
    let factor = factor as i32;
    if factor < 0 { [high * factor, low * factor] } else { [low * factor, high * factor] }
}

impl<S: Simd> Columns<S> {
    /// The extremes of the columns from the one that begins at `at`, units from the sensor.
    #[inline(always)]
    pub(super) fn of(simd: S, shape: &Shape, at: i64) -> Self {
        let mut steps = [0; TILES];
        for (k, step) in steps.iter_mut().enumerate() {
            *step = EDGE * k as i32;
        }
        let low = i32x16::load_array(simd, steps) + (at as i32 + CELL / 2);
        let high = low + (EDGE - CELL);
        let near = low.max(0) + high.min(0);
        let far = low.abs().max(high.abs());
        Columns {
            left: by(low, high, -shape.left[1]),
            right: by(low, high, -shape.right[1]),
            across: by(low, high, -shape.axis[1]),
            along: by(low, high, shape.axis[0]),
            near2: (near * near).bitcast(),
            far2: (far * far).bitcast(),
        }
    }

    /// Tests the tiles of a row.
    #[inline(always)]
    pub(super) fn meet(&self, shape: &Shape, row: &Extremes) -> Met {
        let sum = |columns: i32x16<S>, row: i64| columns + row as i32;
        let along = [sum(self.along[0], row.along[0]), sum(self.along[1], row.along[1])];
        let axis = shape.footprint == Footprint::Axis;
        let mut beam = mask32x16::splat(self.near2.token(), false);
        if axis || shape.narrow {
            let half = CELL / 2 * DIRECTION;
            let before = if axis { -(SLACK as i32) * DIRECTION } else { 0 };
            beam = sum(self.across[0], row.across[0]).simd_le(half)
                & sum(self.across[1], row.across[1]).simd_ge(-half)
                & along[1].simd_ge(before)
                & along[0].simd_le(shape.outer as i32 * DIRECTION);
        }
        if axis {
            let some = beam.to_bitmask() as u32;
            return Met { some, arc: some, inside: 0 };
        }
        let left = [sum(self.left[0], row.left[0]), sum(self.left[1], row.left[1])];
        let right = [sum(self.right[0], row.right[0]), sum(self.right[1], row.right[1])];
        let (near2, far2) = (self.near2 + row.near2 as u32, self.far2 + row.far2 as u32);
        beam |= left[0].simd_le(0) & right[1].simd_ge(0) & along[1].simd_ge(0);
        let some = beam & near2.simd_le(shape.outer2 as u32);
        let arc = far2.simd_ge(shape.inner2 as u32);
        let inside = left[1].simd_lt(0) & right[0].simd_ge(0) & along[0].simd_ge(0) & !arc;
        let bits = [some, some & arc, some & inside].map(|mask| mask.to_bitmask() as u32);
        Met { some: bits[0], arc: bits[1], inside: bits[2] }
    }
}
