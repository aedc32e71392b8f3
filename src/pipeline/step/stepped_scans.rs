//! The scans of a log, for stepping. The beams that a cell takes depend on all poses so far. So a step by a scan recomputes the tiles for
//! which the pose of that scan may be among the nearest.

use super::cells::{Tiles, place, tile_at};
use crate::Result;
use crate::binning::batch::PAIRS;
use crate::binning::scan::{Index, Most, Scan, Selection, Store, Tiles as Listing, snap};
use crate::geometry::layout::CHUNK;
use crate::grid::{ChunkId, chunks, part};
use crate::kernels::Backend;
use crate::kernels::cpu::Cpu;
use crate::method::settings::Csm;
use crate::method::tile_words;
use crate::pipeline::batching::frame;
use crate::pipeline::session::Session;
use rayon::prelude::*;
use std::ops::Range;

/// The scans of a log, snapped.
pub struct SteppedScans {
    /// The scans, in log order.
    pub all: Vec<Scan>,
    /// The counting sensor model.
    pub csm: Csm,
    selection: Selection,
    store: Store,
}

/// The limits of a batch.
const MOST: Most = Most { beams: 1 << 20, pairs: PAIRS, one: [1 << 27; 2], max_loop_iterations: usize::MAX };

impl SteppedScans {
    /// Reads and snaps all scans of a session.
    pub fn read(session: &Session, csm: Csm, selection: Selection) -> Result<SteppedScans> {
        let all: Vec<Scan> = session.scans()?.collect::<Result<_>>()?;
        let mut store = Store::new(&std::env::temp_dir(), u64::MAX);
        let snapped: Vec<_> = all.par_iter().map(|s| snap(s, &selection)).collect();
        snapped.into_iter().try_for_each(|scan| store.push(scan))?;
        Ok(SteppedScans { all, csm, selection, store })
    }

    fn index(&self, scans: usize) -> Option<Index> {
        self.selection.neighbours.map(|n| Index::new(&self.store.poses[..scans], usize::from(n)))
    }

    /// The change of the cells from the first `from` scans of the log to the first `to`.
    pub fn change(&self, session: &Session, from: usize, to: usize) -> Change {
        let (scans, larger) = (from.min(to)..from.max(to), self.index(from.max(to)));
        let range = scans.start as u32..scans.end as u32;
        let near = |chunk: &ChunkId| {
            let grid = part(&session.grid, *chunk);
            let farthest = self.selection.z_max + grid.resolution;
            let ends = [(grid.x0(), grid.width), (grid.y0(), grid.height)]
                .map(|(low, n)| [low, low + n as f64 * grid.resolution]);
            self.store.poses[scans.clone()].iter().any(|pose| {
                let away = |k: usize| {
                    let at = pose[k] as f64 * 1e-6;
                    (ends[k][0] - at).max(at - ends[k][1]).max(0.0)
                };
                away(0).hypot(away(1)) <= farthest
            })
        };
        let of = |chunk: ChunkId| {
            let listing = Listing::of(&session.grid, chunk, &self.store, larger.as_ref(), self.selection);
            (chunk, listing.concerned(range.clone()))
        };
        let tiles = chunks(&session.grid).filter(near).map(of).filter(|(_, tiles)| !tiles.is_empty()).collect();
        let index = if to >= from { larger } else { self.index(to) };
        // Where a cell takes all poses more scans only add to what is there.
        let adds = (self.selection.neighbours.is_none() && to > from).then_some(from as u32..to as u32);
        Change { tiles, index, adds, to }
    }

    /// Recomputes the cells that change.
    pub fn apply(&self, session: &Session, change: Change, cpu: &mut Cpu) -> Result<()> {
        let (method, words) = (session.method.as_ref(), tile_words(session.method.as_ref()));
        let Change { tiles, index, adds, to } = change;
        for (chunk, tiles) in tiles {
            if let (None, Some(state)) = (&adds, cpu.chunks_mut().get_mut(&chunk)) {
                for at in &tiles {
                    let (_, slot) = place(tile(chunk, *at));
                    state[slot * words..(slot + 1) * words].fill(0);
                }
            }
            let mut failed = None;
            let listing = Listing::of(&session.grid, chunk, &self.store, index.as_ref(), self.selection);
            listing.batches_of(tiles, adds.clone().unwrap_or(0..to as u32), MOST, &mut |batch, _| {
                let (frame, steps) = (frame(&session.grid, method), method.sweeps()[0]);
                failed = cpu.apply(method, frame, &batch, steps, &mut Vec::new()).err();
                failed.is_none()
            })?;
            failed.map_or(Ok(()), Err)?;
        }
        Ok(())
    }
}

/// A change of the number of scans.
pub struct Change {
    /// The tiles that may change, by chunk.
    tiles: Vec<(ChunkId, Vec<[usize; 2]>)>,
    /// The index of the poses after the change.
    index: Option<Index>,
    /// The scans to add to the present state; `None`: the tiles are computed from nothing.
    adds: Option<Range<u32>>,
    /// The number of scans after the change.
    to: usize,
}

impl Change {
    /// The tiles that may change, by row and column in the grid.
    pub fn reached(&self) -> Tiles {
        self.tiles.iter().flat_map(|(chunk, tiles)| tiles.iter().map(|at| tile(*chunk, *at))).collect()
    }
}

/// The row and column in the grid of a chunk's tile.
fn tile(chunk: ChunkId, [column, row]: [usize; 2]) -> [u32; 2] {
    tile_at(chunk, (row * CHUNK + column) as u32)
}
