//! How a run is to be done: with how much memory and disk, checked before it starts.

use crate::grid::GridSpec;
use crate::pipeline::memory;
use crate::pipeline::session::Session;
use crate::support::memory::{available, format_size, free_space};
use crate::{Error, Result};
use std::path::Path;

/// How a run is to be done, checked before it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Readings at a time.
    pub batch: usize,
    /// What the run takes, bytes, apart from the binned readings.
    pub needed: u64,
    /// What the binned readings may take, bytes, before they are spilled.
    pub bins: u64,
    /// What the cells and batches take on a card, bytes, where a GPU maps.
    pub card: u64,
    /// What its files take on disk, bytes, without what is compressed.
    pub disk: u64,
}

/// Memory that a run leaves alone where no cap is given, as a share: others want some too.
const SPARE: u64 = 4;

impl Plan {
    /// The plan for a log under a cap, bytes; `batch`: readings at a time at most.
    ///
    /// # Errors
    /// [`Error::Resources`] where the cap, or the machine, has too little.
    pub fn of(session: &Session, batch: usize, cap: Option<u64>) -> Result<Plan> {
        let free = available().map(|free| free - free / SPARE);
        let limit = [cap, free].into_iter().flatten().min().unwrap_or(4 << 30);
        let (grid, method, used) = (&session.grid, session.method.as_ref(), session.survey.counts.used);
        let batch = memory::whole_batch(batch, limit);
        let needed = memory::whole(grid, method, batch, used, session.survey.scans);
        let card = memory::card(method, batch);
        session.check_memory(needed, cap)?;
        // map.pgm, and the levels of the overview
        let disk = grid.cells() as u64 + grid.cells() as u64 / 3;
        Ok(Plan { batch, needed, bins: limit.saturating_sub(needed) / 2, card, disk })
    }

    /// Fails where a card would need more than the cap, bytes. No adapter tells how much it has free: one that runs out says so.
    ///
    /// # Errors
    /// [`Error::Resources`].
    pub fn check_card(&self, session: &Session, cap: Option<u64>) -> Result<()> {
        match cap {
            Some(cap) if self.card > cap => Err(session.explain(Error::Resources(format!(
                "the cells of a chunk and a batch take {} on the card, but `memory` allows {}: give more, or use `backend cpu`",
                format_size(self.card),
                format_size(cap)
            )))),
            _ => Ok(()),
        }
    }

    /// Fails where the map's files don't fit into a folder; `npy`: every layer is written as an array, too.
    pub fn check_space(&self, session: &Session, folder: &Path, npy: bool) -> Result<()> {
        let GridSpec { width, height, resolution, .. } = session.grid;
        let arrays = 4 * session.method.layers().len() as u64 + 2;
        let needed = self.disk + if npy { arrays * session.grid.cells() as u64 } else { 0 };
        match free_space(folder) {
            Some(free) if needed > free => Err(session.explain(Error::Resources(format!(
                "the files of a map of {width} × {height} cells of {resolution} m take {} and more, but there are {} free: \
                 give smaller `bounds` or a coarser `resolution`",
                format_size(needed),
                format_size(free)
            )))),
            _ => Ok(()),
        }
    }
}
