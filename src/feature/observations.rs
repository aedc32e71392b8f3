//! What the log has shown so far: regions of constant depth and the robot's path, and the features that follow from them.

use super::corner::{corners, cut};
use super::features::FeatureMap;
use super::line::lines;
use super::merged::MergedFeatures;
use super::phantom::drop_phantoms;
use super::rcd::Rcd;
use super::rules::Rules;
use super::spatial::SpatialList;
use super::vote::vote;
use super::wall::find_features;
use crate::geometry::plane::Point;
use nalgebra::distance;
use std::collections::{BTreeSet, HashMap, HashSet};

/// With more regions than this the features of the whole log are found block by block.
const LARGE: usize = 2000;
/// Edge of a block, metres.
const BLOCK: f64 = 16.0;
/// What is considered around a block, metres.
const MARGIN: f64 = 6.0;
/// Between scans no farther apart than this the robot is taken to have moved straight, metres.
const LONGEST_STEP: f64 = 2.0;
/// Regions with the centre and the foot in the same squares are duplicates: edge of the centres' squares, metres.
const CENTRE_SQUARE: f64 = 0.3;
/// Edge of the feet's squares, metres.
const FOOT_SQUARE: f64 = 0.1;

/// Most regions of one surface from one side.
const MAX_VIEWS: u8 = 4;
/// Edge of the square that stands for one surface, metres.
const SURFACE_SQUARE: f64 = 0.2;
/// The sector of normals that stands for one side, radians.
const SIDE_SECTOR: f64 = 0.35;
/// Steps of the robot between the same squares are duplicates: edge of the squares, metres.
const STEP_SQUARE: f64 = 0.1;

/// The regions and the steps of the robot, by position.
#[derive(Debug, Clone, Default)]
pub struct Observations {
    regions: SpatialList<Rcd>,
    /// The squares of the regions' centres and feet.
    kept: HashSet<[i64; 4]>,
    /// The number of regions of one surface from one side.
    views: HashMap<[i64; 3], u8>,
    path: SpatialList<[Point; 2]>,
    /// The squares between which a step was kept.
    walked: HashSet<[i64; 4]>,
}

/// The column and the row of the square that holds a point.
fn square_of(at: Point, edge: f64) -> [i64; 2] {
    [at.x, at.y].map(|v| (v / edge).floor() as i64)
}

fn both([a, b]: [i64; 2], [c, d]: [i64; 2]) -> [i64; 4] {
    [a, b, c, d]
}

impl Observations {
    /// Keeps a step of the robot.
    pub fn walk(&mut self, from: Point, to: Point) {
        // How the robot moved between points far apart is not known.
        let near = distance(&from, &to) <= LONGEST_STEP;
        if near && self.walked.insert(both(square_of(from, STEP_SQUARE), square_of(to, STEP_SQUARE))) {
            self.path.push(to, [from, to]);
        }
    }

    /// Keeps a region, unless it repeats others.
    pub fn keep(&mut self, rcd: Rcd) {
        let side = (rcd.normal.y.atan2(rcd.normal.x) / SIDE_SECTOR).floor() as i64;
        let [x, y] = square_of(rcd.foot, SURFACE_SQUARE);
        let views = self.views.entry([x, y, side]).or_default();
        if *views < MAX_VIEWS
            && self.kept.insert(both(square_of(rcd.centre, CENTRE_SQUARE), square_of(rcd.foot, FOOT_SQUARE)))
        {
            *views += 1;
            self.regions.push(rcd.foot, rcd);
        }
    }

    /// All features so far, with their regions. In a large log they are found block by block.
    pub fn feature_map(&self, rules: &Rules) -> FeatureMap {
        const ALL: [f64; 4] = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
        if self.regions.len() <= LARGE {
            return self.around(ALL, rules).0;
        }
        let mut all = MergedFeatures::new(self.regions.all().to_vec());
        // One block at a time, and not one region: regions beside each other share most of their surroundings.
        let blocks: BTreeSet<[i64; 2]> = self.regions.all().iter().map(|r| square_of(r.foot, BLOCK)).collect();
        for [i, j] in blocks {
            let [x, y] = [i, j].map(|v| v as f64 * BLOCK);
            let place = [x - MARGIN, y - MARGIN, x + BLOCK + MARGIN, y + BLOCK + MARGIN];
            let (part, ids) = self.around(place, rules);
            all.add(&part, &ids, |at| square_of(at, BLOCK) == [i, j]);
        }
        all.feature_map
    }

    /// The features in a box x0, y0, x1, y1, metres, and the indices of their regions among all.
    pub fn around(&self, place: [f64; 4], rules: &Rules) -> (FeatureMap, Vec<u32>) {
        let ids = self.regions.within(place);
        let mut rcds: Vec<Rcd> = ids.iter().map(|k| self.regions.all()[*k as usize].clone()).collect();
        let path: Vec<[Point; 2]> = self.path.within(place).iter().map(|k| self.path.all()[*k as usize]).collect();
        if rules.points && !rules.paper {
            vote(&mut rcds);
        }
        let mut features = find_features(&mut rcds, rules);
        if rules.phantoms && !rules.paper {
            drop_phantoms(&mut features, &rcds, &path);
        }
        if rules.corners {
            features.corners = corners(&features, &rcds, &path, rules);
            if rules.phantoms && !rules.paper {
                // Extrapolated walls hide phantoms as well, and these may have hidden corners.
                drop_phantoms(&mut features, &rcds, &path);
                features.corners = corners(&features, &rcds, &path, rules);
            }
            cut(&mut features);
        }
        if rules.lines && !rules.paper {
            features.lines = lines(&features, &rcds, &path);
        }
        (FeatureMap { features, regions: rcds }, ids)
    }
}
