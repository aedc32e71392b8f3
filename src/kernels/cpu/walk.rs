//! The drivers of the CPU's passes: a tile's list of readings, in log order, row by row; twins of `shaders/driver/*.wgsl`.

use crate::cone::{Row, Rows, axis_row, cone_row, inside_row, rows};
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

/// A tile and the part of it that lies in the grid.
struct Place {
    corner: [i32; 2],
    columns: usize,
    rows: usize,
}

impl Place {
    #[inline(always)]
    fn of(job: &Job) -> Place {
        let [width, height] = job.frame.size;
        let [x, y] = job.tile.corner;
        Place { corner: [x as i32, y as i32], columns: (width - x) as usize, rows: TILE.min((height - y) as usize) }
    }

    /// The first cell's centre from the sensor.
    #[inline(always)]
    fn first(&self, cone: &Cone) -> [i32; 2] {
        [0, 1].map(|k| CELL * self.corner[k] + CELL / 2 - cone.sensor[k])
    }

    /// The rows to look at.
    #[inline(always)]
    fn rows<K: Kernel>(&self, entry: &Entry, cone: &Cone) -> Rows {
        if entry.cone & INSIDE != 0 {
            return Rows { some: 0xffff, all: 0xffff };
        }
        let Rows { some, all } = rows(cone, self.first(cone), K::AXIS);
        Rows { some: some & (0xffff >> (TILE - self.rows)), all }
    }

    /// Row `y` of the tile as the cone sees it; `None` if it has no cell there.
    #[inline(always)]
    fn row<K: Kernel>(&self, all: u32, cone: &Cone, y: usize, keep_no_echo: bool) -> Option<Row> {
        let first = self.first(cone);
        let v = [first[0], first[1] + CELL * y as i32];
        let mut row = if all >> y & 1 != 0 {
            inside_row(cone, v)
        } else if K::AXIS {
            axis_row(cone, v)?
        } else {
            cone_row(cone, v)?
        };
        if self.columns < TILE {
            row.clip(self.columns);
        }
        if cone.flags & NO_ECHO != 0 && !keep_no_echo {
            row.arc = [0; TILE];
        }
        Some(row)
    }
}

/// Updates the tile's cells.
#[inline(always)]
fn fuse<K: Kernel>(kernel: &K, job: &Job, state: &mut [[u32; TILE]]) {
    let place = Place::of(job);
    let (counts, planes) = state.split_at_mut(2 * TILE);
    // Copies, so that they live in registers.
    let frame = &{ *job.frame };
    let counting = frame.mode & COUNT != 0;
    for entry in job.entries {
        let cone = &{ job.cones[entry.index()] };
        let share = job.shares.get(cone.index as usize).copied().unwrap_or_default();
        let Rows { mut some, all } = place.rows::<K>(entry, cone);
        while some != 0 {
            let y = some.trailing_zeros() as usize;
            some &= some - 1;
            let Some(row) = place.row::<K>(all, cone, y, false) else { continue };
            if counting {
                for k in 0..TILE {
                    counts[y][k] += row.interior[k];
                    counts[TILE + y][k] += row.arc[k];
                }
            }
            let mut cells = K::load(planes, y);
            kernel.fuse(frame, cone, &row, &share, &mut cells);
            K::store(&cells, planes, y);
        }
    }
}

/// Sums each reading's evidence on the tile's part of its arc: four cells of a row at a time as the GPU's threads do, down
/// the columns of threads, then across.
#[inline(always)]
fn weigh<K: Kernel>(kernel: &K, job: &Job, state: &[[u32; TILE]]) {
    let place = Place::of(job);
    let frame = &{ *job.frame };
    let mut planes = state[2 * TILE..].to_vec();
    for entry in job.entries {
        let cone = &{ job.cones[entry.index()] };
        let mut columns = [0.0f32; 4];
        let Rows { mut some, all } = place.rows::<K>(entry, cone);
        while some != 0 {
            let y = some.trailing_zeros() as usize;
            some &= some - 1;
            let Some(row) = place.row::<K>(all, cone, y, false) else { continue };
            let mut cells = K::load(&planes, y);
            let e = kernel.weigh(frame, cone, &row, &mut cells);
            K::store(&cells, &mut planes, y);
            for g in 0..4 {
                columns[g] += (e[4 * g] + e[4 * g + 1]) + (e[4 * g + 2] + e[4 * g + 3]);
            }
        }
        if entry.cone & ARC != 0 {
            let sum = (columns[0] + columns[1]) + (columns[2] + columns[3]);
            job.parts[entry.slot as usize].store(sum.to_bits(), Ordering::Relaxed);
        }
    }
}

/// Counts the arc cells of each reading.
#[inline(always)]
fn count<K: Kernel>(job: &Job) {
    let place = Place::of(job);
    for entry in job.entries.iter().filter(|e| e.cone & ARC != 0) {
        let cone = &{ job.cones[entry.index()] };
        let mut cells = 0;
        let Rows { mut some, all } = place.rows::<K>(entry, cone);
        while some != 0 {
            let y = some.trailing_zeros() as usize;
            some &= some - 1;
            if let Some(row) = place.row::<K>(all, cone, y, true) {
                cells += row.arc.iter().sum::<u32>();
            }
        }
        if cells > 0 {
            job.parts[cone.index as usize].fetch_add(cells, Ordering::Relaxed);
        }
    }
}
