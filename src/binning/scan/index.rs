//! A spatial index of poses, which finds those that may be among the nearest of a tile's cells.

use rstar::RTree;
use rstar::primitives::GeomWithData;

/// An R-tree of a log's poses, each with its index in log order.
pub struct Index {
    tree: RTree<GeomWithData<[f64; 2], u32>>,
    neighbours: usize,
}

/// A margin larger than all f64 rounding errors together, metres.
const MARGIN: f64 = 1e-5;

impl Index {
    /// Indexes poses, µm, for searches of the `neighbours` nearest. Of several poses at one position only the first `neighbours` are
    /// kept, because the others can't be among the nearest.
    pub fn new(poses: &[[i64; 2]], neighbours: usize) -> Index {
        let mut order: Vec<u32> = (0..poses.len() as u32).collect();
        order.sort_by_key(|k| (poses[*k as usize], *k));
        let mut points = Vec::with_capacity(order.len());
        for group in order.chunk_by(|a, b| poses[*a as usize] == poses[*b as usize]) {
            let at = poses[group[0] as usize].map(|v| v as f64 * 1e-6);
            points.extend(group.iter().take(neighbours).map(|k| GeomWithData::new(at, *k)));
        }
        Index { tree: RTree::bulk_load(points), neighbours }
    }

    /// The poses, in log order, that may be among the nearest of a cell within `half` of a point and nearer to the cell than
    /// `farthest`; all in metres. They lie within the point's own n-th distance plus twice `half`.
    pub fn candidates(&self, point: [f64; 2], half: f64, farthest: f64) -> Vec<u32> {
        let mut radius = farthest + half;
        if let Some(nth) = self.tree.nearest_neighbor_iter(point).nth(self.neighbours - 1) {
            let [x, y] = nth.geom();
            radius = radius.min((x - point[0]).hypot(y - point[1]) + 2.0 * half);
        }
        radius += MARGIN;
        let mut found: Vec<u32> = self.tree.locate_within_distance(point, radius * radius).map(|p| p.data).collect();
        found.sort_unstable();
        found
    }
}
