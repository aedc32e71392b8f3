//! The scans of a log, snapped and stored, and the chunks that their beams may touch; for the methods that take scans.

use crate::Result;
use crate::binning::batch::Batch;
use crate::binning::batch::PAIRS;
use crate::binning::scan::{Index, Most, Scan, Selection, Store, Tiles, micrometres, snap};
use crate::grid::GridSpec;
use crate::grid::{ChunkId, EDGE};
use crate::kernels::{Backend, Limits};
use crate::method::Method;
use crate::pipeline::batching::{BatchStatistics, frame};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Beams that a batch may hold for each of its readings: a beam takes less memory than a cone and its pairs.
const BEAMS_PER_READING: usize = 16;
/// Rays that are snapped together, in parallel.
const SNAP_TOGETHER: usize = 1 << 17;

/// Where beams go that outgrow their share of memory.
#[derive(Debug, Clone)]
pub struct Spill {
    /// The folder of the nameless file that takes them.
    pub folder: PathBuf,
    /// The memory that they may take before they are spilled, bytes.
    pub memory: u64,
}

impl Spill {
    /// Keeps all beams in memory.
    pub fn never() -> Spill {
        Spill { folder: std::env::temp_dir(), memory: u64::MAX }
    }
}

/// The snapped scans of a log, by the chunks that they may touch.
pub struct ChunkedScans {
    grid: GridSpec,
    selection: Selection,
    store: Store,
    /// Scans that are not snapped yet, and the number of their rays.
    waiting: Vec<Scan>,
    waiting_rays: usize,
    index: Option<Index>,
    /// The used readings of the scans that may touch each chunk.
    reached: BTreeMap<ChunkId, u64>,
}

impl ChunkedScans {
    /// Snaps the scans of a log onto a grid. `progress` receives the number of used readings since its last call.
    ///
    /// # Errors
    /// The log's, and [`crate::Error::Resources`] where beams can't be spilled.
    pub fn read(
        grid: &GridSpec,
        selection: Selection,
        scans: impl Iterator<Item = Result<Scan>>,
        spill: &Spill,
        progress: &dyn Fn(u64),
    ) -> Result<ChunkedScans> {
        let mut scanned = ChunkedScans::new(grid, selection, spill);
        for scan in scans {
            let scan = scan?;
            progress(scan.used);
            scanned.push(scan)?;
        }
        scanned.finish()
    }

    fn new(grid: &GridSpec, selection: Selection, spill: &Spill) -> ChunkedScans {
        ChunkedScans {
            grid: *grid,
            selection,
            store: Store::new(&spill.folder, spill.memory),
            waiting: Vec::new(),
            waiting_rays: 0,
            index: None,
            reached: BTreeMap::new(),
        }
    }

    fn push(&mut self, scan: Scan) -> Result<()> {
        self.waiting_rays += scan.rays.len();
        self.waiting.push(scan);
        if self.waiting_rays >= SNAP_TOGETHER { self.snap() } else { Ok(()) }
    }

    /// Snaps and stores the waiting scans.
    fn snap(&mut self) -> Result<()> {
        let selection = self.selection;
        let snapped: Vec<_> = self.waiting.par_iter().map(|s| snap(s, &selection)).collect();
        self.waiting_rays = 0;
        for (scan, snapped) in self.waiting.drain(..).zip(snapped) {
            for place in chunks_around(&self.grid, snapped.pose, snapped.reach) {
                *self.reached.entry(place).or_default() += scan.used;
            }
            self.store.push(snapped)?;
        }
        Ok(())
    }

    /// Builds the index of the poses, once all scans are there.
    fn finish(mut self) -> Result<ChunkedScans> {
        self.snap()?;
        self.index = self.selection.neighbours.map(|n| Index::new(&self.store.poses, usize::from(n)));
        Ok(self)
    }

    /// The chunks that beams may touch, row by row, each with the number of used readings of the scans that may touch it.
    pub fn chunks(&self) -> Vec<(ChunkId, u64)> {
        self.reached.iter().map(|(place, count)| (*place, *count)).collect()
    }

    /// The beams that were spilled, bytes.
    pub fn spilled(&self) -> u64 {
        self.store.spilled()
    }

    /// Gives the batches of a chunk in order. A batch holds as many beams as take the memory of `batch` readings. `give` gets the
    /// batch, its share of the chunk's work and whether it is the last; it returns `false` to stop.
    ///
    /// # Errors
    /// [`crate::Error::Resources`] where spilled beams can't be read back.
    pub fn batches(
        &self,
        place: ChunkId,
        batch: usize,
        limits: Limits,
        give: &mut dyn FnMut(Batch, f64, bool) -> bool,
    ) -> Result<()> {
        let beams = batch.saturating_mul(BEAMS_PER_READING).min(limits.readings);
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

    /// Runs the batches of every chunk on a backend, with all chunks resident. `progress` receives the number of readings done since
    /// its last call; a reading counts once in each chunk that it may touch.
    ///
    /// # Errors
    /// The backend's.
    pub fn apply(
        &self,
        method: &dyn Method,
        backend: &mut dyn Backend,
        batch: usize,
        progress: &dyn Fn(u64),
    ) -> Result<BatchStatistics> {
        let (mut statistics, started, mut computing) = (BatchStatistics::default(), Instant::now(), Duration::ZERO);
        let (frame, steps, limits) = (frame(&self.grid, method), method.sweeps()[0], backend.limits());
        for (place, count) in self.chunks() {
            let mut failed = None;
            self.batches(place, batch, limits, &mut |batch, share, _| {
                statistics.count(&batch);
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
        statistics.binning_us = (started.elapsed() - computing).as_micros() as u64;
        Ok(statistics)
    }
}

/// The chunks that meet a square around a pose; `pose` and `reach` in µm.
fn chunks_around(grid: &GridSpec, pose: [i64; 2], reach: i32) -> impl Iterator<Item = ChunkId> {
    let edge = (EDGE as f64 * grid.resolution * 1e6).max(1.0);
    let corner = [micrometres(grid.x0()), micrometres(grid.y0())];
    let spans = [(0, grid.width), (1, grid.height)].map(|(k, cells)| {
        let at = |v: i64| ((v - corner[k]) as f64 / edge).floor();
        let last = cells.div_ceil(EDGE) as f64;
        let (from, to) = (at(pose[k] - i64::from(reach)), at(pose[k] + i64::from(reach)) + 1.0);
        from.clamp(0.0, last) as u32..to.clamp(0.0, last) as u32
    });
    let [columns, rows] = if reach > 0 { spans } else { [0..0, 0..0] };
    rows.flat_map(move |row| columns.clone().map(move |column| ChunkId { row, column }))
}
