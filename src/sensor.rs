//! Sensors: where a transducer sits on the robot, what it sees, and which of its answers are to be trusted.
//!
//! A sensor is described by a preset, a log's header, a TOML file (`--sensor-file`) or `--set key=value`; the later beats
//! the earlier. Lengths are metres, angles radians, counter-clockwise from the robot's forward axis.

mod description;
mod file;
mod overrides;
mod quantity;

pub use description::Description;
pub use file::{SensorFile, preset};
pub use overrides::{Mounts, OVERRIDE_KEYS, Overrides};
pub use quantity::{angle, length};

pub(crate) use crate::similar::similar;
pub(crate) use description::{SensorKey, Value};

use serde::{Deserialize, Serialize};

/// What kind of beam a sensor has. It decides the defaults and the membership rule (a laser leaves no holes).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A cone of sound: its echo comes from anywhere on the arc.
    Sonar,
    /// A beam of light: narrow, its off-axis angle counts as 0.
    Laser,
}

/// One sensor, complete.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Its name in the log.
    pub id: String,
    /// Sonar or laser.
    pub kind: Kind,
    /// Its place in the robot's frame: metres forward.
    pub x: f64,
    /// Its place in the robot's frame: metres to the left.
    pub y: f64,
    /// Its bearing in the robot's frame, radians.
    pub axis: f64,
    /// Half the beam's width β, radians, 0 to 60°.
    pub half_width: f64,
    /// Ranges below this are rejected, metres.
    pub r_min: f64,
    /// Ranges above this are no echo, metres; also Bayes' R.
    pub r_max: f64,
    /// Echoes from beyond this (≤ `r_max`) are rejected, metres.
    pub hit_range: f64,
    /// How far a missing echo frees the cone, metres; 0: not at all.
    pub no_echo_range: f64,
    /// Half the depth of the arc ε, metres; `None`: by kind and resolution, see [`Sensor::epsilon`].
    pub epsilon: Option<f64>,
}

impl Sensor {
    /// ε in metres for cells of `resolution` metres: the sensor's own, else one cell for a laser and the larger of
    /// one cell and 0.05 m for a sonar.
    pub fn epsilon(&self, resolution: f64) -> f64 {
        self.epsilon.unwrap_or(match self.kind {
            Kind::Laser => resolution,
            Kind::Sonar => resolution.max(0.05),
        })
    }
}
