//! Plane geometry, and the exact integers that decide which cells a cone holds.
//!
//! `plane` is in metres, in f64, for worlds and features. `layout`, `cone` and `profile` are twins of `shaders/geometry/`: the
//! records that both backends read, membership in integers of 1/32 cell, distances and angles in f32.

pub(crate) mod bits;
pub mod cone;
pub mod layout;
pub mod plane;
pub mod profile;
