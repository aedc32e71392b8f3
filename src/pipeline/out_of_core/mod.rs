//! The whole-log way: the readings are binned to chunks once, then each chunk takes all of its readings, runs to its end
//! and is handed on, so that memory is a few chunks however large the map.
//!
//! A method whose update needs a number of the whole reading goes over the chunks twice: the first round gathers each
//! reading's sum (or count), chunk by chunk in one order, the last one updates. The cells' bytes are those of the
//! incremental way (`mapper`). Reading and binning, the kernels, and what is done with a finished chunk overlap.

mod bins;
mod busy;
mod map;
mod plan;
mod reader;
mod run;
mod scanned;
mod stages;

pub use bins::Bins;
pub use busy::Busy;
pub use map::{ChunkSink, Done, FOUND, FOUND_PARTIAL, MAPPING, Progress, map};
pub use plan::Plan;
pub use run::{Calibration, Run};
pub use scanned::Scanned;
pub use stages::{Chunk, Take};
