//! What a reading does to the map, as the stage hands it to the kernels: free regions, occupied lines, and their weights.

use super::decide::Case;
use crate::geometry::plane::Point;
use crate::log::reading::Reading;

/// A star-shaped region around the sensor: the triangles between it and each two successive vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Fan {
    /// At least two, in order of bearing counter-clockwise, spanning less than 180° from the sensor; world frame, metres.
    pub vertices: Vec<Point>,
}

/// What kind of feature a part is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// A wall.
    Wall,
    /// A concave corner.
    Corner,
    /// A point.
    Point,
}

/// What a feature says, if the reading came from it: 0.8 occupied on its lines, 0.2 in its free region, else nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Which kind of feature.
    pub origin: Origin,
    /// The probability that the reading came from it; an update's weights sum to 1.
    pub weight: f64,
    /// What is free then.
    pub free: Option<Fan>,
    /// Lines on which the cells are occupied, each from one end to the other; a point, whose ends are the same, occupies what lies
    /// within ¾ cell. World frame, metres.
    pub occupied: Vec<[Point; 2]>,
}

/// What the reading says if it came from no feature: the routine update of the Bayesian grid, cut off at the free limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Routine {
    /// The probability of that.
    pub weight: f64,
    /// Cells of the interior outside of it aren't freed; `None`: there is no limit.
    pub free: Option<Fan>,
    /// Cells of the arc outside of it aren't occupied; `None`: there is no limit.
    pub arc: Option<Fan>,
    /// Whether the arc is occupied; `false`: the reading only frees.
    pub occupies: bool,
}

/// A reading's update: P(occupied) of a cell is the mean of what its parts say, by their weights; where a part says nothing
/// of the cell it says ½, and a cell of which none says anything is left as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Update {
    /// The reading; its `range` is the z that the routine part uses.
    pub reading: Reading,
    /// Its number among the log's used readings, from 0.
    pub number: u64,
    /// Which case the reading is.
    pub case: Case,
    /// At most two features.
    pub parts: Vec<Part>,
    /// What remains.
    pub routine: Option<Routine>,
}
