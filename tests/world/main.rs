//! Simulated worlds: their files, the sonar's physics, true maps, and maps of simulated logs.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking; here are the tests' helpers too")]

mod echoes;
mod errors;
mod maps;
mod physics;
mod truth;
