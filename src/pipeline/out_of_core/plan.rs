//! The memory and disk that a run will take, checked before it starts.

use crate::grid::GridSpec;
use crate::pipeline::memory;
use crate::pipeline::session::Session;
use crate::support::memory::{available, format_size, free_space};
use crate::{Error, Result};
use std::path::Path;

/// The batch size of a run, and the memory and disk that it will take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResourcePlan {
    /// Readings at a time.
    pub batch: usize,
    /// Memory of the run, bytes, without the binned readings.
    pub needed: u64,
    /// Memory that the binned readings may take, bytes, before they are spilled.
    pub bins: u64,
    /// Memory of the cells and batches on a card, bytes, where a GPU maps.
    pub card: u64,
    /// Disk space of the files that are not compressed, bytes.
    pub disk: u64,
}

/// One part in so many of the free memory is left to other programs where no cap is given.
const SPARE: u64 = 4;

impl ResourcePlan {
    /// Plans a run under a cap, bytes. `batch`: the most readings at a time.
    ///
    /// # Errors
    /// [`Error::Resources`] where the cap, or the machine, has too little.
    pub fn of(session: &Session, batch: usize, cap: Option<u64>) -> Result<ResourcePlan> {
        let free = available().map(|free| free - free / SPARE);
        let limit = [cap, free].into_iter().flatten().min().unwrap_or(4 << 30);
        let (grid, method, used) = (&session.grid, session.method.as_ref(), session.survey.counts.used);
        let batch = memory::out_of_core_batch(batch, limit);
        let needed = memory::out_of_core(grid, method, batch, used, session.survey.scans);
        let card = memory::card(method, batch);
        session.check_memory(needed, cap)?;
        // map.pgm, and the levels of the overview
        let disk = grid.cells() as u64 + grid.cells() as u64 / 3;
        Ok(ResourcePlan { batch, needed, bins: limit.saturating_sub(needed) / 2, card, disk })
    }

    /// Checks that a card needs no more than the cap, bytes. No adapter tells how much memory it has free.
    ///
    /// # Errors
    /// [`Error::Resources`] where it needs more.
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

    /// Checks that the map's files fit into a folder; `npy`: every layer is written as an array, too.
    ///
    /// # Errors
    /// [`Error::Resources`] where they don't.
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
