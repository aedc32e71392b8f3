//! A complete sensor, and the choices that describe it.

use serde::{Deserialize, Serialize};

/// The kind of a sensor's beam. It decides the defaults and the membership rule (a laser leaves no holes).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A cone of sound: the echo may come from any point of the arc.
    Sonar,
    /// A beam of light: narrow, its off-axis angle counts as 0.
    Laser,
}

/// The meaning of a range of exactly `r_max`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AtMax {
    /// No echo: the sensor reports its maximum for a missing echo (default).
    #[default]
    NoEcho,
    /// An echo: the log marks a missing echo otherwise.
    Hit,
}

impl AtMax {
    /// From its name, `hit` or `no_echo`.
    pub(crate) fn parse(name: &str) -> Result<AtMax, String> {
        match name {
            "hit" => Ok(AtMax::Hit),
            "no_echo" => Ok(AtMax::NoEcho),
            _ => Err("takes \"hit\" or \"no_echo\"".into()),
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            AtMax::Hit => "hit",
            AtMax::NoEcho => "no_echo",
        }
    }
}

/// The largest half width of a narrow beam, radians: 3° and a margin for rounding.
const NARROW: f64 = 3.0 * std::f64::consts::PI / 180.0 + 1e-12;

/// One sensor, complete.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Its name in the log.
    pub id: String,
    /// Sonar or laser.
    pub kind: Kind,
    /// Its position in the robot's frame: metres forward.
    pub x: f64,
    /// Its position in the robot's frame: metres to the left.
    pub y: f64,
    /// Its bearing in the robot's frame, radians.
    pub axis: f64,
    /// Half the beam's width β, radians, 0 to 60°.
    pub half_width: f64,
    /// Ranges below this are rejected, metres.
    pub r_min: f64,
    /// Ranges above this are no echo, metres; also Bayes' R.
    pub r_max: f64,
    /// The meaning of a range of exactly `r_max`.
    pub at_r_max: AtMax,
    /// Echoes from beyond this (≤ `r_max`) are rejected, metres.
    pub hit_range: f64,
    /// The range up to which a missing echo frees the cone, metres; 0: it frees nothing.
    pub no_echo_range: f64,
    /// Half the depth of the arc ε, metres; `None`: by kind and resolution, see [`Sensor::epsilon`].
    pub epsilon: Option<f64>,
}

impl Sensor {
    /// Whether its beam is narrow: a laser's, or one of β ≤ 3°. Such a beam reaches the cells within half a cell of its axis too,
    /// so that it leaves no holes, and its off-axis angle counts as 0.
    pub fn narrow(&self) -> bool {
        self.kind == Kind::Laser || self.half_width <= NARROW
    }

    /// ε in metres for cells of `resolution` metres: the sensor's own, else one cell for a laser and the larger of
    /// one cell and 0.05 m for a sonar.
    pub fn epsilon(&self, resolution: f64) -> f64 {
        self.epsilon.unwrap_or(match self.kind {
            Kind::Laser => resolution,
            Kind::Sonar => resolution.max(0.05),
        })
    }
}
