//! Concave corners: where two walls' lines meet, near the ends of both and near a point that answers from there.

use super::features::{Corner, Features, Wall, hit};
use super::rcd::{Rcd, Source, tolerance};
use super::rules::Rules;
use super::wall::concave;
use crate::geometry::plane::{Point, cross, distance, dot, length, sub, times};

/// A corner lies no farther inside either wall, metres.
const INSIDE: f64 = 0.6;
/// Corners nearer than this are one, metres.
const SAME: f64 = 0.35;
/// A corner that is so much nearer to its walls, metres, is as likely as one of twice the probability.
const NEARER: f64 = 2.0;

/// A corner that a point answers from may lie so far from what is known of its walls, metres.
const REACH: f64 = 4.5;

/// Walls that were seen so often and end no farther from where they meet do meet, metres.
const REACHED: f64 = 0.3;
const SEEN: usize = 3;

/// 1 up to a distance, then a bell's side.
fn near(d: f64, full: f64, s: f64) -> f64 {
    if d <= full { 1.0 } else { (-(d - full) * (d - full) / (2.0 * s * s)).exp() }
}

/// The likely corners of the walls, with their legs; `rcds`: the points are among them.
pub fn corners(features: &Features, rcds: &[Rcd], path: &[[Point; 2]], rules: &Rules) -> Vec<Corner> {
    let walls = &features.walls;
    let mut found: Vec<Corner> = Vec::new();
    for (i, a) in walls.iter().enumerate() {
        for (k, b) in walls.iter().enumerate().skip(i + 1) {
            if let Some(at) = concave(a, b) {
                let (probability, answers) = probability(at, [a, b], rcds, rules);
                let legs = [a, b].map(|w| leg(at, w));
                let corner = Corner { at, walls: [i, k], probability, legs };
                if probability >= 0.5 && open(&corner, answers, features, rcds, path) {
                    found.push(corner);
                }
            }
        }
    }
    // A point answers for all corners about it: that with the shorter legs is likelier.
    let likely = |c: &Corner| {
        let legs: f64 = c.legs.iter().flatten().map(|[a, b]| distance(*a, *b)).sum();
        // A wall of one region may be none.
        let sure = |k: &usize| 1.0 - 0.5f64.powi(walls[*k].rcds.len().min(30) as i32);
        c.probability * (-legs / NEARER).exp2() * c.walls.iter().map(sure).product::<f64>()
    };
    found.sort_by(|a, b| likely(b).total_cmp(&likely(a)));
    let mut kept: Vec<Corner> = Vec::new();
    for corner in found {
        if kept.iter().all(|k| distance(k.at, corner.at) > SAME) {
            kept.push(corner);
        }
    }
    kept
}

fn probability(at: Point, walls: [&Wall; 2], rcds: &[Rcd], rules: &Rules) -> (f64, usize) {
    let beyond = walls.map(|w| w.beyond(w.place(at)));
    if beyond.iter().any(|b| *b < -INSIDE) {
        return (0.0, 0);
    }
    // Where no region is known for a point, any but the walls' own may be one.
    let told = rules.points && !rules.paper;
    let own = |k: &usize| walls.iter().any(|w| w.rcds.contains(k));
    let point = |(k, r): &(usize, &Rcd)| if told { r.source == Source::Point } else { !own(k) };
    let points: Vec<f64> = rcds.iter().enumerate().filter(point).map(|(_, r)| r).map(|r| answers(r, at)).collect();
    let point = points.iter().copied().fold(0.0, f64::max);
    let reached = beyond.iter().all(|b| *b <= REACHED) && walls.iter().all(|w| w.rcds.len() >= SEEN);
    if reached {
        return (1.0, usize::MAX);
    }
    let walls = near(beyond[0].max(0.0), REACH, 0.6) * near(beyond[1].max(0.0), REACH, 0.6);
    (walls * point, points.iter().filter(|p| **p >= 0.5).count())
}

/// How well a point answers from a place: a range is known to centimetres, a bearing to degrees.
fn answers(rcd: &Rcd, at: Point) -> f64 {
    let v = sub(at, rcd.centre);
    let off = cross(rcd.normal, v).atan2(dot(rcd.normal, v)).abs();
    near((length(v) - rcd.range).abs(), tolerance(rcd.range), 0.03) * near(off, 0.04, 0.02)
}

/// From a corner to the end of a wall that doesn't reach it.
fn leg(at: Point, wall: &Wall) -> Option<[Point; 2]> {
    let s = wall.place(at);
    (wall.beyond(s) > 0.0).then(|| [at, wall.at(s.clamp(wall.extent[0], wall.extent[1]))])
}

/// Whether nothing crosses its legs: no other wall, no sighting of a feature, and not the robot.
fn open(corner: &Corner, answers: usize, features: &Features, rcds: &[Rcd], path: &[[Point; 2]]) -> bool {
    let walls = &features.walls;
    let others = || walls.iter().enumerate().filter(|(k, _)| !corner.walls.contains(k));
    let seen = || features.members().map(|k| &rcds[k]);
    let legs = || corner.legs.iter().flatten();
    let crossed = |from: Point, to: Point, before: f64| {
        let v = sub(to, from);
        let far = length(v);
        let ray = times(v, 1.0 / far.max(1e-9));
        legs().any(|leg| hit(from, ray, *leg).is_some_and(|d| d < far - before))
    };
    others().all(|(_, w)| !crossed(w.ends()[0], w.ends()[1], 0.0))
        && path.iter().all(|step| !crossed(step[0], step[1], 0.0))
        && seen().filter(|r| crossed(r.centre, r.foot, 0.15)).count() <= answers
}

/// Cuts each wall that overshoots a corner there; a point at a corner is the corner.
pub fn cut(features: &mut Features) {
    let Features { walls, corners, spots, .. } = features;
    spots.retain(|s| corners.iter().all(|c| distance(c.at, s.at) > SAME));
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
