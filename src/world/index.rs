//! The walls and arcs by position, in a uniform grid of buckets, so that a ray or a scan in a campus visits its neighbourhood only.

use super::shape::{Arc, Surface, Wall};
use crate::geometry::plane::{Point, Vector, distance_to_segment, intersect_lines, left_normal};

/// Lines of sight are shortened by this at both ends, metres, so that a wall does not hide the points on it.
pub(crate) const TRIM: f64 = 1e-4;
/// Most buckets.
const MAX_BUCKETS: f64 = 4e6;

/// Walls and arcs by position. World frame, metres.
#[derive(Debug, Clone)]
pub struct ShapeIndex {
    pub(crate) walls: Vec<Wall>,
    pub(crate) arcs: Vec<Arc>,
    /// The lower left corner of the grid.
    origin: Point,
    /// Of a bucket.
    edge: f64,
    columns: usize,
    rows: usize,
    /// Where the items of each bucket begin in `items`, row by row.
    start: Vec<u32>,
    items: Vec<u32>,
}

/// The first surface that a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayHit {
    /// The wall, or from `walls.len()` on the arc.
    pub item: u32,
    /// Metres.
    pub distance: f64,
    /// The class of the surface, from 1.
    pub class: Option<u16>,
}

impl ShapeIndex {
    /// Indexes walls and arcs.
    pub fn new(walls: Vec<Wall>, arcs: Vec<Arc>) -> ShapeIndex {
        let [x0, y0, x1, y1] = bounds(&walls, &arcs);
        let edge = ((x1 - x0) * (y1 - y0) / MAX_BUCKETS).sqrt().max((x1 - x0).max(y1 - y0) / 1e6).max(1.0);
        let count = |span: f64| (span / edge).floor() as usize + 1;
        let (columns, rows) = (count(x1 - x0), count(y1 - y0));
        let mut index = ShapeIndex {
            walls,
            arcs,
            origin: Point::new(x0, y0),
            edge,
            columns,
            rows,
            start: vec![0; columns * rows + 1],
            items: Vec::new(),
        };
        let all: Vec<(usize, u32)> = (0..index.walls.len() + index.arcs.len())
            .flat_map(|k| index.buckets_of(k).into_iter().map(move |b| (b, k as u32)))
            .collect();
        for (bucket, _) in &all {
            index.start[bucket + 1] += 1;
        }
        for b in 0..columns * rows {
            index.start[b + 1] += index.start[b];
        }
        let mut next = index.start.clone();
        index.items = vec![0; all.len()];
        for (bucket, item) in all {
            index.items[next[bucket] as usize] = item;
            next[bucket] += 1;
        }
        index
    }

    fn column(&self, x: f64) -> usize {
        (((x - self.origin.x) / self.edge).max(0.0) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.origin.y) / self.edge).max(0.0) as usize).min(self.rows - 1)
    }

    /// The buckets that an item may pass through.
    fn buckets_of(&self, item: usize) -> Vec<usize> {
        let [x0, y0, x1, y1] = match item.checked_sub(self.walls.len()) {
            None => bounds(&self.walls[item..=item], &[]),
            Some(k) => bounds(&[], &self.arcs[k..=k]),
        };
        let mut buckets = Vec::new();
        for row in self.row(y0)..=self.row(y1) {
            for column in self.column(x0)..=self.column(x1) {
                let at = |k: usize, low: f64| low + (k as f64 + 0.5) * self.edge;
                let centre = Point::new(at(column, self.origin.x), at(row, self.origin.y));
                // half a diagonal, rounded up
                let near =
                    self.walls.get(item).is_none_or(|w| distance_to_segment(centre, w.a, w.b) <= 0.7072 * self.edge);
                if near {
                    buckets.push(row * self.columns + column);
                }
            }
        }
        buckets
    }

    /// The walls and arcs within `radius` of a point, in ascending order: walls below `walls.len()`, arcs from there on.
    pub(crate) fn within(&self, p: Point, radius: f64) -> Vec<u32> {
        let mut found = Vec::new();
        for row in self.row(p.y - radius)..=self.row(p.y + radius) {
            for column in self.column(p.x - radius)..=self.column(p.x + radius) {
                found.extend_from_slice(self.bucket(column, row));
            }
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|&k| match self.walls.get(k as usize) {
            Some(w) => distance_to_segment(p, w.a, w.b) <= radius,
            None => self.arcs.get(k as usize - self.walls.len()).is_some_and(|a| a.distance_to(p) <= radius),
        });
        found
    }

    fn bucket(&self, column: usize, row: usize) -> &[u32] {
        let b = row * self.columns + column;
        &self.items[self.start[b] as usize..self.start[b + 1] as usize]
    }

    /// Whether there is a line of sight between two points; both may lie on a surface.
    pub(crate) fn line_of_sight(&self, p: Point, q: Point) -> bool {
        let d = q - p;
        let trim = TRIM / d.norm();
        if trim >= 0.5 {
            return true;
        }
        !self.visit(p, q, &mut |item| self.intersections(item, p, q).iter().any(|t| *t > trim && *t < 1.0 - trim))
    }

    /// Whether no wall or arc meets the segment between two points, its ends included.
    pub(crate) fn unobstructed(&self, p: Point, q: Point) -> bool {
        !self.visit(p, q, &mut |item| self.intersections(item, p, q).iter().any(|t| (0.0..=1.0).contains(t)))
    }

    /// The first surface that a ray of light along the unit vector `direction` meets within `reach` metres. It passes through glass
    /// unless it arrives near the normal.
    pub(crate) fn cast_ray(&self, p: Point, direction: Vector, reach: f64) -> Option<RayHit> {
        let q = p + direction * reach;
        let mut best: Option<RayHit> = None;
        self.visit(p, q, &mut |item| {
            for t in self.intersections(item, p, q) {
                if !(0.0..=1.0).contains(&t) || best.is_some_and(|m| m.distance <= t * reach) {
                    continue;
                }
                let (surface, class, incidence) = match self.walls.get(item as usize) {
                    Some(w) => {
                        let e = w.b - w.a;
                        (w.surface, w.class, e.perp(&direction).abs() / e.norm())
                    }
                    None => {
                        let a = &self.arcs[item as usize - self.walls.len()];
                        let outward = (p + direction * (t * reach) - a.centre) * (1.0 / a.radius);
                        (a.surface, a.class, outward.dot(&direction).abs())
                    }
                };
                if surface != Surface::Glass || incidence >= 0.985 {
                    best = Some(RayHit { item, distance: t * reach, class });
                }
            }
            false
        });
        best
    }

    /// The walls and arcs that may come within `margin` of the segment from `p` to `q`, in ascending order.
    pub(crate) fn near_segment(&self, p: Point, q: Point, margin: f64) -> Vec<u32> {
        let run = (q - p) * (margin / (q - p).norm().max(f64::MIN_POSITIVE));
        let (from, to) = (p - run, q + run);
        let mut found = Vec::new();
        for side in [-1.0, 0.0, 1.0] {
            let off = side * left_normal(run);
            self.visit(from + off, to + off, &mut |item| {
                found.push(item);
                false
            });
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The intersections of an item with the segment from `p` to `q`, as parameters of the segment; NaN where there is none.
    pub(crate) fn intersections(&self, item: u32, p: Point, q: Point) -> [f64; 2] {
        match self.walls.get(item as usize) {
            Some(w) => [crossing(w, p, q), f64::NAN],
            None => self.arcs[item as usize - self.walls.len()].intersections(p, q - p),
        }
    }

    /// Visits the items of the buckets between two points until `stop` returns true; whether it did.
    fn visit(&self, p: Point, q: Point, stop: &mut dyn FnMut(u32) -> bool) -> bool {
        let (r0, r1) = (self.row(p.y.min(q.y)), self.row(p.y.max(q.y)));
        for row in r0..=r1 {
            // the part of the segment in this row of buckets, slightly longer
            let (low, high) = (self.origin.y + row as f64 * self.edge, self.origin.y + (row + 1) as f64 * self.edge);
            let parameter = |y: f64| if q.y == p.y { f64::NAN } else { (y - p.y) / (q.y - p.y) };
            let (a, b) = (parameter(low), parameter(high));
            let (mut t0, mut t1) = if a.is_nan() { (0.0, 1.0) } else { (a.min(b).max(0.0), a.max(b).min(1.0)) };
            if row == r0 || row == r1 {
                // beyond the world's edge rows are clamped
                (t0, t1) =
                    if r0 == r1 { (0.0, 1.0) } else { (t0.min(end(row == r0, p, q)), t1.max(end(row == r0, p, q))) };
            }
            let x = |t: f64| p.x + (q.x - p.x) * t;
            let (x0, x1) = (x(t0).min(x(t1)) - 1e-9, x(t0).max(x(t1)) + 1e-9);
            for column in self.column(x0)..=self.column(x1) {
                if self.bucket(column, row).iter().any(|&item| stop(item)) {
                    return true;
                }
            }
        }
        false
    }
}

/// The parameter of the lower end of a segment (or of the upper).
fn end(lower: bool, p: Point, q: Point) -> f64 {
    if (p.y <= q.y) == lower { 0.0 } else { 1.0 }
}

/// Where a wall crosses the segment from `p` to `q`, as a parameter of the segment; NaN if it doesn't.
pub(crate) fn crossing(w: &Wall, p: Point, q: Point) -> f64 {
    match intersect_lines(p, q, w.a, w.b) {
        Some((t, u)) if (-1e-9..=1.0 + 1e-9).contains(&u) => t,
        _ => f64::NAN,
    }
}

/// The bounding box of walls and of the circles of arcs: left, bottom, right, top, metres; zeros if there is none.
pub(crate) fn bounds(walls: &[Wall], arcs: &[Arc]) -> [f64; 4] {
    let mut b = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    let mut take = |x: f64, y: f64| b = [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)];
    for w in walls {
        take(w.a.x, w.a.y);
        take(w.b.x, w.b.y);
    }
    for a in arcs {
        take(a.centre.x - a.radius, a.centre.y - a.radius);
        take(a.centre.x + a.radius, a.centre.y + a.radius);
    }
    if b[0] <= b[2] { b } else { [0.0; 4] }
}
