//! The out-of-core pipeline: readings are binned to chunks once, then each chunk takes all of its readings, runs to its end and is
//! handed on, so that memory is a few chunks however large the map.
//!
//! A method whose update needs a total of the whole reading runs two rounds over the chunks: the first sums (or counts) each
//! reading's cells chunk by chunk in a fixed order, the last one updates. The cells' bytes are those of the incremental pipeline
//! ([`mapper`](super::mapper)). Reading and binning, the kernels, and the sink of finished chunks overlap.

mod busy;
mod chunk_bins;
mod map;
mod plan;
mod reader;
mod run;
mod sort;
mod stages;

pub use busy::StageTimes;
pub use chunk_bins::ChunkBins;
pub use map::{ChunkSink, MAPPING, MapOutput, MappingStatistics, Progress, TOTALS, TOTALS_PARTIAL, map};
pub use plan::ResourcePlan;
pub use run::{Calibration, OutOfCoreRun};
pub use stages::{FinishedChunk, OnChunk};
