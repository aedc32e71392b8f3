//! What is to be done: a batch, the steps over it, and what of the adapter decides how.

use crate::binning::batch::Batch;
use crate::geometry::layout::Frame;
use crate::method::{self, Method, Step};

/// A batch, and the steps to take over it.
pub struct Work<'a> {
    /// The method.
    pub method: &'a dyn Method,
    /// The passes' frame; each pass sets its mode.
    pub frame: Frame,
    /// The batch.
    pub batch: &'a Batch,
    /// The steps.
    pub steps: &'a [Step],
    /// Where the readings' shares start from.
    pub shares: &'a [[u32; 4]],
}

impl Work<'_> {
    /// Bytes of the cells of a tile.
    pub fn tile_bytes(&self) -> u64 {
        (method::tile_words(self.method) * size_of::<u32>()) as u64
    }
}

/// What of the adapter and its kernels decides the buffers.
#[derive(Debug, Clone, Copy)]
pub struct Capacity {
    /// Bytes of a tile's part of a reading's sum.
    pub part_bytes: usize,
    /// Tiles of a chunk whose cells fit into one binding.
    pub tiles_per_binding: usize,
}
