//! Tiles: 256 × 256 pixels of a level, on which a pixel is a block of cells, 2^level a side. In the colours of the layers'
//! pictures, and reduced as they are.

use super::Ask;
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

/// Where a tile is: its level, its column and its row of tiles there, counted from the lower left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Place {
    /// 0: a pixel is a cell.
    pub level: usize,
    /// Its column of tiles.
    pub column: usize,
    /// Its row of tiles.
    pub row: usize,
}

impl Place {
    /// From a question's `level`, `column` and `row`, on a grid of so many columns and rows.
    ///
    /// # Errors
    /// [`Error::Usage`] where one is missing, or no such tile exists.
    pub fn asked(ask: &Ask, extent: [usize; 2]) -> Result<Place> {
        let place = Place { level: ask.number("level")?, column: ask.number("column")?, row: ask.number("row")? };
        let Place { level, column, row } = place;
        if level >= levels(extent) {
            return Err(Error::Usage(format!("there is no level {level}: there are 0 to {}", levels(extent) - 1)));
        }
        let [columns, rows] = pixels(extent, level).map(|n| n.div_ceil(EDGE));
        if column >= columns || row >= rows {
            return Err(Error::Usage(format!(
                "there is no tile in column {column}, row {row} of level {level}: it has {columns} × {rows}"
            )));
        }
        Ok(place)
    }

    /// Columns and rows of pixels of this tile: fewer than 256 at the right and at the top of a grid.
    pub fn extent(&self, grid: [usize; 2]) -> [usize; 2] {
        let [width, height] = pixels(grid, self.level);
        [width.saturating_sub(self.column * EDGE).min(EDGE), height.saturating_sub(self.row * EDGE).min(EDGE)]
    }

    /// The tiles of the level below that it shows; some may lie outside the grid. None on level 0.
    pub(super) fn below(&self) -> Option<[Place; 4]> {
        let level = self.level.checked_sub(1)?;
        Some([[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, up]| Place {
            level,
            column: 2 * self.column + right,
            row: 2 * self.row + up,
        }))
    }

    /// Whether a tile of level 0 lies in it.
    pub(super) fn holds(&self, [column, row]: [usize; 2]) -> bool {
        column >> self.level == self.column && row >> self.level == self.row
    }
}

/// A tile's values, row by row from the bottom. Not a number where no reading reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// Columns and rows.
    pub extent: [usize; 2],
    /// The values.
    pub values: Vec<f32>,
}

impl Tile {
    /// Its picture as PNG.
    ///
    /// # Errors
    /// [`Error::Resources`] if it can't be encoded.
    pub fn picture(&self, scale: Scale) -> Result<Vec<u8>> {
        picture(self.extent, scale, png::entries(scale, &self.values))
    }
}

/// Palette entries, the bottom row first, as a PNG on their scale.
pub(super) fn picture(extent: [usize; 2], scale: Scale, mut entries: Vec<u8>) -> Result<Vec<u8>> {
    png::flip(&mut entries, extent[0]);
    png::picture(extent, scale, &entries).map_err(|e| Error::Resources(format!("a tile can't be drawn: {e}")))
}
