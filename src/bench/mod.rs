//! Benchmarks: synthetic readings, and what a backend makes of them a second.

pub mod throughput;
pub mod workload;
