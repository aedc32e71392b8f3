//! The rectangle of cells that a map covers.

use crate::{Error, Result};

/// A rectangle of square cells. Cell (column c, row r), row 0 at the bottom, has its centre at
/// `anchor + ((i0 + c + ½)·resolution, (j0 + r + ½)·resolution)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridSpec {
    /// The point that snapping is relative to, metres: (0, 0), or the lower left corner of given bounds.
    pub anchor: (f64, f64),
    /// Length of a cell's edge, metres.
    pub resolution: f64,
    /// Index of column 0, counted from the anchor.
    pub i0: i64,
    /// Index of row 0, counted from the anchor.
    pub j0: i64,
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
}

impl GridSpec {
    /// The grid of given bounds (x0, y0, x1, y1), metres. It is anchored at (x0, y0).
    pub fn from_bounds(bounds: [f64; 4], resolution: f64) -> Result<Self> {
        check_resolution(resolution)?;
        let [x0, y0, x1, y1] = bounds;
        if bounds.iter().any(|b| !b.is_finite()) || x1 <= x0 || y1 <= y0 {
            return Err(Error::Usage(format!(
                "bounds {x0},{y0},{x1},{y1} are empty or inverted: give x0,y0,x1,y1 in metres with x0 < x1 and y0 < y1"
            )));
        }
        let cells = |low: f64, high: f64| ((high - low) / resolution - 1e-9).ceil().max(1.0) as usize;
        let spec = GridSpec { anchor: (x0, y0), resolution, i0: 0, j0: 0, width: cells(x0, x1), height: cells(y0, y1) };
        spec.check_size()
    }

    /// The default grid around a box (x0, y0, x1, y1), metres. Its bounds are rounded outward to multiples of the resolution,
    /// and it is anchored at the world's origin.
    pub fn around(covered: [f64; 4], resolution: f64) -> Result<Self> {
        check_resolution(resolution)?;
        let low = |v: f64| (v / resolution).floor() as i64;
        let high = |v: f64| (v / resolution).ceil() as i64;
        let (i0, j0) = (low(covered[0]), low(covered[1]));
        let cells = |first: i64, last: i64| (last - first).max(1) as usize;
        let (width, height) = (cells(i0, high(covered[2])), cells(j0, high(covered[3])));
        GridSpec { anchor: (0.0, 0.0), resolution, i0, j0, width, height }.check_size()
    }

    /// The smallest grid that contains this one and another of the same anchor and resolution.
    pub fn union(&self, other: &GridSpec) -> GridSpec {
        let (i0, j0) = (self.i0.min(other.i0), self.j0.min(other.j0));
        let end = |first: i64, size: usize| first + size as i64;
        let right = end(self.i0, self.width).max(end(other.i0, other.width));
        let top = end(self.j0, self.height).max(end(other.j0, other.height));
        GridSpec { i0, j0, width: (right - i0) as usize, height: (top - j0) as usize, ..*self }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.width * self.height
    }

    /// World x of the grid's left edge, metres.
    pub fn x0(&self) -> f64 {
        self.anchor.0 + self.i0 as f64 * self.resolution
    }

    /// World y of the grid's bottom edge, metres.
    pub fn y0(&self) -> f64 {
        self.anchor.1 + self.j0 as f64 * self.resolution
    }

    /// World coordinates of a cell's centre, metres.
    pub fn centre(&self, column: usize, row: usize) -> (f64, f64) {
        let at = |anchor: f64, first: i64, k: usize| anchor + ((first + k as i64) as f64 + 0.5) * self.resolution;
        (at(self.anchor.0, self.i0, column), at(self.anchor.1, self.j0, row))
    }

    /// Checks that coordinates in units of 1/32 cell fit 32-bit integers, with room for a reading's reach.
    fn check_size(self) -> Result<Self> {
        const LIMIT: i64 = 1 << 24;
        let far = self.i0.abs().max(self.j0.abs());
        if far > LIMIT || self.width as i64 > LIMIT || self.height as i64 > LIMIT {
            return Err(Error::Usage(format!(
                "a grid of {} × {} cells of {} m, starting {} cells from its anchor, is more than {LIMIT} cells an axis: \
                 give `bounds` nearer the robot or a coarser `resolution`",
                self.width, self.height, self.resolution, far
            )));
        }
        Ok(self)
    }
}

fn check_resolution(resolution: f64) -> Result<()> {
    if resolution.is_finite() && (1e-4..=1e4).contains(&resolution) {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "resolution {resolution} m is not a cell size: give 0.0001 to 10000 metres, such as 0.05"
    )))
}
