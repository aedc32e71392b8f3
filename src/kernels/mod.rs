//! The backends run a method's passes over a batch, chunk by chunk, and keep the cells. What depends on wgpu is in `gpu`, behind the
//! cargo feature of that name; the rest compiles without it.

pub mod adapter;
pub mod bindings;
mod choose;
pub mod cpu;
pub mod dry;
mod error;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod peak;
pub mod shader;
pub mod vulkan;

pub use choose::{Choice, Chosen, adapters, choose, gpu_required};
pub use error::KernelError;

use crate::Result;
use crate::binning::batch::Batch;
use crate::geometry::layout::{Cone, Frame, NO_ECHO};
use crate::grid::ChunkId;
use crate::log::reading::Outcome;
use crate::method::driver::WrongInput;
use crate::method::{Method, Step};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The state of every chunk that a batch reached, row by row: words, tile by tile, plane by plane, row by row.
pub type ChunkStates = BTreeMap<ChunkId, Vec<u32>>;

/// What the steps so far found for each cone of a batch: the bits of a sum, a count, or what [`Method::share`] made of the count.
pub type Shares = Vec<[u32; 4]>;

/// The most that a batch may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Readings.
    pub readings: usize,
    /// Entries of one chunk.
    pub entries: usize,
    /// Parts of sums: (tile, arc) pairs.
    pub parts: usize,
    /// Iterations of a thread's loops ([`Batch::max_loop_iterations`]): Mesa's software adapter silently ends a loop once all loops of a
    /// thread have had 65535.
    pub max_loop_iterations: usize,
    /// Whether the backend bins a batch's cones into tiles itself ([`crate::binning::batch::Binning::bound_cones`]).
    pub bins_tiles: bool,
}

/// Runs a method's steps over batches and keeps the cells.
pub trait Backend: Send {
    /// `cpu` or `gpu`.
    fn name(&self) -> &'static str;

    /// The adapter or processor.
    fn adapter(&self) -> String;

    /// The largest batch that it takes.
    fn limits(&self) -> Limits;

    /// Runs the steps over a batch, in order, and starts from `shares`: one for each cone, or empty for zeros. Only [`Step::ReadBack`]
    /// and [`Step::AccumulateCounts`] change `shares`.
    ///
    /// # Errors
    /// [`crate::Error::Kernel`] where a pass can't run; what the adapter reports.
    fn apply(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        batch: &Batch,
        steps: &[Step],
        shares: &mut Shares,
    ) -> Result<()>;

    /// Measures the processor's peak rates; `None` where there is no processor.
    fn peaks(&mut self) -> Result<Option<peak::Peaks>> {
        Ok(None)
    }

    /// Starts to time each pass. This may slow down what lies between the passes.
    fn time_passes(&mut self) {}

    /// Stops the timing and returns the total of each kind of pass, seconds, by the processor's own clock; empty where it has none.
    fn pass_times(&mut self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// Waits until all batches so far are done.
    fn wait(&mut self) -> Result<()> {
        Ok(())
    }

    /// Moves the cells of the chunk in this row and column out of the backend; `None` where no batch reached it.
    fn take(&mut self, place: ChunkId) -> Result<Option<Vec<u32>>>;

    /// Whether [`Backend::recycle`] saves anything.
    fn recycles_buffers(&self) -> bool {
        false
    }

    /// Takes back a chunk's memory, filled with zeros, for a later chunk.
    fn recycle(&mut self, _zeros: Vec<u32>) {}

    /// Moves all cells out of the backend.
    fn finish(&mut self, method: &dyn Method) -> Result<ChunkStates>;
}

/// Makes each reading's share from its count of arc cells.
pub fn normalize_by_count(method: &dyn Method, counts: impl Iterator<Item = u32>, cones: &[Cone]) -> Shares {
    let outcome = |cone: &Cone| if cone.flags & NO_ECHO != 0 { Outcome::NoEcho } else { Outcome::Hit };
    let counts: Vec<u32> = counts.collect();
    counts.par_iter().with_min_len(256).zip(cones).map(|(count, cone)| method.share(*count, outcome(cone))).collect()
}

/// Fails where a batch is not of the kind that the method takes.
fn check_input(method: &dyn Method, batch: &Batch) -> std::result::Result<(), KernelError> {
    let (takes, given) = (method.unit().name(), batch.input.name());
    if takes == given { Ok(()) } else { Err(WrongInput { takes, given }.into()) }
}

/// Adds the readings' counts of arc cells to the first number of their shares.
fn accumulate_counts(shares: &mut Shares, counts: impl Iterator<Item = u32>, cones: usize) {
    shares.resize(cones, [0; 4]);
    shares.iter_mut().zip(counts).for_each(|(share, count)| share[0] += count);
}
