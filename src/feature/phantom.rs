//! Phantoms: mirror images of features, seen through a wall. They cause most false long echoes and are removed.

use super::features::Features;
use super::limit::{Endpoint, LimitKind, Obstacles};
use super::rcd::Rcd;
use crate::geometry::plane::{Point, intersect_ray};
use std::f64::consts::FRAC_PI_2;

/// A line of sight passes through a wall that is nearer by this, metres.
const THROUGH: f64 = 0.15;
/// A line of sight passes behind a safe line that is nearer by this, metres.
const BEHIND: f64 = 0.30;
/// The longest such safe line, metres.
const MAX_LENGTH: f64 = 1.2;
/// Features seen from this many scans are kept whatever safe lines are in front of them.
const ENOUGH_SCANS: usize = 4;

/// Removes the phantoms, in two rounds, so that a phantom hides nothing.
pub fn drop_phantoms(features: &mut Features, rcds: &[Rcd], path: &[[Point; 2]]) {
    let all = features.clone();
    let mut kept = [vec![true; all.walls.len()], vec![true; all.points.len()]];
    for _ in 0..2 {
        kept = survivors(&all, &kept, rcds, path);
    }
    let [walls, points] = kept;
    let mut keep = walls.iter();
    features.walls.retain(|_| *keep.next().unwrap_or(&true));
    let mut keep = points.iter();
    features.points.retain(|_| *keep.next().unwrap_or(&true));
}

/// Which walls and points are real, if only those that `stand` hide others.
fn survivors(all: &Features, stand: &[Vec<bool>; 2], rcds: &[Rcd], path: &[[Point; 2]]) -> [Vec<bool>; 2] {
    // What doesn't stand is emptied instead of removed, so that indices stay valid.
    let mut standing = all.clone();
    for (wall, _) in standing.walls.iter_mut().zip(&stand[0]).filter(|(_, s)| !**s) {
        wall.extent = [f64::NAN, f64::NAN];
    }
    for (point, _) in standing.points.iter_mut().zip(&stand[1]).filter(|(_, s)| !**s) {
        point.at = Point::new(f64::NAN, f64::NAN);
    }
    let obstacles = Obstacles::near(&standing, Point::origin(), f64::INFINITY, 0.0);
    let through = |rcd: &Rcd| obstacles.first_wall(rcd.centre, rcd.normal).is_some_and(|d| d < rcd.range - THROUGH);
    let behind = |rcd: &Rcd, own: (Option<usize>, Option<usize>)| {
        let other = |e: &Endpoint| (e.wall.is_none() || e.wall != own.0) && (e.point.is_none() || e.point != own.1);
        let limit = obstacles.sector((rcd.centre, rcd.normal), 0.0, FRAC_PI_2, other).limit(rcd.normal, 0.0);
        limit.kind == LimitKind::SafeLine && limit.length <= MAX_LENGTH && limit.distance < rcd.range - BEHIND
    };
    let false_echo = |members: &[usize], own: (Option<usize>, Option<usize>)| {
        let of = || members.iter().map(|k| &rcds[*k]);
        let mut scans: Vec<u64> = of().map(|r| r.scan).collect();
        scans.sort_unstable();
        scans.dedup();
        let half = members.len() / 2;
        of().filter(|r| through(r)).count() > half
            || (scans.len() < ENOUGH_SCANS && of().filter(|r| through(r) || behind(r, own)).count() > half)
    };
    let crossed = |k: usize| {
        let wall = &all.walls[k];
        let crosses = |step: &[Point; 2]| {
            // in lengths of the step
            intersect_ray(step[0], step[1] - step[0], wall.ends()).is_some_and(|t| t <= 1.0)
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
                intersect_ray(rcd.centre, rcd.normal, wall.ends()).is_some_and(|d| d < rcd.range - THROUGH)
            })
            .count();
        count > wall.rcds.len()
    };
    let walls = (0..all.walls.len()).map(|k| !crossed(k) && !false_echo(&all.walls[k].rcds, (Some(k), None))).collect();
    let points = (0..all.points.len()).map(|k| !false_echo(&all.points[k].rcds, (None, Some(k)))).collect();
    [walls, points]
}
