//! Reads the inputs of a chunk and bins them to batches, in log order.

use super::ChunkBins;
use crate::Result;
use crate::binning::batch::{Batch, Binning, snapped};
use crate::geometry::layout::Cone;
use crate::grid::{ChunkId, GridSpec};
use crate::kernels::Limits;
use crate::method::{Method, Step, Steps};
use crate::pipeline::batching::exceeds_limits;
use crate::pipeline::scans::ChunkedScans;

/// The inputs of all chunks.
pub(super) enum InputSource {
    /// Readings, by chunk.
    Readings(ChunkBins),
    /// Scans, with an index of their poses.
    Scans(Box<ChunkedScans>),
}

impl InputSource {
    /// The chunks that readings reach, row by row, each with its number of readings.
    pub fn chunks(&self) -> Vec<(ChunkId, u64)> {
        match self {
            InputSource::Readings(bins) => bins.chunks(),
            InputSource::Scans(scans) => scans.chunks(),
        }
    }

    /// Bytes that were spilled to disk.
    pub fn spilled(&self) -> u64 {
        match self {
            InputSource::Readings(bins) => bins.spilled(),
            InputSource::Scans(scans) => scans.spilled(),
        }
    }
}

/// A batch of one chunk's readings, binned.
pub(super) struct BinnedBatch {
    pub place: ChunkId,
    pub steps: Steps,
    pub batch: Batch,
    /// The numbers of its readings in the log; empty for scans.
    pub numbers: Vec<u32>,
    /// Its share of the chunk's number of readings.
    pub readings: u64,
    /// Whether it is the chunk's last of this round.
    pub last: bool,
}

/// Reads chunks batch by batch.
pub(super) struct ChunkReader<'a> {
    pub source: &'a InputSource,
    pub grid: &'a GridSpec,
    pub method: &'a dyn Method,
    /// Readings at a time; the backend's limits may lower it.
    pub batch: usize,
    pub limits: Limits,
}

/// A part of a chunk's readings, to be binned.
struct ChunkPart<'a> {
    binning: &'a Binning,
    place: ChunkId,
    steps: Steps,
    /// Whether it holds the chunk's last readings of the round.
    last: bool,
}

/// Takes a batch; returns `false` to take no more.
pub(super) type OnBatch<'a> = dyn FnMut(BinnedBatch) -> bool + 'a;

/// The binning of a method's readings onto a grid, or onto one chunk of it, for these steps.
pub(super) fn binning(grid: &GridSpec, method: &dyn Method, steps: &[Step], only: Option<ChunkId>) -> Binning {
    Binning {
        size: [grid.width, grid.height],
        footprint: method.footprint(),
        no_echo_arcs: steps.contains(&Step::AccumulateCounts),
        only,
    }
}

impl ChunkReader<'_> {
    /// Gives the batches of a chunk in order, one pass over its readings for each of `traversals`. `give` returns `false` to stop.
    ///
    /// # Errors
    /// [`crate::Error::Resources`] where spilled readings can't be read back, or one reading exceeds the backend's limits.
    pub fn batches(&self, place: ChunkId, count: u64, traversals: &'static [Steps], give: &mut OnBatch) -> Result<()> {
        match self.source {
            InputSource::Readings(bins) => self.of_readings(bins, (place, count as usize), traversals, give),
            InputSource::Scans(scans) => {
                let batch = self.batch.clamp(1, self.limits.readings);
                scans.batches(place, batch, self.limits, &mut |batch, share, last| {
                    let readings = (share * count as f64) as u64;
                    give(BinnedBatch { place, steps: traversals[0], batch, numbers: Vec::new(), readings, last })
                })
            }
        }
    }

    fn of_readings(
        &self,
        bins: &ChunkBins,
        (place, count): (ChunkId, usize),
        traversals: &'static [Steps],
        give: &mut OnBatch,
    ) -> Result<()> {
        let batch = self.batch.clamp(1, self.limits.readings);
        for (t, steps) in traversals.iter().enumerate() {
            let binning = &binning(self.grid, self.method, steps, Some(place));
            for first in (0..count).step_by(batch) {
                let last = t + 1 == traversals.len() && first + batch >= count;
                let part = ChunkPart { binning, place, steps, last };
                if !self.split(&part, bins.read(place, first, batch)?, give)? {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Bins cones, in halves where they exceed the backend's limits; returns whether they were all taken.
    fn split(&self, part: &ChunkPart, cones: Vec<Cone>, give: &mut OnBatch) -> Result<bool> {
        let ChunkPart { binning, place, steps, last } = *part;
        let numbers: Vec<u32> = cones.iter().map(|c| c.index).collect();
        let batch = binning.of(&cones, snapped, self.limits.bins_tiles);
        let sums = steps.contains(&Step::Sum);
        let fits = match &batch {
            Some(batch) => !exceeds_limits(self.method, batch, sums, self.limits, cones.len() == 1)?,
            None => false,
        };
        match batch.filter(|_| fits) {
            Some(batch) => Ok(give(BinnedBatch { place, steps, batch, readings: numbers.len() as u64, numbers, last })),
            None => {
                let (front, back) = cones.split_at(cones.len() / 2);
                let first = ChunkPart { last: false, ..*part };
                Ok(self.split(&first, front.to_vec(), give)? && self.split(part, back.to_vec(), give)?)
            }
        }
    }
}
