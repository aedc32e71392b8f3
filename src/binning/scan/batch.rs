//! Bins scans into the tiles of a chunk, in log order.
//!
//! Where a cell takes its nearest poses, a batch is some of the chunk's tiles with every scan of the whole log that may be among
//! the nearest of one of their cells. The choice therefore doesn't depend on how the work is split. Where a cell takes all poses,
//! their order doesn't matter to the choice, and a batch is some of the scans with all tiles that they reach.

use super::area::Area;
use super::{Index, Selection, Store, micrometres};
use crate::binning::batch::{Batch, ChunkList, Input, ScanInput};
use crate::geometry::layout::*;
use crate::grid::GridSpec;
use crate::grid::{ChunkId, EDGE};
use crate::{Error, Result};
use rayon::prelude::*;
use std::ops::Range;

/// Makes the batches of one chunk.
pub struct Tiles<'a> {
    store: &'a Store,
    /// The index of poses; `None` if a cell takes all poses.
    index: Option<&'a Index>,
    selection: Selection,
    chunk: ChunkId,
    /// The centre of the chunk's first cell, µm in the world frame.
    origin: [i64; 2],
    /// Centres of the chunk's columns and rows, µm from `origin`.
    centres: [Vec<i32>; 2],
    /// Columns and rows of the grid in this chunk.
    size: [usize; 2],
}

/// A tile (column and row in the chunk) and the scans that its cells may take.
struct Listed {
    at: [usize; 2],
    scans: Vec<u32>,
}

/// Candidates per neighbour above which a tile's list is reduced, as where a robot is parked.
const MANY: usize = 16;

/// Limits of a batch.
#[derive(Debug, Clone, Copy)]
pub struct Most {
    /// The largest number of beams.
    pub beams: usize,
    /// The largest number of (scan, tile) pairs.
    pub pairs: usize,
    /// The largest number of beams and of pairs for one tile, which can't be split.
    pub one: [usize; 2],
    /// The largest number of loop iterations of a thread ([`crate::kernels::Limits::max_loop_iterations`]).
    pub max_loop_iterations: usize,
}

/// An upper bound of the steps of a search among a scan's beams, including the loop that leads to it.
const SEARCH: usize = 40;

impl<'a> Tiles<'a> {
    /// Prepares the tiles of a chunk. With `index` a cell takes its nearest poses, without it all poses.
    pub fn of(
        grid: &GridSpec,
        chunk: ChunkId,
        store: &'a Store,
        index: Option<&'a Index>,
        selection: Selection,
    ) -> Tiles<'a> {
        let first = chunk.first_cell();
        let centre = |k: usize, n: usize| {
            let at = [first[0] + if k == 0 { n } else { 0 }, first[1] + if k == 1 { n } else { 0 }];
            let (x, y) = grid.centre(at[0], at[1]);
            micrometres([x, y][k])
        };
        let origin = [centre(0, 0), centre(1, 0)];
        let centres = [0, 1].map(|k| (0..EDGE).map(|n| (centre(k, n) - origin[k]) as i32).collect());
        let size = [grid.width - first[0], grid.height - first[1]].map(|s| s.min(EDGE));
        Tiles { store, index, selection, chunk, origin, centres, size }
    }

    /// Passes the chunk's batches to `give` in order, each with its share of the chunk's work, until `give` returns `false`.
    /// Returns whether all were taken.
    ///
    /// # Errors
    /// [`crate::Error::Resources`] if spilled beams can't be read back, or one tile exceeds the limits.
    pub fn batches(&self, most: Most, give: &mut dyn FnMut(Batch, f64) -> bool) -> Result<bool> {
        match self.index {
            Some(index) => self.by_tiles(index, self.all(), most, give),
            None => self.by_scans(0..self.store.poses.len() as u32, most, give),
        }
    }

    /// The tiles (column and row in the chunk) for which one of the given scans may be among the nearest.
    pub fn concerned(&self, scans: Range<u32>) -> Vec<[usize; 2]> {
        let Some(index) = self.index else { return self.all() };
        let farthest = self.selection.z_max * 1e6;
        let near = |at: &[usize; 2]| {
            let area = self.tile(*at);
            scans.clone().any(|scan| area.square(self.pose(scan)) <= farthest * farthest)
        };
        let taken = |at: &[usize; 2]| {
            let found = self.candidates(index, &self.tile(*at));
            found.iter().any(|scan| scans.contains(scan))
        };
        self.all().into_par_iter().filter(|at| near(at) && taken(at)).collect()
    }

    /// [`Tiles::batches`] for some of the work: with an index for the given tiles (column and row in the chunk), without one for
    /// the given scans over all tiles.
    ///
    /// # Errors
    /// As [`Tiles::batches`].
    pub fn batches_of(
        &self,
        tiles: Vec<[usize; 2]>,
        scans: Range<u32>,
        most: Most,
        give: &mut dyn FnMut(Batch, f64) -> bool,
    ) -> Result<bool> {
        match self.index {
            Some(index) => self.by_tiles(index, tiles, most, give),
            None => self.by_scans(scans, most, give),
        }
    }

    fn by_tiles(
        &self,
        index: &Index,
        tiles: Vec<[usize; 2]>,
        most: Most,
        give: &mut dyn FnMut(Batch, f64) -> bool,
    ) -> Result<bool> {
        let listed: Vec<Listed> = tiles.into_par_iter().filter_map(|at| self.list(index, at)).collect();
        let total = listed.len() as f64;
        let mut rest = &listed[..];
        while !rest.is_empty() {
            let (mut scans, mut pairs, mut beams) = (std::collections::BTreeSet::new(), 0, 0);
            let mut taken = 0;
            for tile in rest {
                let fresh = tile.scans.iter().filter(|s| !scans.contains(*s));
                let more = fresh.map(|s| self.store.count(*s)).sum::<usize>();
                if taken > 0 && (beams + more > most.beams || pairs + tile.scans.len() > most.pairs) {
                    break;
                }
                scans.extend(&tile.scans);
                (beams, pairs, taken) = (beams + more, pairs + tile.scans.len(), taken + 1);
            }
            // For each candidate a thread keeps the squared distances of its nearest poses sorted; then it searches the beams of the
            // poses taken.
            let held = usize::from(self.selection.neighbours.unwrap_or(0));
            let iterations =
                rest[..taken].iter().map(|t| t.scans.len() * (2 + held)).max().unwrap_or(0) + held * SEARCH;
            if beams > most.one[0] || pairs > most.one[1] || iterations > most.max_loop_iterations {
                return Err(Error::Resources(format!(
                    "the {} poses nearest to one tile of cells, with {beams} beams, are more than the adapter takes at once: \
                     use `backend cpu`, a coarser `resolution` or fewer neighbours",
                    scans.len()
                )));
            }
            let (group, after) = rest.split_at(taken);
            rest = after;
            let scans: Vec<u32> = scans.into_iter().collect();
            if !give(self.batch(&scans, group)?, taken as f64 / total) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn by_scans(&self, scans: Range<u32>, most: Most, give: &mut dyn FnMut(Batch, f64) -> bool) -> Result<bool> {
        let all = self.all();
        let whole = self.extent([0, 0], self.size);
        let reaching: Vec<u32> = scans.filter(|scan| self.reaches(*scan, &whole)).collect();
        let mut rest = &reaching[..];
        while !rest.is_empty() {
            let (mut beams, mut taken) = (0, 0);
            for scan in rest {
                beams += self.store.count(*scan);
                if taken > 0
                    && (beams > most.beams
                        || (taken + 1) * all.len() > most.pairs
                        || (taken + 1) * SEARCH > most.max_loop_iterations)
                {
                    break;
                }
                taken += 1;
            }
            let (group, after) = rest.split_at(taken);
            rest = after;
            let list = |at: [usize; 2]| {
                let area = self.tile(at);
                let scans: Vec<u32> = group.iter().copied().filter(|s| self.reaches(*s, &area)).collect();
                Some(Listed { at, scans }).filter(|l| !l.scans.is_empty())
            };
            let listed: Vec<Listed> = all.par_iter().filter_map(|at| list(*at)).collect();
            if !give(self.batch(group, &listed)?, taken as f64 / reaching.len() as f64) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// All tiles (column and row in the chunk), row by row.
    fn all(&self) -> Vec<[usize; 2]> {
        let [columns, rows] = self.size.map(|s| s.div_ceil(TILE));
        (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row])).collect()
    }

    /// The box of cell centres from cell `from` to before cell `to`.
    fn extent(&self, from: [usize; 2], to: [usize; 2]) -> Area {
        Area { low: [0, 1].map(|k| self.centres[k][from[k]]), high: [0, 1].map(|k| self.centres[k][to[k] - 1]) }
    }

    fn tile(&self, at: [usize; 2]) -> Area {
        let from = at.map(|t| t * TILE);
        self.extent(from, [0, 1].map(|k| (from[k] + TILE).min(self.size[k])))
    }

    /// The position of a scan's pose, µm from the centre of the chunk's first cell.
    fn pose(&self, scan: u32) -> [i64; 2] {
        [0, 1].map(|k| self.store.poses[scan as usize][k] - self.origin[k])
    }

    /// Whether one of the scan's beams may touch a cell of the box.
    fn reaches(&self, scan: u32, area: &Area) -> bool {
        let reach = f64::from(self.store.reaches[scan as usize]);
        reach > 0.0 && area.square(self.pose(scan)) <= reach * reach
    }

    /// A tile and the scans that its cells may take; `None` if none of the scans may touch it.
    fn list(&self, index: &Index, at: [usize; 2]) -> Option<Listed> {
        let area = self.tile(at);
        let scans = self.candidates(index, &area);
        scans.iter().any(|s| self.reaches(*s, &area)).then_some(Listed { at, scans })
    }

    /// The scans that may be among the nearest of a cell of the box.
    fn candidates(&self, index: &Index, area: &Area) -> Vec<u32> {
        let metres = |k: usize, v: i32| (self.origin[k] + i64::from(v)) as f64 * 1e-6;
        let ends = [0, 1].map(|k| [metres(k, area.low[k]), metres(k, area.high[k])]);
        let half = (ends[0][1] - ends[0][0]).hypot(ends[1][1] - ends[1][0]) / 2.0;
        let scans = index.candidates(ends.map(|[low, high]| (low + high) / 2.0), half, self.selection.z_max);
        match self.selection.neighbours.map(usize::from).filter(|n| scans.len() > MANY * n) {
            Some(n) => self.undominated(area, &scans, n),
            None => scans,
        }
    }

    /// Leaves out each scan for which n others are nearer everywhere in the tile, because it is never among the n nearest. The
    /// difference of two squared distances is linear in the position, so a relation that holds at the corners holds between them.
    fn undominated(&self, area: &Area, scans: &[u32], n: usize) -> Vec<u32> {
        let corners = area.corners().map(|c| c.map(f64::from));
        // f64 holds the squares of distances below 90 m exactly; farther poses do not update a cell.
        let squares = |scan: &u32| {
            let [px, py] = self.pose(*scan).map(|v| v as f64);
            corners.map(|[x, y]| (x - px) * (x - px) + (y - py) * (y - py))
        };
        let all: Vec<[f64; 4]> = scans.iter().map(squares).collect();
        // The poses that are nearer than others everywhere are among those with the smallest sums.
        let mut order: Vec<usize> = (0..all.len()).collect();
        let first = (4 * n).min(order.len() - 1);
        let sum = |k: &usize| all[*k].iter().sum::<f64>();
        order.select_nth_unstable_by(first, |a, b| sum(a).total_cmp(&sum(b)).then(a.cmp(b)));
        let nearest: Vec<[f64; 4]> = order[..first].iter().map(|k| all[*k]).collect();
        let kept = |own: &[f64; 4]| {
            let nearer = |other: &&[f64; 4]| other.iter().zip(own).all(|(a, b)| a < b);
            nearest.iter().filter(nearer).take(n).count() < n
        };
        scans.iter().zip(&all).filter(|(_, own)| kept(own)).map(|(scan, _)| *scan).collect()
    }

    /// Makes the batch of some tiles and scans.
    fn batch(&self, numbers: &[u32], listed: &[Listed]) -> Result<Batch> {
        let (mut scans, mut beams) = (Vec::with_capacity(numbers.len()), Vec::new());
        for number in numbers {
            let first = beams.len() as u32;
            self.store.read(*number, &mut beams)?;
            let pose = self.pose(*number).map(|v| v as i32);
            scans.push(Scan { pose, first, count: beams.len() as u32 - first, number: *number, pad: [0; 3] });
        }
        // The entries of each tile; `None` if no scan may touch a cell of it.
        let list = |tile: &Listed| -> Option<Vec<Entry>> {
            let area = self.tile(tile.at);
            let mut touched = false;
            let entries = tile.scans.iter().filter_map(|number| {
                let k = numbers.binary_search(number).ok()?;
                let scan = &scans[k];
                let own = &beams[scan.first as usize..][..scan.count as usize];
                let [low, high] = area.places(scan.pose, own);
                let touches = self.touches(&area, scan.pose, own, [low, high]);
                touched |= touches;
                // A pose may be among the nearest whether or not its beams touch the tile.
                let kept = touches || self.selection.neighbours.is_some();
                kept.then_some(Entry { cone: (k as u32) << ENTRY_SHIFT, slot: low | high << 16 })
            });
            let entries = entries.collect();
            touched.then_some(entries)
        };
        let lists: Vec<Option<Vec<Entry>>> = listed.par_iter().map(list).collect();
        let (mut tiles, mut entries) = (Vec::new(), Vec::new());
        for (tile, list) in listed.iter().zip(lists) {
            let Some(list) = list else { continue };
            let corner = [0, 1].map(|k| (self.chunk.first_cell()[k] + tile.at[k] * TILE) as u32);
            let from = entries.len() as u32;
            entries.extend(list);
            let slot = (tile.at[1] * CHUNK + tile.at[0]) as u32;
            tiles.push(Tile { corner, entries: [from, entries.len() as u32], slot, spare: [0; 3] });
        }
        let chunks = match tiles.is_empty() {
            true => Vec::new(),
            false => vec![ChunkList { place: self.chunk, tiles, entries, cone_bounds: Vec::new() }],
        };
        Ok(Batch { chunks, input: Input::Scans(ScanInput { scans, beams, centres: self.centres.concat() }) })
    }

    /// Whether any beam that may be the nearest of a cell of the box may touch a cell of the box.
    fn touches(&self, area: &Area, pose: [i32; 2], beams: &[Beam], [low, high]: [u32; 2]) -> bool {
        let distance = area.square(pose.map(i64::from)).sqrt();
        let margin = self.selection.margin;
        let n = beams.len() as u32;
        (low..=high).any(|k| {
            let beam = &beams[if k >= n { 0 } else { k as usize }];
            beam.id & IDLE == 0 && distance <= f64::from(beam.range + margin) + 1.0
        })
    }
}
