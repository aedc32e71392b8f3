//! `api/go`: the position in the log, and the reading or scan that was applied last.

use super::common::{CellPoint, SensorKind, Stamp, WorldPose};
use serde::Serialize;
#[cfg(test)]
use ts_rs::TS;

/// The position in the log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct State {
    /// The version and generation of this state.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Items of the first lane that are applied.
    pub position: usize,
    /// All items of the first lane.
    pub total: usize,
    /// Scans begun so far.
    pub scan: usize,
    /// All scans.
    pub scans: usize,
    /// Whether the target is reached; false: the time budget ended first.
    pub done: bool,
    /// The position that was asked for, in items of the first lane.
    pub target: usize,
    /// Each lane's position.
    pub lanes: Vec<LaneState>,
}

/// A lane's position.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct LaneState {
    /// Items that are applied.
    pub position: usize,
    /// All items.
    pub total: usize,
    /// Tiles of level 0 that changed since the last state.
    pub changed: ChangedTiles,
    /// The item that was applied last; `null` at the beginning.
    pub current: Option<Current>,
}

/// Tiles of level 0, of 256 × 256 cells.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
#[cfg_attr(test, derive(TS))]
pub enum ChangedTiles {
    /// These: column and row of tiles.
    Some(Vec<[usize; 2]>),
    /// Possibly all.
    All(AllTiles),
}

/// All tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum AllTiles {
    /// All tiles.
    All,
}

/// The item that was applied last.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum Current {
    /// A reading, or an update that features made of one.
    Reading(Box<CurrentReading>),
    /// A scan.
    Scan(CurrentScan),
}

/// A reading.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct CurrentReading {
    /// Which item, from 1.
    pub number: usize,
    /// Its line of the log.
    pub line: u64,
    /// The log's number of its scan.
    pub scan: u64,
    /// Its time, seconds.
    pub t: Option<f64>,
    /// Its sensor.
    pub sensor: String,
    /// The kind of its sensor.
    pub sensor_kind: SensorKind,
    /// The robot's pose.
    pub robot: WorldPose,
    /// The sensor's pose.
    pub pose: WorldPose,
    /// The range in the log, metres; `null`: no echo.
    pub z: Option<f64>,
    /// Hit or no echo.
    pub outcome: EchoOutcome,
    /// The range that is mapped, metres.
    pub range: Option<f64>,
    /// Half the beam's width, radians.
    pub half_width: Option<f64>,
    /// The outline of its cone; `null` where it lies outside the grid.
    pub outline: Option<Outline>,
    /// What features made of it; `null` for other methods.
    pub case: Option<FeatureCase>,
}

/// Hit or no echo.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(TS))]
pub enum EchoOutcome {
    /// An echo came back.
    Hit,
    /// None came back.
    NoEcho,
}

/// The outline of a cone.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Outline {
    /// The sensor.
    pub sensor: CellPoint,
    /// Both ends of the axis.
    pub axis: [CellPoint; 2],
    /// Polylines.
    pub lines: Vec<Vec<CellPoint>>,
}

/// What features made of a reading.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct FeatureCase {
    /// The case.
    pub name: FeatureCaseName,
    /// What it means.
    pub about: &'static str,
    /// What each feature contributed.
    pub parts: Vec<FeaturePart>,
    /// What the Bayesian update contributed.
    pub routine: Option<RoutinePart>,
}

/// The case of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum FeatureCaseName {
    /// From a visible feature.
    Associated,
    /// From behind a wall.
    Outlier,
    /// From behind a safe line.
    Behind,
    /// From no known feature.
    Routine,
}

/// The contribution of a feature.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct FeaturePart {
    /// The kind of the feature.
    pub feature: FeatureKind,
    /// Its weight, 0 to 1.
    pub weight: f64,
    /// The polygon that it frees.
    pub free: Option<Vec<CellPoint>>,
    /// The line segments that it occupies.
    pub occupied: Vec<[CellPoint; 2]>,
}

/// The kind of a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum FeatureKind {
    /// A wall.
    Wall,
    /// A corner.
    Corner,
    /// A point.
    Point,
}

/// The contribution of the Bayesian update.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct RoutinePart {
    /// Its weight, 0 to 1.
    pub weight: f64,
    /// The polygon that it frees.
    pub free: Option<Vec<CellPoint>>,
    /// The polygon of its arc.
    pub arc: Option<Vec<CellPoint>>,
    /// Whether it occupies the arc.
    pub occupies: bool,
}

/// A scan.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct CurrentScan {
    /// Which item, from 1.
    pub number: usize,
    /// Its last line of the log.
    pub line: u64,
    /// Which scan, from 0.
    pub scan: usize,
    /// A scan has no time of its own: always `null`.
    pub t: Option<f64>,
    /// The robot's pose.
    pub robot: WorldPose,
    /// The robot.
    pub robot_cell: CellPoint,
    /// Its beams.
    pub beams: Vec<Beam>,
}

/// A beam of a scan.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Beam {
    /// Its line of the log.
    pub line: u64,
    /// The sensor's pose.
    pub pose: WorldPose,
    /// Its range, metres; `null`: nothing came back.
    pub range: Option<f64>,
    /// The label of what it hit, from 1; `null`: none.
    pub label: Option<u32>,
    /// From the sensor to the hit, or as far as the sensor hears.
    pub ray: [CellPoint; 2],
}
