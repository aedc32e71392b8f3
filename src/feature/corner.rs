//! Concave corners: intersections of the lines of two walls, near the ends of both and confirmed by echoes from there.

use super::features::{Corner, Features, Wall};
use super::rcd::{Rcd, Source, tolerance};
use super::rules::Rules;
use super::wall::concave;
use crate::geometry::plane::{Point, intersect_ray};
use nalgebra::distance;

/// The farthest that a corner lies inside either wall, metres.
const MAX_INSIDE: f64 = 0.6;
/// Corners nearer than this are one, metres.
const SAME: f64 = 0.35;
/// The length of extrapolated walls that halves the likelihood of a corner, metres.
const HALVING_LENGTH: f64 = 2.0;

/// The distance from the known extents of its walls up to which a corner is fully likely, metres.
const REACH: f64 = 4.5;

/// Walls that end no farther from their intersection are taken to meet, metres, if each has enough regions.
const MEETING: f64 = 0.3;
/// Regions of each wall that are enough.
const MIN_REGIONS: usize = 3;

/// 1 up to a distance of `full`, then a Gaussian of standard deviation `s`.
fn falloff(d: f64, full: f64, s: f64) -> f64 {
    if d <= full { 1.0 } else { (-(d - full) * (d - full) / (2.0 * s * s)).exp() }
}

/// The corners of the walls of probability ½ or more, none of them near a likelier one. `rcds` are the regions of the features,
/// `path` the steps of the robot.
pub fn corners(features: &Features, rcds: &[Rcd], path: &[[Point; 2]], rules: &Rules) -> Vec<Corner> {
    let walls = &features.walls;
    let mut found: Vec<Corner> = Vec::new();
    for (i, a) in walls.iter().enumerate() {
        for (k, b) in walls.iter().enumerate().skip(i + 1) {
            if let Some(at) = concave(a, b) {
                let (probability, answers) = probability(at, [a, b], rcds, rules);
                let extrapolated_walls = [a, b].map(|w| extrapolated(at, w));
                let corner = Corner { at, walls: [i, k], probability, extrapolated_walls };
                if probability >= 0.5 && open(&corner, answers, features, rcds, path) {
                    found.push(corner);
                }
            }
        }
    }
    // An echo confirms all corners around it: that with the shorter extrapolated walls is likelier.
    let likely = |c: &Corner| {
        let length: f64 = c.extrapolated_walls.iter().flatten().map(|[a, b]| distance(a, b)).sum();
        // A wall of one region may be a false one.
        let sure = |k: &usize| 1.0 - 0.5f64.powi(walls[*k].rcds.len().min(30) as i32);
        c.probability * (-length / HALVING_LENGTH).exp2() * c.walls.iter().map(sure).product::<f64>()
    };
    found.sort_by(|a, b| likely(b).total_cmp(&likely(a)));
    let mut kept: Vec<Corner> = Vec::new();
    for corner in found {
        if kept.iter().all(|k| distance(&k.at, &corner.at) > SAME) {
            kept.push(corner);
        }
    }
    kept
}

/// The probability of a corner, and how many echoes confirm it.
fn probability(at: Point, walls: [&Wall; 2], rcds: &[Rcd], rules: &Rules) -> (f64, usize) {
    let beyond = walls.map(|w| w.beyond(w.place(at)));
    if beyond.iter().any(|b| *b < -MAX_INSIDE) {
        return (0.0, 0);
    }
    // If points are not told from walls, every region but the walls' own may be the corner's.
    let told = rules.points && !rules.paper;
    let own = |k: &usize| walls.iter().any(|w| w.rcds.contains(k));
    let point = |(k, r): &(usize, &Rcd)| if told { r.source == Source::Point } else { !own(k) };
    let points: Vec<f64> = rcds.iter().enumerate().filter(point).map(|(_, r)| r).map(|r| answers(r, at)).collect();
    let point = points.iter().copied().fold(0.0, f64::max);
    let reached = beyond.iter().all(|b| *b <= MEETING) && walls.iter().all(|w| w.rcds.len() >= MIN_REGIONS);
    if reached {
        return (1.0, usize::MAX);
    }
    let walls = falloff(beyond[0].max(0.0), REACH, 0.6) * falloff(beyond[1].max(0.0), REACH, 0.6);
    (walls * point, points.iter().filter(|p| **p >= 0.5).count())
}

/// How well a region fits an echo from a point: ranges are known to centimetres, bearings to degrees.
fn answers(rcd: &Rcd, at: Point) -> f64 {
    let v = at - rcd.centre;
    let off = rcd.normal.perp(&v).atan2(rcd.normal.dot(&v)).abs();
    falloff((v.norm() - rcd.range).abs(), tolerance(rcd.range), 0.03) * falloff(off, 0.04, 0.02)
}

/// The segment from a corner to the end of a wall that doesn't reach it.
fn extrapolated(at: Point, wall: &Wall) -> Option<[Point; 2]> {
    let s = wall.place(at);
    (wall.beyond(s) > 0.0).then(|| [at, wall.at(s.clamp(wall.extent[0], wall.extent[1]))])
}

/// Whether nothing crosses its extrapolated walls: no other wall, no line of sight to a feature, and no step of the robot.
fn open(corner: &Corner, answers: usize, features: &Features, rcds: &[Rcd], path: &[[Point; 2]]) -> bool {
    let walls = &features.walls;
    let others = || walls.iter().enumerate().filter(|(k, _)| !corner.walls.contains(k));
    let seen = || features.members().map(|k| &rcds[k]);
    let segments = || corner.extrapolated_walls.iter().flatten();
    let crossed = |from: Point, to: Point, margin: f64| {
        let v = to - from;
        let far = v.norm();
        let ray = v * (1.0 / far.max(1e-9));
        segments().any(|s| intersect_ray(from, ray, *s).is_some_and(|d| d < far - margin))
    };
    others().all(|(_, w)| !crossed(w.ends()[0], w.ends()[1], 0.0))
        && path.iter().all(|step| !crossed(step[0], step[1], 0.0))
        && seen().filter(|r| crossed(r.centre, r.foot, 0.15)).count() <= answers
}

/// Shortens each wall that extends beyond its corner, and drops the points at corners.
pub fn cut(features: &mut Features) {
    let Features { walls, corners, points, .. } = features;
    points.retain(|s| corners.iter().all(|c| distance(&c.at, &s.at) > SAME));
    for corner in corners.iter() {
        for k in corner.walls {
            let wall = &mut walls[k];
            let s = wall.place(corner.at);
            if wall.beyond(s) < 0.0 {
                let side = usize::from(s - wall.extent[0] > wall.extent[1] - s);
                wall.extent[side] = s;
            }
        }
    }
}
