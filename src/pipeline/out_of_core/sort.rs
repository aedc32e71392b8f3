//! Sorts the readings of a log to the chunks that they reach.

use super::ChunkBins;
use super::reader::binning;
use crate::geometry::layout::Cone;
use crate::grid::ChunkId;
use crate::log::reading::Counts;
use crate::pipeline::batching::{count_reached, snap_reading};
use crate::pipeline::readings::ReadingInput;
use crate::pipeline::session::Session;
use crate::{Error, Result};
use rayon::prelude::*;

/// Sorts a log's readings to chunks.
pub(super) struct Sorter<'a> {
    session: &'a Session,
    /// The sorted readings.
    pub bins: ChunkBins,
    /// `outside`, `empty_arc` and `wide` are counted here.
    pub counts: Counts,
    /// Readings sorted so far.
    pub readings: u64,
}

impl<'a> Sorter<'a> {
    /// Creates a sorter that fills empty bins.
    pub fn new(session: &'a Session, bins: ChunkBins) -> Sorter<'a> {
        Sorter { session, bins, counts: Counts::default(), readings: 0 }
    }

    /// Sorts all readings of the session, `batch` at a time.
    ///
    /// # Errors
    /// The log's; [`Error::Resources`] where readings can't be spilled, or are more than a cone's 32-bit index can number.
    pub fn sort(&mut self, batch: usize, progress: &dyn Fn(u64)) -> Result<()> {
        let mut held = Vec::with_capacity(batch);
        for item in self.session.readings()? {
            held.push(item?);
            progress(1);
            if held.len() == batch {
                self.sort_batch(&held)?;
                held.clear();
            }
        }
        self.sort_batch(&held)
    }

    fn sort_batch(&mut self, items: &[ReadingInput]) -> Result<()> {
        let (grid, sensors, method) = (&self.session.grid, self.session.sensors(), self.session.method.as_ref());
        let binning = binning(grid, method, &[], None);
        let first = self.readings;
        self.readings += items.len() as u64;
        if self.readings > u64::from(u32::MAX) {
            return Err(Error::Resources("more than 4294967295 used readings: map the log in parts".into()));
        }
        let cones: Vec<Option<(Cone, Vec<ChunkId>)>> = items
            .par_iter()
            .enumerate()
            .map(|(k, item)| {
                let cone = Cone { index: (first + k as u64) as u32, ..snap_reading(grid, sensors, method, item)? };
                Some((cone, binning.chunks_of(&cone)))
            })
            .collect();
        let snapped: Vec<Cone> = cones.iter().flatten().map(|c| c.0).collect();
        self.counts.outside += (cones.len() - snapped.len()) as u64;
        count_reached(&mut self.counts, &binning, &snapped);
        for (cone, chunks) in cones.into_iter().flatten() {
            for chunk in chunks {
                self.bins.push(chunk, cone)?;
            }
        }
        Ok(())
    }
}
