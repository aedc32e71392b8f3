//! From a log to a map. A [`survey`] and the checks of a [`session`] come first; then one of two pipelines maps the log.
//!
//! *Incremental* ([`mapper`], [`scans`], [`updates`]): batches in time, with every chunk resident. *Out of core* ([`out_of_core`]):
//! readings are binned to chunks once, then each chunk runs to its end, so that memory is a few chunks however large the map. Both
//! give the same bytes. [`step`] steps through a log one input at a time.

pub mod batching;
pub mod finished;
pub mod layers;
pub mod mapper;
pub mod memory;
pub mod out_of_core;
pub mod readings;
pub mod scans;
pub mod session;
pub mod step;
pub mod survey;
pub mod updates;
