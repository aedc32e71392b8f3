//! Concave corners: where two walls' lines meet, near the ends of both and near a point that answers from there.

use super::features::{Corner, Features, Wall, hit};
use super::rcd::{Rcd, Source};
use super::wall::concave;
use crate::world::plane::{Point, distance, length, sub, times};

/// A corner lies no farther inside either wall, metres.
const INSIDE: f64 = 0.35;
/// Corners nearer than this are one, metres.
const SAME: f64 = 0.20;

/// 1 up to a distance, then a bell's side.
fn near(d: f64, full: f64, s: f64) -> f64 {
    if d <= full { 1.0 } else { (-(d - full) * (d - full) / (2.0 * s * s)).exp() }
}

/// The likely corners of the walls, with their legs; `rcds`: the points are among them.
pub fn corners(features: &Features, rcds: &[Rcd]) -> Vec<Corner> {
    let walls = &features.walls;
    let mut found: Vec<Corner> = Vec::new();
    for (i, a) in walls.iter().enumerate() {
        for (k, b) in walls.iter().enumerate().skip(i + 1) {
            if let Some(at) = concave(a, b) {
                let probability = probability(at, [a, b], rcds);
                let legs = [a, b].map(|w| leg(at, w));
                let corner = Corner { at, walls: [i, k], probability, legs };
                if probability >= 0.5 && open(&corner, walls) {
                    found.push(corner);
                }
            }
        }
    }
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let mut kept: Vec<Corner> = Vec::new();
    for corner in found {
        if kept.iter().all(|k| distance(k.at, corner.at) > SAME) {
            kept.push(corner);
        }
    }
    kept
}

fn probability(at: Point, walls: [&Wall; 2], rcds: &[Rcd]) -> f64 {
    let beyond = walls.map(|w| w.beyond(w.place(at)));
    if beyond.iter().any(|b| *b < -INSIDE) {
        return 0.0;
    }
    let points = rcds.iter().filter(|r| r.source == Source::Point).map(|r| distance(r.foot, at));
    let nearest = points.fold(f64::INFINITY, f64::min);
    near(beyond[0].max(0.0), 1.0, 0.6) * near(beyond[1].max(0.0), 1.0, 0.6) * near(nearest, 0.10, 0.10)
}

/// From a corner to the end of a wall that doesn't reach it.
fn leg(at: Point, wall: &Wall) -> Option<[Point; 2]> {
    let s = wall.place(at);
    (wall.beyond(s) > 0.0).then(|| [at, wall.at(s.clamp(wall.extent[0], wall.extent[1]))])
}

/// Whether no other wall crosses its legs.
fn open(corner: &Corner, walls: &[Wall]) -> bool {
    let others = || walls.iter().enumerate().filter(|(k, _)| !corner.walls.contains(k));
    corner.legs.iter().flatten().all(|[from, to]| {
        let v = sub(*to, *from);
        let far = length(v);
        others().all(|(_, w)| hit(*from, times(v, 1.0 / far.max(1e-9)), w.ends()).is_none_or(|d| d > far))
    })
}

/// Cuts each wall that overshoots a corner there.
pub fn cut(features: &mut Features) {
    let Features { walls, corners, .. } = features;
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
