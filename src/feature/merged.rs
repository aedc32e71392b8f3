//! Merges the features of the blocks of a large area.

use super::features::{Corner, FeatureMap, PointFeature, Wall};
use super::rcd::Rcd;
use crate::geometry::plane::Point;
use std::collections::BTreeMap;

/// The merged features so far.
pub struct MergedFeatures {
    /// The features, with all regions.
    pub feature_map: FeatureMap,
    /// The wall of each region.
    wall_of: BTreeMap<usize, usize>,
}

impl MergedFeatures {
    /// No features yet, and these regions.
    pub fn new(regions: Vec<Rcd>) -> MergedFeatures {
        MergedFeatures { feature_map: FeatureMap { regions, ..FeatureMap::default() }, wall_of: BTreeMap::new() }
    }

    /// Adds the features of a part that lie `inside` its own block, and the walls of its corners; `ids` are the indices of the
    /// part's regions among all.
    pub fn add(&mut self, part: &FeatureMap, ids: &[u32], inside: impl Fn(Point) -> bool) {
        let all = |own: &[usize]| own.iter().map(|k| ids[*k] as usize).collect::<Vec<usize>>();
        for (region, id) in part.regions.iter().zip(ids).filter(|(r, _)| inside(r.foot)) {
            self.feature_map.regions[*id as usize].source = region.source;
        }
        for wall in part.features.walls.iter().filter(|w| inside(w.middle())) {
            self.wall(Wall { rcds: all(&wall.rcds), ..wall.clone() });
        }
        for point in part.features.points.iter().filter(|p| inside(p.at)) {
            self.feature_map.features.points.push(PointFeature { at: point.at, rcds: all(&point.rcds) });
        }
        for corner in part.features.corners.iter().filter(|c| inside(c.at)) {
            let walls = corner.walls.map(|k| {
                let wall = &part.features.walls[k];
                self.wall(Wall { rcds: all(&wall.rcds), ..wall.clone() })
            });
            self.feature_map.features.corners.push(Corner { walls, ..corner.clone() });
        }
    }

    /// Adds a wall, or merges it with one that shares a region; its index.
    fn wall(&mut self, wall: Wall) -> usize {
        let walls = &mut self.feature_map.features.walls;
        let Some(k) = wall.rcds.iter().find_map(|r| self.wall_of.get(r)).copied() else {
            self.wall_of.extend(wall.rcds.iter().map(|r| (*r, walls.len())));
            walls.push(wall);
            return walls.len() - 1;
        };
        let there = &mut walls[k];
        for s in wall.ends().map(|end| there.place(end)) {
            there.extent = [there.extent[0].min(s), there.extent[1].max(s)];
        }
        let fresh = wall.rcds.iter().filter(|r| self.wall_of.insert(**r, k).is_none());
        there.rcds.extend(fresh);
        there.rcds.sort_unstable();
        k
    }
}
