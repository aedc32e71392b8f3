//! The features of a large place, from those of its parts.

use super::features::{Corner, Known, Spot, Wall};
use super::rcd::Rcd;
use crate::world::plane::Point;
use std::collections::BTreeMap;

/// Features whose ends agree to this are one, metres.
const SAME: f64 = 0.01;

/// The features so far.
pub struct Merged {
    /// They themselves, over all regions.
    pub known: Known,
    walls: BTreeMap<[i64; 4], usize>,
}

impl Merged {
    /// None yet, of these regions.
    pub fn new(regions: Vec<Rcd>) -> Merged {
        Merged { known: Known { regions, ..Known::default() }, walls: BTreeMap::new() }
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

    /// The place of a wall, which may be there already.
    fn wall(&mut self, wall: Wall) -> usize {
        let [a, b] = wall.ends();
        let walls = &mut self.known.features.walls;
        *self.walls.entry([a.0, a.1, b.0, b.1].map(|v| (v / SAME).round() as i64)).or_insert_with(|| {
            walls.push(wall);
            walls.len() - 1
        })
    }
}
