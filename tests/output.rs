//! Map folders from outside: what is written reads back, a killed run harms nothing, foreign folders stay.

#![allow(clippy::unwrap_used, reason = "clippy.toml allows it in test functions; here are their helpers too")]

#[path = "output/common.rs"]
mod common;
#[path = "output/compare.rs"]
mod compare;
#[path = "output/features.rs"]
mod features;
#[path = "output/folder.rs"]
mod folder;
#[path = "output/formats.rs"]
mod formats;
#[path = "output/python.rs"]
mod python;
