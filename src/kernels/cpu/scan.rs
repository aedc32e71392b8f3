//! Each cell's nearest poses, of each the nearest beam, in log order; twin of `shaders/driver/scan.wgsl`.
//!
//! Here a row of 16 cells looks for its nearest poses together, and from one cell to the next the nearest beam is walked to.

use super::walk::{Job, Plane};
use crate::layout::*;
use crate::method::csm::{Cell, update};
use crate::method::settings::Csm;
use crate::scan::{before, place};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

/// Updates a tile's cells with the scans of its list.
pub fn walk_scans(csm: &Csm, job: &Job, state: &mut [u32]) {
    let planes: &mut [Plane] = bytemuck::cast_slice_mut(state);
    dispatch!(Level::new(), simd => tile(simd, csm, job, planes));
}

/// Squares of the distances of a row's cells, µm²; f64 holds them exactly while they are nearer than 90 m.
type Squares = [f64; TILE];

#[inline(always)]
fn tile<S: Simd>(_: S, csm: &Csm, job: &Job, planes: &mut [Plane]) {
    let from = job.tile.corner.map(|c| c as usize % (TILE * CHUNK));
    let [columns, rows] = [0, 1].map(|k| TILE.min((job.frame.size[k] - job.tile.corner[k]) as usize));
    let (xs, ys) = job.centres.split_at(TILE * CHUNK);
    let xs = &xs[from[0]..from[0] + TILE];
    let scans: Vec<(&Entry, &Scan)> = job.entries.iter().map(|e| (e, &job.scans[e.index()])).collect();
    let poses: Vec<[f64; 2]> = scans.iter().map(|(_, s)| s.pose.map(f64::from)).collect();
    let across: [f64; TILE] = std::array::from_fn(|k| f64::from(xs[k]));
    let farthest = f64::from(job.frame.limits[0]) * f64::from(job.frame.limits[0]);
    let mut nearest = vec![[0.0; TILE]; csm.neighbours.map_or(0, usize::from)];
    for row in 0..rows {
        let up = f64::from(ys[from[1] + row]);
        let (last, mut ties) = nth(&poses, &across, up, &mut nearest);
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
                beams_of(csm, job, entry, scan, [xs, &ys[from[1] + row..]], row, &taken, &squares, planes);
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

/// Each cell's n-th smallest square, and how many of those equal to it are among the n nearest: the earlier ones.
#[inline(always)]
fn nth(poses: &[[f64; 2]], across: &[f64; TILE], up: f64, nearest: &mut [Squares]) -> (Squares, [u32; TILE]) {
    let Some(n) = nearest.len().checked_sub(1) else { return ([f64::INFINITY; TILE], [0; TILE]) };
    nearest.fill([f64::INFINITY; TILE]);
    for pose in poses {
        let mut value = squares(*pose, across, up);
        let mut nearer = false;
        for k in 0..TILE {
            nearer |= value[k] < nearest[n][k];
        }
        if nearer {
            for held in nearest.iter_mut() {
                for k in 0..TILE {
                    let (a, b) = (held[k], value[k]);
                    held[k] = if a < b { a } else { b };
                    value[k] = if a < b { b } else { a };
                }
            }
        }
    }
    let last = nearest[n];
    let mut ties = [0; TILE];
    for held in nearest.iter() {
        for k in 0..TILE {
            ties[k] += u32::from(held[k] == last[k]);
        }
    }
    (last, ties)
}

/// Updates the taken cells of a row with the beam of a scan that is nearest to each.
#[allow(clippy::too_many_arguments, reason = "a loop's body")]
#[inline(always)]
fn beams_of(
    csm: &Csm,
    job: &Job,
    entry: &Entry,
    scan: &Scan,
    [xs, ys]: [&[i32]; 2],
    row: usize,
    taken: &[bool; TILE],
    squares: &Squares,
    planes: &mut [Plane],
) {
    let beams = &job.beams[scan.first as usize..][..scan.count as usize];
    let (low, high) = (entry.slot & 0xffff, entry.slot >> 16);
    let mut at = None;
    for k in 0..TILE {
        if !taken[k] {
            continue;
        }
        let v = [xs[k] - scan.pose[0], ys[0] - scan.pose[1]];
        let found = match at {
            None => place(beams, v, low, high),
            Some(mut at) => {
                while at < high && before(&beams[at as usize], v) {
                    at += 1;
                }
                while at > low && !before(&beams[at as usize - 1], v) {
                    at -= 1;
                }
                at
            }
        };
        at = Some(found);
        let beam = &beams[if found == scan.count { 0 } else { found as usize }];
        update(csm, job.frame, scan.number, beam, v, squares[k], Cell::of(planes, row, k));
    }
}
