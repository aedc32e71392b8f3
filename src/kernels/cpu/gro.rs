//! HIMM with the growth-rate operator (Murphy 2000): an occupied cell adds half of each neighbour's count, so that readings are applied
//! one by one, in log order.

use crate::binning::batch::Batch;
use crate::geometry::cone::EdgeFunctions;
use crate::geometry::layout::*;
use crate::grid::ChunkId;
use crate::kernels::ChunkStates;
use crate::method::himm::{HIT, MOST, ONE};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};

/// Words of a tile: the two counts, and himm's.
const WORDS: usize = 3 * TILE_CELLS;

/// Applies a batch.
pub fn apply(frame: Frame, batch: &Batch, chunks: &mut ChunkStates) {
    // The tiles of each reading, from the readings of each tile.
    let mut reached: Vec<Vec<[u32; 2]>> = vec![Vec::new(); batch.cones().len()];
    for list in &batch.chunks {
        for tile in &list.tiles {
            for entry in &list.entries[tile.entries[0] as usize..tile.entries[1] as usize] {
                reached[entry.index()].push(tile.corner);
            }
        }
    }
    let level = Level::new();
    for (cone, tiles) in batch.cones().iter().zip(reached) {
        // First every cell before the hit, then the hit and its growth.
        let mut hit = None;
        for corner in tiles {
            let first = [0, 1].map(|k| CELL * corner[k] as i32 + CELL / 2 - cone.sensor[k]);
            let regions = dispatch!(level, simd => regions(EdgeFunctions::of(simd, cone, first, true), cone));
            for (y, [interior, arc]) in regions.into_iter().enumerate() {
                for k in 0..TILE {
                    let cell = [corner[0] + k as u32, corner[1] + y as u32];
                    if interior >> k & 1 != 0 {
                        update(chunks, frame, cell, 0, |count| count.max(ONE) - ONE);
                    }
                    if arc >> k & 1 != 0 {
                        hit = Some(cell);
                    }
                }
            }
        }
        if let Some(cell) = hit {
            update(chunks, frame, cell, 1, |count| (count + HIT).min(MOST));
            let sum = neighbours(cell).map(|n| read(chunks, frame, n)).sum::<u32>();
            update(chunks, frame, cell, 2, |count| (count + sum / 2).min(MOST));
        }
    }
}

/// The cells of a tile before the hit, and the hit cell: a bit each, row by row.
#[inline(always)]
fn regions<S: Simd>(edges: EdgeFunctions<S>, cone: &Cone) -> [[u64; 2]; TILE] {
    let (mut regions, axis) = ([[0; 2]; TILE], edges.axis(cone));
    for (y, region) in regions.iter_mut().enumerate() {
        let row = if cone.flags & WIDE != 0 { edges.wide_axis_row(cone, y) } else { edges.axis_row(&axis, y) };
        *region = [row.interior.to_bitmask(), row.arc.to_bitmask()];
    }
    regions
}

/// The eight cells around one; those left of or below the grid wrap far beyond its other end.
fn neighbours([x, y]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    const AROUND: [[i32; 2]; 8] = [[-1, -1], [0, -1], [1, -1], [-1, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];
    AROUND.into_iter().map(move |[i, j]| [x.wrapping_add_signed(i), y.wrapping_add_signed(j)])
}

/// A cell's chunk and its word in the first plane.
fn place(frame: Frame, [x, y]: [u32; 2]) -> Option<(ChunkId, usize)> {
    if x >= frame.size[0] || y >= frame.size[1] {
        return None;
    }
    let (edge, tile) = ((CHUNK * TILE) as u32, TILE as u32);
    let (cx, cy) = (x % edge, y % edge);
    let slot = (cy / tile) as usize * CHUNK + (cx / tile) as usize;
    Some((
        ChunkId { row: y / edge, column: x / edge },
        slot * WORDS + (cy % tile) as usize * TILE + (cx % tile) as usize,
    ))
}

fn read(chunks: &ChunkStates, frame: Frame, cell: [u32; 2]) -> u32 {
    place(frame, cell).and_then(|(key, at)| chunks.get(&key).map(|c| c[at + 2 * TILE_CELLS])).unwrap_or(0)
}

/// Changes a cell's count and counts the update in plane 0 (interior) or 1 (arc), or in neither (2).
fn update(chunks: &mut ChunkStates, frame: Frame, cell: [u32; 2], plane: usize, change: impl Fn(u32) -> u32) {
    if let Some((key, at)) = place(frame, cell)
        && let Some(chunk) = chunks.get_mut(&key)
    {
        let count = &mut chunk[at + 2 * TILE_CELLS];
        *count = change(*count);
        if plane < 2 {
            chunk[at + plane * TILE_CELLS] += 1;
        }
    }
}
