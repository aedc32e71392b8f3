//! `echogrid view`: its server, as a raw connection meets it, and what it shows of saved maps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod command;
#[path = "../cli/common.rs"]
#[allow(dead_code, reason = "the command's tests use all of it")]
mod common;
mod damaged;
mod load;
mod log;
mod maps;
mod pictures;
mod refusals;
mod web;
