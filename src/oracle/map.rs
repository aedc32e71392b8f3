//! The reference map, and what a method fills it from.

use super::cone::{Cell, Cone};
use super::{Region, csm};
use crate::grid::GridSpec;

/// One layer of the reference map.
#[derive(Debug, Clone, PartialEq)]
pub struct OracleLayer {
    /// The layer's name, the same as the method's.
    pub name: &'static str,
    /// Values, row by row from the bottom.
    pub values: Vec<f64>,
    /// For each value, the largest difference of a kernel's value from it.
    pub bound: Vec<f64>,
}

/// The reference map of a log. All vectors hold one entry a cell, row by row from the bottom.
#[derive(Debug, Clone, PartialEq)]
pub struct OracleMap {
    /// Where the cells are.
    pub grid: GridSpec,
    /// The method's layers, in its order, without `touched` and `class`.
    pub layers: Vec<OracleLayer>,
    /// Class by the method's decision rule: 1 occupied, 0 unknown, −1 empty.
    pub class: Vec<i8>,
    /// Whether the decision lies within the bounds of its threshold, so that a kernel may decide otherwise.
    pub ambiguous: Vec<bool>,
    /// Interior updates of each cell.
    pub interior: Vec<u32>,
    /// Arc updates of each cell.
    pub arc: Vec<u32>,
    /// Sum of the marks of each cell's beams or updates; empty for methods without ([`crate::method::Method::marks`]).
    pub marks: Vec<u32>,
    /// What the α of each cell gained, labels and then "free"; empty for methods without α.
    pub gains: Vec<Vec<f64>>,
    /// Number of cells with an update.
    pub touched: u64,
    /// All (reading, cell) pairs with the cell in the interior or on the arc.
    pub updates: u64,
    /// Readings with no cell of the grid.
    pub outside: u64,
    /// Hits with interior cells but no arc cell.
    pub empty_arc: u64,
    /// Readings with a cell of the grid that reach beyond 1024 cells.
    pub wide: u64,
}

impl OracleMap {
    /// The layer of that name.
    pub fn layer(&self, name: &str) -> Option<&OracleLayer> {
        self.layers.iter().find(|l| l.name == name)
    }

    /// Whether a reading reached cell `k`.
    pub fn is_touched(&self, k: usize) -> bool {
        self.interior[k] + self.arc[k] > 0
            || self.gains.get(k).is_some_and(|gains| csm::has_subthreshold_evidence(gains))
    }
}

/// The result of a method: the fields of [`OracleMap`] that differ by method.
pub(super) struct MethodOutput {
    pub layers: Vec<OracleLayer>,
    pub class: Vec<i8>,
    pub ambiguous: Vec<bool>,
}

/// Counts of updates and readings, as in [`OracleMap`].
pub(super) struct UpdateCounts {
    pub interior: Vec<u32>,
    pub arc: Vec<u32>,
    pub updates: u64,
    pub outside: u64,
    pub empty_arc: u64,
    pub wide: u64,
}

impl UpdateCounts {
    pub fn new(cells: usize) -> Self {
        UpdateCounts { interior: vec![0; cells], arc: vec![0; cells], updates: 0, outside: 0, empty_arc: 0, wide: 0 }
    }

    /// Counts one reading's cells; `n` is its number of arc cells.
    pub fn add(&mut self, cone: &Cone, cells: &[Cell], n: usize) {
        for cell in cells {
            match cell.region {
                Region::Interior => self.interior[cell.index] += 1,
                Region::Arc => self.arc[cell.index] += 1,
            }
        }
        self.updates += cells.len() as u64;
        self.outside += u64::from(cells.is_empty());
        self.empty_arc += u64::from(cone.hit && n == 0 && !cells.is_empty());
        self.wide += u64::from(cone.wide && !cells.is_empty());
    }

    /// Whether a reading reached cell `k`.
    pub fn is_touched(&self, k: usize) -> bool {
        self.interior[k] + self.arc[k] > 0
    }
}

/// The reference map of a method's result; `marks`: empty where the method has none.
pub(super) fn assemble(grid: &GridSpec, output: MethodOutput, counts: UpdateCounts, marks: Vec<u32>) -> OracleMap {
    let touched = (0..grid.cells()).filter(|&k| counts.is_touched(k)).count() as u64;
    let MethodOutput { layers, class, ambiguous } = output;
    let UpdateCounts { interior, arc, updates, outside, empty_arc, wide } = counts;
    OracleMap {
        grid: *grid,
        layers,
        class,
        ambiguous,
        interior,
        arc,
        marks,
        gains: Vec::new(),
        touched,
        updates,
        outside,
        empty_arc,
        wide,
    }
}
