//! Logs: every format, real ones, broken ones.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking; here are the tests' helpers too")]

mod bad;
mod carmen;
#[path = "../data/mod.rs"]
mod data;
mod formats;
mod matlab;
mod other;
mod real;
