//! Which walls and arcs lie where: a uniform grid, so that a ray or a scan in a campus looks at its neighbourhood only.

use super::shape::{Arc, Surface, Wall};
use crate::geometry::plane::{Point, add, cross, dot, from_segment, length, meet, sub, times};

/// Legs are shortened by this at both ends, metres, so that the wall on which one ends doesn't hide its own point.
pub(crate) const TRIM: f64 = 1e-4;
/// No more buckets than this.
const BUCKETS: f64 = 4e6;

/// Walls and arcs, findable by place.
#[derive(Debug, Clone)]
pub struct Index {
    pub(crate) walls: Vec<Wall>,
    pub(crate) arcs: Vec<Arc>,
    low: Point,
    edge: f64,
    columns: usize,
    rows: usize,
    start: Vec<u32>,
    items: Vec<u32>,
}

/// What a ray met first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Met {
    /// What: a wall, or an arc above them.
    pub item: u32,
    /// How far, metres.
    pub distance: f64,
    /// The class of what it met.
    pub class: Option<u16>,
}

impl Index {
    /// Indexes walls and arcs.
    pub fn new(walls: Vec<Wall>, arcs: Vec<Arc>) -> Index {
        let [x0, y0, x1, y1] = bounds(&walls, &arcs);
        let edge = ((x1 - x0) * (y1 - y0) / BUCKETS).sqrt().max((x1 - x0).max(y1 - y0) / 1e6).max(1.0);
        let count = |span: f64| (span / edge).floor() as usize + 1;
        let (columns, rows) = (count(x1 - x0), count(y1 - y0));
        let mut index = Index {
            walls,
            arcs,
            low: (x0, y0),
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
        (((x - self.low.0) / self.edge).max(0.0) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.low.1) / self.edge).max(0.0) as usize).min(self.rows - 1)
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
                let centre = (at(column, self.low.0), at(row, self.low.1));
                // half a diagonal, and a hair
                let near = self.walls.get(item).is_none_or(|w| from_segment(centre, w.a, w.b) <= 0.7072 * self.edge);
                if near {
                    buckets.push(row * self.columns + column);
                }
            }
        }
        buckets
    }

    /// The walls and arcs that come within `radius` of a point, in their own order: walls below `walls.len()`, arcs above.
    pub(crate) fn near(&self, p: Point, radius: f64) -> Vec<u32> {
        let mut found = Vec::new();
        for row in self.row(p.1 - radius)..=self.row(p.1 + radius) {
            for column in self.column(p.0 - radius)..=self.column(p.0 + radius) {
                found.extend_from_slice(self.bucket(column, row));
            }
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|&k| match self.walls.get(k as usize) {
            Some(w) => from_segment(p, w.a, w.b) <= radius,
            None => self.arcs.get(k as usize - self.walls.len()).is_some_and(|a| a.off(p) <= radius),
        });
        found
    }

    fn bucket(&self, column: usize, row: usize) -> &[u32] {
        let b = row * self.columns + column;
        &self.items[self.start[b] as usize..self.start[b + 1] as usize]
    }

    /// Whether nothing lies between two points.
    pub(crate) fn clear(&self, p: Point, q: Point) -> bool {
        let d = sub(q, p);
        let trim = TRIM / length(d);
        if trim >= 0.5 {
            return true;
        }
        !self.walk(p, q, &mut |item| self.shares(item, p, q).iter().any(|t| *t > trim && *t < 1.0 - trim))
    }

    /// Whether nothing stands between two points, right up to the second.
    pub(crate) fn reaches(&self, p: Point, q: Point) -> bool {
        !self.walk(p, q, &mut |item| self.shares(item, p, q).iter().any(|t| (0.0..=1.0).contains(t)))
    }

    /// What a ray of light of unit `direction` meets first within `reach`; it goes through glass unless near its normal.
    pub(crate) fn ray(&self, p: Point, direction: Point, reach: f64) -> Option<Met> {
        let q = add(p, times(direction, reach));
        let mut best: Option<Met> = None;
        self.walk(p, q, &mut |item| {
            for t in self.shares(item, p, q) {
                if !(0.0..=1.0).contains(&t) || best.is_some_and(|m| m.distance <= t * reach) {
                    continue;
                }
                let (surface, class, incidence) = match self.walls.get(item as usize) {
                    Some(w) => {
                        let e = sub(w.b, w.a);
                        (w.surface, w.class, cross(e, direction).abs() / length(e))
                    }
                    None => {
                        let a = &self.arcs[item as usize - self.walls.len()];
                        let out = times(sub(add(p, times(direction, t * reach)), a.centre), 1.0 / a.radius);
                        (a.surface, a.class, dot(out, direction).abs())
                    }
                };
                if surface != Surface::Glass || incidence >= 0.985 {
                    best = Some(Met { item, distance: t * reach, class });
                }
            }
            false
        });
        best
    }

    /// The walls and arcs that may come within `margin` of the way from `p` to `q`, in their own order.
    pub(crate) fn beside(&self, p: Point, q: Point, margin: f64) -> Vec<u32> {
        let run = times(sub(q, p), margin / length(sub(q, p)).max(f64::MIN_POSITIVE));
        let (from, to) = (sub(p, run), add(q, run));
        let mut found = Vec::new();
        for side in [-1.0, 0.0, 1.0] {
            let off = (-side * run.1, side * run.0);
            self.walk(add(from, off), add(to, off), &mut |item| {
                found.push(item);
                false
            });
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Where an item meets the way from `p` to `q`, as shares of it; NaN where it doesn't.
    pub(crate) fn shares(&self, item: u32, p: Point, q: Point) -> [f64; 2] {
        match self.walls.get(item as usize) {
            Some(w) => [crossing(w, p, q), f64::NAN],
            None => self.arcs[item as usize - self.walls.len()].meets(p, sub(q, p)),
        }
    }

    /// Shows every item in the buckets between two points, until `stop` says so.
    fn walk(&self, p: Point, q: Point, stop: &mut dyn FnMut(u32) -> bool) -> bool {
        let (r0, r1) = (self.row(p.1.min(q.1)), self.row(p.1.max(q.1)));
        for row in r0..=r1 {
            // the part of the way in this row of buckets, a hair wider
            let (low, high) = (self.low.1 + row as f64 * self.edge, self.low.1 + (row + 1) as f64 * self.edge);
            let share = |y: f64| if q.1 == p.1 { f64::NAN } else { (y - p.1) / (q.1 - p.1) };
            let (a, b) = (share(low), share(high));
            let (mut t0, mut t1) = if a.is_nan() { (0.0, 1.0) } else { (a.min(b).max(0.0), a.max(b).min(1.0)) };
            if row == r0 || row == r1 {
                // beyond the world's edge rows are clamped
                (t0, t1) =
                    if r0 == r1 { (0.0, 1.0) } else { (t0.min(end(row == r0, p, q)), t1.max(end(row == r0, p, q))) };
            }
            let x = |t: f64| p.0 + (q.0 - p.0) * t;
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

/// The share at the lower end of a way (or the upper).
fn end(lower: bool, p: Point, q: Point) -> f64 {
    if (p.1 <= q.1) == lower { 0.0 } else { 1.0 }
}

/// Where a wall crosses the way from `p` to `q`, as a share of it; NaN if it doesn't.
pub(crate) fn crossing(w: &Wall, p: Point, q: Point) -> f64 {
    match meet(p, q, w.a, w.b) {
        Some((t, u)) if (-1e-9..=1.0 + 1e-9).contains(&u) => t,
        _ => f64::NAN,
    }
}

/// The box around walls and arcs (whole circles), metres; a point at the origin if there is none.
pub(crate) fn bounds(walls: &[Wall], arcs: &[Arc]) -> [f64; 4] {
    let mut b = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    let mut take = |x: f64, y: f64| b = [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)];
    for w in walls {
        take(w.a.0, w.a.1);
        take(w.b.0, w.b.1);
    }
    for a in arcs {
        take(a.centre.0 - a.radius, a.centre.1 - a.radius);
        take(a.centre.0 + a.radius, a.centre.1 + a.radius);
    }
    if b[0] <= b[2] { b } else { [0.0; 4] }
}
