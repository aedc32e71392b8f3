//! One sonar reading: the beam, an echo on its way back, and what is detected. Amplitude of an echo from `d` metres:
//! A(d)·e^(−κ(θt² + θr²)/β²)·ρ, with A(d) = e^(−0.36 d)/d, and θt and θr the angles of departure and arrival off the
//! beam's axis.

use crate::geometry::plane::{Point, Vector, Wedge};
use nalgebra::UnitComplex;

/// κ = ½ ln(A(0.15)/A(5)).
const KAPPA: f64 = 2.626_278_948_659_99;

/// How echoes are simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Physics {
    /// Most reflections of an echo, 1 to 3. With 1, only walls, corners, edges and arcs in direct view answer.
    pub bounces: u8,
    /// Whether walls reflect like mirrors; if not, every reading is the nearest distance in its cone.
    pub specular: bool,
    /// Standard deviation of the logarithm of an amplitude.
    pub flutter: f64,
}

impl Default for Physics {
    fn default() -> Self {
        Physics { bounces: 3, specular: true, flutter: 0.15 }
    }
}

/// The beam of one sonar. World frame, metres, radians.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    /// The transducer.
    pub origin: Point,
    /// Unit vector.
    pub axis: Vector,
    pub half_width: f64,
    pub r_min: f64,
    pub r_max: f64,
}

/// What a sensor detected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Detection {
    /// Metres.
    pub distance: f64,
    /// The class of the surface, from 1.
    pub class: Option<u16>,
}

/// An echo that may be detected.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Echo {
    /// Half the length of its path, metres.
    pub distance: f64,
    pub amplitude: f64,
    /// The points at which it is reflected, in order; the first `reflections` count.
    pub path: [Point; 3],
    pub reflections: usize,
    /// Whether it returns to the transducer from its last point directly, instead of the way it came.
    pub closed: bool,
    /// Whether its last point is a corner.
    pub from_corner: bool,
    pub class: Option<u16>,
}

/// A(d): what spreading and absorption leave of an amplitude after `d` metres.
pub(crate) fn attenuation(d: f64) -> f64 {
    (-0.36 * d).exp() / d
}

impl Beam {
    /// The distance to a point, and the gain one way; `None` outside the beam.
    pub fn towards(&self, p: Point) -> Option<(f64, f64)> {
        let v = p - self.origin;
        let d = v.norm();
        let gain = self.gain(v * (1.0 / d))?;
        (d <= self.r_max).then_some((d, gain))
    }

    /// e^(−κθ²/β²) for a unit direction; `None` outside the beam.
    pub fn gain(&self, direction: Vector) -> Option<f64> {
        let cosine = direction.dot(&self.axis);
        if cosine < 0.4 {
            return None; // beams are no wider than 60°
        }
        let angle = self.axis.perp(&direction).atan2(cosine);
        let share = (angle / self.half_width).powi(2);
        (share <= 1.0).then(|| (-KAPPA * share).exp())
    }

    /// The beam as a wedge.
    pub fn wedge(&self) -> Wedge {
        let turn = UnitComplex::new(self.half_width);
        Wedge { apex: self.origin, right: turn.inverse() * self.axis, left: turn * self.axis }
    }
}
