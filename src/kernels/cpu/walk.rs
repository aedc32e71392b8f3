//! The drivers of the CPU's passes: a tile's list of readings, in log order, row by row; twins of `shaders/driver/*.wgsl`.

use crate::cone::{Row, Rows, Sight};
use crate::layout::*;
use crate::method::Pass;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16, u32x16};
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
    type Cells<S: Simd>: Copy;

    /// Whether the method looks at the axis' cells only.
    const AXIS: bool = false;

    /// A row of a tile from its planes, which come row by row, those of the two counts left out.
    fn load<S: Simd>(simd: S, planes: &[[u32; TILE]], row: usize) -> Self::Cells<S>;

    /// And back.
    fn store<S: Simd>(cells: Self::Cells<S>, planes: &mut [[u32; TILE]], row: usize);

    /// What a reading does to a row.
    fn fuse<S: Simd>(&self, frame: &Frame, cone: &Cone, row: &Row<S>, share: &[u32; 4], cells: &mut Self::Cells<S>);

    /// A reading's evidence on its arc before it is normalised, and what of the update it depends on.
    fn weigh<S: Simd>(&self, _: &Frame, _: &Cone, row: &Row<S>, _: &mut Self::Cells<S>) -> f32x16<S> {
        f32x16::splat(row.d2.token(), 0.0)
    }
}

/// A row of one plane, those of the two counts left out.
#[inline(always)]
pub fn plane<S: Simd>(simd: S, planes: &[[u32; TILE]], plane: usize, row: usize) -> u32x16<S> {
    u32x16::load_array(simd, planes[plane * TILE + row])
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
        Pass::Fuse => dispatch!(level, simd => fuse(simd, kernel, job, rows)),
        Pass::Weigh => dispatch!(level, simd => weigh(simd, kernel, job, rows)),
        Pass::Count => dispatch!(level, simd => count::<_, K>(simd, job)),
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

    /// The tile as the cone sees it; a missing echo's arc only with `arcs`.
    #[inline(always)]
    fn sight<S: Simd>(&self, simd: S, cone: &Cone, arcs: bool) -> Sight<S> {
        let [i, j] = self.corner;
        let v = [CELL * i + CELL / 2 - cone.sensor[0], CELL * j + CELL / 2 - cone.sensor[1]];
        Sight::of(simd, cone, v, arcs || cone.flags & NO_ECHO == 0)
    }

    /// The tile's rows that have a member.
    #[inline(always)]
    fn members<'a, S: Simd>(&self, axis: bool, entry: &Entry, cone: &'a Cone, sight: &'a Sight<S>) -> Members<'a, S> {
        let mut left = Rows { some: 0xffff, all: 0xffff };
        if entry.cone & INSIDE == 0 {
            left = sight.rows(cone, axis);
            left.some &= 0xffff >> (TILE - self.rows);
        }
        Members { axis, columns: self.columns, cone, sight, left }
    }
}

/// A cone's rows of a tile, one by one.
struct Members<'a, S: Simd> {
    axis: bool,
    columns: usize,
    cone: &'a Cone,
    sight: &'a Sight<S>,
    /// Rows still to be looked at.
    left: Rows,
}

impl<S: Simd> Iterator for Members<'_, S> {
    /// A row's number, and the row.
    type Item = (usize, Row<S>);

    #[inline(always)]
    fn next(&mut self) -> Option<(usize, Row<S>)> {
        while self.left.some != 0 {
            let y = self.left.some.trailing_zeros() as usize;
            self.left.some &= self.left.some - 1;
            let row = if self.axis {
                self.sight.axis_row(self.cone, y)
            } else if self.left.all >> y & 1 != 0 {
                Some(self.sight.inside_row(self.cone, y))
            } else {
                self.sight.cone_row(self.cone, y)
            };
            if let Some(mut row) = row {
                if self.columns < TILE {
                    row.clip(self.columns);
                }
                return Some((y, row));
            }
        }
        None
    }
}

/// Updates the tile's cells.
#[inline(always)]
fn fuse<S: Simd, K: Kernel>(simd: S, kernel: &K, job: &Job, state: &mut [[u32; TILE]]) {
    let place = Place::of(job);
    let (counts, planes) = state.split_at_mut(2 * TILE);
    // Copies, so that they live in registers.
    let frame = &{ *job.frame };
    let counting = frame.mode & COUNT != 0;
    for entry in job.entries {
        let cone = &{ job.cones[entry.index()] };
        let share = job.shares.get(cone.index as usize).copied().unwrap_or_default();
        let sight = place.sight(simd, cone, false);
        for (y, row) in place.members(K::AXIS, entry, cone, &sight) {
            if counting {
                for (plane, region) in [(0, row.interior), (TILE, row.arc)] {
                    let count = u32x16::load_array(simd, counts[plane + y]);
                    region.select(count + 1, count).store_array(&mut counts[plane + y]);
                }
            }
            let mut cells = K::load(simd, planes, y);
            kernel.fuse(frame, cone, &row, &share, &mut cells);
            K::store(cells, planes, y);
        }
    }
}

/// Sums each reading's evidence on the tile's part of its arc: four cells of a row at a time as the GPU's threads do, down
/// the columns of threads, then across.
#[inline(always)]
fn weigh<S: Simd, K: Kernel>(simd: S, kernel: &K, job: &Job, state: &[[u32; TILE]]) {
    let place = Place::of(job);
    let frame = &{ *job.frame };
    let mut planes = state[2 * TILE..].to_vec();
    for entry in job.entries {
        let cone = &{ job.cones[entry.index()] };
        let mut columns = [0.0f32; 4];
        let sight = place.sight(simd, cone, false);
        for (y, row) in place.members(K::AXIS, entry, cone, &sight) {
            let mut cells = K::load(simd, &planes, y);
            let evidence = kernel.weigh(frame, cone, &row, &mut cells);
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

/// Counts the arc cells of each reading.
#[inline(always)]
fn count<S: Simd, K: Kernel>(simd: S, job: &Job) {
    let place = Place::of(job);
    for entry in job.entries.iter().filter(|e| e.cone & ARC != 0) {
        let cone = &{ job.cones[entry.index()] };
        let mut cells = 0;
        let sight = place.sight(simd, cone, true);
        for (_, row) in place.members(K::AXIS, entry, cone, &sight) {
            cells += row.arc.to_bitmask().count_ones();
        }
        if cells > 0 {
            job.parts[cone.index as usize].fetch_add(cells, Ordering::Relaxed);
        }
    }
}
