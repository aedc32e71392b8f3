//! Decides which of four cases a held reading is.

use super::associate::{Association, associate};
use super::features::Features;
use super::limit::{Limit, LimitKind, Obstacles};
use super::ping::Ping;
use super::rules::Rules;
use crate::geometry::plane::Vector;
use nalgebra::UnitComplex;

/// The number of bearings in a beam at which the free limit is computed.
pub const BEARINGS: usize = 21;
/// An echo is hidden by what is nearer than it by this, metres.
const HIDDEN: f64 = 0.15;

/// The least probability of an association.
const ASSOCIATED: f64 = 0.5;

/// The case of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Case {
    /// (i) It came from a feature that nothing hides.
    Associated,
    /// (ii) It came from behind a wall: an outlier.
    Outlier,
    /// (iii) It came from behind a safe line or from beyond a single endpoint.
    Behind,
    /// (iv) None of these applies.
    Routine,
}

/// The case of a reading, with its features and free limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The case.
    pub case: Case,
    /// Its features.
    pub association: Association,
    /// The unit vectors of the bearings, from right to left.
    pub rays: [Vector; BEARINGS],
    /// The free limit at each bearing, metres.
    pub limits: [f64; BEARINGS],
    /// The range up to which cells may be freed at each bearing, metres.
    pub free: [f64; BEARINGS],
}

/// Decides the case of a reading.
pub fn decide(ping: &Ping, features: &Features, obstacles: &Obstacles, rules: &Rules) -> Decision {
    let z = ping.range.unwrap_or(ping.reach);
    let sector =
        obstacles.sector((ping.at, ping.axis), ping.half_width, rules.endpoint_bearing(ping.half_width), |_| true);
    let bearing = |k: usize| ping.half_width * (k as f64 / (BEARINGS / 2) as f64 - 1.0);
    let rays: [Vector; BEARINGS] = std::array::from_fn(|k| UnitComplex::new(bearing(k)) * ping.axis);
    let all: [Limit; BEARINGS] = std::array::from_fn(|k| sector.limit(rays[k], bearing(k).sin()));
    let axis = all[BEARINGS / 2];
    let hidden = |kind: LimitKind| axis.kind == kind && axis.distance < z - HIDDEN;
    let association = match ping.range {
        Some(z) => associate(ping, z, features, rules),
        None => Association::default(),
    };
    let case = if hidden(LimitKind::Wall) {
        Case::Outlier
    } else if association.best() >= ASSOCIATED {
        Case::Associated
    } else if hidden(LimitKind::SafeLine) && ping.range.is_some() {
        Case::Behind
    } else {
        Case::Routine
    };
    Decision { case, association, rays, limits: all.map(|l| l.distance), free: all.map(|l| l.free) }
}
