//! The association of a reading with features, with probabilities.

use super::features::Features;
use super::ping::Ping;
use super::rules::Rules;
use crate::geometry::plane::{Point, distance_to_segment};
use nalgebra::distance;

/// Standard deviation of a range, and of the projected point's distance from its wall, metres.
const SIGMA: f64 = 0.05;
/// Standard deviation of the projected point's distance from its corner by the paper's rules, metres.
const PAPER_SIGMA: f64 = 0.20;

/// The likeliest feature of each kind: its index, and the probability that the reading came from it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Association {
    /// A wall.
    pub wall: Option<(usize, f64)>,
    /// A corner.
    pub corner: Option<(usize, f64)>,
    /// A point, where its probability exceeds twice the others.
    pub point: Option<(usize, f64)>,
}

impl Association {
    /// P(z = w), P(z = c), P(z = p).
    pub fn weights(&self) -> [f64; 3] {
        [self.wall, self.corner, self.point].map(|f| f.map_or(0.0, |(_, p)| p))
    }

    /// P(z = o): the reading came from none of them.
    pub fn other(&self) -> f64 {
        self.weights().iter().map(|p| 1.0 - p).product()
    }

    /// The largest of the probabilities.
    pub fn best(&self) -> f64 {
        self.weights().into_iter().fold(0.0, f64::max)
    }
}

/// exp(−d²/2σ²).
fn gaussian(d: f64, sigma: f64) -> f64 {
    (-d * d / (2.0 * sigma * sigma)).exp()
}

/// Associates a reading of range `z`, metres.
pub fn associate(ping: &Ping, z: f64, features: &Features, rules: &Rules) -> Association {
    let mut found = Association::default();
    let better = |best: &mut Option<(usize, f64)>, k: usize, p: f64| {
        if p > 1e-3 && best.is_none_or(|(_, b)| p > b) {
            *best = Some((k, p));
        }
    };
    let tip = ping.at + ping.axis * z;
    for (k, wall) in features.walls.iter().enumerate().filter(|(_, w)| w.front(ping.at) > 0.0) {
        let [a, b] = wall.ends();
        better(&mut found.wall, k, gaussian(distance_to_segment(tip, a, b), SIGMA));
    }
    let bearing = |at: Point| {
        let v = at - ping.at;
        ping.axis.perp(&v).atan2(ping.axis.dot(&v)).abs()
    };
    if rules.corners {
        for (k, corner) in features.corners.iter().enumerate() {
            let p = if rules.paper {
                gaussian(distance(&tip, &corner.at), PAPER_SIGMA)
            } else {
                let faced = corner.walls.iter().all(|w| features.walls[*w].front(ping.at) > 0.0);
                if faced && bearing(corner.at) <= ping.half_width {
                    gaussian(z - distance(&ping.at, &corner.at), SIGMA)
                } else {
                    0.0
                }
            };
            better(&mut found.corner, k, p);
        }
    }
    if rules.points {
        for (k, point) in features.points.iter().enumerate() {
            let seen = bearing(point.at) <= ping.half_width;
            better(&mut found.point, k, if seen { gaussian(z - distance(&ping.at, &point.at), SIGMA) } else { 0.0 });
        }
        let [wall, corner, point] = found.weights();
        if point > 2.0 * wall.max(corner) {
            (found.wall, found.corner) = (None, None);
        } else {
            found.point = None;
        }
    }
    found
}
