//! A backend that computes nothing and counts the work, for `plan`.

use super::{Backend, ChunkStates, Limits, Shares};
use crate::Result;
use crate::binning::batch::Batch;
use crate::geometry::layout::Frame;
use crate::grid::ChunkId;
use crate::method::{Method, Step};
use std::collections::BTreeMap;

/// The work in one chunk.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Load {
    /// (Cone, tile) pairs.
    pub entries: u64,
    /// Tiles reached, added up over the batches.
    pub tiles: u64,
}

/// Counts the work of batches.
#[derive(Debug, Default)]
pub struct Dry {
    /// The work in each chunk that readings reach, by chunk row and column.
    pub chunks: BTreeMap<ChunkId, Load>,
}

impl Backend for Dry {
    fn name(&self) -> &'static str {
        "none"
    }

    fn adapter(&self) -> String {
        String::new()
    }

    fn limits(&self) -> Limits {
        Limits {
            readings: 1 << 24,
            entries: usize::MAX,
            parts: usize::MAX,
            max_loop_iterations: usize::MAX,
            bins_tiles: false,
        }
    }

    fn apply(&mut self, _: &dyn Method, _: Frame, batch: &Batch, _: &[Step], _: &mut Shares) -> Result<()> {
        for list in &batch.chunks {
            let load = self.chunks.entry(list.place).or_default();
            load.entries += list.entries.len() as u64;
            load.tiles += list.tiles.len() as u64;
        }
        Ok(())
    }

    fn take(&mut self, _: ChunkId) -> Result<Option<Vec<u32>>> {
        Ok(None)
    }

    fn finish(&mut self, _: &dyn Method) -> Result<ChunkStates> {
        Ok(ChunkStates::new())
    }
}
