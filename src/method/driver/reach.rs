//! What a reading reaches of a tile: regions, distances and angles of its rows; twin of `shaders/method/driver/tile.wgsl`
//! and of `shaders/method/driver/stage.wgsl`.
//!
//! It is found row by row before the method updates row by row: two short chains of dependent operations, of which a
//! processor has several under way, instead of one long one.

use super::walk::{Job, Kernel};
use crate::geometry::bits::Bits;
use crate::geometry::cone::{Row, Sight};
use crate::geometry::layout::*;
use crate::geometry::profile;
use bytemuck::Zeroable;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

/// Entries whose rows are looked at together.
pub(super) const AHEAD: usize = 16;

/// A tile and the part of it that lies in the grid.
pub(super) struct Place {
    corner: [i32; 2],
    columns: usize,
    rows: usize,
}

impl Place {
    #[inline(always)]
    pub(super) fn of(job: &Job) -> Place {
        let [width, height] = job.frame.size;
        let [x, y] = job.tile.corner;
        Place { corner: [x as i32, y as i32], columns: (width - x) as usize, rows: TILE.min((height - y) as usize) }
    }

    /// The rows that the grid has of the tile, a bit each.
    #[inline(always)]
    fn rows(&self) -> u32 {
        0xffff >> (TILE - self.rows)
    }

    /// The tile as a cone sees it; a missing echo's arc only with `arcs`.
    #[inline(always)]
    fn sight<S: Simd>(&self, simd: S, cone: &Cone, arcs: bool) -> Sight<S> {
        let [i, j] = self.corner;
        let v = [CELL * i + CELL / 2 - cone.sensor[0], CELL * j + CELL / 2 - cone.sensor[1]];
        Sight::of(simd, cone, v, arcs || cone.flags & NO_ECHO == 0)
    }
}

/// A few entries' sights of the tile and the rows to look at, found ahead: a loop over rows then knows its end, and doesn't
/// wait for a cone.
pub(super) struct Ahead<S: Simd>(pub(super) [(Sight<S>, u32); AHEAD]);

impl<S: Simd> Ahead<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        Ahead([(Sight::of(simd, &Zeroable::zeroed(), [0, 0], false), 0); AHEAD])
    }

    /// Looks at these entries, `AHEAD` at most; a missing echo's arc only with `arcs`.
    #[inline(always)]
    pub(super) fn look(&mut self, simd: S, axis: bool, place: &Place, job: &Job, entries: &[Entry], arcs: bool) {
        for ((sight, rows), entry) in self.0.iter_mut().zip(entries) {
            let cone = &job.cones[entry.index()];
            *sight = place.sight(simd, cone, arcs);
            *rows = if entry.cone & INSIDE != 0 { 0xffff } else { sight.rows(cone, axis) & place.rows() };
        }
    }
}

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
        Reach { rows: 0, interior: [0; TILE], arc: [0; TILE], distance: [[0.0; TILE]; TILE], turn: [[0.0; TILE]; TILE] }
    }

    /// Fills the rows whose bit is set; without `ARCS` none has a cell on the arc; distances and angles only with `polar`.
    #[inline(always)]
    pub(super) fn fill<S: Simd, K: Kernel, const ARCS: bool>(
        &mut self,
        frame: &Frame,
        place: &Place,
        (entry, cone): (&Entry, &Cone),
        sight: &Sight<S>,
        rows: u32,
        polar: bool,
    ) {
        let columns = 0xffffu32 >> (TILE - place.columns.min(TILE));
        self.rows = rows;
        // A loop each, without a branch or a call that the others need.
        match (cone.flags & WIDE != 0, K::AXIS, entry.cone & INSIDE != 0) {
            (true, true, _) => {
                for y in Bits(rows) {
                    self.set::<S, true>(y, &sight.wide_axis_row(cone, y), columns, None);
                }
            }
            (true, false, _) => {
                for y in Bits(rows) {
                    self.set::<S, true>(y, &sight.wide_row(cone, y), columns, polar.then_some((frame, cone)));
                }
            }
            (false, true, _) => {
                let axis = sight.axis(cone);
                for y in Bits(rows) {
                    self.set::<S, true>(y, &sight.axis_row(&axis, y), columns, None);
                }
            }
            (false, false, true) => {
                for y in Bits(rows) {
                    self.set::<S, ARCS>(y, &sight.inside_row(y), columns, polar.then_some((frame, cone)));
                }
            }
            (false, false, false) => {
                for y in Bits(rows) {
                    self.set::<S, ARCS>(y, &sight.cone_row::<ARCS>(cone, y), columns, polar.then_some((frame, cone)));
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
