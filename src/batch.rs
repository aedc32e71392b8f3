//! Which readings reach which tile, in log order.
//!
//! A batch is any number of readings. For every tile it holds the list of the cones that may touch it, with a flag where
//! the arc may, and one where the tile is interior throughout. Lists may hold a cone too many, never one too few: the
//! kernels decide each cell exactly.

use crate::layout::*;
use crate::snap::{Footprint, SLACK, region};
use rayon::prelude::*;
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

/// A cone in a tile: the tile's key, and the entry.
type Pair = (u64, Entry);

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
        let mut runs: Vec<(Vec<Pair>, Vec<u32>)> = cones
            .par_chunks(run)
            .map(|cones| {
                let (mut pairs, mut parts) = (Vec::new(), Vec::with_capacity(cones.len()));
                let mut slot = 0;
                for cone in cones {
                    parts.push(slot);
                    self.reach(cone, &mut slot, &mut pairs);
                }
                parts.push(slot);
                // Stable: within a tile the log's order stays.
                pairs.sort_by_key(|(key, _)| *key);
                (pairs, parts)
            })
            .collect();
        let mut first_part = Vec::with_capacity(cones.len() + 1);
        let mut before = 0;
        for (pairs, parts) in &mut runs {
            let own = parts.pop().unwrap_or(0);
            first_part.extend(parts.iter().map(|p| p + before));
            pairs.iter_mut().for_each(|(_, entry)| entry.slot += before);
            before += own;
        }
        first_part.push(before);
        let runs: Vec<Vec<Pair>> = runs.into_iter().map(|(pairs, _)| pairs).collect();
        Batch { chunks: self.chunks(&merge(runs)), cones, first_part }
    }

    /// Splits sorted pairs into chunks and tiles.
    fn chunks(&self, pairs: &[Pair]) -> Vec<ChunkList> {
        let chunk_of = |key: u64| key >> 12;
        pairs
            .chunk_by(|a, b| chunk_of(a.0) == chunk_of(b.0))
            .map(|pairs| {
                let place = [(pairs[0].0 >> 12) as u32 & 0xf_ffff, (pairs[0].0 >> 32) as u32];
                let mut first = 0;
                let tiles = pairs
                    .chunk_by(|a, b| a.0 == b.0)
                    .map(|list| {
                        let slot = (list[0].0 & 0xfff) as u32;
                        let at = [slot % CHUNK as u32, slot / CHUNK as u32];
                        let corner = [0, 1].map(|k| (place[k] * CHUNK as u32 + at[k]) * TILE as u32);
                        let from = first;
                        first += list.len() as u32;
                        Tile { corner, entries: [from, first], slot, spare: [0; 3] }
                    })
                    .collect();
                ChunkList { place, tiles, entries: pairs.iter().map(|p| p.1).collect() }
            })
            .collect()
    }

    /// Appends a pair for every tile that the cone may touch, chunk by chunk and in each tile row by tile row, so that a
    /// sum over its arc is the same whether chunks are resident together or done one after the other; `slot` counts
    /// the tiles of its arc.
    fn reach(&self, cone: &Cone, slot: &mut u32, pairs: &mut Vec<Pair>) {
        let arcs = cone.flags & NO_ECHO == 0 || self.no_echo_arcs;
        self.tiles_of(cone, &mut |[i, j], (arc, inside)| {
            let arc = arc && arcs;
            let flags = if arc { ARC } else { 0 } | if inside { INSIDE } else { 0 };
            let (chunk, at) = ([i / CHUNK as i64, j / CHUNK as i64], [i % CHUNK as i64, j % CHUNK as i64]);
            let key = ((chunk[1] << 32) | (chunk[0] << 12) | (at[1] * CHUNK as i64 + at[0])) as u64;
            pairs.push((key, Entry { cone: cone.index << ENTRY_SHIFT | flags, slot: *slot }));
            *slot += u32::from(arc);
        });
    }

    /// Shows each tile that the cone may touch, by column and row: whether its arc may, and whether all of it is interior.
    fn tiles_of(&self, cone: &Cone, show: &mut dyn FnMut([i64; 2], (bool, bool))) {
        let shape = Shape::of(cone, self.footprint);
        let edge = (TILE as i64) * i64::from(CELL);
        for [column, row] in self.chunks_of(cone) {
            let [rows, columns] = self.within(self.spans(cone, &shape), [column, row]);
            for j in rows {
                for i in columns.clone() {
                    let (x, y) = (edge * i - i64::from(cone.sensor[0]), edge * j - i64::from(cone.sensor[1]));
                    let Some((arc, inside)) = shape.meets(x, y) else { continue };
                    let whole = (i + 1) as usize * TILE <= self.size[0] && (j + 1) as usize * TILE <= self.size[1];
                    show([i, j], (arc, inside && whole));
                }
            }
        }
    }

    /// The chunks of a cone's box, by column and row, row by row.
    pub fn chunks_of(&self, cone: &Cone) -> Vec<[u32; 2]> {
        let shape = Shape::of(cone, self.footprint);
        let [rows, columns] = self.spans(cone, &shape).map(|s| {
            let chunk = |tile: i64| tile.div_euclid(CHUNK as i64) as u32;
            if s.is_empty() { 0..0 } else { chunk(s.start)..chunk(s.end - 1) + 1 }
        });
        let all = rows.flat_map(|row| columns.clone().map(move |column| [column, row]));
        all.filter(|place| self.only.is_none_or(|only| only == *place)).collect()
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

/// Merges sorted runs into one, equal keys in the order of the runs.
fn merge(mut runs: Vec<Vec<Pair>>) -> Vec<Pair> {
    while runs.len() > 1 {
        runs = runs
            .par_chunks(2)
            .map(|pair| match pair {
                [a, b] => merge_two(a, b),
                _ => pair[0].clone(),
            })
            .collect();
    }
    runs.pop().unwrap_or_default()
}

fn merge_two(a: &[Pair], b: &[Pair]) -> Vec<Pair> {
    let mut merged = Vec::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        if a[i].0 <= b[j].0 {
            merged.push(a[i]);
            i += 1;
        } else {
            merged.push(b[j]);
            j += 1;
        }
    }
    merged.extend_from_slice(&a[i..]);
    merged.extend_from_slice(&b[j..]);
    merged
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

    /// Whether the cone may touch the tile whose lower left corner is at (x, y) from the sensor: (its arc may, all of the
    /// tile is interior).
    fn meets(&self, x: i64, y: i64) -> Option<(bool, bool)> {
        // The box of the cells' centres.
        let half = i64::from(CELL / 2);
        let last = i64::from(CELL) * (TILE as i64 - 1);
        let (xs, ys) = ([x + half, x + half + last], [y + half, y + half + last]);
        let extremes = |a: [i64; 2], b: [i64; 2]| -> [i64; 2] {
            let products = [a[0] * xs[0], a[0] * xs[1]];
            let others = [b[0] * ys[0], b[0] * ys[1]];
            [
                products[0].min(products[1]) + others[0].min(others[1]),
                products[0].max(products[1]) + others[0].max(others[1]),
            ]
        };
        // cross(a, v) = a.x·v.y − a.y·v.x; dot(a, v) = a.x·v.x + a.y·v.y.
        let cross_range = |a: [i64; 2]| extremes([-a[1], 0], [a[0], 0]);
        let nearest = |range: [i64; 2]| 0.clamp(range[0], range[1]);
        let farthest = |range: [i64; 2]| range[0].abs().max(range[1].abs());
        let near2 = nearest(xs).pow(2) + nearest(ys).pow(2);
        let far2 = farthest(xs).pow(2) + farthest(ys).pow(2);
        let along = extremes([self.axis[0], 0], [self.axis[1], 0]);
        let across = cross_range(self.axis);
        let direction = i64::from(DIRECTION);
        let in_band = |width: i64, before: i64| {
            across[0] <= width && across[1] >= -width && along[1] >= before && along[0] <= self.outer * direction
        };
        match self.footprint {
            // On the axis: within half a cell of it along the other world axis, so at most that far from it.
            Footprint::Axis => in_band(half * direction, -SLACK * direction).then_some((true, false)),
            Footprint::Cone | Footprint::Wedge => {
                let (left, right) = (cross_range(self.left), cross_range(self.right));
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

fn cross(a: [i64; 2], v: [i64; 2]) -> i64 {
    a[0] * v[1] - a[1] * v[0]
}

fn dot(a: [i64; 2], v: [i64; 2]) -> i64 {
    a[0] * v[0] + a[1] * v[1]
}

#[cfg(test)]
mod tests;
