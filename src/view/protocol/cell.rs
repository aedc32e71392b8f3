//! `api/cell`, `api/history`, `api/working`: what is known of cells.

use super::state::{Beam, EchoOutcome};
use serde::Serialize;
use serde_json::Number;
#[cfg(test)]
use ts_rs::TS;

/// `api/cell`: a cell's state in every source.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Cell {
    /// Column.
    pub column: usize,
    /// Row, from the bottom.
    pub row: usize,
    /// World x of its centre, metres.
    pub x: f64,
    /// World y of its centre, metres.
    pub y: f64,
    /// Its state in each source.
    pub sources: Vec<CellSource>,
}

/// A cell's state in a source.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct CellSource {
    /// The source.
    pub name: String,
    /// Whether a reading reached it.
    pub touched: bool,
    /// Its class.
    pub class: CellClass,
    /// Of a log: updates from interiors of cones.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub interior: Option<u32>,
    /// Of a log: updates from arcs of cones.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub arc: Option<u32>,
    /// Its layers by name.
    pub values: Vec<NamedValue>,
    /// Of a counting sensor model: the beams that the cell counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub chosen: Option<Vec<ChosenBeam>>,
}

/// A name and its value; `null`: it has none.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
#[cfg_attr(test, ts(type = "[string, number | null]"))]
pub struct NamedValue(pub String, pub Option<Number>);

/// A cell's class.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum CellClass {
    /// Occupied.
    Occupied,
    /// Empty.
    Empty,
    /// Unknown.
    Unknown,
}

/// A beam that a cell of a counting sensor model counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct ChosenBeam {
    /// The beam itself.
    #[serde(flatten)]
    pub ray: Beam,
    /// Its scan, from 0.
    pub scan: usize,
    /// Which beam of the scan, from 0.
    pub beam: usize,
    /// What each class gained, "free" last.
    pub gained: Vec<(String, Option<f64>)>,
}

/// `api/history`: the readings that touched a cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct History {
    /// How many touched it.
    pub total: usize,
    /// Names of the values in `before` and `after`.
    pub layers: Vec<&'static str>,
    /// The last of them, latest first.
    pub events: Vec<HistoryEvent>,
    /// How to read the list, where that needs an explanation.
    pub note: Option<&'static str>,
}

/// A reading that touched a cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct HistoryEvent {
    /// Which item, from 1.
    pub number: usize,
    /// Its line of the log.
    pub line: u64,
    /// The log's number of its scan; of a counting sensor model's scan its own, from 0.
    pub scan: u64,
    /// Its time, seconds.
    pub t: Option<f64>,
    /// Its sensor.
    pub sensor: String,
    /// Hit or no echo.
    pub outcome: EchoOutcome,
    /// Its range, metres.
    pub range: Option<f64>,
    /// Where in its cone the cell lay.
    pub region: Region,
    /// Its own evidence of the cell; `null` where the method has none.
    pub own: Option<f64>,
    /// The cell's values before it.
    pub before: Vec<Option<f64>>,
    /// The cell's values after it.
    pub after: Vec<Option<f64>>,
}

/// A region of a cone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum Region {
    /// Nearer than the range.
    Interior,
    /// At the range.
    Arc,
}

/// `api/working`: what the last item says of each cell that it changed. The lists have an entry a cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Working {
    /// The lane's position.
    pub position: usize,
    /// Cells in the interior.
    pub interior: usize,
    /// Cells on the arc.
    pub arc: usize,
    /// n, the reading's arc cells, where the method uses it.
    pub n: Option<usize>,
    /// The sum of the cancelled evidence over the arc, where the method uses it.
    pub sum: Option<f64>,
    /// What `own` means.
    pub own_is: &'static str,
    /// Names of the lists in `before` and `after`.
    pub layers: Vec<&'static str>,
    /// The steps that the method has.
    pub steps: Vec<WorkingStep>,
    /// Whether the lists leave cells out, as there are too many.
    pub truncated: bool,
    /// Columns.
    pub column: Vec<usize>,
    /// Rows.
    pub row: Vec<usize>,
    /// 0 interior, 1 arc.
    pub region: Vec<u8>,
    /// Distances from the sensor, metres.
    pub d: Vec<Option<f64>>,
    /// Angles off the axis, radians.
    pub theta: Vec<Option<f64>>,
    /// The item's own evidence.
    pub own: Vec<Option<f64>>,
    /// The evidence after cancellation; `null` in the interior.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub cancelled: Option<Vec<Option<f64>>>,
    /// The evidence after normalisation; `null` in the interior.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub normalised: Option<Vec<Option<f64>>>,
    /// How strong the cell's shade is, 0 to 1.
    pub strength: Vec<Option<f64>>,
    /// The value whose shade is 1.
    pub strongest: Option<f64>,
    /// What `strength` is computed from.
    pub strength_is: &'static str,
    /// The cells' layers before the item, a list a layer.
    pub before: Vec<Vec<Option<f64>>>,
    /// The cells' layers after it.
    pub after: Vec<Vec<Option<f64>>>,
}

/// A step of the evidence's computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum WorkingStep {
    /// The reading's own evidence.
    Own,
    /// Cancelled by what is known to be empty.
    Cancelled,
    /// Normalised over the arc.
    Normalised,
}
