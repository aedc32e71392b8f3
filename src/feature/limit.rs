//! The free limit: how far from a sensor, at each bearing, the cells may be freed. Walls end it, and between two features' ends the
//! *safe line* that joins them: what lies behind it no echo has told of.

use super::features::{Features, Wall, hit};
use crate::geometry::plane::{Point, cross, distance, dot, from_segment, sub, times, unit};

/// An end hidden by something that is nearer by this, metres, isn't seen.
const HIDDEN: f64 = 0.10;
/// A safe line before a wall is no longer, metres.
const SHORT: f64 = 1.2;
/// Freeing ends so many cells before the last that a line passes through.
const SLACK: f64 = 0.1;
/// Freeing ends so many cells before a single end.
const BEFORE: f64 = 0.6;

/// A wall's end, a corner or a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Where, metres.
    pub at: Point,
    /// The wall that ends there.
    pub wall: Option<usize>,
    /// The point that it is.
    pub spot: Option<usize>,
}

/// What ends what may be freed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// A wall, or the leg to a corner.
    Wall,
    /// The line between two ends, or a single end.
    Line,
    /// Nothing.
    Nothing,
}

/// A free limit at a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Metres; infinite where nothing ends it.
    pub distance: f64,
    /// Up to where cells may be freed: before any cell that the limit passes through, metres.
    pub before: f64,
    /// What it is.
    pub by: By,
    /// Length of the safe line between two ends, metres.
    pub length: f64,
}

/// No limit.
const NOTHING: Limit = Limit { distance: f64::INFINITY, before: f64::INFINITY, by: By::Nothing, length: f64::INFINITY };

/// A segment that ends sight, or freeing.
#[derive(Debug, Clone, Copy)]
struct Blocker {
    segment: [Point; 2],
    /// Its unit normal, and how far before it, along that, freeing ends, metres.
    normal: Point,
    depth: f64,
}

impl Blocker {
    fn new(segment: [Point; 2], resolution: f64) -> Blocker {
        let along = unit(sub(segment[1], segment[0]));
        let normal = (-along.1, along.0);
        // A line passes through the cells whose centre is so near.
        let depth = resolution * (0.5 * (normal.0.abs() + normal.1.abs()) + SLACK);
        Blocker { segment, normal, depth }
    }

    /// As a limit on a ray that meets it after `d` metres.
    fn limit(&self, ray: Point, d: f64, by: By) -> Limit {
        let before = (d - self.depth / dot(self.normal, ray).abs().max(1e-9)).max(0.0);
        Limit { distance: d, before, by, length: distance(self.segment[0], self.segment[1]) }
    }
}

/// What stands near a place.
#[derive(Debug, Clone)]
pub struct View<'a> {
    walls: &'a [Wall],
    blockers: Vec<Blocker>,
    lines: Vec<Blocker>,
    ends: Vec<End>,
    resolution: f64,
}

impl<'a> View<'a> {
    /// What stands within so many metres of a place; `resolution` is the edge of a cell.
    pub fn of(features: &'a Features, place: Point, reach: f64, resolution: f64) -> View<'a> {
        let near = |s: &[Point; 2]| from_segment(place, s[0], s[1]) <= reach;
        let block = |s: [Point; 2]| Blocker::new(s, resolution);
        let of_walls = features
            .walls
            .iter()
            .enumerate()
            .flat_map(|(k, w)| w.ends().map(|at| End { at, wall: Some(k), spot: None }));
        let of_spots = features.spots.iter().enumerate().map(|(k, s)| End { at: s.at, wall: None, spot: Some(k) });
        let of_corners = features.corners.iter().map(|c| End { at: c.at, wall: None, spot: None });
        View {
            walls: &features.walls,
            blockers: features.blockers().filter(near).map(block).collect(),
            lines: features.lines.iter().copied().filter(near).map(block).collect(),
            ends: of_walls.chain(of_spots).chain(of_corners).filter(|e| distance(e.at, place) <= reach).collect(),
            resolution,
        }
    }

    /// How far the first wall or leg is along a ray, metres.
    pub fn first(&self, from: Point, ray: Point) -> Option<f64> {
        nearest(&self.blockers, from, ray).map(|(d, _)| d)
    }

    fn sees(&self, from: Point, at: Point) -> bool {
        let far = distance(from, at);
        let ray = times(sub(at, from), 1.0 / far);
        !self.blockers.iter().any(|b| hit(from, ray, b.segment).is_some_and(|d| d < far - HIDDEN))
    }

    /// What a sensor has before it: `half_width` radians to each side of its axis, and ends up to `aside` radians (at most 90°)
    /// off the axis; `counts` says which ends are to count.
    pub fn sector(
        &self,
        (from, axis): (Point, Point),
        half_width: f64,
        aside: f64,
        counts: impl Fn(&End) -> bool,
    ) -> Sector<'_> {
        let (sin, cos) = half_width.sin_cos();
        let (right, left) = (
            (axis.0 * cos + axis.1 * sin, axis.1 * cos - axis.0 * sin),
            (axis.0 * cos - axis.1 * sin, axis.1 * cos + axis.0 * sin),
        );
        // A hair wider, so that rounding loses nothing.
        let inside = |b: &&Blocker| {
            let [u, v] = b.segment.map(|p| sub(p, from));
            let beside = |edge: Point, side: f64| side * cross(edge, u) < -1e-9 && side * cross(edge, v) < -1e-9;
            !beside(right, 1.0) && !beside(left, -1.0) && (dot(axis, u) > 0.0 || dot(axis, v) > 0.0)
        };
        let within = |all: &[Blocker]| all.iter().filter(inside).copied().collect();
        Sector {
            walls: self.walls,
            from,
            blockers: within(&self.blockers),
            lines: within(&self.lines),
            ends: self.seen((from, axis), sin, aside.sin(), counts),
            resolution: self.resolution,
        }
    }

    /// The ends seen in a cone, and the next on each side of it, from right to left.
    fn seen(&self, (from, axis): (Point, Point), cone: f64, aside: f64, counts: impl Fn(&End) -> bool) -> Vec<Seen> {
        let seen = |end: &End| {
            let v = sub(end.at, from);
            let far = dot(v, v).sqrt();
            let side = cross(axis, v) / far;
            (far > 1e-6 && dot(axis, v) >= 0.0 && side.abs() <= aside).then_some(Seen {
                side,
                distance: far,
                end: *end,
            })
        };
        let mut all: Vec<Seen> = self.ends.iter().filter(|e| counts(e)).filter_map(seen).collect();
        all.sort_by(|a, b| a.side.total_cmp(&b.side));
        let sees = |s: &&Seen| self.sees(from, s.end.at);
        let (low, high) = (all.partition_point(|s| s.side < -cone), all.partition_point(|s| s.side <= cone));
        let right = all[..low].iter().rev().find(sees);
        let left = all[high..].iter().find(sees);
        right.into_iter().chain(all[low..high].iter().filter(sees)).chain(left).copied().collect()
    }
}

/// An end as a sensor sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Seen {
    /// Sine of its angle off the axis, to the left.
    side: f64,
    /// Metres.
    distance: f64,
    end: End,
}

/// What a sensor has before it.
#[derive(Debug, Clone)]
pub struct Sector<'a> {
    walls: &'a [Wall],
    from: Point,
    blockers: Vec<Blocker>,
    lines: Vec<Blocker>,
    ends: Vec<Seen>,
    resolution: f64,
}

impl Sector<'_> {
    /// The limit along a ray whose angle off the axis has that sine, to the left.
    pub fn limit(&self, ray: Point, side: f64) -> Limit {
        let met = |all: &[Blocker], by: By| nearest(all, self.from, ray).map(|(d, b)| b.limit(ray, d, by));
        let (wall, line) = (met(&self.blockers, By::Wall), met(&self.lines, By::Line));
        let split = self.ends.partition_point(|s| s.side < side);
        let (right, left) = (split.checked_sub(1).map(|k| self.ends[k]), self.ends.get(split).copied());
        let between = match (right, left) {
            (Some(a), Some(b)) => self.between(ray, a, b, wall),
            (Some(only), None) | (None, Some(only)) if wall.is_none() => Some(self.single(ray, only)),
            _ => None,
        };
        let all = [wall, line, between].into_iter().flatten();
        all.min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap_or(NOTHING)
    }

    /// The safe line between two ends; before a wall only where it is short and both of its ends are nearer.
    fn between(&self, ray: Point, a: Seen, b: Seen, wall: Option<Limit>) -> Option<Limit> {
        let blocker = Blocker::new([a.end.at, b.end.at], self.resolution);
        let line = blocker.limit(ray, hit(self.from, ray, blocker.segment)?, By::Line);
        let before = |w: Limit| a.distance < w.distance && b.distance < w.distance && line.length <= SHORT;
        wall.is_none_or(before).then_some(line)
    }

    /// With one end alone: its distance, or that to where its wall would go on.
    fn single(&self, ray: Point, only: Seen) -> Limit {
        let prolonged = only.end.wall.map(|w| self.walls[w].front(self.from) / dot(self.walls[w].normal, ray));
        let distance = prolonged.filter(|d| *d > 0.0).map_or(only.distance, |d| d.min(only.distance));
        let before = (distance - BEFORE * self.resolution).max(0.0);
        Limit { distance, before, by: By::Line, length: f64::INFINITY }
    }
}

/// The blocker that a ray meets first, and where.
fn nearest(blockers: &[Blocker], from: Point, ray: Point) -> Option<(f64, &Blocker)> {
    let mut first: Option<(f64, &Blocker)> = None;
    for blocker in blockers {
        if let Some(d) = hit(from, ray, blocker.segment)
            && first.is_none_or(|(f, _)| d < f)
        {
            first = Some((d, blocker));
        }
    }
    first
}
