//! A list of items with positions in the plane, in an R-tree, so that a query of a box visits what is near the box only.

use crate::geometry::plane::Point;
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

/// Queries are widened to squares of this edge, metres. Features near the rim of a box are made of regions beyond it, so the edge
/// is a part of the result: another one finds other features there.
const SQUARE: f64 = 2.0;

/// Items in the order of insertion, found by their positions. World frame, metres.
#[derive(Debug, Clone)]
pub struct SpatialList<T> {
    items: Vec<T>,
    tree: RTree<GeomWithData<[f64; 2], u32>>,
}

impl<T> Default for SpatialList<T> {
    fn default() -> Self {
        SpatialList { items: Vec::new(), tree: RTree::new() }
    }
}

impl<T> SpatialList<T> {
    /// Appends an item.
    pub fn push(&mut self, at: Point, item: T) {
        self.tree.insert(GeomWithData::new([at.x, at.y], self.items.len() as u32));
        self.items.push(item);
    }

    /// The number of items.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// All items, in the order of insertion.
    pub fn all(&self) -> &[T] {
        &self.items
    }

    /// The indices of the items in the squares that the box x0, y0, x1, y1 meets, ascending.
    pub fn within(&self, [x0, y0, x1, y1]: [f64; 4]) -> Vec<u32> {
        let low = [x0, y0].map(|v| (v / SQUARE).floor() * SQUARE);
        let high = [x1, y1].map(|v| ((v / SQUARE).floor() + 1.0) * SQUARE);
        // the upper sides belong to the next squares
        let inside = |at: &[f64; 2]| at[0] < high[0] && at[1] < high[1];
        let found = self.tree.locate_in_envelope(AABB::from_corners(low, high)).filter(|item| inside(item.geom()));
        let mut indices: Vec<u32> = found.map(|item| item.data).collect();
        indices.sort_unstable();
        indices
    }
}
