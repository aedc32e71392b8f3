//! The overlap of two grids, and the part of a map inside it.

use crate::grid::{Data, GridSpec, Layer, Map};
use crate::{Error, Result};

/// The rectangle of cells that two grids have in common.
pub(super) struct Overlap {
    /// Its first column and row in the first grid.
    pub a: (usize, usize),
    /// Its first column and row in the second grid.
    pub b: (usize, usize),
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Overlap {
    /// The overlap of two grids.
    ///
    /// # Errors
    /// [`Error::Usage`] where their cells differ in size or do not coincide, or there is no common cell.
    pub fn of(a: &GridSpec, b: &GridSpec) -> Result<Overlap> {
        let refuse = |why: &str| {
            Error::Usage(format!("{} and {} can't be compared cell by cell: {why}", describe(a), describe(b)))
        };
        if a.resolution != b.resolution {
            return Err(refuse("make both with one --resolution"));
        }
        // The number of cells from the first grid's start to the second's; exact for equal anchors.
        let offset = |anchor: (f64, f64), first: (i64, i64)| {
            let cells = (anchor.1 - anchor.0) / a.resolution;
            let whole = cells.round();
            ((cells - whole).abs() < 1e-6 && whole.abs() < 1e15).then_some(whole as i64 + first.1 - first.0)
        };
        let across = offset((a.anchor.0, b.anchor.0), (a.i0, b.i0));
        let up = offset((a.anchor.1, b.anchor.1), (a.j0, b.j0));
        let (Some(across), Some(up)) = (across, up) else {
            return Err(refuse("their cells don't fall on one another: give both the same --bounds"));
        };
        match (axis_overlap(across, a.width, b.width), axis_overlap(up, a.height, b.height)) {
            (Some(x), Some(y)) => Ok(Overlap { a: (x.a, y.a), b: (x.b, y.b), width: x.length, height: y.length }),
            _ => Err(refuse("they have no cell in common")),
        }
    }

    /// Indices of the common cells in a grid, row by row.
    pub fn cells(&self, grid: &GridSpec, first: (usize, usize)) -> impl Iterator<Item = usize> + use<> {
        let (grid_width, width, height) = (grid.width, self.width, self.height);
        (0..height).flat_map(move |r| (0..width).map(move |c| (first.1 + r) * grid_width + first.0 + c))
    }

    /// The part of a map inside the overlap.
    pub fn crop(&self, map: &Map, first: (usize, usize)) -> Map {
        let cells = || self.cells(&map.grid, first);
        let layers = map.layers.iter().map(|layer| {
            let data = match &layer.data {
                Data::F32(v) => Data::F32(cells().map(|k| v[k]).collect()),
                Data::U32(v) => Data::U32(cells().map(|k| v[k]).collect()),
                Data::U8(v) => Data::U8(cells().map(|k| v[k]).collect()),
                Data::I8(v) => Data::I8(cells().map(|k| v[k]).collect()),
            };
            Layer { data, ..layer.clone() }
        });
        let (i0, j0) = (map.grid.i0 + first.0 as i64, map.grid.j0 + first.1 as i64);
        let grid = GridSpec { i0, j0, width: self.width, height: self.height, ..map.grid };
        Map {
            grid,
            method: map.method.clone(),
            layers: layers.collect(),
            updates: map.updates,
            increments: map.increments.clone(),
        }
    }
}

/// The overlap of two rows of cells.
pub(crate) struct AxisOverlap {
    /// Its first cell in the first row.
    pub a: usize,
    /// Its first cell in the second row.
    pub b: usize,
    /// Its cells.
    pub length: usize,
}

/// The overlap of a row of `a` cells and one of `b` cells that starts `offset` cells after it, if there is one.
pub(crate) fn axis_overlap(offset: i64, a: usize, b: usize) -> Option<AxisOverlap> {
    let (low, high) = (offset.max(0), (a as i64).min(offset + b as i64));
    (high > low).then_some(AxisOverlap { a: low as usize, b: (low - offset) as usize, length: (high - low) as usize })
}

/// A grid as messages describe it.
pub(super) fn describe(grid: &GridSpec) -> String {
    let GridSpec { resolution, width, height, .. } = grid;
    format!("{width} × {height} cells of {resolution} m from ({}, {})", grid.x0(), grid.y0())
}
