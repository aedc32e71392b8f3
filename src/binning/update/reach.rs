//! The cells of a tile that an update reaches: those of its fans and lines, and of its cone; twin of
//! `shaders/binning/update/reach.wgsl`.

use super::region::{Rows, in_fan, on_lines};
use crate::geometry::bits::Bits;
use crate::geometry::cone::EdgeFunctions;
use crate::geometry::layout::*;
use crate::geometry::profile;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

/// An update in a tile's list, with its entry, cone, shapes and points.
pub(crate) struct Update<'a> {
    pub entry: &'a Entry,
    pub cone: &'a Cone,
    pub shapes: &'a Shapes,
    pub points: &'a [[i32; 2]],
}

/// The position of a tile relative to an update's sensor.
pub(crate) struct Place {
    /// Centre of the tile's first cell, units from the sensor.
    v: [i32; 2],
    /// Bit masks of the tile's columns and of its rows that lie in the grid.
    within: [u32; 2],
}

impl Place {
    /// The position of the tile with the lower left cell `corner`, in a grid of `size` columns and rows.
    #[inline(always)]
    pub fn of(cone: &Cone, corner: [u32; 2], size: [u32; 2]) -> Place {
        let v = [0, 1].map(|k| CELL * corner[k] as i32 + CELL / 2 - cone.sensor[k]);
        Place { v, within: [0, 1].map(|k| 0xffff >> (TILE - TILE.min((size[k] - corner[k]) as usize))) }
    }
}

/// The cells of a tile that each source of an update occupies or frees. The sources are the first part, the second part
/// and the routine part.
pub(crate) struct Regions {
    /// Cells that each source occupies.
    pub occupied: [Rows; 3],
    /// Cells that each source frees.
    pub freed: [Rows; 3],
    /// Distances from the sensor, metres, of the cells that the routine part updates.
    pub distance: [[f32; TILE]; TILE],
    /// Off-axis angles over β of the cells that the routine part updates.
    pub turn: [[f32; TILE]; TILE],
}

impl Regions {
    /// Regions without cells.
    pub fn new() -> Regions {
        let (none, zeros) = ([[0; TILE]; 3], [[0.0; TILE]; TILE]);
        Regions { occupied: none, freed: none, distance: zeros, turn: zeros }
    }

    /// A bit mask of the cells of row `y` that any source updates.
    #[inline(always)]
    pub fn members(&self, y: usize) -> u32 {
        let [a, b, c] = [0, 1, 2].map(|k| self.occupied[k][y] | self.freed[k][y]);
        a | b | c
    }

    /// Whether any cell is updated, and whether any is occupied.
    pub fn any(&self) -> (bool, bool) {
        let some = |rows: &Rows| rows.iter().any(|row| *row != 0);
        let arc = self.occupied.iter().any(some);
        (arc || self.freed.iter().any(some), arc)
    }
}

impl Default for Regions {
    fn default() -> Self {
        Regions::new()
    }
}

/// Finds the cells of a tile that an update reaches, without distances and angles. The last argument is the tile's lower left
/// cell and the grid's size.
pub(crate) fn regions(
    entry: &Entry,
    cone: &Cone,
    shapes: &Shapes,
    points: &[[i32; 2]],
    [corner, size]: [[u32; 2]; 2],
) -> Regions {
    let (place, mut seen) = (Place::of(cone, corner, size), Regions::new());
    let update = Update { entry, cone, shapes, points };
    dispatch!(Level::new(), simd => look_at::<_>(simd, None, &place, &update, &mut seen));
    seen
}

/// The cells in fan `k`, decided by the entry's slot where possible.
#[inline(always)]
fn fan<S: Simd>(simd: S, place: &Place, update: &Update, k: usize) -> Rows {
    let Update { entry: Entry { slot, .. }, shapes, points, .. } = *update;
    if slot & FULL << k != 0 {
        [0xffff; TILE]
    } else if slot & FAN << k != 0 {
        in_fan(simd, range(points, shapes.fans[k]), place.v)
    } else {
        [0; TILE]
    }
}

#[inline(always)]
fn range(points: &[[i32; 2]], [from, to]: [u32; 2]) -> &[[i32; 2]] {
    &points[from as usize..to as usize]
}

/// Finds the cells that each source updates. Distances and angles are computed only with a frame.
#[inline(always)]
pub(crate) fn look_at<S: Simd>(simd: S, frame: Option<&Frame>, place: &Place, update: &Update, seen: &mut Regions) {
    let Update { entry, cone, shapes, points } = *update;
    let [columns, rows] = place.within;
    let slot = entry.slot;
    for k in 0..2 {
        let mut lines = [0; TILE];
        if slot & LINES << k != 0 {
            lines = on_lines(simd, range(points, shapes.lines[k]), place.v);
        }
        let free = fan(simd, place, update, k);
        for y in 0..TILE {
            let within = if rows >> y & 1 != 0 { columns } else { 0 };
            seen.occupied[k][y] = lines[y] & within;
            seen.freed[k][y] = free[y] & !lines[y] & within;
        }
    }
    (seen.occupied[2], seen.freed[2]) = ([0; TILE], [0; TILE]);
    if slot & ROUTINE == 0 {
        return;
    }
    let all = [0xffff; TILE];
    let free = if shapes.flags & FREE_LIMIT != 0 { fan(simd, place, update, 2) } else { all };
    let arc = if shapes.flags & ARC_LIMIT != 0 { fan(simd, place, update, 3) } else { all };
    let edges = EdgeFunctions::of(simd, cone, place.v, cone.flags & NO_ECHO == 0);
    let (inside, arcs) = (entry.cone & INSIDE != 0, entry.cone & ARC != 0);
    for y in Bits(if inside { rows } else { edges.rows(cone, false) & rows }) {
        let row = match (inside, arcs) {
            (true, _) => edges.inside_row(y),
            (false, true) => edges.cone_row::<true>(cone, y),
            (false, false) => edges.cone_row::<false>(cone, y),
        };
        seen.freed[2][y] = row.interior.to_bitmask() as u32 & columns & free[y];
        seen.occupied[2][y] = row.arc.to_bitmask() as u32 & columns & arc[y];
        if let Some(frame) = frame.filter(|_| seen.freed[2][y] | seen.occupied[2][y] != 0) {
            let (distance, turn) = profile::polar(frame, cone, &row);
            distance.store_array(&mut seen.distance[y]);
            turn.store_array(&mut seen.turn[y]);
        }
    }
}
