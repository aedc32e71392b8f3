//! A finished map, as a run hands it over.

use crate::grid::{Layer, Map};

/// A finished map and what doesn't belong to its files.
#[derive(Debug, Clone)]
pub struct Finished {
    /// The map.
    pub map: Map,
    /// The combined picture, −1 surely empty to 1 surely occupied.
    pub combined: Layer,
    /// How often each cell was updated.
    pub visits: Visits,
}

/// How often each cell was updated, row by row: what membership came to.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Visits {
    /// From the interior of a cone.
    pub interior: Vec<u32>,
    /// On an arc.
    pub arc: Vec<u32>,
    /// Sums of marks of what the cell took ([`Method::marks`]); empty where the method has none.
    pub marks: Vec<u32>,
}
