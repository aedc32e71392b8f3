//! The true map of a world: what an ideal sensor on the path could know, by exact geometry.
//!
//! A cell with a visible piece of surface in it is occupied (visible from any scan's centre within range); a cell that
//! holds only invisible surface is unknown; else it is empty if its centre is in sight of a scan's centre, within range;
//! else unknown. A surface on the line between two cells belongs to the right or upper one. Which parts of an arc are in
//! sight is asked of chords that leave it by 0.2 mm at most; which cells it passes through, of the arc itself.

use super::World;
use super::index::Index;
use super::shape::{Arc, Wall};
use crate::geometry::plane::{Point, Wedge, along, cut, distance, dot, sub};
use crate::grid::{Class, GridSpec};
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// How far facets leave an arc, metres.
const SAGITTA: f64 = 2e-4;
/// A piece of surface must be longer, metres.
const PIECE: f64 = 1e-7;

/// Shares of a wall, from and to.
type Span = (f64, f64);

/// The true class of each cell: 1 occupied, 0 unknown, −1 empty; row by row from the bottom. `scans` are the robot's
/// places, metres; `r_max` in metres.
pub fn true_map(world: &World, scans: &[Point], grid: &GridSpec, r_max: f64) -> Vec<i8> {
    let mut walls = world.index.walls.clone();
    let mut pieces: Vec<Piece> = world.index.walls.iter().map(Piece::Straight).collect();
    for arc in &world.index.arcs {
        for (wall, from, to) in arc.facets(SAGITTA) {
            walls.push(wall);
            pieces.push(Piece::Bent { arc, from, to });
        }
    }
    let index = Index::new(walls, Vec::new());
    let mut scans = scans.to_vec();
    scans.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    scans.dedup();
    let mut seen: Vec<Vec<Span>> = vec![Vec::new(); index.walls.len()];
    let one: Vec<Vec<(u32, Span)>> = scans.par_iter().map(|s| visible(&index, *s, r_max)).collect();
    for (wall, span) in one.into_iter().flatten() {
        seen[wall as usize].push(span);
    }
    let mut surface: HashMap<usize, bool> = HashMap::new();
    for (piece, spans) in pieces.iter().zip(&mut seen) {
        spans.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = PIECE / piece.length();
        piece.rasterise(grid, &mut |cell, span| {
            let found = spans.iter().any(|s| s.1.min(span.1) - s.0.max(span.0) > least);
            *surface.entry(cell).or_default() |= found;
        });
    }
    let near = Places::new(scans, r_max);
    let class = |k: usize| match surface.get(&k) {
        Some(true) => Class::Occupied,
        Some(false) => Class::Unknown,
        None => {
            let centre = grid.centre(k % grid.width, k / grid.width);
            if near.around(centre).any(|s| world.index.clear(s, centre)) { Class::Empty } else { Class::Unknown }
        }
    };
    (0..grid.cells()).into_par_iter().map(|k| class(k) as i8).collect()
}

/// The parts of the walls that are in sight of a point, within range.
fn visible(index: &Index, from: Point, r_max: f64) -> Vec<(u32, Span)> {
    let near = index.near(from, r_max);
    let walls: Vec<&Wall> = near.iter().map(|k| &index.walls[*k as usize]).collect();
    let mut found = Vec::new();
    for (k, wall) in near.iter().zip(&walls) {
        let Some(reach) = within(from, wall, r_max).filter(|_| wall.faces(from)) else { continue };
        let (a, b) = (along(wall.a, wall.b, reach.0), along(wall.a, wall.b, reach.1));
        let mut shadows: Vec<Span> = Vec::new();
        let wedge = Wedge::over(from, a, b);
        let side = wall.side(from);
        for other in walls.iter().filter(|w| !std::ptr::eq(**w, *wall)) {
            // the part of the other that stands in the triangle from the point to this wall
            let Some(span) = wedge.clip(other.a, other.b) else { continue };
            let e = sub(wall.b, wall.a);
            let front = |p: Point| side * crate::geometry::plane::cross(e, sub(p, wall.a)) - 1e-9;
            let Some(span) = cut(span, front(other.a), front(other.b)) else { continue };
            let shadow = [span.0, span.1].map(|t| shadow_of(from, along(other.a, other.b, t), wall));
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

/// Where the ray from a point through another meets a wall's line, as a share of the wall.
fn shadow_of(from: Point, through: Point, wall: &Wall) -> f64 {
    crate::geometry::plane::meet(from, through, wall.a, wall.b).map_or(f64::NAN, |(_, u)| u)
}

/// The part of a wall within range of a point.
fn within(from: Point, wall: &Wall, r_max: f64) -> Option<Span> {
    let (e, w) = (sub(wall.b, wall.a), sub(wall.a, from));
    let (a, b, c) = (dot(e, e), dot(e, w), dot(w, w) - r_max * r_max);
    // a wall that the range only touches, or less, has no part within it
    let root = Some(b * b - a * c).filter(|d| *d > 0.0)?.sqrt();
    let span = (((-b - root) / a).max(0.0), ((-b + root) / a).min(1.0));
    (span.0 < span.1).then_some(span)
}

/// A piece of surface: a wall, or an arc between two angles from its beginning.
enum Piece<'a> {
    Straight(&'a Wall),
    Bent { arc: &'a Arc, from: f64, to: f64 },
}

impl Piece<'_> {
    /// Metres.
    fn length(&self) -> f64 {
        match self {
            Piece::Straight(w) => distance(w.a, w.b),
            Piece::Bent { arc, from, to } => (to - from).abs() * arc.radius,
        }
    }

    /// The point at a share of it.
    fn at(&self, t: f64) -> Point {
        match self {
            Piece::Straight(w) => along(w.a, w.b, t),
            Piece::Bent { arc, from, to } => arc.at(from + (to - from) * t),
        }
    }

    /// The shares at which its x (or its y) takes a value.
    fn meets(&self, x: bool, value: f64) -> [f64; 2] {
        let of = |p: Point| if x { p.0 } else { p.1 };
        match self {
            Piece::Straight(w) => [(value - of(w.a)) / (of(w.b) - of(w.a)), f64::NAN],
            Piece::Bent { arc, from, to } => {
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

    /// Shows each cell that it passes through, and the share of it in there.
    fn rasterise(&self, grid: &GridSpec, show: &mut dyn FnMut(usize, Span)) {
        let mut cuts = vec![0.0, 1.0];
        for (x, low, cells) in [(true, grid.x0(), grid.width), (false, grid.y0(), grid.height)] {
            let line = |k: i64| low + k as f64 * grid.resolution;
            let (least, most) = self.spans(x);
            // the grid's lines that it may cross
            let column = |v: f64| ((v - low) / grid.resolution).clamp(-1.0, cells as f64 + 1.0);
            let lines = (column(least).ceil() as i64).max(0)..=(column(most).floor() as i64).min(cells as i64);
            let shares = lines.flat_map(|k| self.meets(x, line(k)));
            cuts.extend(shares.filter(|t| *t > 0.0 && *t < 1.0));
        }
        cuts.sort_by(f64::total_cmp);
        let least = PIECE / self.length();
        for pair in cuts.windows(2) {
            if pair[1] - pair[0] <= least {
                continue;
            }
            let p = self.at((pair[0] + pair[1]) / 2.0);
            // a wall on a line of the grid belongs to the cell above it, whichever way its coordinates were rounded
            let cell = |v: f64, low: f64| ((v - low) / grid.resolution + 1e-9).floor();
            let (x, y) = (cell(p.0, grid.x0()), cell(p.1, grid.y0()));
            if x >= 0.0 && y >= 0.0 && x < grid.width as f64 && y < grid.height as f64 {
                show(y as usize * grid.width + x as usize, (pair[0], pair[1]));
            }
        }
    }

    /// Bounds of its x (or its y).
    fn spans(&self, x: bool) -> (f64, f64) {
        let of = |p: Point| if x { p.0 } else { p.1 };
        match self {
            Piece::Straight(w) => (of(w.a).min(of(w.b)), of(w.a).max(of(w.b))),
            Piece::Bent { arc, .. } => {
                // a facet is short: no farther from its middle than its length
                let (middle, reach) = (of(self.at(0.5)), self.length().min(2.0 * arc.radius));
                (middle - reach, middle + reach)
            }
        }
    }
}

/// Places in buckets of `reach`.
struct Places {
    buckets: HashMap<(i64, i64), Vec<Point>>,
    reach: f64,
}

impl Places {
    fn new(all: Vec<Point>, reach: f64) -> Places {
        let mut places = Places { buckets: HashMap::new(), reach };
        for p in all {
            places.buckets.entry(places.key(p)).or_default().push(p);
        }
        places
    }

    fn key(&self, p: Point) -> (i64, i64) {
        ((p.0 / self.reach).floor() as i64, (p.1 / self.reach).floor() as i64)
    }

    /// Those within reach of a point.
    fn around(&self, p: Point) -> impl Iterator<Item = Point> {
        let (x, y) = self.key(p);
        let keys = (-1..=1).flat_map(move |j| (-1..=1).map(move |i| (x + i, y + j)));
        keys.filter_map(|k| self.buckets.get(&k)).flatten().copied().filter(move |s| distance(*s, p) <= self.reach)
    }
}
