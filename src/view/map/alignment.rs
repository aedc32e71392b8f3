//! The alignment of one grid's cells with another's, and the part of them that a tile shows.

use crate::grid::GridSpec;
use crate::view::{EDGE, TileId};
use crate::{Error, Result};
use std::sync::Arc;

/// A grid's position on the base grid, which is that of the first map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct GridAlignment {
    /// Columns and rows of the base grid.
    base: [usize; 2],
    /// Columns and rows of the grid itself.
    pub extent: [usize; 2],
    /// The column and row of its lower left corner on the base grid.
    first: [i64; 2],
    /// Whether its cells coincide with the base grid's; else it is shown shifted by less than half a cell.
    pub exact: bool,
}

impl GridAlignment {
    /// Aligns a grid with the base grid.
    ///
    /// # Errors
    /// [`Error::Usage`] where their cells differ in size; `name` is what the error calls the grid.
    pub fn of(base: &GridSpec, grid: &GridSpec, name: &str) -> Result<GridAlignment> {
        let largest = [base.width, base.height, grid.width, grid.height].into_iter().fold(1, usize::max);
        // Over a whole map the two may drift apart by a hundredth of a cell.
        if (grid.resolution / base.resolution - 1.0).abs() * largest as f64 > 0.01 {
            return Err(Error::Usage(format!(
                "{name} has cells of {} m, the map that it is laid on of {} m: make both with one --resolution",
                grid.resolution, base.resolution
            )));
        }
        let offset = |base: (f64, i64), of: (f64, i64), resolution: f64| {
            let cells = (of.0 - base.0) / resolution;
            (cells.round() as i64).saturating_add(of.1 - base.1).clamp(-FAR, FAR)
        };
        let fraction = |base: f64, of: f64| ((of - base) / grid.resolution).fract().abs();
        let is_whole = |rest: f64| rest.min(1.0 - rest) < 1e-4;
        let first = [
            offset((base.anchor.0, base.i0), (grid.anchor.0, grid.i0), base.resolution),
            offset((base.anchor.1, base.j0), (grid.anchor.1, grid.j0), base.resolution),
        ];
        let exact =
            is_whole(fraction(base.anchor.0, grid.anchor.0)) && is_whole(fraction(base.anchor.1, grid.anchor.1));
        Ok(GridAlignment { base: [base.width, base.height], extent: [grid.width, grid.height], first, exact })
    }

    /// Columns and rows of the base grid.
    pub fn base(&self) -> [usize; 2] {
        self.base
    }

    /// Whether the grid is the base grid.
    pub fn is_base(&self) -> bool {
        self.first == [0, 0] && self.extent == self.base
    }

    /// The column and row, in this grid, of a cell of the base grid; `None` where this grid has no cell.
    pub fn cell(&self, at: [usize; 2]) -> Option<[usize; 2]> {
        let own = |k: usize| {
            let own = usize::try_from(at[k] as i64 - self.first[k]).ok()?;
            (own < self.extent[k]).then_some(own)
        };
        Some([own(0)?, own(1)?])
    }

    /// The values of a tile of level 0 of the base grid, from the pieces of 256 × 256 cells of this grid that it overlaps; `None` where no
    /// piece has any.
    pub fn tile(
        &self,
        [column, row]: [usize; 2],
        piece: impl Fn([usize; 2]) -> Result<Option<Arc<Vec<f32>>>>,
    ) -> Result<Option<Vec<f32>>> {
        let extent = TileId { level: 0, column, row }.extent(self.base);
        let mut all: Option<Vec<f32>> = None;
        let spans = [self.spans(0, column * EDGE, extent[0]), self.spans(1, row * EDGE, extent[1])];
        for up in &spans[1] {
            for across in &spans[0] {
                let Some(values) = piece([across.piece, up.piece])? else { continue };
                let width = EDGE.min(self.extent[0] - across.piece * EDGE);
                let all = all.get_or_insert_with(|| vec![f32::NAN; extent[0] * extent[1]]);
                for k in 0..up.length {
                    let from = (up.from + k) * width + across.from;
                    let to = (up.to + k) * extent[0] + across.to;
                    if let (Some(to), Some(from)) =
                        (all.get_mut(to..to + across.length), values.get(from..from + across.length))
                    {
                        to.copy_from_slice(from);
                    }
                }
            }
        }
        Ok(all)
    }

    /// The pieces that a span of cells of the base grid overlaps, along one axis.
    fn spans(&self, axis: usize, start: usize, length: usize) -> Vec<Span> {
        let own = start as i64 - self.first[axis]; // the span's beginning in this grid
        let (low, high) = (own.max(0), (own + length as i64).min(self.extent[axis] as i64));
        let mut spans = Vec::new();
        let mut at = low;
        while at < high {
            let piece = at as usize / EDGE;
            let end = high.min(((piece + 1) * EDGE) as i64);
            let from = at as usize - piece * EDGE;
            spans.push(Span { piece, from, to: (at - own) as usize, length: (end - at) as usize });
            at = end;
        }
        spans
    }
}

/// Offsets in cells are limited to this; grids so far apart do not overlap.
const FAR: i64 = 1 << 40;

/// Part of a piece along one axis.
#[derive(Debug, PartialEq)]
struct Span {
    piece: usize,
    /// The first cell in the piece, and in the tile.
    from: usize,
    to: usize,
    length: usize,
}

/// Small labels on a grid, in memory; 0 is no label.
#[derive(Debug)]
pub(super) struct LabelGrid {
    /// Their position on the base grid.
    pub alignment: GridAlignment,
    /// Row by row from the bottom.
    pub values: Vec<i8>,
}

impl LabelGrid {
    /// The values of a tile of level 0; NaN where there is no label.
    pub fn tile(&self, at: [usize; 2]) -> Result<Option<Vec<f32>>> {
        let [width, height] = self.alignment.extent;
        self.alignment.tile(at, |[column, row]| {
            let (left, bottom) = (column * EDGE, row * EDGE);
            let (right, top) = (width.min(left + EDGE), height.min(bottom + EDGE));
            let lines = (bottom..top).flat_map(|row| &self.values[row * width + left..row * width + right]);
            Ok(Some(Arc::new(lines.map(|v| if *v == 0 { f32::NAN } else { f32::from(*v) }).collect())))
        })
    }

    /// The label at a cell of the base grid.
    pub fn at(&self, cell: [usize; 2]) -> i8 {
        self.alignment.cell(cell).map_or(0, |[column, row]| self.values[row * self.alignment.extent[0] + column])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(anchor: f64, i0: i64, width: usize) -> GridSpec {
        GridSpec { anchor: (anchor, anchor), resolution: 0.05, i0, j0: 2 * i0, width, height: width }
    }

    /// Each cell's value is what its place says.
    fn plane(on: &GridSpec, of: &GridSpec) -> LabelGrid {
        let alignment = GridAlignment::of(on, of, "it").expect("it fits");
        let value = |k: usize| ((k % of.width * 7 + k / of.width * 13) % 120 + 1) as i8;
        LabelGrid { alignment, values: (0..of.cells()).map(value).collect() }
    }

    #[test]
    fn a_tile_shows_each_cell_where_it_is() {
        let on = grid(0.0, 3, 600);
        for of in [grid(0.0, 3, 600), grid(0.0, -297, 700), grid(5.0, 10, 20), grid(0.0, 9000, 50), grid(0.0, 3, 90)] {
            let plane = plane(&on, &of);
            for (column, row) in (0..9).map(|k| (k % 3, k / 3)) {
                let [width, height] = TileId { level: 0, column, row }.extent([600, 600]);
                let tile = plane.tile([column, row]).expect("a tile").unwrap_or(vec![f32::NAN; width * height]);
                for (k, value) in tile.iter().enumerate() {
                    let at = [column * EDGE + k % width, row * EDGE + k / width];
                    let wanted = plane.at(at);
                    assert!(if wanted == 0 { value.is_nan() } else { *value == f32::from(wanted) }, "{at:?}");
                }
            }
        }
    }

    #[test]
    fn cells_coincide_or_are_reported_not_to() {
        let on = grid(0.0, 0, 100);
        let aligned = |of: GridSpec| GridAlignment::of(&on, &of, "it");
        assert!(aligned(on).is_ok_and(|l| l.is_base() && l.exact));
        assert!(aligned(grid(0.35, 0, 100)).is_ok_and(|l| l.exact && l.first == [7, 7]));
        assert!(aligned(grid(0.36, 0, 100)).is_ok_and(|l| !l.exact && l.first == [7, 7]));
        let coarse = GridSpec { resolution: 0.1, ..on };
        let error = aligned(coarse).map_err(|e| e.to_string());
        assert_eq!(
            error,
            Err("it has cells of 0.1 m, the map that it is laid on of 0.05 m: make both with one --resolution".into())
        );
    }
}
