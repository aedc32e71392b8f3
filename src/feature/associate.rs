//! Which feature a reading came from, and with what probability.

use super::features::Features;
use super::ping::Ping;
use super::rules::Rules;
use crate::geometry::plane::{Point, add, cross, distance, dot, from_segment, sub, times};

/// Deviation of a range, and of a projected point from its wall, metres.
const SIGMA: f64 = 0.05;
/// The paper's deviation of a projected point from its corner, metres.
const PAPER: f64 = 0.20;

/// The best of each kind: which, and P(z = it).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Association {
    /// A wall.
    pub wall: Option<(usize, f64)>,
    /// A corner.
    pub corner: Option<(usize, f64)>,
    /// A point, where it exceeds twice the others.
    pub spot: Option<(usize, f64)>,
}

impl Association {
    /// P(z = w), P(z = c), P(z = p).
    pub fn weights(&self) -> [f64; 3] {
        [self.wall, self.corner, self.spot].map(|f| f.map_or(0.0, |(_, p)| p))
    }

    /// P(z = o).
    pub fn other(&self) -> f64 {
        self.weights().iter().map(|p| 1.0 - p).product()
    }

    /// The likeliest.
    pub fn best(&self) -> f64 {
        self.weights().into_iter().fold(0.0, f64::max)
    }
}

fn bell(d: f64, sigma: f64) -> f64 {
    (-d * d / (2.0 * sigma * sigma)).exp()
}

/// Where a reading's echo may have come from.
pub fn associate(ping: &Ping, z: f64, features: &Features, rules: &Rules) -> Association {
    let mut found = Association::default();
    let better = |best: &mut Option<(usize, f64)>, k: usize, p: f64| {
        if p > 1e-3 && best.is_none_or(|(_, b)| p > b) {
            *best = Some((k, p));
        }
    };
    let tip = add(ping.at, times(ping.axis, z));
    for (k, wall) in features.walls.iter().enumerate().filter(|(_, w)| w.front(ping.at) > 0.0) {
        let [a, b] = wall.ends();
        better(&mut found.wall, k, bell(from_segment(tip, a, b), SIGMA));
    }
    let bearing = |at: Point| {
        let v = sub(at, ping.at);
        cross(ping.axis, v).atan2(dot(ping.axis, v)).abs()
    };
    if rules.corners {
        for (k, corner) in features.corners.iter().enumerate() {
            let p = if rules.paper {
                bell(distance(tip, corner.at), PAPER)
            } else {
                let faced = corner.walls.iter().all(|w| features.walls[*w].front(ping.at) > 0.0);
                if faced && bearing(corner.at) <= ping.half_width {
                    bell(z - distance(ping.at, corner.at), SIGMA)
                } else {
                    0.0
                }
            };
            better(&mut found.corner, k, p);
        }
    }
    if rules.points {
        for (k, spot) in features.spots.iter().enumerate() {
            let seen = bearing(spot.at) <= ping.half_width;
            better(&mut found.spot, k, if seen { bell(z - distance(ping.at, spot.at), SIGMA) } else { 0.0 });
        }
        let [wall, corner, spot] = found.weights();
        if spot > 2.0 * wall.max(corner) {
            (found.wall, found.corner) = (None, None);
        } else {
            found.spot = None;
        }
    }
    found
}
