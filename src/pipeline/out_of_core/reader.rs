//! The batches of a chunk, binned, in log order.

use super::{Bins, Scanned};
use crate::Result;
use crate::binning::batch::{Batch, Binning, snapped};
use crate::geometry::layout::Cone;
use crate::grid::{GridSpec, Place};
use crate::kernels::Limits;
use crate::method::{Method, Step, Steps};
use crate::pipeline::mapper::too_large;

/// What the chunks are made of.
pub(super) enum Source {
    /// Readings, by chunk.
    Readings(Bins),
    /// Scans, and where their poses are.
    Scans(Box<Scanned>),
}

impl Source {
    /// The chunks that readings reach, row by row, and how many readings each has.
    pub fn places(&self) -> Vec<(Place, u64)> {
        match self {
            Source::Readings(bins) => bins.places(),
            Source::Scans(scans) => scans.places(),
        }
    }

    /// Bytes that were spilled to disk.
    pub fn spilled(&self) -> u64 {
        match self {
            Source::Readings(bins) => bins.spilled(),
            Source::Scans(scans) => scans.spilled(),
        }
    }
}

/// A batch of one chunk's readings, binned.
pub(super) struct BinnedBatch {
    pub place: Place,
    pub steps: Steps,
    pub batch: Batch,
    /// The readings' numbers in the log; none for scans.
    pub numbers: Vec<u32>,
    /// How many readings it is, in the chunk's count.
    pub readings: u64,
    /// Whether it is the chunk's last of this round.
    pub last: bool,
}

/// Reads chunks batch by batch.
pub(super) struct Reader<'a> {
    pub source: &'a Source,
    pub grid: &'a GridSpec,
    pub method: &'a dyn Method,
    /// Readings at a time, before the backend's limits.
    pub batch: usize,
    pub limits: Limits,
}

/// One part of a chunk's readings, to be binned.
struct Part<'a> {
    binning: &'a Binning,
    place: Place,
    steps: Steps,
    /// Whether it holds the chunk's last readings of the round.
    last: bool,
}

/// Takes batches; `false` when it takes no more.
pub(super) type Give<'a> = dyn FnMut(BinnedBatch) -> bool + 'a;

/// How a method's readings are binned onto a grid for these steps.
pub(super) fn binning(grid: &GridSpec, method: &dyn Method, steps: &[Step], only: Option<Place>) -> Binning {
    Binning {
        size: [grid.width, grid.height],
        footprint: method.footprint(),
        no_echo_arcs: steps.contains(&Step::AccumulateCounts),
        only: only.map(|[row, column]| [column, row]),
    }
}

impl Reader<'_> {
    /// Gives a chunk's batches in order, `traversals` times over its readings; stops when nobody takes them any more.
    pub fn batches(&self, place: Place, count: u64, traversals: &'static [Steps], give: &mut Give) -> Result<()> {
        match self.source {
            Source::Readings(bins) => self.of_readings(bins, place, count as usize, traversals, give),
            Source::Scans(scans) => {
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
        bins: &Bins,
        place: Place,
        count: usize,
        traversals: &'static [Steps],
        give: &mut Give,
    ) -> Result<()> {
        let batch = self.batch.clamp(1, self.limits.readings);
        for (t, steps) in traversals.iter().enumerate() {
            let binning = &binning(self.grid, self.method, steps, Some(place));
            for first in (0..count).step_by(batch) {
                let last = t + 1 == traversals.len() && first + batch >= count;
                let part = Part { binning, place, steps, last };
                if !self.split(&part, bins.read(place, first, batch)?, give)? {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Bins cones, in halves where they come to too much; whether they were all taken.
    fn split(&self, part: &Part, cones: Vec<Cone>, give: &mut Give) -> Result<bool> {
        let Part { binning, place, steps, last } = *part;
        let numbers: Vec<u32> = cones.iter().map(|c| c.index).collect();
        let batch = binning.of(&cones, snapped, self.limits.bins_tiles);
        let sums = steps.contains(&Step::Sum);
        let fits = match &batch {
            Some(batch) => !too_large(self.method, batch, sums, self.limits, cones.len() == 1)?,
            None => false,
        };
        match batch.filter(|_| fits) {
            Some(batch) => Ok(give(BinnedBatch { place, steps, batch, readings: numbers.len() as u64, numbers, last })),
            None => {
                let (head, tail) = cones.split_at(cones.len() / 2);
                let first = Part { last: false, ..*part };
                Ok(self.split(&first, head.to_vec(), give)? && self.split(part, tail.to_vec(), give)?)
            }
        }
    }
}
