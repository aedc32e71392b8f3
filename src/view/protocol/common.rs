//! Points, poses, and what several answers have in common.

use serde::Serialize;
use serde_json::Value;
#[cfg(test)]
use ts_rs::TS;

/// A point in cells: column and row, counted from the grid's lower left corner; a cell's centre lies at + 0.5.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct CellPoint(pub [f64; 2]);

/// A pose in the world frame: x and y in metres, heading in radians.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct WorldPose(pub [f64; 3]);

/// Any JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
#[cfg_attr(test, ts(type = "string | number | boolean | null | Json[] | { [key: string]: Json }"))]
pub struct Json(pub Value);

/// What an answer about a log refers to: the page compares it with its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct Stamp {
    /// Increases whenever the position in the log changes, and with new lanes.
    pub version: u64,
    /// Increases whenever the lanes are made anew.
    pub generation: u64,
}

/// An answer together with its stamp, in one JSON object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stamped<T> {
    /// The answer.
    #[serde(flatten)]
    pub answer: T,
    /// What it refers to.
    #[serde(flatten)]
    pub stamp: Stamp,
}

/// Sonar or laser.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum SensorKind {
    /// Sonar.
    Sonar,
    /// Laser.
    Laser,
}

/// The number, or `None` where it is not finite: JSON has no such number.
pub fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}
