//! **echogrid** turns logs of sonar and laser readings into occupancy grids, on any GPU through wgpu and on the CPU with
//! the same result. The rooms stand in the order of the data, and each uses only those before it (`tests/rooms.rs`): a *log* gives
//! *readings*, *binning* says which tiles they reach, a *method* runs on one of the *kernels*, a *pipeline* takes a whole log to
//! the layers of a *grid*, *output* writes them, *evaluate* compares them.

#![cfg_attr(
    not(all(feature = "view", feature = "cli")),
    allow(dead_code, unused_imports, reason = "what only the page and the command use")
)]

pub mod support;
pub mod geometry;
pub mod grid;
pub mod sensor;
pub mod log;
pub mod feature;
pub mod binning;
pub mod method;
pub mod kernels;
pub mod oracle;
pub mod pipeline;
pub mod output;
pub mod world;
pub mod evaluate;
pub mod bench;
#[cfg(feature = "view")]
pub mod view;
#[cfg(feature = "cli")]
pub mod cli;

pub use support::error::{Error, ErrorKind, Result};

/// The README's library example compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
