//! Scores: hand-made cases for every number, and the command as a user runs it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking; here are their helpers too")]

#[path = "score/command.rs"]
mod command;
#[path = "score/common.rs"]
mod common;
#[path = "data/mod.rs"]
mod data;
#[path = "score/levels.rs"]
mod levels;
#[path = "score/maps.rs"]
mod maps;
#[path = "score/numbers.rs"]
mod numbers;
#[path = "score/pictures.rs"]
mod pictures;
#[path = "score/ros.rs"]
mod ros;
#[path = "score/yaml.rs"]
mod yaml;
