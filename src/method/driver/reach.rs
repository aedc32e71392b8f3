//! The cells of a tile that a reading reaches: their regions, distances and angles, row by row; twin of `shaders/method/driver/tile.wgsl`
//! and of `shaders/method/driver/stage.wgsl`.
//!
//! All rows are found before the method updates them. Two short chains of dependent operations, of which a processor overlaps several,
//! are faster than one long chain.

use super::job::ReadingJob;
use super::kernel::{Kernel, Reached};
use crate::geometry::bits::Bits;
use crate::geometry::cone::{EdgeFunctions, Row};
use crate::geometry::layout::*;
use crate::geometry::profile;
use bytemuck::Zeroable;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

/// Number of entries whose rows are found ahead of their updates.
pub(super) const LOOKAHEAD: usize = 16;

/// A tile and the part of it that lies in the grid.
pub(super) struct Place {
    corner: [i32; 2],
    columns: usize,
    rows: usize,
}

impl Place {
    #[inline(always)]
    pub(super) fn of(job: &ReadingJob) -> Place {
        let [width, height] = job.frame.size;
        let [x, y] = job.tile.corner;
        Place { corner: [x as i32, y as i32], columns: (width - x) as usize, rows: TILE.min((height - y) as usize) }
    }

    /// A bit for each row of the tile that lies in the grid.
    #[inline(always)]
    fn rows(&self) -> u32 {
        0xffff >> (TILE - self.rows)
    }

    /// The cone's edge functions over the tile; the arc of a reading without an echo only with `arcs`.
    #[inline(always)]
    fn edges<S: Simd>(&self, simd: S, cone: &Cone, arcs: bool) -> EdgeFunctions<S> {
        let [i, j] = self.corner;
        let v = [CELL * i + CELL / 2 - cone.sensor[0], CELL * j + CELL / 2 - cone.sensor[1]];
        EdgeFunctions::of(simd, cone, v, arcs || cone.flags & NO_ECHO == 0)
    }
}

/// The edge functions and the rows to visit of the next entries, computed ahead, so that a loop over rows knows its end and does not wait
/// for a cone to be loaded.
pub(super) struct Lookahead<S: Simd>(pub(super) [(EdgeFunctions<S>, u32); LOOKAHEAD]);

impl<S: Simd> Lookahead<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        Lookahead([(EdgeFunctions::of(simd, &Zeroable::zeroed(), [0, 0], false), 0); LOOKAHEAD])
    }

    /// Computes the edge functions and rows of at most `LOOKAHEAD` entries; the arc of a reading without an echo only with `arcs`.
    #[inline(always)]
    pub(super) fn look(
        &mut self,
        simd: S,
        axis: bool,
        place: &Place,
        (cones, entries): (&[Cone], &[Entry]),
        arcs: bool,
    ) {
        for ((edges, rows), entry) in self.0.iter_mut().zip(entries) {
            let cone = &cones[entry.index()];
            *edges = place.edges(simd, cone, arcs);
            *rows = if entry.cone & INSIDE != 0 { 0xffff } else { edges.rows(cone, axis) & place.rows() };
        }
    }
}

/// The rows of a tile that a reading reaches.
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
        Reach { rows: 0, interior: [0; TILE], arc: [0; TILE], distance: [[0.0; TILE]; TILE], turn: [[0.0; TILE]; TILE] }
    }

    /// Fills the rows whose bit is set. Without `ARCS` no cell is on the arc; distances and angles only with a frame in `polar`.
    #[inline(always)]
    pub(super) fn fill<S: Simd, K: Kernel, const ARCS: bool>(
        &mut self,
        place: &Place,
        (entry, cone): (&Entry, &Cone),
        edges: &EdgeFunctions<S>,
        rows: u32,
        polar: Option<&Frame>,
    ) {
        let polar = polar.map(|frame| (frame, cone));
        let columns = 0xffffu32 >> (TILE - place.columns.min(TILE));
        self.rows = rows;
        // Each case has its own loop, without the branches and calls that only other cases need.
        match (cone.flags & WIDE != 0, K::AXIS, entry.cone & INSIDE != 0) {
            (true, true, _) => {
                for y in Bits(rows) {
                    self.set::<S, true>(y, &edges.wide_axis_row(cone, y), columns, None);
                }
            }
            (true, false, _) => {
                for y in Bits(rows) {
                    self.set::<S, true>(y, &edges.wide_row(cone, y), columns, polar);
                }
            }
            (false, true, _) => {
                let axis = edges.axis(cone);
                for y in Bits(rows) {
                    self.set::<S, true>(y, &edges.axis_row(&axis, y), columns, None);
                }
            }
            (false, false, true) => {
                for y in Bits(rows) {
                    self.set::<S, ARCS>(y, &edges.inside_row(y), columns, polar);
                }
            }
            (false, false, false) => {
                for y in Bits(rows) {
                    self.set::<S, ARCS>(y, &edges.cone_row::<ARCS>(cone, y), columns, polar);
                }
            }
        }
    }

    #[inline(always)]
    fn set<S: Simd, const ARCS: bool>(&mut self, y: usize, row: &Row<S>, columns: u32, polar: Option<(&Frame, &Cone)>) {
        self.interior[y] = row.interior.to_bitmask() as u32 & columns;
        if ARCS {
            self.arc[y] = row.arc.to_bitmask() as u32 & columns;
        }
        if let Some((frame, cone)) = polar {
            let (distance, turn) = profile::polar(frame, cone, row);
            distance.store_array(&mut self.distance[y]);
            turn.store_array(&mut self.turn[y]);
        }
    }

    /// Row `y`, which must have been filled.
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
