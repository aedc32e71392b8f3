//! Bins updates into tiles, in log order.
//!
//! A list may hold an update that does not reach the tile, but it never lacks one that does. The slot of each entry says which of
//! the update's shapes may meet the tile, and which fans hold all of it.

use super::reach::regions;
use super::region::{SPAN, SPOT, cross};
use super::snap::Snapped;
use crate::binning::batch::{Batch, Binning, Input, Pair, UpdateInput, list};
use crate::binning::snap::Footprint;
use crate::geometry::layout::*;
use crate::grid::ChunkId;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// The parameters by which updates are binned.
#[derive(Debug, Clone, Copy)]
pub struct Bins {
    /// Columns and rows of the grid.
    pub size: [usize; 2],
}

/// The result of binning updates.
pub struct Binned {
    /// The batch.
    pub batch: Batch,
    /// Number of updates that reach no cell.
    pub outside: u64,
    /// Number of updates that may occupy and reach cells, but occupy none.
    pub empty_arc: u64,
}

/// An update's flags and slot for one tile: the cone's flags, and the shapes that may meet the tile.
type Meeting = (u32, u32);

/// The box of tiles around an update.
struct Area {
    columns: Range<i64>,
    rows: Range<i64>,
    tiles: Vec<Meeting>,
}

impl Area {
    fn at(&mut self, [i, j]: [i64; 2]) -> Option<&mut Meeting> {
        let within = self.columns.contains(&i) && self.rows.contains(&j);
        let width = self.columns.end - self.columns.start;
        let at = (j - self.rows.start) * width + i - self.columns.start;
        if within { self.tiles.get_mut(at as usize) } else { None }
    }
}

/// The pairs of a run of consecutive updates, by chunk.
#[derive(Default)]
struct Run {
    chunks: BTreeMap<ChunkId, Vec<Pair>>,
    outside: u64,
    empty_arc: u64,
}

impl Bins {
    /// The largest number of tiles that an update may reach.
    pub fn at_most(&self, update: &Snapped) -> usize {
        let [columns, rows] = self.spans(update).map(|s| (s.end - s.start).max(0) as usize);
        columns * rows
    }

    /// Bins snapped updates, which are given in log order.
    pub fn bin(&self, updates: &[Snapped]) -> Binned {
        let length = updates.len().div_ceil(4 * rayon::current_num_threads()).max(16);
        let run = |(k, updates)| self.run((k * length) as u32, updates);
        let runs: Vec<Run> = updates.par_chunks(length).enumerate().map(run).collect();
        let mut places: BTreeMap<ChunkId, Vec<(&[Pair], u32)>> = BTreeMap::new();
        for run in &runs {
            for (place, pairs) in &run.chunks {
                places.entry(*place).or_default().push((pairs, 0));
            }
        }
        let chunks = places.into_par_iter().map(|(chunk, pairs)| list(chunk, &pairs)).collect();
        let [outside, empty_arc] = [|r: &Run| r.outside, |r: &Run| r.empty_arc].map(|of| runs.iter().map(of).sum());
        let mut input = UpdateInput::default();
        for update in updates {
            let before = input.points.len() as u32;
            let shift = |[from, to]: [u32; 2]| [from + before, to + before];
            let Shapes { fans, lines, .. } = update.shapes;
            input.shapes.push(Shapes { fans: fans.map(shift), lines: lines.map(shift), ..update.shapes });
            input.points.extend_from_slice(&update.points);
            input.cones.push(Cone { index: input.cones.len() as u32, ..update.cone });
        }
        Binned { batch: Batch { chunks, input: Input::Updates(input) }, outside, empty_arc }
    }

    /// Bins a run of updates; `first` is the index in the batch of the run's first update.
    fn run(&self, first: u32, updates: &[Snapped]) -> Run {
        let mut run = Run::default();
        for (index, update) in (first..).zip(updates) {
            let area = self.meet(update);
            let width = (area.columns.end - area.columns.start).max(1);
            let (mut any, mut occupied) = (false, false);
            for (k, meeting) in (0i64..).zip(&area.tiles) {
                let Some((flags, slot)) = useful(update, *meeting) else { continue };
                let [i, j] = [area.columns.start + k % width, area.rows.start + k / width];
                let [column, row] = [i, j].map(|t| (t / CHUNK as i64) as u32);
                let within = (j % CHUNK as i64 * CHUNK as i64 + i % CHUNK as i64) as u16;
                let entry = Entry { cone: index << ENTRY_SHIFT | flags, slot };
                run.chunks.entry(ChunkId { row, column }).or_default().push((within, entry));
                let occupies = flags & ARC != 0 || slot & (LINES | LINES << 1) != 0;
                if !any || (!occupied && occupies) {
                    let corner = [i, j].map(|t| (t * TILE as i64) as u32);
                    let size = self.size.map(|s| s as u32);
                    let found = regions(&entry, &update.cone, &update.shapes, &update.points, [corner, size]).any();
                    (any, occupied) = (any | found.0, occupied | found.1);
                }
            }
            run.outside += u64::from(!any);
            run.empty_arc += u64::from(any && !occupied && update.may_occupy);
        }
        run
    }

    /// Columns and rows of the tiles in an update's box.
    fn spans(&self, update: &Snapped) -> [Range<i64>; 2] {
        let outer = if update.routine { i64::from(update.cone.reach[1]) + 2 } else { 0 };
        [0, 1].map(|k| {
            let all = || update.points.iter().map(|p| i64::from(p[k]));
            let low = all().map(|v| v - i64::from(SPOT)).fold(-outer, i64::min);
            let high = all().map(|v| v + i64::from(SPOT)).fold(outer, i64::max);
            self.span(update, k, [low, high])
        })
    }

    /// The tiles along axis `k` with cell centres that may lie between two coordinates, units from the sensor.
    fn span(&self, update: &Snapped, k: usize, [low, high]: [i64; 2]) -> Range<i64> {
        let (at, edge) = (i64::from(update.cone.sensor[k] - CELL / 2), i64::from(CELL) * TILE as i64);
        let tiles = self.size[k].div_ceil(TILE) as i64;
        let from = -(i64::from(SPAN) - low - at).div_euclid(edge);
        from.max(0)..((high + at).div_euclid(edge) + 1).min(tiles)
    }

    /// Finds for each tile of an update's box which shapes of the update may meet it.
    fn meet(&self, update: &Snapped) -> Area {
        let [columns, rows] = self.spans(update);
        let count = (columns.end - columns.start).max(0) * (rows.end - rows.start).max(0);
        let mut area = Area { columns, rows, tiles: vec![(0, 0); count as usize] };
        let points = |[from, to]: [u32; 2]| &update.points[from as usize..to as usize];
        for (k, fan) in update.shapes.fans.iter().enumerate() {
            let fan = points(*fan);
            for (n, side) in fan.windows(2).enumerate() {
                let triangle = Triangle::of([side[0], side[1]], if n + 2 == fan.len() { 0 } else { -1 });
                self.tiles(update, [side[0], side[1], [0, 0]], 0, &mut area, &mut |v, meeting| {
                    meeting.1 |= match triangle.meets(v) {
                        (_, true) => (FAN | FULL) << k,
                        (true, _) => FAN << k,
                        _ => 0,
                    };
                });
            }
        }
        for (k, lines) in update.shapes.lines.iter().enumerate() {
            for line in points(*lines).chunks_exact(2) {
                let [a, b] = [line[0], line[1]];
                self.tiles(update, [a, b, b], SPOT, &mut area, &mut |v, meeting| {
                    if line_meets([a, b], v) {
                        meeting.1 |= LINES << k;
                    }
                });
            }
        }
        if update.routine {
            let binning = Binning { size: self.size, footprint: Footprint::Cone, no_echo_arcs: false, only: None };
            binning.tiles_of(&update.cone, &mut |tile, (arc, inside)| {
                if let Some(meeting) = area.at(tile) {
                    meeting.0 = if arc { ARC } else { 0 } | if inside { INSIDE } else { 0 };
                    meeting.1 |= ROUTINE;
                }
            });
        }
        area
    }

    /// Calls `show` for each tile that meets the box of three points, with the centre of the tile's first cell, units from the sensor.
    fn tiles(
        &self,
        update: &Snapped,
        corners: [[i32; 2]; 3],
        slack: i32,
        area: &mut Area,
        show: &mut dyn FnMut([i32; 2], &mut Meeting),
    ) {
        let [columns, rows] = [0, 1].map(|k| {
            let all = corners.map(|c| c[k]);
            let [low, high] = [all.into_iter().fold(i32::MAX, i32::min), all.into_iter().fold(i32::MIN, i32::max)];
            self.span(update, k, [low - slack, high + slack].map(i64::from))
        });
        for j in rows {
            for i in columns.clone() {
                let v = [first_centre(update, 0, i), first_centre(update, 1, j)];
                if let Some(meeting) = area.at([i, j]) {
                    show(v, meeting);
                }
            }
        }
    }
}

/// Coordinate of the first cell centre of a column (`k` 0) or row (1) of tiles, units from the sensor.
fn first_centre(update: &Snapped, k: usize, tile: i64) -> i32 {
    CELL * TILE as i32 * tile as i32 + CELL / 2 - update.cone.sensor[k]
}

/// The flags and slot of a tile's entry; `None` if no part of the update can change a cell of the tile.
fn useful(update: &Snapped, (mut flags, mut slot): Meeting) -> Option<(u32, u32)> {
    let limited = |bit: u32| update.shapes.flags & bit != 0;
    if update.cone.flags & NO_ECHO != 0 || (limited(ARC_LIMIT) && slot & FAN << 3 == 0) {
        flags &= !ARC;
    }
    let frees = !limited(FREE_LIMIT) || slot & FAN << 2 != 0;
    if flags & ARC == 0 && !frees {
        slot &= !ROUTINE;
    }
    let says = FAN | FAN << 1 | LINES | LINES << 1 | ROUTINE;
    (slot & says != 0).then_some((flags, slot))
}

/// The least and the largest value of the linear function a·p over the cell centres of a tile; `v` is its first cell's centre.
fn extremes(a: [i32; 2], v: [i32; 2]) -> [i32; 2] {
    let at = |k: usize| a[k] * v[k];
    let (low, high) = (a[0].min(0) + a[1].min(0), a[0].max(0) + a[1].max(0));
    [at(0) + at(1) + low * SPAN, at(0) + at(1) + high * SPAN]
}

/// The triangle of the sensor and a fan's side, as three linear functions that are not negative inside it.
struct Triangle {
    area: i32,
    sides: [([i32; 2], i32); 3],
}

impl Triangle {
    fn of([a, b]: [[i32; 2]; 2], limit: i32) -> Triangle {
        let (area, e) = (cross(a, b), [b[0] - a[0], b[1] - a[1]]);
        Triangle { area, sides: [([-a[1], a[0]], 0), ([b[1], -b[0]], limit), ([-e[1], e[0]], area)] }
    }

    /// Whether the triangle may meet a tile that its box meets, and whether it holds the whole tile.
    fn meets(&self, v: [i32; 2]) -> (bool, bool) {
        let (mut some, mut all) = (self.area > 0, self.area > 0);
        for (side, more) in self.sides {
            let [low, high] = extremes(side, v);
            some &= high + more >= 0;
            all &= low + more >= 0;
        }
        (some, all)
    }
}

/// Whether a line may meet a tile that the line's box meets.
fn line_meets([a, b]: [[i32; 2]; 2], v: [i32; 2]) -> bool {
    let d = [b[0] - a[0], b[1] - a[1]];
    let from = [v[0] - a[0], v[1] - a[1]];
    let half = CELL / 2 * (d[0].abs() + d[1].abs());
    let (across, along) = (extremes([-d[1], d[0]], from), extremes(d, from));
    across[0] <= half && across[1] >= -half && along[1] >= 0 && along[0] <= d[0] * d[0] + d[1] * d[1]
}
