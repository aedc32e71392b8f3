//! The drivers of the CPU's passes: a tile's list of readings, in log order, row by row; twins of `shaders/driver/*.wgsl`.

use crate::cone::{Row, axis_row, cone_row, inside_row};
use crate::layout::*;
use crate::method::Pass;
use fearless_simd::{Level, dispatch};
use std::sync::atomic::{AtomicU32, Ordering};

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
}

/// A method's CPU half: the state of a row of cells, and what a reading does to it.
pub trait Kernel: Sync {
    /// A row of cells in registers.
    type Cells: Copy;

    /// Whether the method looks at the axis' cells only.
    const AXIS: bool = false;

    /// A row of a tile from its planes, which come row by row, those of the two counts left out.
    fn load(planes: &[[u32; TILE]], row: usize) -> Self::Cells;

    /// And back.
    fn store(cells: &Self::Cells, planes: &mut [[u32; TILE]], row: usize);

    /// What a reading does to a row.
    fn fuse(&self, frame: &Frame, cone: &Cone, row: &Row, share: &[u32; 4], cells: &mut Self::Cells);

    /// A reading's evidence on its arc before it is normalised, and what of the update it depends on.
    fn weigh(&self, _: &Frame, _: &Cone, _: &Row, _: &mut Self::Cells) -> [f32; TILE] {
        [0.0; TILE]
    }
}

/// The SIMD level that this machine runs.
pub fn simd_level() -> String {
    format!("{:?}", Level::new()).split('(').next().unwrap_or_default().to_lowercase()
}

/// Runs a pass over a tile.
pub fn walk<K: Kernel>(kernel: &K, pass: Pass, job: &Job, state: &mut [u32]) {
    let level = Level::new();
    let rows: &mut [[u32; TILE]] = bytemuck::cast_slice_mut(state);
    match pass {
        Pass::Fuse => dispatch!(level, _simd => fuse(kernel, job, rows)),
        Pass::Weigh => dispatch!(level, _simd => weigh(kernel, job, rows)),
        Pass::Count => dispatch!(level, _simd => count::<K>(job)),
    }
}

/// Calls `each` with every row of the tile that a cone of the list touches, in log order.
#[inline(always)]
fn rows<K: Kernel>(job: &Job, arcs_only: bool, keep_no_echo: bool, mut each: impl FnMut(&Entry, &Cone, usize, Row)) {
    let [width, height] = job.frame.size;
    let columns = (width - job.tile.corner[0]) as usize;
    let height = (height - job.tile.corner[1]) as usize;
    for entry in job.entries {
        if arcs_only && entry.cone & ARC == 0 {
            continue;
        }
        let cone = &job.cones[entry.index()];
        let first = [0, 1].map(|k| CELL * job.tile.corner[k] as i32 + CELL / 2 - cone.sensor[k]);
        for y in 0..TILE.min(height) {
            let v = [first[0], first[1] + CELL * y as i32];
            let row = if entry.cone & INSIDE != 0 {
                Some(inside_row(cone, v))
            } else if K::AXIS {
                axis_row(cone, v)
            } else {
                cone_row(cone, v)
            };
            let Some(mut row) = row else { continue };
            if columns < TILE {
                row.clip(columns);
            }
            if cone.flags & NO_ECHO != 0 && !keep_no_echo {
                row.arc = [false; TILE];
            }
            each(entry, cone, y, row);
        }
    }
}

/// Updates the tile's cells.
#[inline(always)]
fn fuse<K: Kernel>(kernel: &K, job: &Job, state: &mut [[u32; TILE]]) {
    let (counts, planes) = state.split_at_mut(2 * TILE);
    let counting = job.frame.mode & COUNT != 0;
    rows::<K>(job, false, false, |_, cone, y, row| {
        if counting {
            for k in 0..TILE {
                counts[y][k] += u32::from(row.interior[k]);
                counts[TILE + y][k] += u32::from(row.arc[k]);
            }
        }
        let mut cells = K::load(planes, y);
        let share = job.shares.get(cone.index as usize).copied().unwrap_or_default();
        kernel.fuse(job.frame, cone, &row, &share, &mut cells);
        K::store(&cells, planes, y);
    });
}

/// Sums each reading's evidence on the tile's part of its arc: down the columns, then across.
#[inline(always)]
fn weigh<K: Kernel>(kernel: &K, job: &Job, state: &[[u32; TILE]]) {
    let mut planes = state[2 * TILE..].to_vec();
    let mut columns = [0.0f32; TILE];
    let mut open: Option<u32> = None;
    let finish = |slot: Option<u32>, columns: &mut [f32; TILE]| {
        if let Some(slot) = slot {
            let group = |g: usize| (columns[g] + columns[g + 1]) + (columns[g + 2] + columns[g + 3]);
            let sum = (group(0) + group(4)) + (group(8) + group(12));
            job.parts[slot as usize].store(sum.to_bits(), Ordering::Relaxed);
            *columns = [0.0; TILE];
        }
    };
    rows::<K>(job, false, false, |entry, cone, y, row| {
        if open != Some(entry.slot) {
            finish(open, &mut columns);
            open = (entry.cone & ARC != 0).then_some(entry.slot);
        }
        let mut cells = K::load(&planes, y);
        let evidence = kernel.weigh(job.frame, cone, &row, &mut cells);
        K::store(&cells, &mut planes, y);
        for k in 0..TILE {
            columns[k] += evidence[k];
        }
    });
    finish(open, &mut columns);
}

/// Counts the arc cells of each reading.
#[inline(always)]
fn count<K: Kernel>(job: &Job) {
    rows::<K>(job, true, true, |_, cone, _, row| {
        let cells: u32 = row.arc.iter().map(|a| u32::from(*a)).sum();
        if cells > 0 {
            job.parts[cone.index as usize].fetch_add(cells, Ordering::Relaxed);
        }
    });
}
