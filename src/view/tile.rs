//! Tiles of 256 × 256 pixels. On level k a pixel covers 2^k × 2^k cells. Colours and reduction are those of the layers' pictures.

use super::Request;
use crate::grid::Scale;
use crate::output::png;
use crate::{Error, Result};

/// Pixels along a tile's edge.
pub const EDGE: usize = 256;

/// Levels of a grid of so many columns and rows: the last is one tile.
pub fn levels(extent: [usize; 2]) -> usize {
    let larger = |k: &usize| pixels(extent, *k).iter().any(|n| *n > EDGE);
    1 + (0..).take_while(larger).count()
}

/// Columns and rows of pixels on a level.
pub fn pixels(extent: [usize; 2], level: usize) -> [usize; 2] {
    extent.map(|n| n.div_ceil(1 << level))
}

/// A tile: its level, and its column and row of tiles there, counted from the lower left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TileId {
    /// Its level; on level 0 a pixel is a cell.
    pub level: usize,
    /// Its column of tiles.
    pub column: usize,
    /// Its row of tiles.
    pub row: usize,
}

impl TileId {
    /// The tile of a request's `level`, `column` and `row`, on a grid of so many columns and rows.
    ///
    /// # Errors
    /// [`Error::Usage`] where one of them is missing, or no such tile exists.
    pub fn requested(request: &Request, extent: [usize; 2]) -> Result<TileId> {
        let [level, column, row] =
            [request.query_number("level")?, request.query_number("column")?, request.query_number("row")?];
        if level >= levels(extent) {
            return Err(Error::Usage(format!("there is no level {level}: there are 0 to {}", levels(extent) - 1)));
        }
        let [columns, rows] = pixels(extent, level).map(|n| n.div_ceil(EDGE));
        if column >= columns || row >= rows {
            return Err(Error::Usage(format!(
                "there is no tile in column {column}, row {row} of level {level}: it has {columns} × {rows}"
            )));
        }
        Ok(TileId { level, column, row })
    }

    /// Columns and rows of pixels of this tile: fewer than 256 at the right and at the top of a grid.
    pub fn extent(&self, grid: [usize; 2]) -> [usize; 2] {
        let [width, height] = pixels(grid, self.level);
        [width.saturating_sub(self.column * EDGE).min(EDGE), height.saturating_sub(self.row * EDGE).min(EDGE)]
    }

    /// The four tiles of the level below that it covers; some may lie outside the grid. `None` on level 0.
    pub(super) fn children(&self) -> Option<[TileId; 4]> {
        let level = self.level.checked_sub(1)?;
        Some([[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, up]| TileId {
            level,
            column: 2 * self.column + right,
            row: 2 * self.row + up,
        }))
    }

    /// Whether it covers a tile of level 0.
    pub(super) fn covers(&self, [column, row]: [usize; 2]) -> bool {
        column >> self.level == self.column && row >> self.level == self.row
    }
}

/// A tile's values, row by row from the bottom. NaN where no reading reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// Columns and rows.
    pub extent: [usize; 2],
    /// The values.
    pub values: Vec<f32>,
}

impl Tile {
    /// The tile as PNG.
    ///
    /// # Errors
    /// [`Error::Resources`] where it can't be encoded.
    pub fn to_png(&self, scale: Scale) -> Result<Vec<u8>> {
        encode_png(self.extent, scale, png::entries(scale, &self.values))
    }
}

/// Palette entries of a scale, the bottom row first, as PNG.
pub(super) fn encode_png(extent: [usize; 2], scale: Scale, mut entries: Vec<u8>) -> Result<Vec<u8>> {
    png::flip(&mut entries, extent[0]);
    png::picture(extent, scale, &entries).map_err(|e| Error::Resources(format!("a tile can't be drawn: {e}")))
}
