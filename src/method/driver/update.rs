//! The CPU's pass over updates: a tile's list of them, in log order, row by row; twin of `shaders/method/driver/update.wgsl`.

use super::job::{Job, UpdateJob, WrongInput};
use super::kernel::Plane;
use super::reach::LOOKAHEAD;
use super::walk::count_row;
use crate::binning::update::reach::{Place, Regions, Update, look_at};
use crate::geometry::layout::*;
use crate::method::features::{Contributions, FREED, MARKS, OCCUPIED, fuse_cells, mark};
use crate::method::odds;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16, mask32x16, u32x16};

/// Updates the tile's cells.
///
/// # Errors
/// [`WrongInput`] if the job has no updates.
pub fn walk_updates(job: &Job, state: &mut [u32]) -> Result<(), WrongInput> {
    let (job, planes): (_, &mut [Plane]) = (job.updates()?, bytemuck::cast_slice_mut(state));
    dispatch!(Level::new(), simd => fuse(simd, job, planes));
    Ok(())
}

#[inline(always)]
fn fuse<S: Simd>(simd: S, job: &UpdateJob, state: &mut [Plane]) {
    let frame = &{ *job.frame };
    let mut seen = Regions::new();
    for entries in job.entries.chunks(LOOKAHEAD) {
        for entry in entries {
            let (cone, shapes) = (&job.cones[entry.index()], &job.shapes[entry.index()]);
            let place = Place::of(cone, job.tile.corner, frame.size);
            let update = Update { entry, cone, shapes, points: job.points };
            look_at(simd, Some(frame), &place, &update, &mut seen);
            for y in 0..TILE {
                if seen.members(y) != 0 {
                    row(simd, (frame, &update), &seen, state, y);
                }
            }
        }
        let planes = &mut state[2..];
        for y in 0..TILE {
            let mut cells = odds::load(simd, planes, y);
            odds::renormalize(&mut cells);
            odds::store(cells, planes, y);
        }
    }
}

/// Updates a row of cells.
#[inline(always)]
fn row<S: Simd>(simd: S, (frame, update): (&Frame, &Update), seen: &Regions, state: &mut [Plane], y: usize) {
    let Update { cone, shapes, .. } = *update;
    let none = mask32x16::splat(simd, false);
    let zero = f32x16::splat(simd, 0.0);
    let mut contributions = Contributions { occupied: [none; 3], freed: [none; 3], polar: [zero; 2] };
    let mut code = u32x16::splat(simd, 0);
    for k in 0..3 {
        contributions.occupied[k] = mask32x16::from_bitmask(simd, seen.occupied[k][y].into());
        contributions.freed[k] = mask32x16::from_bitmask(simd, seen.freed[k][y].into());
        let [occupied, freed] = [OCCUPIED, FREED].map(|bit| u32x16::splat(simd, bit << (2 * k)));
        let nothing = u32x16::splat(simd, 0);
        code |= contributions.occupied[k].select(occupied, contributions.freed[k].select(freed, nothing));
    }
    let arc = contributions.occupied[0] | contributions.occupied[1] | contributions.occupied[2];
    let member = arc | contributions.freed[0] | contributions.freed[1] | contributions.freed[2];
    if frame.mode & COUNT != 0 {
        count_row(simd, member & !arc, &mut state[0][y]);
        count_row(simd, arc, &mut state[1][y]);
    }
    let planes = &mut state[2..];
    let marks = u32x16::load_array(simd, planes[MARKS][y]);
    member.select(marks + mark(shapes.number, code), marks).store_array(&mut planes[MARKS][y]);
    let mut cells = odds::load(simd, planes, y);
    if seen.occupied[2][y] | seen.freed[2][y] != 0 {
        contributions.polar = [f32x16::load_array(simd, seen.distance[y]), f32x16::load_array(simd, seen.turn[y])];
        fuse_cells::<S, true>(simd, frame, cone, shapes, &contributions, &mut cells);
    } else {
        fuse_cells::<S, false>(simd, frame, cone, shapes, &contributions, &mut cells);
    }
    odds::store(cells, planes, y);
}
