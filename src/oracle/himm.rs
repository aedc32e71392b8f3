//! HIMM, histogrammic in-motion mapping (Murphy 2000, 11.11): a count 0..15 of the cells on the acoustic axis.
//!
//! Without the growth-rate operator counts are integers and have no error. With it the reference keeps exact halves;
//! a kernel in fixed point loses up to a unit a step, which the clamps forget again.

use super::cone::Cone;
use super::{MethodOutput, OracleLayer, Region, UpdateCounts};
use crate::grid::GridSpec;
use crate::method::settings::Himm;

/// Largest count.
const MOST: f64 = 15.0;
/// A cell is occupied from this count on.
const OCCUPIED: f64 = 3.0;
/// The kernels' fixed point of the growth-rate operator.
const GRO_UNIT: f64 = 1.0 / 65536.0;

/// The count of each cell, and the bound of a kernel's error in it.
struct State<'a> {
    grid: &'a GridSpec,
    count: Vec<f64>,
    error: Vec<f64>,
}

impl State<'_> {
    /// Sets a cell to `value` ± `error`, clamped to 0..=15; where both ends are clamped to the same value the error is 0.
    fn set(&mut self, k: usize, value: f64, error: f64) {
        let sure = value - error >= MOST || value + error <= 0.0;
        self.count[k] = value.clamp(0.0, MOST);
        self.error[k] = if sure { 0.0 } else { error };
    }

    /// Growth-rate operator: the 3 × 3 weighted sum, centre 1, others ½; outside the grid 0.
    fn grow(&mut self, k: usize) {
        let (width, height) = (self.grid.width, self.grid.height);
        let (column, row) = (k % width, k / width);
        let (mut value, mut error) = (self.count[k], self.error[k]);
        for r in row.saturating_sub(1)..(row + 2).min(height) {
            for c in column.saturating_sub(1)..(column + 2).min(width) {
                let j = r * width + c;
                if j != k {
                    value += 0.5 * self.count[j];
                    error += 0.5 * self.error[j];
                }
            }
        }
        let exact = error == 0.0 && (value / GRO_UNIT).fract() == 0.0;
        self.set(k, value, if exact { 0.0 } else { error + GRO_UNIT });
    }
}

/// Maps the cones, in their order: the layer count, and the classes.
pub(super) fn map(grid: &GridSpec, cones: &[Cone], settings: &Himm, counts: &mut UpdateCounts) -> MethodOutput {
    let cell_count = grid.cells();
    let mut state = State { grid, count: vec![0.0; cell_count], error: vec![0.0; cell_count] };
    let mut cells = Vec::new();
    for cone in cones {
        let n = cone.cells(grid, &mut cells);
        counts.add(cone, &cells, n);
        cells.sort_by_key(|cell| cell.region == Region::Arc);
        for cell in &cells {
            let k = cell.index;
            let step = if cell.region == Region::Arc { 3.0 } else { -1.0 };
            state.set(k, state.count[k] + step, state.error[k]);
            if settings.gro && cell.region == Region::Arc {
                state.grow(k);
            }
        }
    }
    let State { count, error, .. } = state;
    let class = (0..cell_count)
        .map(|k| if !counts.is_touched(k) { 0 } else { 2 * i8::from(count[k] >= OCCUPIED) - 1 })
        .collect();
    let ambiguous = (0..cell_count).map(|k| error[k] > 0.0 && (count[k] - OCCUPIED).abs() <= error[k]).collect();
    // stored as f32: exact up to 20 bits after the point of a count
    let bound = error.iter().map(|e| if *e > 0.0 { e + MOST * super::bound::U } else { 0.0 }).collect();
    MethodOutput { layers: vec![OracleLayer { name: "count", values: count, bound }], class, ambiguous }
}
