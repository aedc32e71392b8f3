//! The free limit: how far from a sensor, at each bearing, the cells may be freed. Walls end it, and between two features' ends the
//! *safe line* that joins them: what lies behind it no echo has told of.

use super::features::{Features, hit};
use crate::world::plane::{Point, cross, distance, dot, sub, times};

/// An end hidden by something that is nearer by this, metres, isn't seen.
const HIDDEN: f64 = 0.10;
/// Ends farther off the axis don't count, radians.
fn aside() -> f64 { static A: std::sync::OnceLock<f64> = std::sync::OnceLock::new(); *A.get_or_init(|| std::env::var("ASIDE").ok().and_then(|s| s.parse::<f64>().ok()).unwrap_or(90.0).to_radians()) }
/// A safe line before a wall is no longer, metres.
const SHORT: f64 = 1.2;

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

/// An end as it is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Off the axis, to the left, radians.
    pub bearing: f64,
    /// Metres.
    pub distance: f64,
    /// The end.
    pub end: End,
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
    /// What it is.
    pub by: By,
    /// Length of the safe line between two ends, metres.
    pub length: f64,
    /// Up to where cells may be freed: before any cell that it passes through, metres.
    pub before: f64,
}

/// Slack of a free limit, cells.
const SLACK: f64 = 0.1;

/// A segment that ends sight.
#[derive(Debug, Clone, Copy)]
struct Blocker {
    segment: [Point; 2],
    wall: usize,
    /// How far before it, square to it, freeing ends: unit normal and metres.
    normal: Point,
    depth: f64,
}

impl Blocker {
    fn new(segment: [Point; 2], wall: usize, resolution: f64) -> Blocker {
        let along = crate::world::plane::unit(sub(segment[1], segment[0]));
        let normal = (-along.1, along.0);
        Blocker { segment, wall, normal, depth: resolution * (0.5 * (normal.0.abs() + normal.1.abs()) + SLACK) }
    }

    /// Up to where a ray that meets it after `d` metres may free.
    fn before(&self, ray: Point, d: f64) -> f64 {
        (d - self.depth / dot(self.normal, ray).abs().max(1e-9)).max(0.0)
    }
}

/// What stands near a place.
#[derive(Debug, Clone, Default)]
pub struct View<'a> {
    walls: &'a [super::features::Wall],
    blockers: Vec<Blocker>,
    lines: Vec<Blocker>,
    resolution: f64,
    ends: Vec<End>,
}

impl<'a> View<'a> {
    /// What stands within so many metres of a place.
    pub fn of(features: &'a Features, place: Point, reach: f64, resolution: f64) -> View<'a> {
        let near = |[a, b]: [Point; 2]| crate::world::plane::from_segment(place, a, b) <= reach;
        let block = |(s, w)| Blocker::new(s, w, resolution);
        let blockers = features.blockers().filter(|(s, _)| near(*s)).map(block).collect();
        let lines = features.lines.iter().filter(|s| near(**s)).map(|s| block((*s, usize::MAX))).collect();
        let of_walls = features.walls.iter().enumerate().flat_map(|(k, w)| {
            w.ends().map(|at| End { at, wall: Some(k), spot: None })
        });
        let of_spots = features.spots.iter().enumerate().map(|(k, s)| End { at: s.at, wall: None, spot: Some(k) });
        let of_corners = features.corners.iter().map(|c| End { at: c.at, wall: None, spot: None });
        let ends = of_walls.chain(of_spots).chain(of_corners).filter(|e| distance(e.at, place) <= reach).collect();
        View { walls: &features.walls, blockers, lines, resolution, ends }
    }

    /// How far the first wall or leg is along a ray, and whose it is.
    pub fn first(&self, from: Point, ray: Point) -> Option<(f64, usize)> {
        nearest(&self.blockers, from, ray).map(|(d, b)| (d, b.wall))
    }

    /// The ends seen within 60° of an axis, from right to left.
    pub fn ends(&self, from: Point, axis: Point, counts: impl Fn(&End) -> bool) -> Vec<Seen> {
        let mut seen = Vec::new();
        for end in self.ends.iter().filter(|e| counts(e)) {
            let v = sub(end.at, from);
            let far = dot(v, v).sqrt();
            let bearing = cross(axis, v).atan2(dot(axis, v));
            if bearing.abs() > aside() || far < 1e-6 {
                continue;
            }
            let ray = times(v, 1.0 / far);
            let hidden = self.blockers.iter().any(|b| hit(from, ray, b.segment).is_some_and(|d| d < far - HIDDEN));
            if !hidden {
                seen.push(Seen { bearing, distance: far, end: *end });
            }
        }
        seen.sort_by(|a, b| a.bearing.total_cmp(&b.bearing));
        seen
    }

    /// The limit along a ray that is `bearing` off the axis for which the ends were seen.
    pub fn limit(&self, from: Point, ray: Point, bearing: f64, seen: &[Seen]) -> Limit {
        let limit = |by: By, length: f64, d: f64, blocker: &Blocker| Limit { distance: d, by, length, before: blocker.before(ray, d) };
        let wall = nearest(&self.blockers, from, ray).map(|(d, b)| limit(By::Wall, 0.0, d, b));
        let line = nearest(&self.lines, from, ray).map(|(d, b)| limit(By::Line, distance(b.segment[0], b.segment[1]), d, b));
        let split = seen.partition_point(|s| s.bearing < bearing);
        let (right, left) = (split.checked_sub(1).map(|k| seen[k]), seen.get(split).copied());
        let between = match (right, left) {
            (Some(a), Some(b)) => {
                let blocker = Blocker::new([a.end.at, b.end.at], usize::MAX, self.resolution);
                let length = distance(a.end.at, b.end.at);
                let counts = wall.is_none_or(|w| a.distance < w.distance && b.distance < w.distance && length <= SHORT);
                hit(from, ray, blocker.segment).filter(|_| counts).map(|d| limit(By::Line, length, d, &blocker))
            }
            (Some(only), None) | (None, Some(only)) if wall.is_none() => {
                let prolonged = only.end.wall.and_then(|w| {
                    let wall = &self.walls[w];
                    let slant = dot(wall.normal, ray);
                    let d = wall.front(from) / slant;
                    (slant != 0.0 && d > 0.0).then_some(d)
                });
                let distance = prolonged.map_or(only.distance, |d| d.min(only.distance));
                let before = (distance - 0.6 * self.resolution).max(0.0);
                Some(Limit { distance, by: By::Line, length: f64::INFINITY, before })
            }
            _ => None,
        };
        let all = [wall, line, between].into_iter().flatten();
        all.min_by(|a, b| a.distance.total_cmp(&b.distance)).unwrap_or(NOTHING)
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

/// No limit.
const NOTHING: Limit = Limit { distance: f64::INFINITY, by: By::Nothing, length: f64::INFINITY, before: f64::INFINITY };
