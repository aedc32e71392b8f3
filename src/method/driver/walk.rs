//! The drivers of the CPU's passes: a tile's list of readings, in log order, row by row; twins of `shaders/method/driver/*.wgsl`.

use super::reach::{AHEAD, Ahead, Place, Reach, Reached};
use crate::geometry::bits::Bits;
use crate::geometry::layout::*;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16, mask32x16, u32x16};
use std::sync::atomic::{AtomicU32, Ordering};

/// One kernel over a chunk's tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pass {
    /// Σ of the evidence on each reading's arc, tile by tile, from emptiness alone.
    Weigh,
    /// Arc cells of each reading.
    Count,
    /// The update of the cells.
    Fuse,
}

/// A tile's work in one pass.
pub struct Job<'a> {
    /// The pass.
    pub frame: &'a Frame,
    /// The batch's cones.
    pub cones: &'a [Cone],
    /// The tile.
    pub tile: &'a Tile,
    /// Its entries, in log order.
    pub entries: &'a [Entry],
    /// Where parts of sums go, by the entry's slot; counts, by the cone's index.
    pub parts: &'a [AtomicU32],
    /// What the pass before found, for each cone.
    pub shares: &'a [[u32; 4]],
    /// The batch's scans, for methods that take them, …
    pub scans: &'a [Scan],
    /// … their beams, …
    pub beams: &'a [Beam],
    /// … and the centres of the chunk's columns and rows.
    pub centres: &'a [i32],
    /// For methods that take updates what they do beside their cones, …
    pub shapes: &'a [Shapes],
    /// … and their points.
    pub points: &'a [[i32; 2]],
}

/// A method's CPU half: the state of a row of cells, and what a reading does to it.
pub trait Kernel: Copy + Sync {
    /// A row of cells in registers.
    type Cells<S: Simd>: Copy;

    /// Whether the method looks at the axis' cells only.
    const AXIS: bool = false;

    /// A row of a tile from its planes, those of the two counts left out.
    fn load<S: Simd>(simd: S, planes: &[Plane], row: usize) -> Self::Cells<S>;

    /// And back.
    fn store<S: Simd>(cells: Self::Cells<S>, planes: &mut [Plane], row: usize);

    /// Whether the method looks at distance and angle.
    fn polar(&self) -> bool {
        false
    }

    /// What a reading does to a row.
    fn fuse<S: Simd>(&self, frame: &Frame, cone: &Cone, row: &Reached<S>, share: &[u32; 4], cells: &mut Self::Cells<S>);

    /// Brings the cells to their one form, at least once in 16 updates: updates may leave the same value in several.
    #[inline(always)]
    fn settle<S: Simd>(&self, _: &mut Self::Cells<S>) {}

    /// A reading's evidence on its arc before it is normalised, and what of the update it depends on.
    fn weigh<S: Simd>(&self, _: &Frame, _: &Cone, row: &Reached<S>, _: &mut Self::Cells<S>) -> f32x16<S> {
        f32x16::splat(row.distance.token(), 0.0)
    }
}

/// A tile's words of one kind, row by row.
pub type Plane = [[u32; TILE]; TILE];

/// The SIMD level that this machine runs.
pub fn simd_level() -> String {
    format!("{:?}", Level::new()).split('(').next().unwrap_or_default().to_lowercase()
}

/// Runs a pass over a tile.
pub fn walk<K: Kernel>(kernel: &K, pass: Pass, job: &Job, state: &mut [u32]) {
    let level = Level::new();
    let planes: &mut [Plane] = bytemuck::cast_slice_mut(state);
    match pass {
        Pass::Fuse => dispatch!(level, simd => fuse(simd, kernel, job, planes)),
        Pass::Weigh => dispatch!(level, simd => weigh(simd, kernel, job, planes)),
        Pass::Count => dispatch!(level, simd => count::<_, K>(simd, job)),
    }
}

/// Updates the tile's cells.
#[inline(always)]
fn fuse<S: Simd, K: Kernel>(simd: S, kernel: &K, job: &Job, state: &mut [Plane]) {
    let place = Place::of(job);
    // Copies, so that what they decide is decided outside the loops.
    let (kernel, frame) = (&{ *kernel }, &{ *job.frame });
    let Some(([interior, arc], planes)) = state.split_first_chunk_mut::<2>() else { return };
    let (mut reach, mut ahead, polar) = (Reach::new(), Ahead::new(simd), kernel.polar());
    for entries in job.entries.chunks(AHEAD) {
        ahead.look(simd, K::AXIS, &place, job, entries, false);
        for (entry, (sight, rows)) in entries.iter().zip(&ahead.0) {
            let cone = &job.cones[entry.index()];
            let share = job.shares.get(cone.index as usize).copied().unwrap_or_default();
            // Most tiles lie off the arc: theirs are loops without it.
            if entry.cone & ARC != 0 {
                reach.fill::<S, K, true>(frame, &place, (entry, cone), sight, *rows, polar);
                update::<S, K, true>(simd, kernel, frame, cone, &share, &reach, [&mut *interior, &mut *arc], planes);
            } else {
                reach.fill::<S, K, false>(frame, &place, (entry, cone), sight, *rows, polar);
                update::<S, K, false>(simd, kernel, frame, cone, &share, &reach, [&mut *interior, &mut *arc], planes);
            }
        }
        for y in 0..TILE {
            let mut cells = K::load(simd, planes, y);
            kernel.settle(&mut cells);
            K::store(cells, planes, y);
        }
    }
}

/// Updates the rows that one reading reaches; without `ARCS` none has a cell on its arc.
#[allow(clippy::too_many_arguments, reason = "a loop's body")]
#[inline(always)]
fn update<S: Simd, K: Kernel, const ARCS: bool>(
    simd: S,
    kernel: &K,
    frame: &Frame,
    cone: &Cone,
    share: &[u32; 4],
    reach: &Reach,
    [interior, arc]: [&mut Plane; 2],
    planes: &mut [Plane],
) {
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
        kernel.fuse(frame, cone, &row, share, &mut cells);
        K::store(cells, planes, y);
    }
}

#[inline(always)]
pub(super) fn count_row<S: Simd>(simd: S, region: mask32x16<S>, counts: &mut [u32; TILE]) {
    let count = u32x16::load_array(simd, *counts);
    region.select(count + 1, count).store_array(counts);
}

/// Sums each reading's evidence on the tile's part of its arc: four cells of a row at a time as the GPU does, down the
/// columns of such groups, then across.
#[inline(always)]
fn weigh<S: Simd, K: Kernel>(simd: S, kernel: &K, job: &Job, state: &[Plane]) {
    let place = Place::of(job);
    let mut planes = state[2..].to_vec();
    let (mut reach, mut ahead, polar) = (Reach::new(), Ahead::new(simd), kernel.polar());
    for entries in job.entries.chunks(AHEAD) {
        ahead.look(simd, K::AXIS, &place, job, entries, false);
        for (entry, (sight, rows)) in entries.iter().zip(&ahead.0) {
            let cone = &job.cones[entry.index()];
            let mut columns = [0.0f32; 4];
            reach.fill::<S, K, true>(job.frame, &place, (entry, cone), sight, *rows, polar);
            for y in Bits(reach.rows) {
                let row = reach.row(simd, y);
                let mut cells = K::load(simd, &planes, y);
                let evidence = kernel.weigh(job.frame, cone, &row, &mut cells);
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
fn count<S: Simd, K: Kernel>(simd: S, job: &Job) {
    let place = Place::of(job);
    let (mut reach, mut ahead) = (Reach::new(), Ahead::new(simd));
    // Only these have arc cells.
    let arcs: Vec<Entry> = job.entries.iter().copied().filter(|e| e.cone & ARC != 0).collect();
    for entries in arcs.chunks(AHEAD) {
        ahead.look(simd, K::AXIS, &place, job, entries, true);
        for (entry, (sight, rows)) in entries.iter().zip(&ahead.0) {
            let cone = &job.cones[entry.index()];
            reach.fill::<S, K, true>(job.frame, &place, (entry, cone), sight, *rows, false);
            let cells: u32 = Bits(reach.rows).map(|y| reach.arc[y].count_ones()).sum();
            if cells > 0 {
                job.parts[cone.index as usize].fetch_add(cells, Ordering::Relaxed);
            }
        }
    }
}
