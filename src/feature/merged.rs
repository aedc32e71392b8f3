//! The features of a large place, from those of its parts.

use super::features::{Corner, Known, Spot, Wall};
use super::rcd::Rcd;
use crate::geometry::plane::Point;
use std::collections::BTreeMap;

/// The features so far.
pub struct Merged {
    /// They themselves, over all regions.
    pub known: Known,
    /// Which wall a region is of.
    of: BTreeMap<usize, usize>,
}

impl Merged {
    /// None yet, of these regions.
    pub fn new(regions: Vec<Rcd>) -> Merged {
        Merged { known: Known { regions, ..Known::default() }, of: BTreeMap::new() }
    }

    /// Adds those of a part that lie `inside` of what is its own, and the walls of its corners; `ids` says which of all regions the
    /// part's are.
    pub fn add(&mut self, part: &Known, ids: &[u32], inside: impl Fn(Point) -> bool) {
        let all = |own: &[usize]| own.iter().map(|k| ids[*k] as usize).collect::<Vec<usize>>();
        for (region, id) in part.regions.iter().zip(ids).filter(|(r, _)| inside(r.foot)) {
            self.known.regions[*id as usize].source = region.source;
        }
        for wall in part.features.walls.iter().filter(|w| inside(w.middle())) {
            self.wall(Wall { rcds: all(&wall.rcds), ..wall.clone() });
        }
        for spot in part.features.spots.iter().filter(|s| inside(s.at)) {
            self.known.features.spots.push(Spot { at: spot.at, rcds: all(&spot.rcds) });
        }
        for corner in part.features.corners.iter().filter(|c| inside(c.at)) {
            let walls = corner.walls.map(|k| {
                let wall = &part.features.walls[k];
                self.wall(Wall { rcds: all(&wall.rcds), ..wall.clone() })
            });
            self.known.features.corners.push(Corner { walls, ..corner.clone() });
        }
    }

    /// The place of a wall; with one that has a region of it it is one.
    fn wall(&mut self, wall: Wall) -> usize {
        let walls = &mut self.known.features.walls;
        let Some(k) = wall.rcds.iter().find_map(|r| self.of.get(r)).copied() else {
            self.of.extend(wall.rcds.iter().map(|r| (*r, walls.len())));
            walls.push(wall);
            return walls.len() - 1;
        };
        let there = &mut walls[k];
        for s in wall.ends().map(|end| there.place(end)) {
            there.extent = [there.extent[0].min(s), there.extent[1].max(s)];
        }
        let fresh = wall.rcds.iter().filter(|r| self.of.insert(**r, k).is_none());
        there.rcds.extend(fresh);
        there.rcds.sort_unstable();
        k
    }
}
