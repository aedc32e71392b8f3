//! The kernels from outside: layouts, the specification's vectors, oracle against cpu against gpu, seeded faults, laws.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking; here are the tests' helpers too")]
#![allow(clippy::print_stdout, reason = "times and adapters, for those who ask with --nocapture")]

#[path = "kernels/common.rs"]
mod common;
#[path = "kernels/csm.rs"]
mod csm;
#[path = "kernels/differential.rs"]
mod differential;
#[path = "kernels/faults.rs"]
mod faults;
#[path = "kernels/laws.rs"]
mod laws;
#[path = "kernels/layouts.rs"]
mod layouts;
#[path = "kernels/lists.rs"]
mod lists;
#[path = "kernels/real_log.rs"]
mod real_log;
#[path = "kernels/same_bytes.rs"]
mod same_bytes;
#[path = "kernels/scenes.rs"]
mod scenes;
#[path = "kernels/updates.rs"]
mod updates;
#[path = "kernels/vectors.rs"]
mod vectors;
