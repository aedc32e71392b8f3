//! Phantoms: mirror images, seen through a wall. They are the main false long echoes, and no features.

use super::features::{Features, hit};
use super::limit::{By, End, View};
use super::rcd::Rcd;
use crate::geometry::plane::Point;
use std::f64::consts::FRAC_PI_2;

/// A sighting passes through a wall that is nearer by this, metres.
const THROUGH: f64 = 0.15;
/// A sighting passes behind a safe line that is nearer by this, metres.
const BEHIND: f64 = 0.30;
/// Such a safe line is no longer, metres.
const SHORT: f64 = 1.2;
/// Features seen from so many scans are believed whatever lines are before them.
const FEW: usize = 4;

/// Drops the phantoms. Twice over, so that a phantom hides nothing.
pub fn drop_phantoms(features: &mut Features, rcds: &[Rcd], path: &[[Point; 2]]) {
    let all = features.clone();
    let mut kept = [vec![true; all.walls.len()], vec![true; all.spots.len()]];
    for _ in 0..2 {
        kept = survivors(&all, &kept, rcds, path);
    }
    let [walls, spots] = kept;
    let mut keep = walls.iter();
    features.walls.retain(|_| *keep.next().unwrap_or(&true));
    let mut keep = spots.iter();
    features.spots.retain(|_| *keep.next().unwrap_or(&true));
}

/// Which walls and points are real, if only those that `stand` hide anything.
fn survivors(all: &Features, stand: &[Vec<bool>; 2], rcds: &[Rcd], path: &[[Point; 2]]) -> [Vec<bool>; 2] {
    // What doesn't stand is emptied, so that the numbers stay.
    let mut standing = all.clone();
    for (wall, _) in standing.walls.iter_mut().zip(&stand[0]).filter(|(_, s)| !**s) {
        wall.extent = [f64::NAN, f64::NAN];
    }
    for (spot, _) in standing.spots.iter_mut().zip(&stand[1]).filter(|(_, s)| !**s) {
        spot.at = (f64::NAN, f64::NAN);
    }
    let view = View::of(&standing, (0.0, 0.0), f64::INFINITY, 0.0);
    let through = |rcd: &Rcd| view.first(rcd.centre, rcd.normal).is_some_and(|d| d < rcd.range - THROUGH);
    let behind = |rcd: &Rcd, own: (Option<usize>, Option<usize>)| {
        let other = |e: &End| (e.wall.is_none() || e.wall != own.0) && (e.spot.is_none() || e.spot != own.1);
        let limit = view.sector((rcd.centre, rcd.normal), 0.0, FRAC_PI_2, other).limit(rcd.normal, 0.0);
        limit.by == By::Line && limit.length <= SHORT && limit.distance < rcd.range - BEHIND
    };
    let false_echo = |members: &[usize], own: (Option<usize>, Option<usize>)| {
        let of = || members.iter().map(|k| &rcds[*k]);
        let mut scans: Vec<u64> = of().map(|r| r.scan).collect();
        scans.sort_unstable();
        scans.dedup();
        let half = members.len() / 2;
        of().filter(|r| through(r)).count() > half
            || (scans.len() < FEW && of().filter(|r| through(r) || behind(r, own)).count() > half)
    };
    let crossed = |k: usize| {
        let wall = &all.walls[k];
        let crosses = |step: &[Point; 2]| {
            let v = (step[1].0 - step[0].0, step[1].1 - step[0].1);
            hit(step[0], v, wall.ends()).is_some_and(|t| t <= 1.0)
        };
        if path.iter().any(crosses) {
            return true;
        }
        let passing = all
            .walls
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != k && stand[0][*other])
            .flat_map(|(_, w)| &w.rcds);
        let count = passing
            .filter(|m| {
                let rcd = &rcds[**m];
                hit(rcd.centre, rcd.normal, wall.ends()).is_some_and(|d| d < rcd.range - THROUGH)
            })
            .count();
        count > wall.rcds.len()
    };
    let walls = (0..all.walls.len()).map(|k| !crossed(k) && !false_echo(&all.walls[k].rcds, (Some(k), None))).collect();
    let spots = (0..all.spots.len()).map(|k| !false_echo(&all.spots[k].rcds, (None, Some(k)))).collect();
    [walls, spots]
}
