//! Finds the corners that walls make: wherever walls meet, cross or end, one corner or edge for each free sector between
//! neighbouring arms.

use super::index::Index;
use super::shape::{Corner, CornerKind, Wall};
use crate::geometry::plane::{Point, along, cross, distance, dot, from_segment, meet, nearest_share, sub, unit};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Walls nearer than this join, metres.
pub(crate) const SAME: f64 = 1e-3;
/// A joint that turns by less than this, radians, is part of a curve.
const STRAIGHT: f64 = 0.035;
/// Cosine of 86°: corners this near to square return every sound.
const SQUARE: f64 = 0.069_756_473_744_125_3;

/// A wall's way from a vertex: its direction, and which of its sides are free as seen along it.
#[derive(Debug, Clone, Copy)]
struct Arm<'a> {
    direction: Point,
    angle: f64,
    wall: &'a Wall,
    free_left: bool,
    free_right: bool,
}

/// Every corner of the walls, vertex by vertex in the walls' order.
pub(crate) fn corners(index: &Index) -> Vec<Corner> {
    let mut vertices = Vertices::default();
    for (i, wall) in index.walls.iter().enumerate() {
        let reach = distance(wall.a, wall.b) / 2.0 + SAME;
        let near = index.near(along(wall.a, wall.b, 0.5), reach);
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

/// Places where walls join or end, each with its walls; places nearer than [`SAME`] are one.
#[derive(Default)]
struct Vertices {
    all: Vec<(Point, Vec<usize>)>,
    buckets: HashMap<(i64, i64), Vec<usize>>,
}

impl Vertices {
    fn add(&mut self, at: Point, wall: usize) {
        let key = ((at.0 / SAME).floor() as i64, (at.1 / SAME).floor() as i64);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (key.0 + i, key.1 + j)));
        let known = around.filter_map(|k| self.buckets.get(&k)).flatten();
        match known.copied().find(|v| distance(self.all[*v].0, at) < SAME) {
            Some(v) if self.all[v].1.contains(&wall) => {}
            Some(v) => self.all[v].1.push(wall),
            None => {
                self.buckets.entry(key).or_default().push(self.all.len());
                self.all.push((at, vec![wall]));
            }
        }
    }
}

/// Where two walls meet, if they do: where they cross, else on one where the other ends before it.
fn joint(one: &Wall, two: &Wall) -> Option<Point> {
    let on = |t: f64| (0.0..=1.0).contains(&t);
    if let Some((t, u)) = meet(one.a, one.b, two.a, two.b)
        && on(t)
        && on(u)
    {
        return Some(along(one.a, one.b, t));
    }
    let ends = [(one.a, two), (one.b, two), (two.a, one), (two.b, one)];
    let (end, other) = ends.into_iter().find(|(p, w)| from_segment(*p, w.a, w.b) < SAME)?;
    Some(along(other.a, other.b, nearest_share(end, other.a, other.b)))
}

/// The corners and edges about a vertex.
fn sectors<'a>(at: Point, walls: impl Iterator<Item = &'a Wall>, found: &mut Vec<Corner>) {
    let mut arms: Vec<Arm<'a>> = Vec::new();
    for wall in walls {
        for (end, to_b) in [(wall.a, false), (wall.b, true)] {
            if distance(end, at) > 2.0 * SAME {
                let direction = unit(sub(end, at));
                let angle = direction.1.atan2(direction.0);
                // a wall's free side is to the left of the way to b
                let (free_left, free_right) = (wall.thin || to_b, wall.thin || !to_b);
                arms.push(Arm { direction, angle, wall, free_left, free_right });
            }
        }
    }
    arms.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    // walls that lie on one another are one arm, free where all of them are
    let mut merged: Vec<Arm<'a>> = Vec::new();
    for arm in arms {
        let same = |m: &&mut Arm<'_>| {
            cross(m.direction, arm.direction).abs() < STRAIGHT && dot(m.direction, arm.direction) > 0.0
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
    let (kind, keeps) = match () {
        () if angle > PI => (CornerKind::Edge, one.min(two)),
        () if angle.cos().abs() <= SQUARE => (CornerKind::Right, one * two),
        () => (CornerKind::Concave, one * two),
    };
    let class = right.wall.class.or(left.wall.class);
    Corner { at, kind, arms: [right.direction, left.direction], keeps, class }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::shape::Surface;

    fn wall(a: Point, b: Point, thin: bool) -> Wall {
        Wall { a, b, surface: Surface::Specular, class: None, thin }
    }

    /// The kinds found: right-angled, other concave, edges.
    fn kinds(walls: Vec<Wall>) -> [usize; 3] {
        let found = corners(&Index::new(walls, Vec::new()));
        [CornerKind::Right, CornerKind::Concave, CornerKind::Edge].map(|k| found.iter().filter(|c| c.kind == k).count())
    }

    fn thin(points: &[Point]) -> Vec<Wall> {
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
        assert_eq!(kinds(room().into_iter().map(|w| wall(w.b, w.a, false)).collect()), [0, 0, 4]);
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
            let index = Index::new([room(), solid].concat(), Vec::new());
            let found = corners(&index);
            let square = found.iter().filter(|c| c.kind == CornerKind::Right);
            let on_floor = square.filter(|c| c.at.1.abs() < 1e-12 && (c.at.0 - 1.5).abs() < 0.51);
            assert_eq!(on_floor.count(), 2, "gap {gap}: {found:?}");
        }
    }
}
