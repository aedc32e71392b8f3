//! The stage's rules.

/// How the stage decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// The paper's literal rules.
    pub paper: bool,
    /// Corners are found.
    pub corners: bool,
    /// Points are told from walls.
    pub points: bool,
    /// Phantoms are dropped.
    pub phantoms: bool,
    /// Travel for which a reading is held, metres.
    pub hold: f64,
    /// σ of the distance from a wall, metres.
    pub sigma_wall: f64,
    /// σ of a range, metres.
    pub sigma_range: f64,
    /// P(z = feature) from which a reading is associated.
    pub associated: f64,
}

impl Default for Rules {
    fn default() -> Self {
        Rules { paper: false, corners: true, points: true, phantoms: true, hold: 5.0, sigma_wall: 0.05, sigma_range: 0.05, associated: 0.5 }
    }
}
