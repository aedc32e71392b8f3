//! The parts of a report: its sensors, its cells, its layers.

use super::values::tidy;
use crate::grid::Scale;
use crate::sensor::{AtMax, Kind, Sensor};
use serde::Serialize;
use serde_json::{Value, json};

/// A sensor; lengths in metres and angles in radians, to 1e-9.
#[derive(Debug, Clone, Serialize)]
pub struct SensorReport {
    /// Its name in the log.
    pub id: String,
    /// Sonar or laser.
    pub kind: Kind,
    /// Its x in the robot's frame, forward.
    pub x: f64,
    /// Its y in the robot's frame, to the left.
    pub y: f64,
    /// Its bearing in the robot's frame.
    pub axis: f64,
    /// Half the beam's width.
    pub half_width: f64,
    /// Ranges below this are rejected.
    pub r_min: f64,
    /// Ranges above this are no echo.
    pub r_max: f64,
    /// What a range of just `r_max` is.
    pub at_r_max: AtMax,
    /// Echoes from beyond this are rejected.
    pub hit_range: f64,
    /// The range up to which a missing echo frees the cone.
    pub no_echo_range: f64,
    /// Half the depth of the arc.
    pub epsilon: f64,
}

impl SensorReport {
    /// The report of a sensor over cells of `resolution`, metres.
    pub(super) fn of(sensor: &Sensor, resolution: f64) -> SensorReport {
        SensorReport {
            id: sensor.id.clone(),
            kind: sensor.kind,
            x: tidy(sensor.x),
            y: tidy(sensor.y),
            axis: tidy(sensor.axis),
            half_width: tidy(sensor.half_width),
            r_min: tidy(sensor.r_min),
            r_max: tidy(sensor.r_max),
            at_r_max: sensor.at_r_max,
            hit_range: tidy(sensor.hit_range),
            no_echo_range: tidy(sensor.no_echo_range),
            epsilon: tidy(sensor.epsilon(resolution)),
        }
    }
}

/// The grid of a map, and the number of cells of each class.
#[derive(Debug, Clone, Serialize)]
pub struct CellCounts {
    /// World x of the left edge, metres.
    pub x0: f64,
    /// World y of the bottom edge, metres.
    pub y0: f64,
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Cells that a reading reached.
    pub touched: u64,
    /// Cells of class occupied.
    pub occupied: u64,
    /// Cells of class empty.
    pub empty: u64,
    /// Cells of class unknown, reached or not.
    pub unknown: u64,
}

/// A summary of a layer's values. Not-a-number and infinities are `null` in the file.
#[derive(Debug, Clone, Serialize)]
pub struct LayerReport {
    /// The sum over all cells in f64: chunk by chunk of 1024 × 1024 cells, in each row by row, from the lower left.
    pub sum: f64,
    /// The smallest value.
    pub min: f64,
    /// The largest value.
    pub max: f64,
    /// Its colours: `{"grey": [low, high]}`, `{"signed": limit}`, `{"heat": [low, high]}` or `{"classes": [[r, g, b], …]}`.
    pub scale: Value,
}

impl LayerReport {
    /// The summary of no cells.
    pub(super) fn start(scale: Scale) -> LayerReport {
        let scale = match scale {
            Scale::Grey { low, high } => json!({ "grey": [low, high] }),
            Scale::Signed { limit } => json!({ "signed": limit }),
            Scale::Heat { low, high } => json!({ "heat": [low, high] }),
            Scale::Classes(palette) => json!({ "classes": palette.colours() }),
        };
        LayerReport { sum: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY, scale }
    }

    /// Adds the sum, the least and the largest value of more cells.
    pub(super) fn add(&mut self, [sum, min, max]: [f64; 3]) {
        self.sum += sum;
        (self.min, self.max) = (self.min.min(min), self.max.max(max));
    }
}
