//! The stage's rules.

/// How the stage decides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// The paper's literal rules: every region a wall, readings held for three scans and only where no feature explains them,
    /// corners associated by the distance of the projected point.
    pub paper: bool,
    /// Corners are found.
    pub corners: bool,
    /// Points are told from walls.
    pub points: bool,
    /// Phantoms are dropped.
    pub phantoms: bool,
    /// Short safe lines between ends near each other.
    pub lines: bool,
    /// Safe lines join ends up to 90° off the axis; else those in the cone alone.
    pub wide: bool,
    /// Travel for which a reading is held, metres.
    pub hold: f64,
}

impl Default for Rules {
    fn default() -> Self {
        Rules { paper: false, corners: true, points: true, phantoms: true, lines: true, wide: true, hold: 5.0 }
    }
}

impl Rules {
    /// How far off the axis ends count, radians.
    pub fn aside(&self, half_width: f64) -> f64 {
        if self.wide { std::f64::consts::FRAC_PI_2 } else { half_width }
    }
}
