//! The backends: they run a method's passes over a batch, chunk by chunk.

pub mod ceiling;
mod choose;
pub mod cpu;
pub mod dry;
pub mod gpu;

pub use choose::{Choice, Chosen, choose, gpu_required};

use crate::Result;
use crate::binning::batch::Batch;
use crate::geometry::layout::{Cone, Frame, NO_ECHO};
use crate::log::reading::Outcome;
use crate::method::{Method, Step};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The cells of the chunks that readings reached: words, tile by tile, plane by plane, row by row; by chunk row and column.
pub type Chunks = BTreeMap<[u32; 2], Vec<u32>>;

/// What a reading's steps have found for it so far, for each cone of a batch: the bits of a sum, a count, or what
/// [`Method::share`] made of it.
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
    /// How often a thread may go round its loops ([`Batch::turns`]): Mesa's software adapter ends a loop without a word
    /// once all of a thread's have gone round 65535 times.
    pub turns: usize,
    /// Whether the backend lists the tiles of a batch's cones itself ([`crate::binning::batch::Binning::near`]).
    pub lists: bool,
}

/// Something that runs a method's steps over batches and keeps the cells.
pub trait Backend: Send {
    /// `cpu` or `gpu`.
    fn name(&self) -> &'static str;

    /// The adapter or processor.
    fn adapter(&self) -> String;

    /// What a batch may come to; more, and it is split.
    fn limits(&self) -> Limits;

    /// Runs the steps over a batch, in order. `shares`, one a cone or empty for none, is where they start from; only
    /// [`Step::Hand`] and [`Step::Tally`] change it.
    fn apply(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        batch: &Batch,
        steps: &[Step],
        shares: &mut Shares,
    ) -> Result<()>;

    /// What it can do at most, measured now; `None` where there is nothing to measure.
    fn ceilings(&mut self) -> Result<Option<ceiling::Ceilings>> {
        Ok(None)
    }

    /// From here on each pass is timed, which may slow down what lies between them.
    fn time_passes(&mut self) {}

    /// Ends that, and says what each kind of pass took in all, seconds, by the processor's own clock; nothing where it has none.
    fn pass_times(&mut self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    /// Returns when all that was applied is done.
    fn wait(&mut self) -> Result<()> {
        Ok(())
    }

    /// Hands over the cells of the chunk in this row and column, and forgets them; `None`: nothing reached it.
    fn take(&mut self, place: [u32; 2]) -> Result<Option<Vec<u32>>>;

    /// Whether it has a use for [`Backend::spare`].
    fn reuses(&self) -> bool {
        false
    }

    /// Takes the memory of a chunk that was handed over, zeros again, for another.
    fn spare(&mut self, _zeros: Vec<u32>) {}

    /// Hands over all cells and forgets them.
    fn finish(&mut self, method: &dyn Method) -> Result<Chunks>;
}

/// Each reading's share from its count of arc cells.
pub fn shares(method: &dyn Method, counts: impl Iterator<Item = u32>, cones: &[Cone]) -> Shares {
    let outcome = |cone: &Cone| if cone.flags & NO_ECHO != 0 { Outcome::NoEcho } else { Outcome::Hit };
    let counts: Vec<u32> = counts.collect();
    counts.par_iter().with_min_len(256).zip(cones).map(|(count, cone)| method.share(*count, outcome(cone))).collect()
}

/// Adds counts to those in the shares.
fn tally(shares: &mut Shares, counts: impl Iterator<Item = u32>, cones: usize) {
    shares.resize(cones, [0; 4]);
    shares.iter_mut().zip(counts).for_each(|(share, count)| share[0] += count);
}
