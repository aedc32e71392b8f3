//! Rasterizing a cone: rows of cells over spans that are supersets by a cell and more; every cell of a span is then decided exactly.

use super::{Cell, Cone, LENGTH, Rule, UNITS};
use crate::grid::GridSpec;
use crate::oracle::Region;

impl Cone {
    /// Writes this reading's cells of the grid to `cells`; returns n, the number of its arc cells. A missing echo has no arc: n counts
    /// the arc cells that a hit of the same range would have, and `cells` holds none of them.
    pub fn cells(&self, grid: &GridSpec, cells: &mut Vec<Cell>) -> usize {
        cells.clear();
        let mut arc = 0;
        let axis = self.rule == Rule::Axis;
        let reach = if axis { self.reach + 2 * UNITS } else { self.outer };
        let (left, right) = if axis { (self.axis, self.axis) } else { (self.left, self.right) };
        // A narrow beam's strip: its cross products with the edges exceed 0 by half a cell and the directions' snapping.
        let slack = match self.rule {
            Rule::Cone | Rule::Wedge => 0.0,
            Rule::Narrow => 16.0 * LENGTH + 4.0 * reach as f64,
            Rule::Axis => 16.0 * LENGTH,
        };
        let first = (UNITS * grid.i0 + UNITS / 2 - self.origin.0, UNITS * grid.j0 + UNITS / 2 - self.origin.1);
        for row in span(-reach as f64, reach as f64, first.1, grid.height) {
            let vy = first.1 + UNITS * row as i64;
            let (y, r) = (vy as f64, reach as f64);
            let half = (r * r - y * y).max(0.0).sqrt();
            let (mut low, mut high) = (-half, half);
            // cross(left, v) ≤ slack and cross(right, v) ≥ −slack, solved for v.0
            for (edge, sign) in [(left, 1.0), (right, -1.0)] {
                let (ex, ey) = (edge.0 as f64, edge.1 as f64);
                if ey * sign > 0.0 {
                    low = low.max((ex * y - sign * slack) / ey);
                } else if ey * sign < 0.0 {
                    high = high.min((ex * y - sign * slack) / ey);
                }
            }
            for column in span(low - 1.0, high + 1.0, first.0, grid.width) {
                let v = (first.0 + UNITS * column as i64, vy);
                let Some(region) = self.region(v) else { continue };
                arc += usize::from(region == Region::Arc);
                if self.hit || region == Region::Interior {
                    cells.push(Cell { index: row * grid.width + column, region, v });
                }
            }
        }
        arc
    }
}

/// The cells of a row or column whose centres lie between `low` and `high` units, with one more on either side. `first`: the first
/// cell's centre, units.
fn span(low: f64, high: f64, first: i64, count: usize) -> std::ops::Range<usize> {
    let at = |v: f64| (v - first as f64) / UNITS as f64;
    let from = (at(low).floor() - 1.0).clamp(0.0, count as f64) as usize;
    let to = (at(high).ceil() + 2.0).clamp(0.0, count as f64) as usize;
    from..to.max(from)
}
