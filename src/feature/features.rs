//! The features of a place: walls with faces and extents, corners where two meet, points.

use super::rcd::Rcd;
use crate::geometry::plane::{Point, add, dot, times};

/// A wall's face: a segment seen from one side.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Unit normal, away from the robot that saw it.
    pub normal: Point,
    /// normal · x on its line, metres.
    pub offset: f64,
    /// How far it is known, along [`Wall::along`], metres.
    pub extent: [f64; 2],
    /// The regions of constant depth that it is made of, by their places in the list that it was built from.
    pub rcds: Vec<usize>,
}

impl Wall {
    /// Unit vector along it: the normal turned left.
    pub fn along(&self) -> Point {
        (-self.normal.1, self.normal.0)
    }

    /// Its point at a place along it.
    pub fn at(&self, s: f64) -> Point {
        add(times(self.normal, self.offset), times(self.along(), s))
    }

    /// Where it begins and ends.
    pub fn ends(&self) -> [Point; 2] {
        self.extent.map(|s| self.at(s))
    }

    /// Its middle.
    pub fn middle(&self) -> Point {
        self.at((self.extent[0] + self.extent[1]) / 2.0)
    }

    /// How far a point lies in front of its line, metres; negative behind.
    pub fn front(&self, p: Point) -> f64 {
        self.offset - dot(self.normal, p)
    }

    /// A point's place along it.
    pub fn place(&self, p: Point) -> f64 {
        dot(self.along(), p)
    }

    /// How far a place along it lies beyond its nearer end, metres; negative inside.
    pub fn beyond(&self, s: f64) -> f64 {
        (self.extent[0] - s).max(s - self.extent[1])
    }
}

/// A corner or an edge that sends echoes back to wherever they come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    /// Where it is, metres.
    pub at: Point,
    /// The regions that saw it.
    pub rcds: Vec<usize>,
}

/// A concave corner of two walls.
#[derive(Debug, Clone, PartialEq)]
pub struct Corner {
    /// Where their lines meet, metres.
    pub at: Point,
    /// The walls.
    pub walls: [usize; 2],
    /// P(c_e).
    pub probability: f64,
    /// From it to the end of a wall that doesn't reach it, for each wall.
    pub legs: [Option<[Point; 2]>; 2],
}

/// What is known of a place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Features {
    /// Walls.
    pub walls: Vec<Wall>,
    /// Points.
    pub spots: Vec<Spot>,
    /// Corners.
    pub corners: Vec<Corner>,
    /// Short lines between ends, which nothing is known to have crossed.
    pub lines: Vec<[Point; 2]>,
}

impl Features {
    /// Everything that blocks sight: walls, then legs.
    pub fn blockers(&self) -> impl Iterator<Item = [Point; 2]> + '_ {
        self.walls.iter().map(Wall::ends).chain(self.corners.iter().flat_map(|c| c.legs).flatten())
    }

    /// The regions that its walls and points are made of, by their places in the list that it was built from.
    pub fn members(&self) -> impl Iterator<Item = usize> + '_ {
        self.walls.iter().flat_map(|w| &w.rcds).chain(self.spots.iter().flat_map(|s| &s.rcds)).copied()
    }
}

/// Features and the regions of constant depth that they are made of.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Known {
    /// The features; their `rcds` are places in the list of regions.
    pub features: Features,
    /// The regions.
    pub regions: Vec<Rcd>,
}

/// How far along a ray (a unit vector) from a point it meets a segment, metres.
#[inline]
pub fn hit(from: Point, ray: Point, [a, b]: [Point; 2]) -> Option<f64> {
    let (e, w) = ((b.0 - a.0, b.1 - a.1), (a.0 - from.0, a.1 - from.1));
    let den = ray.0 * e.1 - ray.1 * e.0;
    if den == 0.0 {
        return None;
    }
    let (t, u) = ((w.0 * e.1 - w.1 * e.0) / den, (w.0 * ray.1 - w.1 * ray.0) / den);
    (t > 0.0 && (0.0..=1.0).contains(&u)).then_some(t)
}
