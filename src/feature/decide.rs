//! What becomes of a held reading: one of four cases.

use super::associate::{Association, associate};
use super::features::Features;
use super::limit::{By, Limit, View};
use super::ping::Ping;
use super::rules::Rules;
use crate::geometry::plane::{Point, add, times};

/// Bearings at which the free limit is known.
pub const BEARINGS: usize = 21;
/// An echo hidden by what is nearer by this, metres.
const HIDDEN: f64 = 0.15;

/// P(z = feature) from which on a reading is associated with it.
const ASSOCIATED: f64 = 0.5;

/// The case of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Case {
    /// (i) From a feature, and nothing hides it.
    Associated,
    /// (ii) From behind a wall: an outlier.
    Outlier,
    /// (iii) From behind a safe line, or beyond a single end.
    Behind,
    /// (iv) None of these.
    Routine,
}

/// A reading with its features and limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The case.
    pub case: Case,
    /// Its features.
    pub association: Association,
    /// Directions of the bearings, from right to left, unit vectors.
    pub rays: [Point; BEARINGS],
    /// The free limit there, metres.
    pub limits: [f64; BEARINGS],
    /// Up to where cells may be freed there, metres.
    pub before: [f64; BEARINGS],
}

/// The direction turned left by an angle.
fn turned(axis: Point, by: f64) -> Point {
    let (sin, cos) = by.sin_cos();
    add(times(axis, cos), times((-axis.1, axis.0), sin))
}

/// Decides a reading.
pub fn decide(ping: &Ping, features: &Features, view: &View, rules: &Rules) -> Decision {
    let z = ping.range.unwrap_or(ping.reach);
    let sector = view.sector((ping.at, ping.axis), ping.half_width, rules.aside(ping.half_width), |_| true);
    let bearing = |k: usize| ping.half_width * (k as f64 / (BEARINGS / 2) as f64 - 1.0);
    let rays: [Point; BEARINGS] = std::array::from_fn(|k| turned(ping.axis, bearing(k)));
    let all: [Limit; BEARINGS] = std::array::from_fn(|k| sector.limit(rays[k], bearing(k).sin()));
    let axis = all[BEARINGS / 2];
    let hidden = |by: By| axis.by == by && axis.distance < z - HIDDEN;
    let association = match ping.range {
        Some(z) => associate(ping, z, features, rules),
        None => Association::default(),
    };
    let case = if hidden(By::Wall) {
        Case::Outlier
    } else if association.best() >= ASSOCIATED {
        Case::Associated
    } else if hidden(By::Line) && ping.range.is_some() {
        Case::Behind
    } else {
        Case::Routine
    };
    Decision { case, association, rays, limits: all.map(|l| l.distance), before: all.map(|l| l.before) }
}
