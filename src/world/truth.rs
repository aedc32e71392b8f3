//! The true map of a world: what an ideal sensor on the trajectory could know, by exact geometry.
//!
//! A cell is occupied if it holds a part of a surface that is visible from a scan's position within range. A cell that
//! holds only invisible surface is unknown. Any other cell is empty if its centre is visible from a scan's position within
//! range, and else unknown. A surface on the line between two cells belongs to the right or upper one. The visibility of an
//! arc is that of chords at most 0.2 mm from it; the cells that it passes through are those of the arc itself.

use super::index::ShapeIndex;
use super::model::World;
use super::shape::{Arc, Wall};
use crate::geometry::plane::{Point, Wedge, clip_to_non_negative, intersect_lines, lerp};
use crate::grid::{Class, GridSpec};
use nalgebra::distance;
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// The largest distance of a chord from its arc, metres.
const SAGITTA: f64 = 2e-4;
/// Shorter parts of a surface do not count, metres.
const MIN_LENGTH: f64 = 1e-7;

/// A part of a wall, as parameters of it from 0 to 1.
type Interval = (f64, f64);

/// The true class of each cell: 1 occupied, 0 unknown, −1 empty; row by row from the bottom. `scans` are the positions of
/// the robot, world frame; `r_max` is the range of the ideal sensor, metres.
pub fn true_map(world: &World, scans: &[Point], grid: &GridSpec, r_max: f64) -> Vec<i8> {
    let mut walls = world.index.walls.clone();
    let mut parts: Vec<SurfacePart> = world.index.walls.iter().map(SurfacePart::Straight).collect();
    for arc in &world.index.arcs {
        for (wall, from, to) in arc.facets(SAGITTA) {
            walls.push(wall);
            parts.push(SurfacePart::Bent { arc, from, to });
        }
    }
    let index = ShapeIndex::new(walls, Vec::new());
    let mut scans = scans.to_vec();
    scans.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    scans.dedup();
    let mut seen: Vec<Vec<Interval>> = vec![Vec::new(); index.walls.len()];
    let one: Vec<Vec<(u32, Interval)>> = scans.par_iter().map(|s| visible(&index, *s, r_max)).collect();
    for (wall, span) in one.into_iter().flatten() {
        seen[wall as usize].push(span);
    }
    let mut surface: HashMap<usize, bool> = HashMap::new();
    for (part, spans) in parts.iter().zip(&mut seen) {
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = MIN_LENGTH / part.length();
        part.rasterise(grid, &mut |cell, span| {
            let found = spans.iter().any(|s| s.1.min(span.1) - s.0.max(span.0) > least);
            *surface.entry(cell).or_default() |= found;
        });
    }
    let near = PointBuckets::new(scans, r_max);
    let class = |k: usize| match surface.get(&k) {
        Some(true) => Class::Occupied,
        Some(false) => Class::Unknown,
        None => {
            let (x, y) = grid.centre(k % grid.width, k / grid.width);
            let centre = Point::new(x, y);
            if near.around(centre).any(|s| world.index.line_of_sight(s, centre)) {
                Class::Empty
            } else {
                Class::Unknown
            }
        }
    };
    (0..grid.cells()).into_par_iter().map(|k| class(k) as i8).collect()
}

/// The parts of the walls that are visible from a point within range.
fn visible(index: &ShapeIndex, from: Point, r_max: f64) -> Vec<(u32, Interval)> {
    let near = index.within(from, r_max);
    let walls: Vec<&Wall> = near.iter().map(|k| &index.walls[*k as usize]).collect();
    let mut found = Vec::new();
    for (k, wall) in near.iter().zip(&walls) {
        let Some(reach) = within_range(from, wall, r_max).filter(|_| wall.faces(from)) else { continue };
        let (a, b) = (lerp(wall.a, wall.b, reach.0), lerp(wall.a, wall.b, reach.1));
        let mut shadows: Vec<Interval> = Vec::new();
        let wedge = Wedge::spanning(from, a, b);
        let side = wall.side(from);
        for other in walls.iter().filter(|w| !std::ptr::eq(**w, *wall)) {
            // the part of the other wall in the triangle between the point and this wall
            let Some(span) = wedge.clip(other.a, other.b) else { continue };
            let e = wall.b - wall.a;
            let front = |p: Point| side * e.perp(&(p - wall.a)) - 1e-9;
            let Some(span) = clip_to_non_negative(span, front(other.a), front(other.b)) else { continue };
            let shadow = [span.0, span.1].map(|t| shadow_of(from, lerp(other.a, other.b, t), wall));
            shadows.push((shadow[0].min(shadow[1]), shadow[0].max(shadow[1])));
        }
        shadows.sort_by(|x, y| x.0.total_cmp(&y.0));
        let mut free = reach.0;
        for (low, high) in shadows {
            if low > free {
                found.push((*k, (free, low.min(reach.1))));
            }
            free = free.max(high);
        }
        if free < reach.1 {
            found.push((*k, (free, reach.1)));
        }
    }
    found
}

/// The intersection of the ray from a point through another with the line of a wall, as a parameter of the wall.
fn shadow_of(from: Point, through: Point, wall: &Wall) -> f64 {
    intersect_lines(from, through, wall.a, wall.b).map_or(f64::NAN, |(_, u)| u)
}

/// The part of a wall within range of a point.
fn within_range(from: Point, wall: &Wall, r_max: f64) -> Option<Interval> {
    let (e, w) = (wall.b - wall.a, wall.a - from);
    let (a, b, c) = (e.dot(&e), e.dot(&w), w.dot(&w) - r_max * r_max);
    // a wall that only touches the circle of the range has no part within it
    let root = Some(b * b - a * c).filter(|d| *d > 0.0)?.sqrt();
    let span = (((-b - root) / a).max(0.0), ((-b + root) / a).min(1.0));
    (span.0 < span.1).then_some(span)
}

/// A part of a surface: a wall, or an arc between two angles from its beginning.
enum SurfacePart<'a> {
    Straight(&'a Wall),
    Bent { arc: &'a Arc, from: f64, to: f64 },
}

impl SurfacePart<'_> {
    /// Metres.
    fn length(&self) -> f64 {
        match self {
            SurfacePart::Straight(w) => distance(&w.a, &w.b),
            SurfacePart::Bent { arc, from, to } => (to - from).abs() * arc.radius,
        }
    }

    /// The point at a parameter from 0 to 1.
    fn at(&self, t: f64) -> Point {
        match self {
            SurfacePart::Straight(w) => lerp(w.a, w.b, t),
            SurfacePart::Bent { arc, from, to } => arc.at(from + (to - from) * t),
        }
    }

    /// The parameters at which its x (or its y) has a value.
    fn parameters_at(&self, x: bool, value: f64) -> [f64; 2] {
        let of = |p: Point| if x { p.x } else { p.y };
        match self {
            SurfacePart::Straight(w) => [(value - of(w.a)) / (of(w.b) - of(w.a)), f64::NAN],
            SurfacePart::Bent { arc, from, to } => {
                // NaN where the circle doesn't reach so far
                let angle = ((value - of(arc.centre)) / arc.radius).acos();
                let right_angle = if x { 0.0 } else { PI / 2.0 };
                [angle, -angle].map(|a| {
                    let middle = arc.from + (from + to) / 2.0;
                    let turn = (a + right_angle - middle + PI).rem_euclid(TAU) - PI;
                    0.5 + turn / (to - from)
                })
            }
        }
    }

    /// Visits each cell that it passes through, with the part of it in that cell.
    fn rasterise(&self, grid: &GridSpec, visit: &mut dyn FnMut(usize, Interval)) {
        let mut cuts = vec![0.0, 1.0];
        for (x, low, cells) in [(true, grid.x0(), grid.width), (false, grid.y0(), grid.height)] {
            let line = |k: i64| low + k as f64 * grid.resolution;
            let (least, most) = self.bounds(x);
            // the lines of the grid that it may cross
            let column = |v: f64| ((v - low) / grid.resolution).clamp(-1.0, cells as f64 + 1.0);
            let lines = (column(least).ceil() as i64).max(0)..=(column(most).floor() as i64).min(cells as i64);
            let shares = lines.flat_map(|k| self.parameters_at(x, line(k)));
            cuts.extend(shares.filter(|t| *t > 0.0 && *t < 1.0));
        }
        cuts.sort_by(f64::total_cmp);
        let least = MIN_LENGTH / self.length();
        for pair in cuts.windows(2) {
            if pair[1] - pair[0] <= least {
                continue;
            }
            let p = self.at((pair[0] + pair[1]) / 2.0);
            // a wall on a line of the grid belongs to the cell above it, however its coordinates were rounded
            let cell = |v: f64, low: f64| ((v - low) / grid.resolution + 1e-9).floor();
            let (x, y) = (cell(p.x, grid.x0()), cell(p.y, grid.y0()));
            if x >= 0.0 && y >= 0.0 && x < grid.width as f64 && y < grid.height as f64 {
                visit(y as usize * grid.width + x as usize, (pair[0], pair[1]));
            }
        }
    }

    /// The bounds of its x (or its y).
    fn bounds(&self, x: bool) -> (f64, f64) {
        let of = |p: Point| if x { p.x } else { p.y };
        match self {
            SurfacePart::Straight(w) => (of(w.a).min(of(w.b)), of(w.a).max(of(w.b))),
            SurfacePart::Bent { arc, .. } => {
                // a chord is short: no point is farther from its middle than its length
                let (middle, reach) = (of(self.at(0.5)), self.length().min(2.0 * arc.radius));
                (middle - reach, middle + reach)
            }
        }
    }
}

/// PointBuckets in buckets of `reach`.
struct PointBuckets {
    buckets: HashMap<(i64, i64), Vec<Point>>,
    reach: f64,
}

impl PointBuckets {
    fn new(all: Vec<Point>, reach: f64) -> PointBuckets {
        let mut points = PointBuckets { buckets: HashMap::new(), reach };
        for p in all {
            points.buckets.entry(points.key(p)).or_default().push(p);
        }
        points
    }

    fn key(&self, p: Point) -> (i64, i64) {
        ((p.x / self.reach).floor() as i64, (p.y / self.reach).floor() as i64)
    }

    /// The points within reach of a point.
    fn around(&self, p: Point) -> impl Iterator<Item = Point> {
        let (x, y) = self.key(p);
        let keys = (-1..=1).flat_map(move |j| (-1..=1).map(move |i| (x + i, y + j)));
        keys.filter_map(|k| self.buckets.get(&k)).flatten().copied().filter(move |s| distance(s, &p) <= self.reach)
    }
}
