//! Wall or point: a plane shows another foot from elsewhere, on one line; a corner or an edge shows the same place.

use super::rcd::{Rcd, Source};
use crate::geometry::plane::{distance, dot, sub};

/// Scans nearer than this tell nothing of each other, metres.
const APART: f64 = 0.15;
/// Feet farther apart than this are of other things, metres.
const NEAR: f64 = 1.2;
/// Normals of one plane differ by less: cosine.
const PARALLEL: f64 = 0.994_521_895; // cos 6°
/// Bearings of one point from two places differ by more: cosine.
const TURNED: f64 = 0.998_629_535; // cos 3°
/// A foot of one plane lies no farther from the other's, metres.
const BESIDE: f64 = 0.08;

/// How near two feet are the same place, at a range, metres.
pub fn same_place(range: f64) -> f64 {
    0.05 + 0.03 * range
}

/// Says of each region whether it is a wall or a point, but for those that know it themselves.
pub fn vote(rcds: &mut [Rcd]) {
    // By place, so that each meets the near ones alone.
    let mut order: Vec<usize> = (0..rcds.len()).collect();
    order.sort_by(|a, b| rcds[*a].foot.0.total_cmp(&rcds[*b].foot.0).then(a.cmp(b)));
    let mut votes = vec![[0u32; 2]; rcds.len()];
    for (place, k) in order.iter().enumerate() {
        let rcd = &rcds[*k];
        for other in order[place + 1..].iter().take_while(|j| rcds[**j].foot.0 - rcd.foot.0 < NEAR) {
            if let Some(source) = verdict(rcd, &rcds[*other]) {
                votes[*k][source as usize] += 1;
                votes[*other][source as usize] += 1;
            }
        }
    }
    for (rcd, [walls, points]) in rcds.iter_mut().zip(votes).filter(|(r, _)| !r.fitted) {
        rcd.source = if points > walls { Source::Point } else { Source::Wall };
    }
}

/// What two regions say of each other.
fn verdict(a: &Rcd, b: &Rcd) -> Option<Source> {
    let apart = distance(a.foot, b.foot);
    if apart >= NEAR || distance(a.centre, b.centre) < APART {
        return None;
    }
    let turn = dot(a.normal, b.normal);
    let offset = |from: &Rcd, to: &Rcd| dot(from.normal, sub(to.foot, from.foot)).abs();
    let tau = same_place(a.range.max(b.range));
    let plane = turn >= PARALLEL && offset(a, b).min(offset(b, a)) <= BESIDE;
    if plane {
        (apart > tau).then_some(Source::Wall)
    } else {
        (apart <= tau && turn <= TURNED).then_some(Source::Point)
    }
}
