//! Features: walls with faces and extents, corners where two walls meet, and points.

use super::rcd::Rcd;
use crate::geometry::plane::{Point, Vector, left_normal};

/// One face of a wall: a segment seen from one side. World frame, metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Unit normal, away from the robot.
    pub normal: Vector,
    /// normal · x for the points x of its line, metres.
    pub offset: f64,
    /// The positions of its known ends along [`Wall::along`], metres.
    pub extent: [f64; 2],
    /// The indices of the regions of constant depth that it was fitted to.
    pub rcds: Vec<usize>,
}

impl Wall {
    /// Unit vector along it: the normal turned left.
    pub fn along(&self) -> Vector {
        left_normal(self.normal)
    }

    /// The point at a position along it.
    pub fn at(&self, s: f64) -> Point {
        Point::from(self.normal * self.offset + self.along() * s)
    }

    /// Its ends.
    pub fn ends(&self) -> [Point; 2] {
        self.extent.map(|s| self.at(s))
    }

    /// Its middle.
    pub fn middle(&self) -> Point {
        self.at((self.extent[0] + self.extent[1]) / 2.0)
    }

    /// The distance of a point in front of its line, metres; negative behind it.
    pub fn front(&self, p: Point) -> f64 {
        self.offset - self.normal.dot(&p.coords)
    }

    /// The position of a point along it, metres.
    pub fn place(&self, p: Point) -> f64 {
        self.along().dot(&p.coords)
    }

    /// The distance of a position along it beyond the nearer end, metres; negative inside.
    pub fn beyond(&self, s: f64) -> f64 {
        (self.extent[0] - s).max(s - self.extent[1])
    }
}

/// A point reflector: a corner or an edge that returns echoes to wherever they come from.
#[derive(Debug, Clone, PartialEq)]
pub struct PointFeature {
    /// Its position, metres.
    pub at: Point,
    /// The indices of the regions of constant depth that it was fitted to.
    pub rcds: Vec<usize>,
}

/// A concave corner of two walls.
#[derive(Debug, Clone, PartialEq)]
pub struct Corner {
    /// The intersection of their lines, metres.
    pub at: Point,
    /// The indices of the walls.
    pub walls: [usize; 2],
    /// P(c_e): the probability that the corner exists.
    pub probability: f64,
    /// For each wall that doesn't reach it, the segment from it to the end of the wall.
    pub extrapolated_walls: [Option<[Point; 2]>; 2],
}

/// The features of an area.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Features {
    /// Walls.
    pub walls: Vec<Wall>,
    /// Points.
    pub points: Vec<PointFeature>,
    /// Corners.
    pub corners: Vec<Corner>,
    /// Short safe lines between endpoints, which nothing has crossed.
    pub lines: Vec<[Point; 2]>,
}

impl Features {
    /// Everything that blocks sight: walls, then extrapolated walls.
    pub fn blockers(&self) -> impl Iterator<Item = [Point; 2]> + '_ {
        self.walls.iter().map(Wall::ends).chain(self.corners.iter().flat_map(|c| c.extrapolated_walls).flatten())
    }

    /// The indices of the regions that its walls and points were fitted to.
    pub fn members(&self) -> impl Iterator<Item = usize> + '_ {
        self.walls.iter().flat_map(|w| &w.rcds).chain(self.points.iter().flat_map(|s| &s.rcds)).copied()
    }
}

/// Features and the regions of constant depth that they were fitted to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FeatureMap {
    /// The features; their `rcds` are indices into `regions`.
    pub features: Features,
    /// The regions.
    pub regions: Vec<Rcd>,
}
