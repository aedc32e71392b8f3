//! `api/session`: what the page is told when it opens.

use super::common::{Json, SensorKind};
use super::state::State;
use serde::Serialize;
use std::collections::BTreeMap;
#[cfg(test)]
use ts_rs::TS;

/// A session: a log being stepped through, or saved maps.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "mode", rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum Session {
    /// A log.
    Log(Box<LogSession>),
    /// Saved maps.
    Map(Box<MapSession>),
}

/// The session of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct LogSession {
    /// The log's file name.
    pub name: String,
    /// The version of echogrid.
    pub version: String,
    /// The grid of all lanes.
    pub grid: Grid,
    /// Levels of tiles: a pixel of level k covers 2^k × 2^k cells; the last level is one tile.
    pub levels: usize,
    /// The lanes, one or two.
    pub sources: Vec<LogSource>,
    /// Every method that a lane can run.
    pub methods: Vec<MethodInfo>,
    /// The parameters of sensors that can be set.
    pub sensor_keys: Vec<ParameterInfo>,
    /// The log's sensors.
    pub sensors: Vec<SensorInfo>,
    /// The difference of two lanes, second minus first; `null` with one lane.
    pub difference: Option<ViewInfo>,
    /// Increases whenever the lanes are made anew.
    pub generation: u64,
    /// What was read of the log.
    pub report: LogReport,
    /// The position in the log.
    pub state: State,
}

/// The session of saved maps.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct MapSession {
    /// The first map's folder name.
    pub name: String,
    /// The version of echogrid.
    pub version: String,
    /// The first map's grid.
    pub grid: Grid,
    /// Levels of tiles: a pixel of level k covers 2^k × 2^k cells; the last level is one tile.
    pub levels: usize,
    /// The map, and what is shown beside it.
    pub sources: Vec<MapSource>,
    /// The difference of two maps, second minus first; `null` where there is none.
    pub difference: Option<ViewInfo>,
    /// The first map's report.json.
    pub report: Json,
    /// The first map's score, as `echogrid score --json` gives it; only with a truth.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub score: Option<Json>,
}

/// A grid's place and size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Grid {
    /// World x of the lower left corner, metres.
    pub x0: f64,
    /// World y of the lower left corner, metres.
    pub y0: f64,
    /// A cell's edge, metres.
    pub resolution: f64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// A lane of a log: a method and its parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct LogSource {
    /// The name to show.
    pub name: String,
    /// The method.
    pub method: String,
    /// The parameters that the user set.
    pub set: BTreeMap<String, String>,
    /// All parameters with their values.
    pub parameters: BTreeMap<String, String>,
    /// What can be shown.
    pub views: Vec<ViewInfo>,
}

/// A saved map, or a truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum MapSource {
    /// A map.
    Map {
        /// The name to show.
        name: String,
        /// The map's method.
        method: String,
        /// The map's folder.
        path: String,
        /// Whether its cells coincide with the first map's.
        aligned: bool,
        /// What can be shown.
        views: Vec<ViewInfo>,
    },
    /// A truth.
    Truth {
        /// The name to show.
        name: String,
        /// What can be shown.
        views: Vec<ViewInfo>,
    },
}

/// Something that can be shown of a source.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct ViewInfo {
    /// Its name in requests.
    pub name: String,
    /// What it shows, with the unit.
    pub about: String,
    /// Where the page lists it.
    pub group: ViewGroup,
    /// Its colours.
    pub legend: Legend,
}

/// Where the page lists a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum ViewGroup {
    /// Among the main views.
    Main,
    /// Among the layers.
    Layer,
}

/// A view's colours, in CSS notation.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum Legend {
    /// A gradient.
    Scale {
        /// Values and their colours, evenly spaced, low to high.
        stops: Vec<(String, String)>,
        /// The colour of cells that no reading reached.
        untouched: String,
    },
    /// Classes.
    Classes {
        /// Names and their colours.
        entries: Vec<(String, String)>,
        /// The colour of cells that no reading reached.
        untouched: String,
    },
}

/// A method.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct MethodInfo {
    /// Its name.
    pub name: &'static str,
    /// What it does.
    pub about: &'static str,
    /// The publication.
    pub source: &'static str,
    /// Its parameters.
    pub keys: Vec<ParameterInfo>,
}

/// A parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct ParameterInfo {
    /// Its name.
    pub name: &'static str,
    /// The values that it takes.
    pub values: &'static str,
    /// Its default.
    pub default: &'static str,
    /// What it does.
    pub about: &'static str,
}

/// A sensor; lengths in metres, angles in radians.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct SensorInfo {
    /// Its name in the log.
    pub id: String,
    /// Sonar or laser.
    pub kind: SensorKind,
    /// Half the beam's width.
    pub half_width: Option<f64>,
    /// Shorter ranges are rejected.
    pub r_min: Option<f64>,
    /// The farthest range.
    pub r_max: Option<f64>,
    /// Longer ranges are no hit.
    pub hit_range: Option<f64>,
    /// The range that a missing echo frees.
    pub no_echo_range: Option<f64>,
    /// Half the arc's thickness.
    pub epsilon: Option<f64>,
}

/// What was read of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct LogReport {
    /// Counts of readings: read, used, rejected and why.
    pub readings: Json,
    /// Lines that could not be read.
    pub bad_lines: BadLines,
}

/// Lines that could not be read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct BadLines {
    /// How many.
    pub count: u64,
    /// What is wrong with the first of them.
    pub first: Vec<String>,
}
