//! The result of a verification, as `verify --json` prints it.

use serde::Serialize;

/// A cell in which a backend and the oracle differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CellDifference {
    /// Column, from the left.
    pub column: usize,
    /// Row, from the bottom.
    pub row: usize,
    /// World x of its centre, metres.
    pub x: f64,
    /// World y of its centre, metres.
    pub y: f64,
    /// The oracle's value.
    pub oracle: f64,
    /// The backend's value.
    pub value: f64,
    /// Their absolute difference.
    pub difference: f64,
    /// The largest difference that is allowed.
    pub bound: f64,
    /// The last readings that reached it, the last first.
    pub last_readings: Vec<ReadingRef>,
}

/// A reading that reached a cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReadingRef {
    /// Its line of the log; the beams of a laser scan share one.
    pub line: u64,
    /// Its sensor.
    pub sensor: String,
    /// Its range R, metres.
    pub range: f64,
}

/// One layer of a backend compared with the oracle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerCheck {
    /// The layer's name.
    pub layer: String,
    /// Its largest difference.
    pub largest: f64,
    /// The bound in the cell of the largest difference.
    pub bound: f64,
    /// Cells beyond their bound: must be 0.
    pub beyond: u64,
    /// The cell of the largest difference; `None` where all are equal.
    pub largest_cell: Option<CellDifference>,
    /// The cell of the largest ratio of a difference to its bound; `None` where all are equal.
    pub worst: Option<CellDifference>,
}

/// One backend compared with the oracle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BackendCheck {
    /// cpu or gpu.
    pub backend: String,
    /// The adapter that it ran on.
    pub adapter: String,
    /// Cells whose interior or arc updates differ in number: must be 0.
    pub membership: u64,
    /// The first of them.
    pub membership_cell: Option<CellDifference>,
    /// Readings counted differently (outside, empty_arc, wide): must be 0.
    pub counts: u64,
    /// Each layer.
    pub layers: Vec<LayerCheck>,
    /// Cells whose class differs.
    pub class: u64,
    /// Of those, cells that do not stand on a decision boundary: must be 0.
    pub class_wrong: u64,
    /// Cell updates.
    pub updates: u64,
    /// Seconds from the log to the map.
    pub seconds: f64,
    /// Whether nothing differs that must not.
    pub passed: bool,
}

/// The result of `verify`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verification {
    /// The method.
    pub method: String,
    /// Readings mapped.
    pub readings: u64,
    /// Cells of the grid: columns, rows.
    pub size: [usize; 2],
    /// Cell updates by the oracle.
    pub updates: u64,
    /// The oracle's seconds.
    pub oracle_seconds: f64,
    /// Each backend.
    pub backends: Vec<BackendCheck>,
    /// Whether cpu and gpu gave the same bytes in every layer, where both ran.
    pub same_bytes: Option<bool>,
    /// Backends that were requested and could not run, with the reason.
    pub skipped: Vec<String>,
    /// Backends that the method does not have, with the reason.
    pub absent: Vec<String>,
    /// Whether every requested backend that the method has ran and passed.
    pub passed: bool,
}
