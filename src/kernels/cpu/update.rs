//! Updates that features made of readings: a tile's list of them, in order, row by row; twin of `shaders/driver/update.wgsl`.

use super::reach::{AHEAD, Bits};
use super::walk::{Job, Plane, count_row};
use crate::cone::Sight;
use crate::layout::*;
use crate::method::features::{FREED, MARKS, OCCUPIED, Said, fuse_cells, mark};
use crate::method::odds;
use crate::profile;
use crate::update::{Rows, in_fan, on_lines};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16, mask32x16, u32x16};

/// Updates the tile's cells.
pub fn walk_updates(job: &Job, state: &mut [u32]) {
    let planes: &mut [Plane] = bytemuck::cast_slice_mut(state);
    dispatch!(Level::new(), simd => fuse(simd, job, planes));
}

/// A tile as an update sees it.
pub struct Place {
    /// Its first cell's centre from the sensor, units.
    v: [i32; 2],
    /// The columns and rows that the grid has of it, a bit each.
    within: [u32; 2],
}

impl Place {
    /// Of the tile with this lower left cell, in a grid of so many columns and rows.
    #[inline(always)]
    fn of(cone: &Cone, corner: [u32; 2], size: [u32; 2]) -> Place {
        let v = [0, 1].map(|k| CELL * corner[k] as i32 + CELL / 2 - cone.sensor[k]);
        Place { v, within: [0, 1].map(|k| 0xffff >> (TILE - TILE.min((size[k] - corner[k]) as usize))) }
    }
}

/// Who says what of a tile's cells.
pub struct Regions {
    /// The two parts and the routine part occupy these.
    pub occupied: [Rows; 3],
    /// They free these.
    pub freed: [Rows; 3],
    distance: [[f32; TILE]; TILE],
    turn: [[f32; TILE]; TILE],
}

impl Regions {
    /// Of nothing.
    pub fn new() -> Regions {
        let (none, zeros) = ([[0; TILE]; 3], [[0.0; TILE]; TILE]);
        Regions { occupied: none, freed: none, distance: zeros, turn: zeros }
    }

    /// A row's cells of which something is said.
    #[inline(always)]
    fn members(&self, y: usize) -> u32 {
        let [a, b, c] = [0, 1, 2].map(|k| self.occupied[k][y] | self.freed[k][y]);
        a | b | c
    }

    /// Whether something is said of a cell, and whether one is occupied.
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

/// Finds which cells of a tile (its lower left cell, the grid's size) an update reaches, without distances and angles.
pub fn regions(
    entry: &Entry,
    cone: &Cone,
    shapes: &Shapes,
    points: &[[i32; 2]],
    [corner, size]: [[u32; 2]; 2],
) -> Regions {
    let (place, mut seen) = (Place::of(cone, corner, size), Regions::new());
    dispatch!(Level::new(), simd => look::<_>(simd, None, &place, (entry, cone, shapes), points, &mut seen));
    seen
}

/// The cells that a shape of one fan holds, by the entry's slot.
#[inline(always)]
fn fan<S: Simd>(simd: S, place: &Place, shapes: &Shapes, k: usize, slot: u32, points: &[[i32; 2]]) -> Rows {
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

/// What an update says of a tile's cells; distances and angles only with a frame.
#[inline(always)]
fn look<S: Simd>(
    simd: S,
    frame: Option<&Frame>,
    place: &Place,
    (entry, cone, shapes): (&Entry, &Cone, &Shapes),
    points: &[[i32; 2]],
    seen: &mut Regions,
) {
    let [columns, rows] = place.within;
    let slot = entry.slot;
    for k in 0..2 {
        let mut lines = [0; TILE];
        if slot & LINES << k != 0 {
            lines = on_lines(simd, range(points, shapes.lines[k]), place.v);
        }
        let free = fan(simd, place, shapes, k, slot, points);
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
    let free = if shapes.flags & FREE_LIMIT != 0 { fan(simd, place, shapes, 2, slot, points) } else { all };
    let arc = if shapes.flags & ARC_LIMIT != 0 { fan(simd, place, shapes, 3, slot, points) } else { all };
    let sight = Sight::of(simd, cone, place.v, cone.flags & NO_ECHO == 0);
    let (inside, arcs) = (entry.cone & INSIDE != 0, entry.cone & ARC != 0);
    for y in Bits(if inside { rows } else { sight.rows(cone, false) & rows }) {
        let row = match (inside, arcs) {
            (true, _) => sight.inside_row(y),
            (false, true) => sight.cone_row::<true>(cone, y),
            (false, false) => sight.cone_row::<false>(cone, y),
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

#[inline(always)]
fn fuse<S: Simd>(simd: S, job: &Job, state: &mut [Plane]) {
    let frame = &{ *job.frame };
    let mut seen = Regions::new();
    for entries in job.entries.chunks(AHEAD) {
        for entry in entries {
            let (cone, shapes) = (&job.cones[entry.index()], &job.shapes[entry.index()]);
            let place = Place::of(cone, job.tile.corner, frame.size);
            look(simd, Some(frame), &place, (entry, cone, shapes), job.points, &mut seen);
            for y in 0..TILE {
                if seen.members(y) != 0 {
                    row(simd, frame, cone, shapes, &seen, state, y);
                }
            }
        }
        let planes = &mut state[2..];
        for y in 0..TILE {
            let mut cells = odds::load(simd, planes, y);
            odds::settle(&mut cells);
            odds::store(cells, planes, y);
        }
    }
}

/// Updates a row of cells.
#[inline(always)]
fn row<S: Simd>(simd: S, frame: &Frame, cone: &Cone, shapes: &Shapes, seen: &Regions, state: &mut [Plane], y: usize) {
    let none = mask32x16::splat(simd, false);
    let zero = f32x16::splat(simd, 0.0);
    let mut said = Said { occupied: [none; 3], freed: [none; 3], polar: [zero; 2] };
    let mut code = u32x16::splat(simd, 0);
    for k in 0..3 {
        said.occupied[k] = mask32x16::from_bitmask(simd, seen.occupied[k][y].into());
        said.freed[k] = mask32x16::from_bitmask(simd, seen.freed[k][y].into());
        let [occupied, freed] = [OCCUPIED, FREED].map(|bit| u32x16::splat(simd, bit << (2 * k)));
        let nothing = u32x16::splat(simd, 0);
        code |= said.occupied[k].select(occupied, said.freed[k].select(freed, nothing));
    }
    let arc = said.occupied[0] | said.occupied[1] | said.occupied[2];
    let member = arc | said.freed[0] | said.freed[1] | said.freed[2];
    if frame.mode & COUNT != 0 {
        count_row(simd, member & !arc, &mut state[0][y]);
        count_row(simd, arc, &mut state[1][y]);
    }
    let planes = &mut state[2..];
    let marks = u32x16::load_array(simd, planes[MARKS][y]);
    member.select(marks + mark(shapes.number, code), marks).store_array(&mut planes[MARKS][y]);
    let mut cells = odds::load(simd, planes, y);
    if seen.occupied[2][y] | seen.freed[2][y] != 0 {
        said.polar = [f32x16::load_array(simd, seen.distance[y]), f32x16::load_array(simd, seen.turn[y])];
        fuse_cells::<S, true>(simd, frame, cone, shapes, &said, &mut cells);
    } else {
        fuse_cells::<S, false>(simd, frame, cone, shapes, &said, &mut cells);
    }
    odds::store(cells, planes, y);
}
