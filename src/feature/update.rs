//! The update of a reading, as the stage hands it to the kernels: free regions, occupied segments, and weights.

use super::decide::Case;
use crate::geometry::plane::Point;
use crate::log::reading::Reading;

/// A star-shaped region around the sensor: the triangles of the sensor and each two successive vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Fan {
    /// At least two, in order of bearing counter-clockwise, spanning less than 180° from the sensor; world frame, metres.
    pub vertices: Vec<Point>,
}

/// The kind of a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// A wall.
    Wall,
    /// A concave corner.
    Corner,
    /// A point.
    Point,
}

/// The update by one feature, if the reading came from it: P(occupied) is 0.8 on its segments and 0.2 in its free region.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// The kind of the feature.
    pub origin: Origin,
    /// The probability that the reading came from it; an update's weights sum to 1.
    pub weight: f64,
    /// The free region.
    pub free: Option<Fan>,
    /// The occupied segments. A point is one with equal ends, and occupies the cells within ¾ cell. World frame, metres.
    pub occupied: Vec<[Point; 2]>,
}

/// The update if the reading came from no feature: that of the Bayesian grid, cut off at the free limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Routine {
    /// The probability that it came from no feature.
    pub weight: f64,
    /// Cells of the interior are freed inside it only; `None`: there is no limit.
    pub free: Option<Fan>,
    /// Cells of the arc are occupied inside it only; `None`: there is no limit.
    pub arc: Option<Fan>,
    /// Whether the arc is occupied; if not, the reading only frees.
    pub occupies: bool,
}

/// The update of a reading: P(occupied) of a cell is the weighted mean over its parts, with ½ for a part that doesn't reach the cell.
/// Cells that no part reaches are left unchanged.
#[derive(Debug, Clone, PartialEq)]
pub struct Update {
    /// The reading; its `range` is the z that the routine part uses.
    pub reading: Reading,
    /// Its number among the log's used readings, from 0.
    pub number: u64,
    /// The case of the reading.
    pub case: Case,
    /// The parts by features, at most two.
    pub parts: Vec<Part>,
    /// The part by no feature.
    pub routine: Option<Routine>,
}
