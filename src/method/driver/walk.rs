//! The CPU's passes over readings: a tile's list of them, in log order, row by row; twins of `shaders/method/driver/*.wgsl`.

use super::job::{Job, Pass, ReadingJob, WrongInput};
use super::kernel::{Kernel, Plane};
use super::reach::{LOOKAHEAD, Lookahead, Place, Reach};
use crate::geometry::bits::Bits;
use crate::geometry::layout::*;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, mask32x16, u32x16};
use std::sync::atomic::Ordering;

/// The name of the SIMD level that this machine uses.
pub fn simd_level() -> String {
    format!("{:?}", Level::new()).split('(').next().unwrap_or_default().to_lowercase()
}

/// Runs a pass over a tile.
///
/// # Errors
/// [`WrongInput`] if the job has no readings.
pub fn walk<K: Kernel>(kernel: &K, pass: Pass, job: &Job, state: &mut [u32]) -> Result<(), WrongInput> {
    let (level, job) = (Level::new(), job.readings()?);
    let planes: &mut [Plane] = bytemuck::cast_slice_mut(state);
    match pass {
        Pass::Fuse => dispatch!(level, simd => fuse(simd, kernel, job, planes)),
        Pass::Weigh => dispatch!(level, simd => weigh(simd, kernel, job, planes)),
        Pass::Count => dispatch!(level, simd => count::<_, K>(simd, job)),
    }
    Ok(())
}

/// Updates the tile's cells.
#[inline(always)]
fn fuse<S: Simd, K: Kernel>(simd: S, kernel: &K, job: &ReadingJob, state: &mut [Plane]) {
    let place = Place::of(job);
    // Local copies let the compiler move the branches that depend on them out of the loops.
    let (kernel, frame) = (&{ *kernel }, &{ *job.frame });
    let (mut reach, mut lookahead) = (Reach::new(), Lookahead::new(simd));
    let polar = kernel.polar().then_some(frame);
    for entries in job.entries.chunks(LOOKAHEAD) {
        lookahead.look(simd, K::AXIS, &place, (job.cones, entries), false);
        for (entry, (edges, rows)) in entries.iter().zip(&lookahead.0) {
            let cone = &job.cones[entry.index()];
            let share = job.shares.get(cone.index as usize).copied().unwrap_or_default();
            let reading = Applied { frame, cone, share: &share };
            // Most tiles lie off the arc and use loops without it.
            if entry.cone & ARC != 0 {
                reach.fill::<S, K, true>(&place, (entry, cone), edges, *rows, polar);
                update_cells::<S, K, true>(simd, kernel, &reading, &reach, state);
            } else {
                reach.fill::<S, K, false>(&place, (entry, cone), edges, *rows, polar);
                update_cells::<S, K, false>(simd, kernel, &reading, &reach, state);
            }
        }
        let planes = &mut state[2..];
        for y in 0..TILE {
            let mut cells = K::load(simd, planes, y);
            kernel.renormalize(&mut cells);
            K::store(cells, planes, y);
        }
    }
}

/// A reading in the form in which a method applies it.
struct Applied<'a> {
    frame: &'a Frame,
    cone: &'a Cone,
    share: &'a [u32; 4],
}

/// Updates the rows that one reading reaches. Without `ARCS` no cell is on the arc.
#[inline(always)]
fn update_cells<S: Simd, K: Kernel, const ARCS: bool>(
    simd: S,
    kernel: &K,
    reading: &Applied,
    reach: &Reach,
    state: &mut [Plane],
) {
    let Applied { frame, cone, share } = *reading;
    let [interior, arc, planes @ ..] = state else { unreachable!("every method has the planes of both counts") };
    for y in Bits(reach.rows) {
        let mut row = reach.row(simd, y);
        if !ARCS {
            row.arc = mask32x16::splat(simd, false);
        }
        if frame.mode & COUNT != 0 {
            count_row(simd, row.interior, &mut interior[y]);
            if ARCS {
                count_row(simd, row.arc, &mut arc[y]);
            }
        }
        let mut cells = K::load(simd, planes, y);
        kernel.fuse_cells(frame, cone, &row, share, &mut cells);
        K::store(cells, planes, y);
    }
}

#[inline(always)]
pub(super) fn count_row<S: Simd>(simd: S, region: mask32x16<S>, counts: &mut [u32; TILE]) {
    let count = u32x16::load_array(simd, *counts);
    region.select(count + 1, count).store_array(counts);
}

/// Sums each reading's evidence on the tile's part of its arc in the same order as the GPU: within vectors of four cells of a
/// row, then down the columns of vectors, then across.
#[inline(always)]
fn weigh<S: Simd, K: Kernel>(simd: S, kernel: &K, job: &ReadingJob, state: &[Plane]) {
    let place = Place::of(job);
    let mut planes = state[2..].to_vec();
    let (mut reach, mut lookahead) = (Reach::new(), Lookahead::new(simd));
    let polar = kernel.polar().then_some(job.frame);
    for entries in job.entries.chunks(LOOKAHEAD) {
        lookahead.look(simd, K::AXIS, &place, (job.cones, entries), false);
        for (entry, (edges, rows)) in entries.iter().zip(&lookahead.0) {
            let cone = &job.cones[entry.index()];
            let mut columns = [0.0f32; 4];
            reach.fill::<S, K, true>(&place, (entry, cone), edges, *rows, polar);
            for y in Bits(reach.rows) {
                let row = reach.row(simd, y);
                let mut cells = K::load(simd, &planes, y);
                let evidence = kernel.weigh_cells(job.frame, cone, &row, &mut cells);
                K::store(cells, &mut planes, y);
                if row.arc.any_true() {
                    let e = evidence.to_array();
                    for g in 0..4 {
                        columns[g] += (e[4 * g] + e[4 * g + 1]) + (e[4 * g + 2] + e[4 * g + 3]);
                    }
                }
            }
            if entry.cone & ARC != 0 {
                let sum = (columns[0] + columns[1]) + (columns[2] + columns[3]);
                job.parts[entry.slot as usize].store(sum.to_bits(), Ordering::Relaxed);
            }
        }
    }
}

/// Counts the arc cells of each reading.
#[inline(always)]
fn count<S: Simd, K: Kernel>(simd: S, job: &ReadingJob) {
    let place = Place::of(job);
    let (mut reach, mut lookahead) = (Reach::new(), Lookahead::new(simd));
    // Only entries with this flag have arc cells.
    let arcs: Vec<Entry> = job.entries.iter().copied().filter(|e| e.cone & ARC != 0).collect();
    for entries in arcs.chunks(LOOKAHEAD) {
        lookahead.look(simd, K::AXIS, &place, (job.cones, entries), true);
        for (entry, (edges, rows)) in entries.iter().zip(&lookahead.0) {
            let cone = &job.cones[entry.index()];
            reach.fill::<S, K, true>(&place, (entry, cone), edges, *rows, None);
            let cells: u32 = Bits(reach.rows).map(|y| reach.arc[y].count_ones()).sum();
            if cells > 0 {
                job.parts[cone.index as usize].fetch_add(cells, Ordering::Relaxed);
            }
        }
    }
}
