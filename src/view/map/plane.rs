//! Where one grid's cells lie on another's, and what of them a tile shows.

use crate::grid::GridSpec;
use crate::view::{EDGE, Place};
use crate::{Error, Result};
use std::sync::Arc;

/// A grid laid on the one that is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Laid {
    on: [usize; 2],
    /// Columns and rows of its own.
    pub extent: [usize; 2],
    /// Cells right of and above the other's lower left corner.
    first: [i64; 2],
    /// Whether its cells fall on the other's; else it is shown moved by less than half a cell.
    pub exact: bool,
}

impl Laid {
    /// Lays a grid on another.
    ///
    /// # Errors
    /// [`Error::Usage`] where their cells are not of one size; `name` is what the error calls the grid.
    pub fn of(on: &GridSpec, grid: &GridSpec, name: &str) -> Result<Laid> {
        let largest = [on.width, on.height, grid.width, grid.height].into_iter().fold(1, usize::max);
        // over a whole map the two may drift apart by a hundredth of a cell
        if (grid.resolution / on.resolution - 1.0).abs() * largest as f64 > 0.01 {
            return Err(Error::Usage(format!(
                "{name} has cells of {} m, the map that it is laid on of {} m: make both with one --resolution",
                grid.resolution, on.resolution
            )));
        }
        let apart = |on: (f64, i64), of: (f64, i64), resolution: f64| {
            let cells = (of.0 - on.0) / resolution;
            (cells.round() as i64).saturating_add(of.1 - on.1).clamp(-FAR, FAR)
        };
        let fits = |on: f64, of: f64| ((of - on) / grid.resolution).fract().abs();
        let whole = |rest: f64| rest.min(1.0 - rest) < 1e-4;
        let first = [
            apart((on.anchor.0, on.i0), (grid.anchor.0, grid.i0), on.resolution),
            apart((on.anchor.1, on.j0), (grid.anchor.1, grid.j0), on.resolution),
        ];
        let exact = whole(fits(on.anchor.0, grid.anchor.0)) && whole(fits(on.anchor.1, grid.anchor.1));
        Ok(Laid { on: [on.width, on.height], extent: [grid.width, grid.height], first, exact })
    }

    /// Columns and rows of the grid that is looked at.
    pub fn on(&self) -> [usize; 2] {
        self.on
    }

    /// Whether it is the grid that is looked at.
    pub fn same(&self) -> bool {
        self.first == [0, 0] && self.extent == self.on
    }

    /// The column and row, in this grid, of a cell of the other; `None`: it has none there.
    pub fn cell(&self, at: [usize; 2]) -> Option<[usize; 2]> {
        let own = |k: usize| {
            let own = usize::try_from(at[k] as i64 - self.first[k]).ok()?;
            (own < self.extent[k]).then_some(own)
        };
        Some([own(0)?, own(1)?])
    }

    /// The values that a tile of level 0 shows, from the pieces of 256 × 256 cells of this grid that it lies over; `None`: no
    /// piece has any.
    pub fn tile(
        &self,
        [column, row]: [usize; 2],
        piece: impl Fn([usize; 2]) -> Result<Option<Arc<Vec<f32>>>>,
    ) -> Result<Option<Vec<f32>>> {
        let extent = Place { level: 0, column, row }.extent(self.on);
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

    /// The pieces that a span of cells of the other grid lies over, along one axis.
    fn spans(&self, axis: usize, start: usize, length: usize) -> Vec<Span> {
        let own = start as i64 - self.first[axis]; // where the span begins, in this grid
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

/// Grids farther apart than this have nothing in common.
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

/// Small whole numbers on a grid, in memory; 0 is nothing.
#[derive(Debug)]
pub(super) struct Plane {
    /// Where they are.
    pub laid: Laid,
    /// Row by row from the bottom.
    pub values: Vec<i8>,
}

impl Plane {
    /// The values that a tile of level 0 shows.
    pub fn tile(&self, at: [usize; 2]) -> Result<Option<Vec<f32>>> {
        let [width, height] = self.laid.extent;
        self.laid.tile(at, |[column, row]| {
            let (left, bottom) = (column * EDGE, row * EDGE);
            let (right, top) = (width.min(left + EDGE), height.min(bottom + EDGE));
            let lines = (bottom..top).flat_map(|row| &self.values[row * width + left..row * width + right]);
            Ok(Some(Arc::new(lines.map(|v| if *v == 0 { f32::NAN } else { f32::from(*v) }).collect())))
        })
    }

    /// The value at a cell of the grid that is looked at.
    pub fn at(&self, cell: [usize; 2]) -> i8 {
        self.laid.cell(cell).map_or(0, |[column, row]| self.values[row * self.laid.extent[0] + column])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(anchor: f64, i0: i64, width: usize) -> GridSpec {
        GridSpec { anchor: (anchor, anchor), resolution: 0.05, i0, j0: 2 * i0, width, height: width }
    }

    /// Each cell's value is what its place says.
    fn plane(on: &GridSpec, of: &GridSpec) -> Plane {
        let laid = Laid::of(on, of, "it").expect("it fits");
        let value = |k: usize| ((k % of.width * 7 + k / of.width * 13) % 120 + 1) as i8;
        Plane { laid, values: (0..of.cells()).map(value).collect() }
    }

    #[test]
    fn a_tile_shows_each_cell_where_it_is() {
        let on = grid(0.0, 3, 600);
        for of in [grid(0.0, 3, 600), grid(0.0, -297, 700), grid(5.0, 10, 20), grid(0.0, 9000, 50), grid(0.0, 3, 90)] {
            let plane = plane(&on, &of);
            for (column, row) in (0..9).map(|k| (k % 3, k / 3)) {
                let [width, height] = Place { level: 0, column, row }.extent([600, 600]);
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
    fn cells_fall_on_cells_or_are_said_not_to() {
        let on = grid(0.0, 0, 100);
        let laid = |of: GridSpec| Laid::of(&on, &of, "it");
        assert!(laid(on).is_ok_and(|l| l.same() && l.exact));
        assert!(laid(grid(0.35, 0, 100)).is_ok_and(|l| l.exact && l.first == [7, 7]));
        assert!(laid(grid(0.36, 0, 100)).is_ok_and(|l| !l.exact && l.first == [7, 7]));
        let coarse = GridSpec { resolution: 0.1, ..on };
        let error = laid(coarse).map_err(|e| e.to_string());
        assert_eq!(
            error,
            Err("it has cells of 0.1 m, the map that it is laid on of 0.05 m: make both with one --resolution".into())
        );
    }
}
