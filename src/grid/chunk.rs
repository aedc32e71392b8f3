//! Chunks: squares of 1024 × 1024 cells, the unit of residence, of storage and of distribution.

use super::GridSpec;
use crate::geometry::layout::{CHUNK, TILE};

/// A chunk's place: row, column.
pub type Place = [u32; 2];

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
