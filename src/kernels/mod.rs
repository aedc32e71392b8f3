//! The backends: they run a method's passes over a batch, chunk by chunk.

mod choose;
pub mod cpu;
pub mod dry;
pub mod gpu;

pub use choose::{Choice, Chosen, choose, gpu_required};

use crate::Result;
use crate::batch::Batch;
use crate::layout::{self, Frame};
use crate::method::{self, Method};
use crate::reading::Outcome;
use std::collections::BTreeMap;

/// The cells of the chunks that readings reached: words, tile by tile, plane by plane, row by row; by chunk row and column.
pub type Chunks = BTreeMap<[u32; 2], Vec<u32>>;

/// A batch's readings' outcomes are needed for their shares; one a cone.
pub type Outcomes<'a> = &'a [Outcome];

/// Something that runs a method's sweeps over batches and keeps the cells.
pub trait Backend {
    /// `cpu` or `gpu`.
    fn name(&self) -> &'static str;

    /// The adapter or processor.
    fn adapter(&self) -> String;

    /// Entries that one chunk may have in a batch; more, and the batch is split.
    fn entry_limit(&self) -> usize;

    /// Readings that a batch may have.
    fn reading_limit(&self) -> usize {
        usize::MAX
    }

    /// Runs sweep number `sweep` of the method over a batch.
    fn apply(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        batch: &Batch,
        outcomes: Outcomes,
        sweep: usize,
    ) -> Result<()>;

    /// Returns when all that was applied is done.
    fn wait(&mut self) -> Result<()> {
        Ok(())
    }

    /// Hands over the cells and forgets them.
    fn finish(&mut self, method: &dyn Method) -> Result<Chunks>;
}

/// A chunk of cells that no reading has reached.
pub fn fresh_chunk(method: &dyn Method) -> Vec<u32> {
    let mut tile = vec![0; method::tile_words(method)];
    for (plane, start) in method.start().iter().enumerate() {
        tile[(plane + 2) * layout::TILE_CELLS..][..layout::TILE_CELLS].fill(*start);
    }
    tile.repeat(layout::CHUNK * layout::CHUNK)
}

/// Each reading's share from its count of arc cells.
pub fn shares(method: &dyn Method, counts: impl Iterator<Item = u32>, outcomes: Outcomes) -> Vec<[u32; 4]> {
    counts.zip(outcomes).map(|(count, outcome)| method.share(count, *outcome)).collect()
}
