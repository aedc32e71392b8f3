//! From a log to a map: a survey, a checked session, and the two ways through a log.
//!
//! *Incremental* ([`mapper`], [`updates`]): batches in time, every chunk resident. *Out of core* ([`out_of_core`]): readings
//! are binned to chunks once, then each chunk runs to its end, so that memory is a few chunks however large the map. Both give
//! the same bytes. [`step`] goes through a log reading by reading.

pub mod finished;
pub mod layers;
pub mod mapper;
pub mod memory;
pub mod out_of_core;
pub mod session;
pub mod step;
pub mod survey;
pub mod updates;
