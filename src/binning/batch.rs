//! Bins readings into tiles, in log order; `shaders/binning/list/tiles.wgsl` makes the same lists on a GPU.
//!
//! A batch is any number of readings. Each tile has a list of the cones that may touch it. One flag says that the arc may touch
//! the tile, another that all of the tile is interior. A list may hold a cone that does not touch the tile, but it never lacks one
//! that does: the kernels decide each cell exactly.

mod cone_tile_bounds;
mod input;
mod narrow;
mod shape;

pub use input::{Batch, ChunkList, ConeInput, Input, ScanInput, UpdateInput};

use crate::binning::snap::{Footprint, region};
use crate::geometry::layout::*;
use crate::grid::ChunkId;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use narrow::{Columns, Met, TILES};
use rayon::prelude::*;
use shape::{Extremes, Shape};
use std::collections::BTreeMap;
use std::ops::Range;

/// Default number of readings in a batch: enough to fill any machine, few enough to bin in little memory.
pub const BATCH: usize = 65_536;

/// The largest number of (cone, tile) pairs in a batch. The pairs take most of a batch's memory.
pub const PAIRS: usize = 1 << 22;

/// The parameters by which readings are binned.
#[derive(Debug, Clone, Copy)]
pub struct Binning {
    /// Columns and rows of the grid.
    pub size: [usize; 2],
    /// The cells that a reading may update.
    pub footprint: Footprint,
    /// Whether the arc of a reading without an echo is included (Dempster-Shafer counts its cells).
    pub no_echo_arcs: bool,
    /// The only chunk to bin into; `None`: all chunks.
    pub only: Option<ChunkId>,
}

/// The snapping function for [`Binning::of`] when the items are cones that are already snapped.
pub(crate) fn snapped(cone: &Cone) -> Option<Cone> {
    Some(*cone)
}

/// A (cone, tile) pair: the tile's slot in its chunk, and the entry.
pub(crate) type Pair = (u16, Entry);

/// The pairs of a run of consecutive readings: each chunk's in log order, with the index in the run at which each reading's
/// parts begin.
#[derive(Default)]
struct Run {
    chunks: BTreeMap<ChunkId, Vec<Pair>>,
    first_part: Vec<u32>,
    parts: u32,
}

impl Binning {
    /// Snaps items and bins their cones; where the backend `bins_tiles` itself, the cones are only sorted by chunk. Items without a
    /// cone are left out. Returns `None` if several items together have more than [`PAIRS`] pairs.
    pub fn of<T: Sync>(
        &self,
        items: &[T],
        snap: impl Fn(&T) -> Option<Cone> + Sync,
        bins_tiles: bool,
    ) -> Option<Batch> {
        let fits = |pairs: usize| items.len() == 1 || pairs <= PAIRS;
        if bins_tiles {
            return match self.bound_cones(items, &snap) {
                Ok(batch) => fits(batch.chunks.iter().map(ChunkList::pairs).sum()).then_some(batch),
                Err(cones) => self.of(&cones, snapped, false),
            };
        }
        // Each snapped reading, with the largest number of tiles that it may reach.
        let snap = |item| snap(item).map(|cone| (self.at_most(&cone), cone));
        let cones: Vec<_> = items.par_iter().with_min_len(256).map(snap).collect();
        let pairs = cones.iter().flatten().map(|s| s.0).sum();
        fits(pairs).then(|| self.bin(cones.into_iter().flatten().map(|s| s.1).collect()))
    }

    /// Number of tiles of the grid along x and y.
    fn tiles(&self) -> [i64; 2] {
        self.size.map(|s| s.div_ceil(TILE) as i64)
    }

    /// The largest number of tiles that a cone may reach: those of its box.
    pub fn at_most(&self, cone: &Cone) -> usize {
        let shape = Shape::of(cone, self.footprint);
        let [rows, columns] = self.spans(cone, &shape).map(|s| (s.end - s.start).max(0) as usize);
        rows * columns
    }

    /// The tile rows and tile columns of a cone's box.
    fn spans(&self, cone: &Cone, shape: &Shape) -> [Range<i64>; 2] {
        let edge = (TILE as i64) * i64::from(CELL);
        let tiles = self.tiles();
        [1, 0].map(|k| {
            let at = i64::from(cone.sensor[k]);
            let first = (shape.low[k] + at).div_euclid(edge).max(0);
            first..((shape.high[k] + at).div_euclid(edge) + 1).min(tiles[k])
        })
    }

    /// Bins snapped readings, which are given in log order.
    pub fn bin(&self, mut cones: Vec<Cone>) -> Batch {
        for (k, cone) in cones.iter_mut().enumerate() {
            cone.index = k as u32;
        }
        // Runs of readings are binned independently and joined in order, so the result does not depend on the split.
        let run = cones.len().div_ceil(4 * rayon::current_num_threads()).max(64);
        let runs: Vec<Run> = cones.par_chunks(run).map(|cones| self.run(cones)).collect();
        let mut first_part = Vec::with_capacity(cones.len() + 1);
        let mut places: BTreeMap<ChunkId, Vec<(&[Pair], u32)>> = BTreeMap::new();
        let mut before = 0;
        for run in &runs {
            first_part.extend(run.first_part.iter().map(|p| p + before));
            for (place, pairs) in run.chunks.iter().filter(|(_, pairs)| !pairs.is_empty()) {
                places.entry(*place).or_default().push((pairs, before));
            }
            before += run.parts;
        }
        first_part.push(before);
        let chunks = places.into_par_iter().map(|(chunk, pairs)| list(chunk, &pairs)).collect();
        Batch { chunks, input: Input::Cones(ConeInput { cones, first_part }) }
    }

    /// Bins a run of readings.
    fn run(&self, cones: &[Cone]) -> Run {
        dispatch!(Level::new(), simd => self.run_on(simd, cones))
    }

    #[inline(always)]
    fn run_on<S: Simd>(&self, simd: S, cones: &[Cone]) -> Run {
        let mut run = Run::default();
        for cone in cones {
            run.first_part.push(run.parts);
            self.reach(simd, cone, cones.len(), &mut run);
        }
        run
    }

    /// Adds a pair for every tile that the cone may touch, chunk by chunk and in each chunk tile row by tile row. The sum over the
    /// cone's arc is therefore the same whether chunks are resident together or processed one after the other. `readings` is
    /// the number of readings in the run.
    #[inline(always)]
    fn reach<S: Simd>(&self, simd: S, cone: &Cone, readings: usize, run: &mut Run) {
        let arcs = cone.flags & NO_ECHO == 0 || self.no_echo_arcs;
        let shape = Shape::of(cone, self.footprint);
        for place in self.chunks_of_shape(cone, &shape) {
            // The first chunk's list has room for a sonar's cones of a usual size, so that it is rarely reallocated.
            let first = run.chunks.is_empty();
            let room = || if first { Vec::with_capacity(16 * readings) } else { Vec::new() };
            let pairs = run.chunks.entry(place).or_insert_with(room);
            let mut push = |[i, j]: [i64; 2], (arc, inside): (bool, bool)| {
                let arc = arc && arcs;
                let flags = if arc { ARC } else { 0 } | if inside { INSIDE } else { 0 };
                let slot = (j % CHUNK as i64 * CHUNK as i64 + i % CHUNK as i64) as u16;
                pairs.push((slot, Entry { cone: cone.index << ENTRY_SHIFT | flags, slot: run.parts }));
                run.parts += u32::from(arc);
            };
            let [rows, columns] = self.within(self.spans(cone, &shape), place);
            let edge = (TILE as i64) * i64::from(CELL);
            let count = (columns.end - columns.start).max(0) as usize;
            let at = edge * columns.start - i64::from(cone.sensor[0]);
            // A cone of a usual size lies in at most 16 columns of tiles.
            if cone.flags & WIDE != 0 || count > TILES {
                self.tiles_in(cone, &shape, place, &mut push);
                continue;
            }
            let across = Columns::of(simd, &shape, at);
            for j in rows {
                let Met { some, arc, inside } =
                    across.meet(&shape, &shape.extremes(1, edge * j - i64::from(cone.sensor[1])));
                let mut left = some & ((1 << count) - 1);
                while left != 0 {
                    let k = left.trailing_zeros();
                    left &= left - 1;
                    let i = columns.start + i64::from(k);
                    push([i, j], (arc >> k & 1 != 0, inside >> k & 1 != 0 && self.whole([i, j])));
                }
            }
        }
    }

    /// Whether the whole tile lies in the grid.
    fn whole(&self, tile: [i64; 2]) -> bool {
        [0, 1].iter().all(|&k| (tile[k] + 1) as usize * TILE <= self.size[k])
    }

    /// Calls `show` for each tile that the cone may touch, with the tile's column and row, whether the arc may touch it, and
    /// whether all of it is interior.
    pub(crate) fn tiles_of(&self, cone: &Cone, show: &mut impl FnMut([i64; 2], (bool, bool))) {
        let shape = Shape::of(cone, self.footprint);
        self.chunks_of_shape(cone, &shape).for_each(|place| self.tiles_in(cone, &shape, place, show));
    }

    /// [`Self::tiles_of`] for the tiles of one chunk.
    fn tiles_in(&self, cone: &Cone, shape: &Shape, place: ChunkId, show: &mut impl FnMut([i64; 2], (bool, bool))) {
        let [rows, columns] = self.within(self.spans(cone, shape), place);
        let edge = (TILE as i64) * i64::from(CELL);
        let extremes = |k: usize, tile: i64| shape.extremes(k, edge * tile - i64::from(cone.sensor[k]));
        // A chunk has at most `CHUNK` columns of tiles.
        let mut across = [Extremes::default(); CHUNK];
        columns.clone().zip(&mut across).for_each(|(i, column)| *column = extremes(0, i));
        for j in rows {
            let up = extremes(1, j);
            for (i, column) in columns.clone().zip(&across) {
                let Some((arc, inside)) = shape.meets(column, &up) else { continue };
                show([i, j], (arc, inside && self.whole([i, j])));
            }
        }
    }

    /// The chunks that a cone's box meets, row by row.
    pub fn chunks_of(&self, cone: &Cone) -> Vec<ChunkId> {
        self.chunks_of_shape(cone, &Shape::of(cone, self.footprint)).collect()
    }

    fn chunks_of_shape(&self, cone: &Cone, shape: &Shape) -> impl Iterator<Item = ChunkId> {
        let [rows, columns] = self.spans(cone, shape).map(|s| {
            let chunk = |tile: i64| tile.div_euclid(CHUNK as i64) as u32;
            if s.is_empty() { 0..0 } else { chunk(s.start)..chunk(s.end - 1) + 1 }
        });
        let only = self.only;
        rows.flat_map(move |row| columns.clone().map(move |column| ChunkId { row, column }))
            .filter(move |place| only.is_none_or(|only| only == *place))
    }

    /// The part of some tile rows and tile columns that lies in a chunk.
    fn within(&self, [rows, columns]: [Range<i64>; 2], ChunkId { row, column }: ChunkId) -> [Range<i64>; 2] {
        let cut = |span: Range<i64>, chunk: u32| {
            let first = i64::from(chunk) * CHUNK as i64;
            span.start.max(first)..span.end.min(first + CHUNK as i64)
        };
        [cut(rows, row), cut(columns, column)]
    }

    /// Whether the cone has a cell of the grid in its interior, and whether it has one on its arc.
    pub fn regions(&self, cone: &Cone) -> (bool, bool) {
        let hit = cone.flags & NO_ECHO == 0;
        let mut any = (false, false);
        self.tiles_of(cone, &mut |[i, j], (arc, inside)| {
            any.0 |= inside;
            if any.0 && (any.1 || !hit || !arc) {
                return;
            }
            for cell in 0..TILE_CELLS {
                let at = [i as usize * TILE + cell % TILE, j as usize * TILE + cell / TILE];
                if at[0] < self.size[0] && at[1] < self.size[1] {
                    let (interior, arc) = region(cone, self.footprint, at[0] as i64, at[1] as i64);
                    any = (any.0 | interior, any.1 | (arc & hit));
                }
            }
        });
        any
    }
}

/// Makes a chunk's lists from its pairs, given run by run with the number of parts before each run. A counting sort keeps the
/// log order within a tile.
pub(crate) fn list(place: ChunkId, runs: &[(&[Pair], u32)]) -> ChunkList {
    let pairs = || runs.iter().flat_map(|(pairs, before)| pairs.iter().map(move |pair| (pair, before)));
    let mut ends = [0u32; CHUNK * CHUNK];
    pairs().for_each(|((slot, _), _)| ends[usize::from(*slot)] += 1);
    let (mut tiles, mut sum) = (Vec::new(), 0);
    for (slot, end) in ends.iter_mut().enumerate() {
        let count = std::mem::replace(end, sum);
        if count > 0 {
            let at = [slot % CHUNK, slot / CHUNK].map(|s| s as u32);
            let corner = [0, 1].map(|k| (place.first_cell()[k] + at[k] as usize * TILE) as u32);
            tiles.push(Tile { corner, entries: [sum, sum + count], slot: slot as u32, spare: [0; 3] });
            sum += count;
        }
    }
    let mut entries = vec![Entry { cone: 0, slot: 0 }; sum as usize];
    for ((slot, entry), before) in pairs() {
        let end = &mut ends[usize::from(*slot)];
        entries[*end as usize] = Entry { slot: entry.slot + before, ..*entry };
        *end += 1;
    }
    ChunkList { place, tiles, entries, cone_bounds: Vec::new() }
}

#[cfg(test)]
mod tests;
