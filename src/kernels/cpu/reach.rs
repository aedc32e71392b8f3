//! What a reading reaches of a tile: regions, distances and angles of its rows.
//!
//! It is found row by row before the method updates row by row: two short chains of dependent operations, of which a
//! processor has several under way, instead of one long one.

use super::walk::{Bits, Kernel, Place};
use crate::cone::Sight;
use crate::layout::*;
use crate::profile::polar;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

/// 16 cells of a row as a method sees them.
#[derive(Debug, Clone, Copy)]
pub struct Reached<S: Simd> {
    /// Freed by the reading.
    pub interior: mask32x16<S>,
    /// On its arc.
    pub arc: mask32x16<S>,
    /// From the sensor, metres.
    pub distance: f32x16<S>,
    /// Off-axis angle over β; 0 for a laser.
    pub turn: f32x16<S>,
}

/// The rows of a tile.
pub(super) struct Reach {
    /// A bit for each row that is reached.
    pub(super) rows: u32,
    interior: [u32; TILE],
    pub(super) arc: [u32; TILE],
    distance: [[f32; TILE]; TILE],
    turn: [[f32; TILE]; TILE],
}

impl Reach {
    pub(super) fn new() -> Reach {
        Reach {
            rows: 0,
            interior: [0; TILE],
            arc: [0; TILE],
            distance: [[0.0; TILE]; TILE],
            turn: [[0.0; TILE]; TILE],
        }
    }

    /// Looks at the rows whose bit is set; a missing echo's arc only with `arcs`, distances and angles with `polar`.
    #[inline(always)]
    pub(super) fn fill<S: Simd, K: Kernel>(
        &mut self,
        simd: S,
        frame: &Frame,
        place: &Place,
        (entry, cone, rows): (&Entry, &Cone, u32),
        arcs: bool,
        with_polar: bool,
    ) {
        let sight = Sight::of(simd, cone, place.first(cone), arcs || cone.flags & NO_ECHO == 0);
        let columns = 0xffffu32 >> (TILE - place.columns.min(TILE));
        let inside = entry.cone & INSIDE != 0;
        self.rows = rows;
        for y in Bits(rows) {
            let row = if K::AXIS {
                sight.axis_row(cone, y)
            } else if inside {
                sight.inside_row(cone, y)
            } else {
                sight.cone_row(cone, y)
            };
            self.interior[y] = row.interior.to_bitmask() as u32 & columns;
            self.arc[y] = row.arc.to_bitmask() as u32 & columns;
            if with_polar {
                let (distance, turn) = polar(frame, cone, &row);
                distance.store_array(&mut self.distance[y]);
                turn.store_array(&mut self.turn[y]);
            }
        }
    }

    /// A row that was filled.
    #[inline(always)]
    pub(super) fn row<S: Simd>(&self, simd: S, y: usize) -> Reached<S> {
        Reached {
            interior: mask32x16::from_bitmask(simd, self.interior[y].into()),
            arc: mask32x16::from_bitmask(simd, self.arc[y].into()),
            distance: f32x16::load_array(simd, self.distance[y]),
            turn: f32x16::load_array(simd, self.turn[y]),
        }
    }
}
