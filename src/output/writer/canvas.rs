//! Pictures that are written chunk by chunk: canvases of palette entries on disk, saved as PNG when the map is whole.

use crate::Result;
use crate::grid::{ChunkId, EDGE, GridSpec, Layer};
use crate::output::png;
use crate::output::raster::{Block, Raster, RasterLayout};
use std::path::Path;

/// The block of a chunk in a raster that is reduced by a factor.
pub(super) fn block(part: &GridSpec, chunk: ChunkId, factor: usize) -> Block {
    let [width, height] = png::reduced(part, factor);
    let [column, row] = chunk.first_cell().map(|first| first / factor);
    Block { column, row, width, height }
}

/// Opens the canvas of a picture of the grid reduced by a factor: its palette entries, bottom row first.
pub(super) fn open_canvas(path: &Path, grid: &GridSpec, factor: usize, resume: bool) -> Result<Raster> {
    let layout = RasterLayout { header: Vec::new(), extent: png::reduced(grid, factor), element: 1, top_first: false };
    Raster::open(path, layout, resume)
}

/// Calls `show` with each shard of a level's entries.
pub(super) fn shards(raster: &Raster, mut show: impl FnMut(ChunkId, &[u8]) -> Result<()>) -> Result<()> {
    let [width, height] = raster.extent();
    for row in (0..height).step_by(EDGE) {
        for column in (0..width).step_by(EDGE) {
            let block = Block { column, row, width: EDGE.min(width - column), height: EDGE.min(height - row) };
            show(ChunkId { row: (row / EDGE) as u32, column: (column / EDGE) as u32 }, &raster.read(block)?)?;
        }
    }
    Ok(())
}

/// Saves a canvas as a PNG on the scale of its layer.
pub(super) fn save_png(raster: &Raster, path: &Path, layer: &Layer) -> Result<()> {
    let [width, height] = raster.extent();
    let mut pixels = raster.read(Block { column: 0, row: 0, width, height })?;
    png::flip(&mut pixels, width);
    png::save(path, [width, height], layer.scale, &pixels)
}
