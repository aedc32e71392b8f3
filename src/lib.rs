//! **echogrid** turns logs of sonar and laser readings into occupancy grids, on any GPU through wgpu and on the CPU with
//! the same result. The modules stand in the order of the data: a *log* gives *readings*, a *batch* says which tiles they
//! reach, a *method* runs on one of the *kernels*, the *grid* holds its layers, *output* writes them.

mod similar;
mod wrapped;
pub mod world;
pub mod sensor;
pub mod log;
pub mod reading;
pub mod wedge;
pub mod classes;
pub mod scan;
pub mod feature;
pub mod snap;
pub mod batch;
pub mod update;
pub mod layout;
pub mod cone;
pub mod profile;
pub mod method;
pub mod kernels;
pub mod oracle;
pub mod mapper;
pub mod whole;
pub mod layers;
pub mod survey;
pub mod session;
pub mod step;
pub mod memory;
pub mod verify;
pub mod workload;
pub mod throughput;
pub mod grid;
pub mod output;
pub mod score;
pub mod compare;
pub mod view;
pub mod cli;
pub mod error;
mod positioned;

pub use error::{Error, Result};

/// The README's library example compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
