//! The CPU's loops over a tile: its list of readings, scans or updates in log order, row by row; twins of
//! `shaders/method/driver/*.wgsl`. A method is a [`Kernel`] that they call.

mod job;
mod kernel;
mod reach;
mod scan;
mod update;
mod walk;

pub use job::{Job, Pass, ReadingJob, ScanJob, TileTask, UpdateJob, WrongInput};
pub use kernel::{Kernel, Plane, Reached};
pub use scan::walk_scans;
pub use update::walk_updates;
pub use walk::{simd_level, walk};
