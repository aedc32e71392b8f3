//! A log's scans, snapped, and the chunks that their beams may touch: for the methods that take scans.

use crate::Result;
use crate::binning::batch::Batch;
use crate::binning::batch::PAIRS;
use crate::binning::scan::{Index, Most, Scan, Selection, Store, Tiles, micrometres, snap};
use crate::grid::GridSpec;
use crate::grid::{EDGE, Place};
use crate::kernels::{Backend, Limits};
use crate::method::Method;
use crate::pipeline::mapper::{Work, frame};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// Beams that a batch may hold for each of its readings: a beam takes less than a cone and its pairs.
const BEAMS: usize = 16;
/// Rays that wait to be snapped together.
const TOGETHER: usize = 1 << 17;

/// The scans of a log.
pub struct Scanned {
    grid: GridSpec,
    selection: Selection,
    store: Store,
    waiting: Vec<Scan>,
    /// Rays of those.
    rays: usize,
    index: Option<Index>,
    reached: BTreeMap<Place, u64>,
}

impl Scanned {
    /// Snaps a log's scans for a model on a grid; `memory` is what their beams may take, bytes, before they are spilled to `folder`;
    /// `progress` hears of each used reading.
    ///
    /// # Errors
    /// The log's, and [`crate::Error::Resources`] where beams can't be spilled.
    pub fn read(
        grid: &GridSpec,
        selection: Selection,
        scans: impl Iterator<Item = Result<Scan>>,
        (folder, memory): (&Path, u64),
        progress: &dyn Fn(u64),
    ) -> Result<Scanned> {
        let mut scanned = Scanned::new(grid, selection, folder, memory);
        for scan in scans {
            let scan = scan?;
            progress(scan.used);
            scanned.push(scan)?;
        }
        scanned.finish()
    }

    fn new(grid: &GridSpec, selection: Selection, folder: &Path, memory: u64) -> Scanned {
        let store = Store::new(folder, memory);
        Scanned { grid: *grid, selection, store, waiting: Vec::new(), rays: 0, index: None, reached: BTreeMap::new() }
    }

    fn push(&mut self, scan: Scan) -> Result<()> {
        self.rays += scan.rays.len();
        self.waiting.push(scan);
        if self.rays >= TOGETHER { self.snap() } else { Ok(()) }
    }

    fn snap(&mut self) -> Result<()> {
        let selection = self.selection;
        let snapped: Vec<_> = self.waiting.par_iter().map(|s| snap(s, &selection)).collect();
        self.rays = 0;
        for (scan, snapped) in self.waiting.drain(..).zip(snapped) {
            for place in chunks(&self.grid, snapped.pose, snapped.reach) {
                *self.reached.entry(place).or_default() += scan.used;
            }
            self.store.push(snapped)?;
        }
        Ok(())
    }

    /// All are there: finds where their poses are.
    fn finish(mut self) -> Result<Scanned> {
        self.snap()?;
        self.index = self.selection.neighbours.map(|n| Index::new(&self.store.poses, usize::from(n)));
        Ok(self)
    }

    /// The chunks that beams may touch, row by row, and the used readings of the scans that may.
    pub fn places(&self) -> Vec<(Place, u64)> {
        self.reached.iter().map(|(place, count)| (*place, *count)).collect()
    }

    /// Bytes of beams that were spilled.
    pub fn spilled(&self) -> u64 {
        self.store.spilled()
    }

    /// Gives a chunk's batches in order, of as many beams as `batch` readings weigh, each with the share of the chunk's work
    /// that it is and whether it is the last; stops when one isn't taken.
    ///
    /// # Errors
    /// [`crate::Error::Resources`] where spilled beams can't be read back.
    pub fn batches(
        &self,
        place: Place,
        batch: usize,
        limits: Limits,
        give: &mut dyn FnMut(Batch, f64, bool) -> bool,
    ) -> Result<()> {
        let beams = batch.saturating_mul(BEAMS).min(limits.readings);
        let most = Most {
            beams,
            pairs: PAIRS.min(limits.entries),
            one: [limits.readings, limits.entries],
            max_loop_iterations: limits.max_loop_iterations,
        };
        let mut held: Option<(Batch, f64)> = None;
        let tiles = Tiles::of(&self.grid, place, &self.store, self.index.as_ref(), self.selection);
        let taken = tiles.batches(most, &mut |batch, share| {
            held.replace((batch, share)).is_none_or(|(batch, share)| give(batch, share, false))
        })?;
        if let Some((batch, share)) = held.filter(|_| taken) {
            give(batch, share, true);
        }
        Ok(())
    }

    /// Runs every chunk's batches on a backend, all chunks resident; `progress` hears of readings, each once a chunk.
    ///
    /// # Errors
    /// The backend's.
    pub fn apply(
        &self,
        method: &dyn Method,
        backend: &mut dyn Backend,
        batch: usize,
        progress: &dyn Fn(u64),
    ) -> Result<Work> {
        let (mut work, started, mut computing) = (Work::default(), Instant::now(), Duration::ZERO);
        let (frame, steps, limits) = (frame(&self.grid, method), method.sweeps()[0], backend.limits());
        for (place, count) in self.places() {
            let mut failed = None;
            self.batches(place, batch, limits, &mut |batch, share, _| {
                work.count(&batch);
                let applied = Instant::now();
                failed = backend.apply(method, frame, &batch, steps, &mut Vec::new()).err();
                computing += applied.elapsed();
                progress((share * count as f64) as u64);
                failed.is_none()
            })?;
            if let Some(e) = failed {
                return Err(e);
            }
        }
        work.binning_us = (started.elapsed() - computing).as_micros() as u64;
        Ok(work)
    }
}

/// The chunks that meet a square around a pose; µm.
fn chunks(grid: &GridSpec, pose: [i64; 2], reach: i32) -> impl Iterator<Item = Place> {
    let edge = (EDGE as f64 * grid.resolution * 1e6).max(1.0);
    let corner = [micrometres(grid.x0()), micrometres(grid.y0())];
    let spans = [(0, grid.width), (1, grid.height)].map(|(k, cells)| {
        let at = |v: i64| ((v - corner[k]) as f64 / edge).floor();
        let last = cells.div_ceil(EDGE) as f64;
        let (from, to) = (at(pose[k] - i64::from(reach)), at(pose[k] + i64::from(reach)) + 1.0);
        from.clamp(0.0, last) as u32..to.clamp(0.0, last) as u32
    });
    let [columns, rows] = if reach > 0 { spans } else { [0..0, 0..0] };
    rows.flat_map(move |row| columns.clone().map(move |column| [row, column]))
}
