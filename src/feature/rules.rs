//! The rules of the feature stage.

/// The rules of the feature stage; each can be turned off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// The rules of the paper to the letter: every region is a wall, readings are held for three scans and only if no feature
    /// explains them, and corners are associated by the distance of the projected point.
    pub paper: bool,
    /// Corners are found.
    pub corners: bool,
    /// Points are distinguished from walls.
    pub points: bool,
    /// Phantoms are dropped.
    pub phantoms: bool,
    /// Endpoints close to each other are joined by short safe lines.
    pub lines: bool,
    /// Safe lines join endpoints up to 90° off the axis; else only those in the beam.
    pub wide: bool,
    /// The distance that the robot travels before a reading is released, metres.
    pub hold: f64,
}

impl Default for Rules {
    fn default() -> Self {
        Rules { paper: false, corners: true, points: true, phantoms: true, lines: true, wide: true, hold: 5.0 }
    }
}

impl Rules {
    /// The largest bearing off the axis of an endpoint of a safe line, radians.
    pub fn endpoint_bearing(&self, half_width: f64) -> f64 {
        if self.wide { std::f64::consts::FRAC_PI_2 } else { half_width }
    }
}
