//! What has been seen where: regions of constant depth and the robot's way, and the features of a place that follow from them.

use super::corner::{corners, cut};
use super::features::Known;
use super::line::lines;
use super::merged::Merged;
use super::near::Near;
use super::phantom::drop_phantoms;
use super::rcd::Rcd;
use super::rules::Rules;
use super::vote::vote;
use super::wall::gather;
use crate::geometry::plane::{Point, distance};
use std::collections::{BTreeSet, HashMap, HashSet};

/// With more regions than this the features of the whole log are found block by block: so many squares a block, and so much
/// around it, metres.
const LARGE: usize = 2000;
const BLOCK: f64 = 8.0;
const MARGIN: f64 = 6.0;
/// Between scans no farther apart the robot went straight, metres.
const LONGEST_STEP: f64 = 2.0;
/// Regions from one place of one thing tell no more than the first: edges of these places, metres.
const SAME_CENTRE: f64 = 0.3;
const SAME_FOOT: f64 = 0.1;

/// Nor do more than so many of one thing from one side: edge of such a place, metres, and angle, radians.
const ENOUGH: u8 = 4;
const SAME_THING: f64 = 0.2;
const SIDE: f64 = 0.35;
/// Edge of the places between which a step counts once, metres.
const SAME_STEP: f64 = 0.1;

/// All of it, by place.
#[derive(Debug, Clone, Default)]
pub struct Atlas {
    regions: Near<Rcd>,
    known: HashSet<[i64; 4]>,
    /// How many regions there are of one thing, seen from one side.
    told: HashMap<[i64; 3], u8>,
    path: Near<[Point; 2]>,
    walked: HashSet<[i64; 4]>,
}

/// Whole numbers of squares.
fn squares(at: Point, edge: f64) -> [i64; 2] {
    [at.0, at.1].map(|v| (v / edge).floor() as i64)
}

fn both([a, b]: [i64; 2], [c, d]: [i64; 2]) -> [i64; 4] {
    [a, b, c, d]
}

impl Atlas {
    /// The robot went from one place to another.
    pub fn walk(&mut self, from: Point, to: Point) {
        // Of the way between places far apart nothing is known.
        let near = distance(from, to) <= LONGEST_STEP;
        if near && self.walked.insert(both(squares(from, SAME_STEP), squares(to, SAME_STEP))) {
            self.path.push(to, [from, to]);
        }
    }

    /// Keeps a region that tells something new.
    pub fn keep(&mut self, rcd: Rcd) {
        let side = (rcd.normal.1.atan2(rcd.normal.0) / SIDE).floor() as i64;
        let [x, y] = squares(rcd.foot, SAME_THING);
        let told = self.told.entry([x, y, side]).or_default();
        if *told < ENOUGH && self.known.insert(both(squares(rcd.centre, SAME_CENTRE), squares(rcd.foot, SAME_FOOT))) {
            *told += 1;
            self.regions.push(rcd.foot, rcd);
        }
    }

    /// Every feature so far: of a large place those found block by block.
    pub fn known(&self, rules: &Rules) -> Known {
        const ALL: [f64; 4] = [f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY];
        if self.regions.len() <= LARGE {
            return self.around(ALL, rules).0;
        }
        let mut all = Merged::new(self.regions.all().to_vec());
        let (middles, edge) = self.regions.squares();
        // Some squares at a time: most of what is looked at for one is looked at for those beside it, too.
        let block = BLOCK * edge;
        let blocks: BTreeSet<[i64; 2]> = middles.iter().map(|m| squares(*m, block)).collect();
        for [i, j] in blocks {
            let [x, y] = [i, j].map(|v| v as f64 * block);
            let place = [x - MARGIN, y - MARGIN, x + block + MARGIN, y + block + MARGIN];
            let (known, ids) = self.around(place, rules);
            all.add(&known, &ids, |at| squares(at, block) == [i, j]);
        }
        all.known
    }

    /// The features in a box x0, y0, x1, y1, and which regions their own are.
    pub fn around(&self, place: [f64; 4], rules: &Rules) -> (Known, Vec<u32>) {
        let ids = self.regions.within(place);
        let mut rcds: Vec<Rcd> = ids.iter().map(|k| self.regions.all()[*k as usize].clone()).collect();
        let path: Vec<[Point; 2]> = self.path.within(place).iter().map(|k| self.path.all()[*k as usize]).collect();
        if rules.points && !rules.paper {
            vote(&mut rcds);
        }
        let mut features = gather(&mut rcds, rules);
        if rules.phantoms && !rules.paper {
            drop_phantoms(&mut features, &rcds, &path);
        }
        if rules.corners {
            features.corners = corners(&features, &rcds, &path, rules);
            if rules.phantoms && !rules.paper {
                // Legs hide phantoms, too, which may have stood in the way of corners.
                drop_phantoms(&mut features, &rcds, &path);
                features.corners = corners(&features, &rcds, &path, rules);
            }
            cut(&mut features);
        }
        if rules.lines && !rules.paper {
            features.lines = lines(&features, &rcds, &path);
        }
        (Known { features, regions: rcds }, ids)
    }
}
