//! Benchmarks: synthetic readings, and the rate at which a backend maps them.

pub mod throughput;
pub mod workload;
