//! Map folders from outside: what is written reads back, a killed run harms nothing, foreign folders stay.

#[path = "output/common.rs"]
mod common;
#[path = "output/compare.rs"]
mod compare;
#[path = "output/folder.rs"]
mod folder;
#[path = "output/formats.rs"]
mod formats;
#[path = "output/python.rs"]
mod python;
