//! A finished map, as every pipeline returns it.

use crate::grid::{Layer, Map};

/// A finished map, with its combined picture and the visits of its cells.
#[derive(Debug, Clone)]
pub struct FinishedMap {
    /// The map.
    pub map: Map,
    /// The combined picture, −1 surely empty to 1 surely occupied.
    pub combined: Layer,
    /// How often each cell was updated.
    pub visits: CellVisits,
}

/// How often each cell was updated, row by row from the lower left.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CellVisits {
    /// Updates from the interior of a cone.
    pub interior: Vec<u32>,
    /// Updates from an arc.
    pub arc: Vec<u32>,
    /// Sums of the marks of the beams or updates that the cell took; empty for a method without marks
    /// ([`Method::marks`](crate::method::Method::marks)).
    pub marks: Vec<u32>,
}
