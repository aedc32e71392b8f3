//! Which readings reach which tile, in log order.
//!
//! A batch is any number of readings. For every tile it holds the list of the cones that may touch it, with a flag where
//! the arc may, and one where the tile is interior throughout. Lists may hold a cone too many, never one too few: the
//! kernels decide each cell exactly.

use crate::layout::*;
use crate::snap::{Footprint, SLACK, region};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// A chunk's share of a batch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChunkList {
    /// Its place: chunk column, chunk row.
    pub place: [u32; 2],
    /// Its tiles that the batch reaches, by slot.
    pub tiles: Vec<Tile>,
    /// Their entries, in tile order, each tile's in log order.
    pub entries: Vec<Entry>,
}

/// Readings, binned.
#[derive(Debug, Clone, Default)]
pub struct Batch {
    /// The snapped readings, in log order.
    pub cones: Vec<Cone>,
    /// The chunks they reach, row by row.
    pub chunks: Vec<ChunkList>,
    /// Where each reading's parts begin; one more than there are readings.
    pub first_part: Vec<u32>,
}

/// How readings are binned.
#[derive(Debug, Clone, Copy)]
pub struct Binning {
    /// Columns and rows of the grid.
    pub size: [usize; 2],
    /// The cells that a reading concerns.
    pub footprint: Footprint,
    /// Whether a missing echo's arc is looked at (Dempster-Shafer counts its cells).
    pub no_echo_arcs: bool,
    /// Bin into this chunk (column, row) alone.
    pub only: Option<[u32; 2]>,
}

/// A cone in a tile: the tile's slot in its chunk, and the entry.
type Pair = (u16, Entry);

/// What a run of readings reaches: each chunk's pairs in log order, by row and column; and where each reading's parts begin in
/// the run.
#[derive(Default)]
struct Run {
    chunks: BTreeMap<[u32; 2], Vec<Pair>>,
    first_part: Vec<u32>,
    parts: u32,
}

impl Binning {
    /// Tiles along x and y.
    fn tiles(&self) -> [i64; 2] {
        self.size.map(|s| s.div_ceil(TILE) as i64)
    }

    /// Tiles that a cone reaches at most: those of its box.
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

    /// Bins snapped readings.
    pub fn bin(&self, mut cones: Vec<Cone>) -> Batch {
        for (k, cone) in cones.iter_mut().enumerate() {
            cone.index = k as u32;
        }
        // Runs of readings, each on its own; what follows keeps them in order, so the split leaves no trace.
        let run = cones.len().div_ceil(4 * rayon::current_num_threads()).max(64);
        let runs: Vec<Run> = cones.par_chunks(run).map(|cones| self.run(cones)).collect();
        let mut first_part = Vec::with_capacity(cones.len() + 1);
        let mut places: BTreeMap<[u32; 2], Vec<(&[Pair], u32)>> = BTreeMap::new();
        let mut before = 0;
        for run in &runs {
            first_part.extend(run.first_part.iter().map(|p| p + before));
            for (place, pairs) in run.chunks.iter().filter(|(_, pairs)| !pairs.is_empty()) {
                places.entry(*place).or_default().push((pairs, before));
            }
            before += run.parts;
        }
        first_part.push(before);
        let chunks = places.into_par_iter().map(|([row, column], pairs)| list([column, row], &pairs)).collect();
        Batch { chunks, cones, first_part }
    }

    /// What some readings reach.
    fn run(&self, cones: &[Cone]) -> Run {
        let mut run = Run::default();
        for cone in cones {
            run.first_part.push(run.parts);
            self.reach(cone, cones.len(), &mut run);
        }
        run
    }

    /// Adds a pair for every tile that the cone may touch, chunk by chunk and in each tile row by tile row, so that a
    /// sum over its arc is the same whether chunks are resident together or done one after the other. The run has so many
    /// `readings`.
    fn reach(&self, cone: &Cone, readings: usize, run: &mut Run) {
        let arcs = cone.flags & NO_ECHO == 0 || self.no_echo_arcs;
        let shape = Shape::of(cone, self.footprint);
        for place in self.chunks_of_shape(cone, &shape) {
            // Room for a sonar's cones of a usual size, so that a list rarely has to move.
            let room = || Vec::with_capacity(16 * readings);
            let pairs = run.chunks.entry([place[1], place[0]]).or_insert_with(room);
            self.tiles_in(cone, &shape, place, &mut |[i, j], (arc, inside)| {
                let arc = arc && arcs;
                let flags = if arc { ARC } else { 0 } | if inside { INSIDE } else { 0 };
                let slot = (j % CHUNK as i64 * CHUNK as i64 + i % CHUNK as i64) as u16;
                pairs.push((slot, Entry { cone: cone.index << ENTRY_SHIFT | flags, slot: run.parts }));
                run.parts += u32::from(arc);
            });
        }
    }

    /// Shows each tile that the cone may touch, by column and row: whether its arc may, and whether all of it is interior.
    fn tiles_of(&self, cone: &Cone, show: &mut impl FnMut([i64; 2], (bool, bool))) {
        let shape = Shape::of(cone, self.footprint);
        self.chunks_of_shape(cone, &shape).for_each(|place| self.tiles_in(cone, &shape, place, show));
    }

    /// The same in one chunk.
    fn tiles_in(
        &self,
        cone: &Cone,
        shape: &Shape,
        place: [u32; 2],
        show: &mut impl FnMut([i64; 2], (bool, bool)),
    ) {
        let [rows, columns] = self.within(self.spans(cone, shape), place);
        let edge = (TILE as i64) * i64::from(CELL);
        let extremes = |k: usize, tile: i64| shape.extremes(k, edge * tile - i64::from(cone.sensor[k]));
        // A chunk has at most so many columns of tiles.
        let mut across = [Extremes::default(); CHUNK];
        columns.clone().zip(&mut across).for_each(|(i, column)| *column = extremes(0, i));
        for j in rows {
            let up = extremes(1, j);
            for (i, column) in columns.clone().zip(&across) {
                let Some((arc, inside)) = shape.meets(column, &up) else { continue };
                let whole = (i + 1) as usize * TILE <= self.size[0] && (j + 1) as usize * TILE <= self.size[1];
                show([i, j], (arc, inside && whole));
            }
        }
    }

    /// The chunks of a cone's box, by column and row, row by row.
    pub fn chunks_of(&self, cone: &Cone) -> Vec<[u32; 2]> {
        self.chunks_of_shape(cone, &Shape::of(cone, self.footprint)).collect()
    }

    fn chunks_of_shape(&self, cone: &Cone, shape: &Shape) -> impl Iterator<Item = [u32; 2]> {
        let [rows, columns] = self.spans(cone, shape).map(|s| {
            let chunk = |tile: i64| tile.div_euclid(CHUNK as i64) as u32;
            if s.is_empty() { 0..0 } else { chunk(s.start)..chunk(s.end - 1) + 1 }
        });
        let only = self.only;
        rows.flat_map(move |row| columns.clone().map(move |column| [column, row]))
            .filter(move |place| only.is_none_or(|only| only == *place))
    }

    /// The part of tile rows and tile columns in a chunk.
    fn within(&self, [rows, columns]: [Range<i64>; 2], [column, row]: [u32; 2]) -> [Range<i64>; 2] {
        let cut = |span: Range<i64>, chunk: u32| {
            let first = i64::from(chunk) * CHUNK as i64;
            span.start.max(first)..span.end.min(first + CHUNK as i64)
        };
        [cut(rows, row), cut(columns, column)]
    }

    /// Whether the cone has a cell in its interior, and one on its arc, within the grid.
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

/// A chunk's lists from its pairs, run by run with the number of parts before each: sorted by counting, which keeps the log's
/// order within a tile.
fn list(place: [u32; 2], runs: &[(&[Pair], u32)]) -> ChunkList {
    let pairs = || runs.iter().flat_map(|(pairs, before)| pairs.iter().map(move |pair| (pair, before)));
    let mut ends = [0u32; CHUNK * CHUNK];
    pairs().for_each(|((slot, _), _)| ends[usize::from(*slot)] += 1);
    let (mut tiles, mut sum) = (Vec::new(), 0);
    for (slot, end) in ends.iter_mut().enumerate() {
        let count = std::mem::replace(end, sum);
        if count > 0 {
            let at = [slot % CHUNK, slot / CHUNK].map(|s| s as u32);
            let corner = [0, 1].map(|k| (place[k] * CHUNK as u32 + at[k]) * TILE as u32);
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
    ChunkList { place, tiles, entries }
}

/// A cone's outline relative to its sensor, in 64-bit units.
struct Shape {
    footprint: Footprint,
    laser: bool,
    low: [i64; 2],
    high: [i64; 2],
    inner2: i64,
    outer2: i64,
    outer: i64,
    axis: [i64; 2],
    left: [i64; 2],
    right: [i64; 2],
}

impl Shape {
    fn of(cone: &Cone, footprint: Footprint) -> Shape {
        let wide = |a: [i32; 2]| a.map(i64::from);
        let (axis, left, right) = (wide(cone.axis), wide(cone.left), wide(cone.right));
        let [inner, outer] = wide(cone.reach);
        // The sensor, the ends of both edges and of the axis, and the circle's extremes that lie between the edges.
        let direction = i64::from(DIRECTION);
        let between = |v: [i64; 2]| cross(left, v) <= 0 && cross(right, v) >= 0 && dot(axis, v) >= 0;
        let compass = [[direction, 0], [0, direction], [-direction, 0], [0, -direction]];
        let tips = [axis, left, right].into_iter().chain(compass.into_iter().filter(|c| between(*c)));
        let (mut low, mut high) = ([0; 2], [0; 2]);
        for tip in tips {
            for k in 0..2 {
                let v = tip[k] * outer / direction;
                low[k] = low[k].min(v);
                high[k] = high[k].max(v);
            }
        }
        let laser = cone.flags & LASER != 0;
        // A direction is rounded by up to 1/8192, so a far tip by more than a unit.
        let slack = 2 + outer / 4096 + if laser || footprint == Footprint::Axis { SLACK } else { 0 };
        Shape {
            footprint,
            laser,
            low: low.map(|v| v - slack),
            high: high.map(|v| v + slack),
            inner2: inner * inner,
            outer2: outer * outer,
            outer,
            axis,
            left,
            right,
        }
    }

    /// A tile column's (`k` 0) or tile row's (1) part of its tiles' extremes; it begins at `at` from the sensor.
    fn extremes(&self, k: usize, at: i64) -> Extremes {
        // The cells' centres.
        let low = at + i64::from(CELL / 2);
        let high = low + i64::from(CELL) * (TILE as i64 - 1);
        let by = |factor: i64| if factor < 0 { [factor * high, factor * low] } else { [factor * low, factor * high] };
        // cross(a, v) = a.x·v.y − a.y·v.x; dot(a, v) = a.x·v.x + a.y·v.y.
        let cross = |a: [i64; 2]| by(if k == 0 { -a[1] } else { a[0] });
        Extremes {
            left: cross(self.left),
            right: cross(self.right),
            across: cross(self.axis),
            along: by(self.axis[k]),
            near2: 0.clamp(low, high).pow(2),
            far2: low.abs().max(high.abs()).pow(2),
        }
    }

    /// Whether the cone may touch the tile of this column and row: (its arc may, all of the tile is interior).
    fn meets(&self, column: &Extremes, row: &Extremes) -> Option<(bool, bool)> {
        let sum = |a: [i64; 2], b: [i64; 2]| [a[0] + b[0], a[1] + b[1]];
        let half = i64::from(CELL / 2);
        let (near2, far2) = (column.near2 + row.near2, column.far2 + row.far2);
        let along = sum(column.along, row.along);
        let direction = i64::from(DIRECTION);
        let in_band = |width: i64, before: i64| {
            let across = sum(column.across, row.across);
            across[0] <= width && across[1] >= -width && along[1] >= before && along[0] <= self.outer * direction
        };
        match self.footprint {
            // On the axis: within half a cell of it along the other world axis, so at most that far from it.
            Footprint::Axis => in_band(half * direction, -SLACK * direction).then_some((true, false)),
            Footprint::Cone | Footprint::Wedge => {
                let (left, right) = (sum(column.left, row.left), sum(column.right, row.right));
                let in_wedge = left[0] <= 0 && right[1] >= 0 && along[1] >= 0;
                if near2 > self.outer2 || !(in_wedge || self.laser && in_band(half * direction, 0)) {
                    return None;
                }
                let inside = left[1] < 0 && right[0] >= 0 && along[0] >= 0 && far2 < self.inner2;
                Some((far2 >= self.inner2, inside))
            }
        }
    }
}

/// The least and the largest of a cone's products with v over a tile, and the squares of its nearest and farthest distance:
/// the part of a column of tiles, or of a row.
#[derive(Debug, Clone, Copy, Default)]
struct Extremes {
    left: [i64; 2],
    right: [i64; 2],
    across: [i64; 2],
    along: [i64; 2],
    near2: i64,
    far2: i64,
}

fn cross(a: [i64; 2], v: [i64; 2]) -> i64 {
    a[0] * v[1] - a[1] * v[0]
}

fn dot(a: [i64; 2], v: [i64; 2]) -> i64 {
    a[0] * v[0] + a[1] * v[1]
}

#[cfg(test)]
mod tests;
