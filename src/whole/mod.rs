//! The whole-log way: the readings are binned to chunks once, then each chunk takes all of its readings, runs to its end
//! and is handed on, so that memory is a few chunks however large the map.
//!
//! A method whose update needs a number of the whole reading goes over the chunks twice: the first round gathers each
//! reading's sum (or count), chunk by chunk in one order, the last one updates. The cells' bytes are those of the
//! incremental way (`mapper`). Reading and binning, the kernels, and what is done with a finished chunk overlap.

mod bins;
mod map;
mod rounds;
mod scanned;

pub use bins::{Bins, Place};
pub use map::{Done, MAPPING, Plan, Progress, map};
pub use rounds::{Chunk, Run};
pub use scanned::Scanned;

use crate::grid::GridSpec;
use crate::layout::{CHUNK, TILE};

/// Cells along a chunk's edge.
pub const EDGE: usize = CHUNK * TILE;

/// A chunk's part of a grid.
pub fn part(grid: &GridSpec, [row, column]: Place) -> GridSpec {
    let (across, up) = (column as usize * EDGE, row as usize * EDGE);
    GridSpec {
        i0: grid.i0 + across as i64,
        j0: grid.j0 + up as i64,
        width: EDGE.min(grid.width - across),
        height: EDGE.min(grid.height - up),
        ..*grid
    }
}

/// Every chunk of a grid, row by row.
pub fn places(grid: &GridSpec) -> impl Iterator<Item = Place> {
    let (columns, rows) = (grid.width.div_ceil(EDGE) as u32, grid.height.div_ceil(EDGE) as u32);
    (0..rows).flat_map(move |row| (0..columns).map(move |column| [row, column]))
}
