//! Access to the cells and tiles in the chunks of a kernel.

use crate::geometry::layout::{CHUNK, TILE, TILE_CELLS};
use crate::grid::{ChunkId, Class};
use crate::kernels::ChunkStates;
use crate::method::Method;
use std::collections::BTreeSet;

/// A set of tiles of 16 × 16 cells, by row and column.
pub type Tiles = BTreeSet<[u32; 2]>;

/// A cell that an item changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Touched {
    /// Column.
    pub column: usize,
    /// Row.
    pub row: usize,
    /// Whether it was updated from an arc; else from an interior (or its words changed without).
    pub arc: bool,
    /// Its words before the item, one of each plane.
    pub before: Vec<u32>,
    /// Its words after the item.
    pub after: Vec<u32>,
}

/// A cell, decoded from its words.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Whether an item reached it.
    pub touched: bool,
    /// The values of its layers, in the method's order; the fill values of an untouched cell.
    pub values: Vec<f32>,
    /// Its class.
    pub class: Class,
    /// Its value in the combined picture, −1 to 1.
    pub combined: f32,
    /// Interior updates.
    pub interior: u32,
    /// Arc updates.
    pub arc: u32,
}

impl Cell {
    /// Decodes the words of a method's cell; `None`: nothing reached it.
    pub fn of(method: &dyn Method, words: Option<&[u32]>) -> Cell {
        let mut values: Vec<f32> = method.layers().iter().map(|l| l.fill).collect();
        let seen = words.filter(|w| w[0] + w[1] > 0 || method.has_subthreshold_evidence(w));
        let class = seen.map_or(Class::Unknown, |words| method.values(words, &mut values));
        let combined = if seen.is_some() { method.combined(&values, class) } else { 0.0 };
        let count = |k: usize| words.map_or(0, |w| w[k]);
        Cell { touched: seen.is_some(), values, class, combined, interior: count(0), arc: count(1) }
    }
}

/// The chunk of a tile, by row and column in the grid, and the tile's slot there.
pub(super) fn place([row, column]: [u32; 2]) -> (ChunkId, usize) {
    let chunk = ChunkId { row: row / CHUNK as u32, column: column / CHUNK as u32 };
    (chunk, row as usize % CHUNK * CHUNK + column as usize % CHUNK)
}

/// The tile, by row and column, in a slot of a chunk.
pub(crate) fn tile_at(chunk: ChunkId, slot: u32) -> [u32; 2] {
    let edge = CHUNK as u32;
    [chunk.row * edge + slot / edge, chunk.column * edge + slot % edge]
}

/// The words of a tile, plane by plane; `None`: its chunk has no memory yet, all of its words are 0.
pub fn tile_of(chunks: &ChunkStates, planes: usize, tile: [u32; 2]) -> Option<&[u32]> {
    let ((chunk, slot), words) = (place(tile), planes * TILE_CELLS);
    chunks.get(&chunk)?.get(slot * words..(slot + 1) * words)
}

/// The words of a cell, one of each plane; `None`: all of them are 0.
pub fn cell_of(chunks: &ChunkStates, planes: usize, column: usize, row: usize) -> Option<Vec<u32>> {
    let tile = tile_of(chunks, planes, [(row / TILE) as u32, (column / TILE) as u32])?;
    let words = words_at(tile, planes, row % TILE * TILE + column % TILE);
    words.iter().any(|w| *w != 0).then_some(words)
}

/// The words of the cell at an index of its tile.
pub(super) fn words_at(tile: &[u32], planes: usize, at: usize) -> Vec<u32> {
    (0..planes).map(|p| tile.get(p * TILE_CELLS + at).copied().unwrap_or(0)).collect()
}

/// Appends the cells of a tile whose words differ to `to`.
pub(super) fn changes([row, column]: [u32; 2], planes: usize, before: &[u32], after: &[u32], to: &mut Vec<Touched>) {
    for at in 0..TILE_CELLS {
        let [old, new] = [before, after].map(|tile| words_at(tile, planes, at));
        if old != new {
            let (column, row) = (column as usize * TILE + at % TILE, row as usize * TILE + at / TILE);
            to.push(Touched { column, row, arc: new[1] != old[1], before: old, after: new });
        }
    }
}
