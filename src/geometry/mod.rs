//! Plane geometry, and exact integer membership: which cells a cone holds.
//!
//! `plane` works in metres in f64, for worlds and features. `layout`, `cone` and `profile` are twins of `shaders/geometry/`.
//! `layout` has the records that both backends read, `cone` decides membership in integers of 1/32 cell, and `profile`
//! computes distances and angles in f32.

pub(crate) mod bits;
pub mod cone;
pub mod layout;
pub mod plane;
pub mod profile;
