//! The CPU's loops over a tile: its list of readings, scans or updates in log order, row by row; twins of
//! `shaders/method/driver/*.wgsl`. A method is a [`Kernel`] that they call.

mod reach;
mod scan;
mod update;
mod walk;

pub use reach::Reached;
pub use scan::walk_scans;
pub use update::walk_updates;
pub use walk::{Job, Kernel, Pass, Plane, simd_level, walk};
