//! Safe lines between features' ends that are near each other: an object's front that no echo came from, a gap between two walls.

use super::features::{Features, hit};
use super::rcd::Rcd;
use crate::geometry::plane::{Point, distance, length, sub, times};

/// Such a line is no longer, metres.
const LONGEST: f64 = 0.7;
/// Ends nearer than this are one, metres.
const SHORTEST: f64 = 0.01;
/// A sighting that ends so near behind a line doesn't cross it, metres.
const BEYOND: f64 = 0.10;

/// The lines that neither the robot's path nor a sighting of a feature crosses.
pub fn lines(features: &Features, rcds: &[Rcd], path: &[[Point; 2]]) -> Vec<[Point; 2]> {
    let walls = features.walls.iter().enumerate().flat_map(|(k, w)| w.ends().map(|e| (e, Some(k))));
    let spots = features.spots.iter().map(|s| (s.at, None));
    let corners = features.corners.iter().map(|c| (c.at, None));
    let ends: Vec<(Point, Option<usize>)> = walls.chain(spots).chain(corners).collect();
    let sightings: Vec<&Rcd> = features.members().map(|k| &rcds[k]).collect();
    let crossed = |line: [Point; 2]| {
        let passes = |from: Point, to: Point, beyond: f64| {
            let v = sub(to, from);
            let far = length(v);
            far > 0.0 && hit(from, times(v, 1.0 / far), line).is_some_and(|d| d < far - beyond)
        };
        path.iter().any(|s| passes(s[0], s[1], 0.0)) || sightings.iter().any(|r| passes(r.centre, r.foot, BEYOND))
    };
    let mut found = Vec::new();
    for (k, (a, of)) in ends.iter().enumerate() {
        for (b, other) in &ends[k + 1..] {
            let far = distance(*a, *b);
            let own = of.is_some() && of == other;
            if !own && (SHORTEST..=LONGEST).contains(&far) && !crossed([*a, *b]) {
                found.push([*a, *b]);
            }
        }
    }
    found
}
