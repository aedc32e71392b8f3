//! Short safe lines between endpoints close to each other: the front of an object that returned no echo, or a gap between walls.

use super::features::Features;
use super::rcd::Rcd;
use crate::geometry::plane::{Point, intersect_ray};
use nalgebra::distance;

/// The longest such line, metres.
const MAX_LENGTH: f64 = 0.7;
/// Endpoints nearer than this coincide, metres.
const MIN_LENGTH: f64 = 0.01;
/// A line of sight that ends this close behind a line doesn't cross it, metres.
const BEYOND: f64 = 0.10;

/// The lines that neither the robot's path nor a line of sight to a feature crosses.
pub fn lines(features: &Features, rcds: &[Rcd], path: &[[Point; 2]]) -> Vec<[Point; 2]> {
    let walls = features.walls.iter().enumerate().flat_map(|(k, w)| w.ends().map(|e| (e, Some(k))));
    let points = features.points.iter().map(|s| (s.at, None));
    let corners = features.corners.iter().map(|c| (c.at, None));
    let ends: Vec<(Point, Option<usize>)> = walls.chain(points).chain(corners).collect();
    let sightings: Vec<&Rcd> = features.members().map(|k| &rcds[k]).collect();
    let crossed = |line: [Point; 2]| {
        let passes = |from: Point, to: Point, beyond: f64| {
            let v = to - from;
            let far = v.norm();
            far > 0.0 && intersect_ray(from, v * (1.0 / far), line).is_some_and(|d| d < far - beyond)
        };
        path.iter().any(|s| passes(s[0], s[1], 0.0)) || sightings.iter().any(|r| passes(r.centre, r.foot, BEYOND))
    };
    let mut found = Vec::new();
    for (k, (a, of)) in ends.iter().enumerate() {
        for (b, other) in &ends[k + 1..] {
            let far = distance(a, b);
            let own = of.is_some() && of == other;
            if !own && (MIN_LENGTH..=MAX_LENGTH).contains(&far) && !crossed([*a, *b]) {
                found.push([*a, *b]);
            }
        }
    }
    found
}
