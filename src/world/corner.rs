//! The corners of a world's walls: wherever walls meet, cross or end, one corner or edge for each free sector between
//! neighbouring arms.

use super::index::ShapeIndex;
use super::shape::{Corner, CornerKind, Wall};
use crate::geometry::plane::{Point, Vector, distance_to_segment, intersect_lines, lerp, nearest_parameter, unit};
use nalgebra::distance;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Walls nearer than this meet, metres.
pub(crate) const SAME: f64 = 1e-3;
/// A vertex that turns by less than this, radians, is part of a curve, not a corner.
const STRAIGHT: f64 = 0.035;
/// Cosine of 86°: corners this close to 90° return every sound.
const PERPENDICULAR: f64 = 0.069_756_473_744_125_3;

/// A wall that leaves a vertex: its direction, and which of its sides are free as seen along it.
#[derive(Debug, Clone, Copy)]
struct Arm<'a> {
    direction: Vector,
    angle: f64,
    wall: &'a Wall,
    free_left: bool,
    free_right: bool,
}

/// All corners of the walls, vertex by vertex in the order of the walls.
pub(crate) fn corners(index: &ShapeIndex) -> Vec<Corner> {
    let mut vertices = Vertices::default();
    for (i, wall) in index.walls.iter().enumerate() {
        let reach = distance(&wall.a, &wall.b) / 2.0 + SAME;
        let near = index.within(lerp(wall.a, wall.b, 0.5), reach);
        let others = near.into_iter().map(|k| k as usize).filter(|&k| k > i && k < index.walls.len());
        for k in others {
            if let Some(at) = joint(wall, &index.walls[k]) {
                vertices.add(at, i);
                vertices.add(at, k);
            }
        }
        [wall.a, wall.b].into_iter().for_each(|end| vertices.add(end, i));
    }
    let mut found = Vec::new();
    for (at, walls) in &vertices.all {
        sectors(*at, walls.iter().map(|k| &index.walls[*k]), &mut found);
    }
    found
}

/// The points where walls meet or end, each with its walls; points nearer than [`SAME`] are one.
#[derive(Default)]
struct Vertices {
    all: Vec<(Point, Vec<usize>)>,
    buckets: HashMap<(i64, i64), Vec<usize>>,
}

impl Vertices {
    fn add(&mut self, at: Point, wall: usize) {
        let key = ((at.x / SAME).floor() as i64, (at.y / SAME).floor() as i64);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (key.0 + i, key.1 + j)));
        let known = around.filter_map(|k| self.buckets.get(&k)).flatten();
        match known.copied().find(|v| distance(&self.all[*v].0, &at) < SAME) {
            Some(v) if self.all[v].1.contains(&wall) => {}
            Some(v) => self.all[v].1.push(wall),
            None => {
                self.buckets.entry(key).or_default().push(self.all.len());
                self.all.push((at, vec![wall]));
            }
        }
    }
}

/// Where two walls meet, if they do: their crossing, or the point of one at which the other ends.
fn joint(one: &Wall, two: &Wall) -> Option<Point> {
    let on = |t: f64| (0.0..=1.0).contains(&t);
    if let Some((t, u)) = intersect_lines(one.a, one.b, two.a, two.b)
        && on(t)
        && on(u)
    {
        return Some(lerp(one.a, one.b, t));
    }
    let ends = [(one.a, two), (one.b, two), (two.a, one), (two.b, one)];
    let (end, other) = ends.into_iter().find(|(p, w)| distance_to_segment(*p, w.a, w.b) < SAME)?;
    Some(lerp(other.a, other.b, nearest_parameter(end, other.a, other.b)))
}

/// The corners and edges about a vertex.
fn sectors<'a>(at: Point, walls: impl Iterator<Item = &'a Wall>, found: &mut Vec<Corner>) {
    let mut arms: Vec<Arm<'a>> = Vec::new();
    for wall in walls {
        for (end, to_b) in [(wall.a, false), (wall.b, true)] {
            if distance(&end, &at) > 2.0 * SAME {
                let direction = unit(end - at);
                let angle = direction.y.atan2(direction.x);
                // the free side of a wall is to the left of the direction from a to b
                let (free_left, free_right) = (wall.thin || to_b, wall.thin || !to_b);
                arms.push(Arm { direction, angle, wall, free_left, free_right });
            }
        }
    }
    arms.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    // walls that overlap are one arm, free where all of them are
    let mut merged: Vec<Arm<'a>> = Vec::new();
    for arm in arms {
        let same = |m: &&mut Arm<'_>| {
            m.direction.perp(&arm.direction).abs() < STRAIGHT && m.direction.dot(&arm.direction) > 0.0
        };
        match merged.iter_mut().find(same) {
            Some(m) => (m.free_left, m.free_right) = (m.free_left && arm.free_left, m.free_right && arm.free_right),
            None => merged.push(arm),
        }
    }
    for (k, right) in merged.iter().enumerate() {
        let left = &merged[(k + 1) % merged.len()];
        let angle = if merged.len() == 1 { TAU } else { (left.angle - right.angle).rem_euclid(TAU) };
        if right.free_left && left.free_right && (angle - PI).abs() > STRAIGHT {
            found.push(corner(at, right, left, angle));
        }
    }
}

fn corner(at: Point, right: &Arm<'_>, left: &Arm<'_>, angle: f64) -> Corner {
    let (one, two) = (right.wall.surface.reflection() / 0.95, left.wall.surface.reflection() / 0.95);
    let (kind, gain) = match () {
        () if angle > PI => (CornerKind::Edge, one.min(two)),
        () if angle.cos().abs() <= PERPENDICULAR => (CornerKind::Right, one * two),
        () => (CornerKind::Concave, one * two),
    };
    let class = right.wall.class.or(left.wall.class);
    Corner { at, kind, arms: [right.direction, left.direction], gain, class }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::shape::Surface;

    fn wall(a: (f64, f64), b: (f64, f64), thin: bool) -> Wall {
        let [a, b] = [a, b].map(|(x, y)| Point::new(x, y));
        Wall { a, b, surface: Surface::Specular, class: None, thin }
    }

    /// The kinds found: right-angled, other concave, edges.
    fn kinds(walls: Vec<Wall>) -> [usize; 3] {
        let found = corners(&ShapeIndex::new(walls, Vec::new()));
        [CornerKind::Right, CornerKind::Concave, CornerKind::Edge].map(|k| found.iter().filter(|c| c.kind == k).count())
    }

    fn thin(points: &[(f64, f64)]) -> Vec<Wall> {
        points.windows(2).map(|p| wall(p[0], p[1], true)).collect()
    }

    fn room() -> Vec<Wall> {
        let p = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)];
        (0..4).map(|k| wall(p[k], p[(k + 1) % 4], false)).collect()
    }

    #[test]
    fn by_hand() {
        assert_eq!(kinds(room()), [4, 0, 0]);
        // seen from outside: four edges
        assert_eq!(kinds(room().into_iter().map(|w| Wall { a: w.b, b: w.a, ..w }).collect()), [0, 0, 4]);
        // a thin wall: an edge at either end; bent squarely: a right-angled corner inside, an edge outside
        assert_eq!(kinds(thin(&[(0.0, 0.0), (1.0, 0.0)])), [0, 0, 2]);
        assert_eq!(kinds(thin(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])), [1, 0, 3]);
        assert_eq!(kinds(thin(&[(0.0, 0.0), (1.0, 0.0), (1.5, 1.0)])), [0, 1, 3]);
        // nearly straight: no corner
        assert_eq!(kinds(thin(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.02)])), [0, 0, 2]);
        // a T, and a cross
        let cross = [thin(&[(0.0, 0.0), (2.0, 0.0)]), thin(&[(1.0, -1.0), (1.0, 1.0)])].concat();
        assert_eq!(kinds(cross), [4, 0, 4]);
        assert_eq!(kinds([thin(&[(0.0, 0.0), (2.0, 0.0)]), thin(&[(1.0, 0.0), (1.0, 1.0)])].concat()), [2, 0, 3]);
        // a partition out of a room's corner leaves two sharp ones, none of them square
        assert_eq!(kinds([room(), thin(&[(0.0, 0.0), (1.0, 0.8)])].concat()), [3, 2, 1]);
        // three walls from one point: two of the sectors are concave, one is convex
        assert_eq!(
            kinds([thin(&[(0.0, 0.0), (1.0, 0.0)]), thin(&[(0.7, 0.7), (0.0, 0.0), (-0.5, 1.0)])].concat()),
            [0, 2, 4]
        );
    }

    #[test]
    fn a_box_against_a_wall_whatever_the_hair_between() {
        for gap in [-0.002, -0.000_9, -0.000_5, -1e-9, 0.0, 1e-9, 0.000_5, 0.000_9] {
            let p = [(1.0, gap), (1.0, 1.0), (2.0, 1.0), (2.0, gap)];
            let solid: Vec<Wall> = (0..4).map(|k| wall(p[k], p[(k + 1) % 4], false)).collect();
            let index = ShapeIndex::new([room(), solid].concat(), Vec::new());
            let found = corners(&index);
            let square = found.iter().filter(|c| c.kind == CornerKind::Right);
            let on_floor = square.filter(|c| c.at.y.abs() < 1e-12 && (c.at.x - 1.5).abs() < 0.51);
            assert_eq!(on_floor.count(), 2, "gap {gap}: {found:?}");
        }
    }
}
