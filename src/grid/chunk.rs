//! Chunks: squares of 1024 × 1024 cells, the unit of residence, of storage and of distribution.

use super::GridSpec;
use crate::geometry::layout::{CHUNK, TILE};
use serde::{Deserialize, Serialize};

/// A chunk of a grid, identified by its row and column from the grid's lower left corner. Chunks are ordered row by row.
/// In JSON it is `[row, column]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(from = "[u32; 2]", into = "[u32; 2]")]
pub struct ChunkId {
    /// Row of chunks, from the bottom.
    pub row: u32,
    /// Column of chunks, from the left.
    pub column: u32,
}

impl From<[u32; 2]> for ChunkId {
    fn from([row, column]: [u32; 2]) -> Self {
        ChunkId { row, column }
    }
}

impl From<ChunkId> for [u32; 2] {
    fn from(ChunkId { row, column }: ChunkId) -> Self {
        [row, column]
    }
}

impl ChunkId {
    /// Column and row in the grid of the chunk's first cell.
    pub fn first_cell(self) -> [usize; 2] {
        [self.column as usize * EDGE, self.row as usize * EDGE]
    }
}

/// Cells along a chunk's edge.
pub const EDGE: usize = CHUNK * TILE;

/// The part of a grid that lies in a chunk.
pub fn part(grid: &GridSpec, chunk: ChunkId) -> GridSpec {
    let [across, up] = chunk.first_cell();
    GridSpec {
        i0: grid.i0 + across as i64,
        j0: grid.j0 + up as i64,
        width: EDGE.min(grid.width - across),
        height: EDGE.min(grid.height - up),
        ..*grid
    }
}

/// All chunks of a grid, row by row.
pub fn chunks(grid: &GridSpec) -> impl Iterator<Item = ChunkId> {
    let (columns, rows) = (grid.width.div_ceil(EDGE) as u32, grid.height.div_ceil(EDGE) as u32);
    (0..rows).flat_map(move |row| (0..columns).map(move |column| ChunkId { row, column }))
}
