//! Distinguishes walls from points: seen from elsewhere, the foot of a plane moves along a line, and that of a corner or an edge
//! stays.

use super::rcd::{Rcd, Source};
use nalgebra::distance;

/// The least distance between two scans that are compared, metres.
const MIN_BASELINE: f64 = 0.15;
/// The largest distance between two feet that are compared, metres.
const MAX_DISTANCE: f64 = 1.2;
/// The cosine of the largest angle between normals of one plane.
const PARALLEL: f64 = 0.994_521_895; // cos 6°
/// The cosine of the least angle between bearings to one point from two positions.
const TURNED: f64 = 0.998_629_535; // cos 3°
/// The largest distance of a foot from the other region's plane, metres.
const MAX_OFFSET: f64 = 0.08;

/// The largest distance between two feet of one point, at a range, metres.
pub fn same_place(range: f64) -> f64 {
    0.05 + 0.03 * range
}

/// Sets the source of each region by majority vote, except of those fitted by their own readings.
pub fn vote(rcds: &mut [Rcd]) {
    // In the order of x, so that only near ones are compared.
    let mut order: Vec<usize> = (0..rcds.len()).collect();
    order.sort_by(|a, b| rcds[*a].foot.x.total_cmp(&rcds[*b].foot.x).then(a.cmp(b)));
    let mut votes = vec![[0u32; 2]; rcds.len()];
    for (place, k) in order.iter().enumerate() {
        let rcd = &rcds[*k];
        for other in order[place + 1..].iter().take_while(|j| rcds[**j].foot.x - rcd.foot.x < MAX_DISTANCE) {
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

/// The vote of two regions for each other.
fn verdict(a: &Rcd, b: &Rcd) -> Option<Source> {
    let apart = distance(&a.foot, &b.foot);
    if apart >= MAX_DISTANCE || distance(&a.centre, &b.centre) < MIN_BASELINE {
        return None;
    }
    let turn = a.normal.dot(&b.normal);
    let offset = |from: &Rcd, to: &Rcd| from.normal.dot(&(to.foot - from.foot)).abs();
    let tau = same_place(a.range.max(b.range));
    let plane = turn >= PARALLEL && offset(a, b).min(offset(b, a)) <= MAX_OFFSET;
    if plane {
        (apart > tau).then_some(Source::Wall)
    } else {
        (apart <= tau && turn <= TURNED).then_some(Source::Point)
    }
}
