//! Wall or point: a plane shows another foot from elsewhere, on one line; a corner or an edge shows the same place.

use super::rcd::{Rcd, Source};
use crate::world::plane::{Point, cross, distance, dot, sub};

/// Scans nearer than this tell nothing of each other, metres.
const APART: f64 = 0.15;
/// Feet farther apart than this are of other things, metres.
const NEAR: f64 = 1.2;
/// Normals of one plane differ by less, radians.
const PARALLEL: f64 = 0.104_719_755;
/// Bearings of one point from two places differ by more, radians.
const TURNED: f64 = 0.052_359_878;
/// A foot of one plane lies no farther from the other's, metres.
const BESIDE: f64 = 0.08;

/// How near two feet are the same place, at a range, metres.
pub fn same_place(range: f64) -> f64 {
    0.05 + 0.03 * range
}

/// The angle between two unit vectors, radians.
pub fn angle(a: Point, b: Point) -> f64 {
    cross(a, b).atan2(dot(a, b)).abs()
}

/// Says of each region whether it is a wall or a point.
pub fn vote(rcds: &mut [Rcd]) {
    let verdicts: Vec<Source> = (0..rcds.len()).map(|k| verdict(&rcds[k], rcds)).collect();
    rcds.iter_mut().zip(verdicts).for_each(|(rcd, verdict)| rcd.source = verdict);
}

fn verdict(rcd: &Rcd, others: &[Rcd]) -> Source {
    let (mut walls, mut points) = (0, 0);
    for other in others {
        let apart = distance(rcd.foot, other.foot);
        if apart >= NEAR || distance(rcd.centre, other.centre) < APART {
            continue;
        }
        let turn = angle(rcd.normal, other.normal);
        let offset = dot(rcd.normal, sub(other.foot, rcd.foot)).abs();
        let tau = same_place(rcd.range.max(other.range));
        let plane = turn <= PARALLEL && offset <= BESIDE;
        if plane && apart > tau {
            walls += 1;
        } else if !plane && apart <= tau && turn >= TURNED {
            points += 1;
        }
    }
    if points > walls { Source::Point } else { Source::Wall }
}
