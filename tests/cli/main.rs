//! Drives the `echogrid` command: whole messages, exit codes, and what lies in the folders afterwards.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod adapters;
mod bad_logs;
mod bad_usage;
mod common;
mod compare;
mod help;
mod interrupt;
mod features;
mod labels;
mod map;
mod outputs;
mod printing;
mod repeat;
mod resume;
mod sensors;
mod tables;
mod terminal;
mod tools;
mod worlds;
