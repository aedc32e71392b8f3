//! The CPU's pass over scans: a cell takes the nearest beam of each of its nearest poses, in log order; twin of
//! `shaders/method/driver/scan.wgsl`.
//!
//! The 16 cells of a row find their nearest poses together. The search for a cell's beam starts from the beam of the cell before.

use super::job::{Job, ScanJob, WrongInput};
use super::kernel::Plane;
use crate::binning::scan::{before, place};
use crate::geometry::layout::*;
use crate::method::csm::{Row, update};
use crate::method::settings::Csm;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f64x8};

/// Updates a tile's cells with the scans of its list.
///
/// # Errors
/// [`WrongInput`] if the job has no scans.
pub fn walk_scans(csm: &Csm, job: &Job, state: &mut [u32]) -> Result<(), WrongInput> {
    let (job, planes): (_, &mut [Plane]) = (job.scans()?, bytemuck::cast_slice_mut(state));
    dispatch!(Level::new(), simd => fuse(simd, csm, job, planes));
    Ok(())
}

/// Squared distances of a row's cells, µm². f64 holds them exactly for distances below 90 m.
type Squares = [f64; TILE];

#[inline(always)]
fn fuse<S: Simd>(simd: S, csm: &Csm, job: &ScanJob, planes: &mut [Plane]) {
    let from = job.tile.corner.map(|c| c as usize % (TILE * CHUNK));
    let [columns, rows] = [0, 1].map(|k| TILE.min((job.frame.size[k] - job.tile.corner[k]) as usize));
    let (xs, ys) = job.centres.split_at(TILE * CHUNK);
    let xs = &xs[from[0]..from[0] + TILE];
    let scans: Vec<(&Entry, &Scan)> = job.entries.iter().map(|e| (e, &job.scans[e.index()])).collect();
    let poses: Vec<[f64; 2]> = scans.iter().map(|(_, s)| s.pose.map(f64::from)).collect();
    let across: [f64; TILE] = std::array::from_fn(|k| f64::from(xs[k]));
    let farthest = f64::from(job.frame.limits[0]) * f64::from(job.frame.limits[0]);
    let mut nearest: Vec<Halves<S>> = vec![[f64x8::splat(simd, 0.0); 2]; csm.neighbours.map_or(0, usize::from)];
    for row in 0..rows {
        let up = f64::from(ys[from[1] + row]);
        let (last, mut ties) = nth(simd, &poses, &across, up, &mut nearest);
        for ((entry, scan), pose) in scans.iter().zip(&poses) {
            let squares = squares(*pose, &across, up);
            let (mut taken, mut touched) = ([false; TILE], false);
            for k in 0..columns {
                let tied = squares[k] == last[k];
                taken[k] = squares[k] < last[k] || (tied && ties[k] > 0);
                ties[k] -= u32::from(tied && ties[k] > 0);
                taken[k] &= squares[k] < farthest && squares[k] > 0.0;
                touched |= taken[k];
            }
            if touched {
                let row = Taken { line: row, y: ys[from[1] + row], squares: &squares, taken: &taken };
                contributing_beams((csm, job), (entry, scan), xs, &row, planes);
            }
        }
    }
}

#[inline(always)]
fn squares(pose: [f64; 2], across: &[f64; TILE], up: f64) -> Squares {
    let y = up - pose[1];
    let mut squares = [0.0; TILE];
    for k in 0..TILE {
        let x = across[k] - pose[0];
        squares[k] = x * x + y * y;
    }
    squares
}

/// Each cell's n-th smallest square, and how many of the poses at that distance are among the n nearest, where earlier poses
/// come first. `nearest` is scratch memory for n rows of squares.
#[inline(always)]
fn nth<S: Simd>(
    simd: S,
    poses: &[[f64; 2]],
    across: &[f64; TILE],
    up: f64,
    nearest: &mut [Halves<S>],
) -> (Squares, [u32; TILE]) {
    let Some(n) = nearest.len().checked_sub(1) else { return ([f64::INFINITY; TILE], [0; TILE]) };
    for held in nearest.iter_mut() {
        *held = [f64x8::splat(simd, f64::INFINITY); 2];
    }
    let (left, right) = across.split_at(TILE / 2);
    let across = [f64x8::from_slice(simd, left), f64x8::from_slice(simd, right)];
    for pose in poses {
        let (x, y) = ([across[0] - pose[0], across[1] - pose[0]], up - pose[1]);
        let mut value = [x[0] * x[0] + y * y, x[1] * x[1] + y * y];
        let nearer = [value[0].simd_lt(nearest[n][0]), value[1].simd_lt(nearest[n][1])];
        if nearer[0].any_true() || nearer[1].any_true() {
            for held in nearest.iter_mut() {
                let before = *held;
                *held = [before[0].min(value[0]), before[1].min(value[1])];
                value = [before[0].max(value[0]), before[1].max(value[1])];
            }
        }
    }
    let (mut last, mut ties) = ([0.0; TILE], [0; TILE]);
    nearest[n][0].store_slice(&mut last[..TILE / 2]);
    nearest[n][1].store_slice(&mut last[TILE / 2..]);
    for held in nearest.iter() {
        let mut one = [0.0; TILE];
        held[0].store_slice(&mut one[..TILE / 2]);
        held[1].store_slice(&mut one[TILE / 2..]);
        for k in 0..TILE {
            ties[k] += u32::from(one[k] == last[k]);
        }
    }
    (last, ties)
}

/// The squared distances of a row, in two halves.
type Halves<S> = [f64x8<S>; 2];

/// Index that stands for "no beam".
const NONE: u32 = u32::MAX;

/// The cells of a row that take a scan.
struct Taken<'a> {
    /// Index of the row in the tile.
    line: usize,
    /// The y coordinate of the row's cell centres, µm.
    y: i32,
    squares: &'a Squares,
    taken: &'a [bool; TILE],
}

/// Updates each cell of a row that takes a scan with the scan's beam that is nearest to the cell.
#[inline(always)]
fn contributing_beams(
    (csm, job): (&Csm, &ScanJob),
    (entry, scan): (&Entry, &Scan),
    xs: &[i32],
    row: &Taken,
    planes: &mut [Plane],
) {
    let Taken { line, y, squares, taken } = *row;
    let beams = &job.beams[scan.first as usize..][..scan.count as usize];
    let (low, high) = (entry.slot & 0xffff, entry.slot >> 16);
    let y = y - scan.pose[1];
    let mut seen = Row { x: [0.0; TILE], y: f64::from(y), squares: *squares, taken: [0; TILE], line };
    for k in 0..TILE {
        seen.x[k] = f64::from(xs[k].wrapping_sub(scan.pose[0]));
    }
    // The index of each cell's beam. Along a row the bearings turn one way only, so the next cell's beam is near.
    let mut found = [NONE; TILE];
    let mut at = NONE;
    for k in 0..TILE {
        if !taken[k] {
            continue;
        }
        let v = [xs[k] - scan.pose[0], y];
        if at == NONE {
            at = place(beams, v, low, high);
        }
        while at < high && before(&beams[at as usize], v) {
            at += 1;
        }
        while at > low && !before(&beams[at as usize - 1], v) {
            at -= 1;
        }
        found[k] = at;
    }
    // Cells that take the same beam are updated together. Cells that take no beam may lie between them.
    let mut next = 0;
    while next < TILE {
        let at = found[next];
        if at == NONE {
            next += 1;
            continue;
        }
        for k in 0..TILE {
            seen.taken[k] = u32::from(found[k] == at);
        }
        let beam = &beams[if at == scan.count { 0 } else { at as usize }];
        update(csm, job.frame, scan.number, beam, &seen, planes);
        while next < TILE && (found[next] == at || found[next] == NONE) {
            next += 1;
        }
    }
}
