//! The free limit: the range up to which cells may be freed at each bearing of a sensor. It ends at walls, and between the
//! endpoints of two features at the *safe line* that joins them: no echo has come from behind it.

use super::features::{Features, Wall};
use crate::geometry::plane::{Point, Vector, distance_to_segment, intersect_ray, left_normal, unit};
use nalgebra::{UnitComplex, distance};

/// An endpoint is hidden by what is nearer than it by this, metres.
const HIDDEN: f64 = 0.10;
/// The longest safe line in front of a wall, metres.
const MAX_LENGTH: f64 = 1.2;
/// Freeing ends this far before the cells that a line passes through, cells.
const SLACK: f64 = 0.1;
/// Freeing ends this far before a single endpoint, cells.
const ENDPOINT_MARGIN: f64 = 0.6;

/// The end of a wall, a corner or a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Endpoint {
    /// Its position, metres.
    pub at: Point,
    /// The index of the wall that ends there.
    pub wall: Option<usize>,
    /// The index of the point that it is.
    pub point: Option<usize>,
}

/// What limits freeing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// A wall, or one extrapolated to a corner.
    Wall,
    /// The line between two endpoints, or a single endpoint.
    SafeLine,
    /// Nothing.
    Unlimited,
}

/// A free limit at a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Metres; infinite where there is no limit.
    pub distance: f64,
    /// The range up to which cells may be freed, metres: it ends before the cells that the limit passes through.
    pub free: f64,
    /// What limits.
    pub kind: LimitKind,
    /// The length of the safe line, metres; infinite for a single endpoint.
    pub length: f64,
}

/// No limit.
const UNLIMITED: Limit =
    Limit { distance: f64::INFINITY, free: f64::INFINITY, kind: LimitKind::Unlimited, length: f64::INFINITY };

/// A segment that blocks sight, or limits freeing.
#[derive(Debug, Clone, Copy)]
struct Blocker {
    segment: [Point; 2],
    /// Its unit normal.
    normal: Vector,
    /// The distance before it, along the normal, at which freeing ends, metres.
    depth: f64,
}

impl Blocker {
    fn new(segment: [Point; 2], resolution: f64) -> Blocker {
        let along = unit(segment[1] - segment[0]);
        let normal = left_normal(along);
        // A line passes through the cells whose centres are no farther from it.
        let depth = resolution * (0.5 * (normal.x.abs() + normal.y.abs()) + SLACK);
        Blocker { segment, normal, depth }
    }

    /// The limit on a ray that meets it after `d` metres.
    fn limit(&self, ray: Vector, d: f64, kind: LimitKind) -> Limit {
        let free = (d - self.depth / self.normal.dot(&ray).abs().max(1e-9)).max(0.0);
        Limit { distance: d, free, kind, length: distance(&self.segment[0], &self.segment[1]) }
    }
}

/// The walls, safe lines and endpoints near a position.
#[derive(Debug, Clone)]
pub struct Obstacles<'a> {
    walls: &'a [Wall],
    blockers: Vec<Blocker>,
    lines: Vec<Blocker>,
    ends: Vec<Endpoint>,
    resolution: f64,
}

impl<'a> Obstacles<'a> {
    /// The obstacles within `reach` metres of a position; `resolution` is the edge of a cell, metres.
    pub fn near(features: &'a Features, place: Point, reach: f64, resolution: f64) -> Obstacles<'a> {
        let near = |s: &[Point; 2]| distance_to_segment(place, s[0], s[1]) <= reach;
        let block = |s: [Point; 2]| Blocker::new(s, resolution);
        let of_walls = features
            .walls
            .iter()
            .enumerate()
            .flat_map(|(k, w)| w.ends().map(|at| Endpoint { at, wall: Some(k), point: None }));
        let of_points =
            features.points.iter().enumerate().map(|(k, s)| Endpoint { at: s.at, wall: None, point: Some(k) });
        let of_corners = features.corners.iter().map(|c| Endpoint { at: c.at, wall: None, point: None });
        Obstacles {
            walls: &features.walls,
            blockers: features.blockers().filter(near).map(block).collect(),
            lines: features.lines.iter().copied().filter(near).map(block).collect(),
            ends: of_walls.chain(of_points).chain(of_corners).filter(|e| distance(&e.at, &place) <= reach).collect(),
            resolution,
        }
    }

    /// The distance to the first wall along a ray, metres.
    pub fn first_wall(&self, from: Point, ray: Vector) -> Option<f64> {
        nearest(&self.blockers, from, ray).map(|(d, _)| d)
    }

    fn sees(&self, from: Point, at: Point) -> bool {
        let far = distance(&from, &at);
        let ray = (at - from) * (1.0 / far);
        !self.blockers.iter().any(|b| intersect_ray(from, ray, b.segment).is_some_and(|d| d < far - HIDDEN))
    }

    /// The obstacles in front of a sensor: those within `half_width` radians of its axis, and the endpoints up to `aside` radians
    /// (at most 90°) off the axis that `counts` accepts.
    pub fn sector(
        &self,
        (from, axis): (Point, Vector),
        half_width: f64,
        aside: f64,
        counts: impl Fn(&Endpoint) -> bool,
    ) -> Sector<'_> {
        let turn = UnitComplex::new(half_width);
        let (right, left) = (turn.inverse() * axis, turn * axis);
        // Slightly wider, so that rounding loses nothing.
        let inside = |b: &&Blocker| {
            let [u, v] = b.segment.map(|p| p - from);
            let beside = |edge: Vector, side: f64| side * edge.perp(&u) < -1e-9 && side * edge.perp(&v) < -1e-9;
            !beside(right, 1.0) && !beside(left, -1.0) && (axis.dot(&u) > 0.0 || axis.dot(&v) > 0.0)
        };
        let within = |all: &[Blocker]| all.iter().filter(inside).copied().collect();
        Sector {
            walls: self.walls,
            from,
            blockers: within(&self.blockers),
            lines: within(&self.lines),
            ends: self.seen((from, axis), half_width.sin(), aside.sin(), counts),
            resolution: self.resolution,
        }
    }

    /// The visible endpoints in a beam, and the next one on each side of it, from right to left; `cone` and `aside` are sines.
    fn seen(
        &self,
        (from, axis): (Point, Vector),
        cone: f64,
        aside: f64,
        counts: impl Fn(&Endpoint) -> bool,
    ) -> Vec<VisibleEnd> {
        let seen = |end: &Endpoint| {
            let v = end.at - from;
            let far = v.norm();
            let side = axis.perp(&v) / far;
            (far > 1e-6 && axis.dot(&v) >= 0.0 && side.abs() <= aside).then_some(VisibleEnd {
                side,
                distance: far,
                end: *end,
            })
        };
        let mut all: Vec<VisibleEnd> = self.ends.iter().filter(|e| counts(e)).filter_map(seen).collect();
        all.sort_by(|a, b| a.side.total_cmp(&b.side));
        let sees = |s: &&VisibleEnd| self.sees(from, s.end.at);
        let (low, high) = (all.partition_point(|s| s.side < -cone), all.partition_point(|s| s.side <= cone));
        let right = all[..low].iter().rev().find(sees);
        let left = all[high..].iter().find(sees);
        right.into_iter().chain(all[low..high].iter().filter(sees)).chain(left).copied().collect()
    }
}

/// An endpoint as a sensor sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct VisibleEnd {
    /// The sine of its bearing off the axis, to the left.
    side: f64,
    /// Metres.
    distance: f64,
    end: Endpoint,
}

/// The obstacles in front of a sensor.
#[derive(Debug, Clone)]
pub struct Sector<'a> {
    walls: &'a [Wall],
    from: Point,
    blockers: Vec<Blocker>,
    lines: Vec<Blocker>,
    ends: Vec<VisibleEnd>,
    resolution: f64,
}

impl Sector<'_> {
    /// The limit along a ray; `side` is the sine of its bearing off the axis, to the left.
    pub fn limit(&self, ray: Vector, side: f64) -> Limit {
        let met = |all: &[Blocker], kind: LimitKind| nearest(all, self.from, ray).map(|(d, b)| b.limit(ray, d, kind));
        let (wall, line) = (met(&self.blockers, LimitKind::Wall), met(&self.lines, LimitKind::SafeLine));
        let split = self.ends.partition_point(|s| s.side < side);
        let (right, left) = (split.checked_sub(1).map(|k| self.ends[k]), self.ends.get(split).copied());
        let between = match (right, left) {
            (Some(a), Some(b)) => self.between(ray, a, b, wall),
            (Some(only), None) | (None, Some(only)) if wall.is_none() => Some(self.single(ray, only)),
            _ => None,
        };
        let all = [wall, line, between].into_iter().flatten();
        all.min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap_or(UNLIMITED)
    }

    /// The safe line between two endpoints; in front of a wall only if it is short and both endpoints are nearer than the wall.
    fn between(&self, ray: Vector, a: VisibleEnd, b: VisibleEnd, wall: Option<Limit>) -> Option<Limit> {
        let blocker = Blocker::new([a.end.at, b.end.at], self.resolution);
        let line = blocker.limit(ray, intersect_ray(self.from, ray, blocker.segment)?, LimitKind::SafeLine);
        let in_front = |w: Limit| a.distance < w.distance && b.distance < w.distance && line.length <= MAX_LENGTH;
        wall.is_none_or(in_front).then_some(line)
    }

    /// The limit at a single endpoint: its distance, or that to the prolongation of its wall if it is nearer.
    fn single(&self, ray: Vector, only: VisibleEnd) -> Limit {
        let prolonged = only.end.wall.map(|w| self.walls[w].front(self.from) / self.walls[w].normal.dot(&ray));
        let distance = prolonged.filter(|d| *d > 0.0).map_or(only.distance, |d| d.min(only.distance));
        let free = (distance - ENDPOINT_MARGIN * self.resolution).max(0.0);
        Limit { distance, free, kind: LimitKind::SafeLine, length: f64::INFINITY }
    }
}

/// The blocker that a ray meets first, and its distance, metres.
fn nearest(blockers: &[Blocker], from: Point, ray: Vector) -> Option<(f64, &Blocker)> {
    let mut first: Option<(f64, &Blocker)> = None;
    for blocker in blockers {
        if let Some(d) = intersect_ray(from, ray, blocker.segment)
            && first.is_none_or(|(f, _)| d < f)
        {
            first = Some((d, blocker));
        }
    }
    first
}
