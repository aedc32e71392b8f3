//! Finds the corners that walls make: at the joints of an outline or a polyline, at its ends, and where one thing stands
//! against another.

use super::index::Index;
use super::plane::{Point, cross, distance, dot, meet, sub, times, unit};
use super::shape::{Corner, CornerKind, Wall};

/// Points nearer than this are one, metres.
const SAME: f64 = 1e-3;
/// A joint that turns by less than this (sine) is part of a curve.
const STRAIGHT: f64 = 0.035;
/// Cosine of 86°: corners this near to square return every sound.
const SQUARE: f64 = 0.069_756_473_744_125_3;

/// Every corner of the walls, in the walls' order.
pub(crate) fn corners(index: &Index) -> Vec<Corner> {
    let mut found = Vec::new();
    for (i, wall) in index.walls.iter().enumerate() {
        let others: Vec<usize> = {
            let middle = times((wall.a.0 + wall.b.0, wall.a.1 + wall.b.1), 0.5);
            let reach = distance(wall.a, wall.b) / 2.0 + SAME;
            index
                .near(middle, reach)
                .into_iter()
                .map(|k| k as usize)
                .filter(|&k| k != i && k < index.walls.len())
                .collect()
        };
        for &k in others.iter().filter(|&&k| k > i) {
            if let Some(at) = touch(wall, &index.walls[k]) {
                wedges(at, wall, &index.walls[k], &mut found);
            }
        }
        for (end, other) in [(wall.a, wall.b), (wall.b, wall.a)] {
            // an edge where nothing goes on, or where one other wall turns away; the first of the two walls lists it
            let here: Vec<usize> = others.iter().copied().filter(|&k| touches(end, &index.walls[k])).collect();
            let arm = unit(sub(other, end));
            match here[..] {
                [] => found.push(edge(end, [arm, arm], wall, wall)),
                [k] if k > i => {
                    let next = &index.walls[k];
                    let far = if distance(next.a, end) < SAME {
                        next.b
                    } else if distance(next.b, end) < SAME {
                        next.a
                    } else {
                        continue;
                    };
                    let second = unit(sub(far, end));
                    let middle = (arm.0 + second.0, arm.1 + second.1);
                    // solid between the arms, or thin walls: the outer side is convex
                    let bulges = !wall.faces((end.0 + SAME * middle.0, end.1 + SAME * middle.1)) || wall.thin;
                    if bulges && cross(arm, second).abs() > STRAIGHT {
                        found.push(edge(end, [arm, second], wall, next));
                    }
                }
                _ => {}
            }
        }
    }
    found
}

fn edge(at: Point, arms: [Point; 2], one: &Wall, two: &Wall) -> Corner {
    let keeps = one.surface.reflection().min(two.surface.reflection()) / 0.95;
    Corner { at, kind: CornerKind::Edge, arms, keeps, class: one.class.or(two.class) }
}

fn touches(p: Point, wall: &Wall) -> bool {
    super::plane::from_segment(p, wall.a, wall.b) < SAME
}

/// Where two walls meet, if they do.
fn touch(one: &Wall, two: &Wall) -> Option<Point> {
    for (p, other) in [(one.a, two), (one.b, two), (two.a, one), (two.b, one)] {
        if touches(p, other) {
            return Some(p);
        }
    }
    let (t, u) = meet(one.a, one.b, two.a, two.b)?;
    let on = |t: f64| (0.0..=1.0).contains(&t);
    (on(t) && on(u)).then(|| super::plane::along(one.a, one.b, t))
}

/// The concave corners at `at`: an arm of each wall, with the free side of both between them.
fn wedges(at: Point, one: &Wall, two: &Wall, found: &mut Vec<Corner>) {
    let arms = |w: &Wall| {
        [w.a, w.b].into_iter().filter(|e| distance(*e, at) > 2.0 * SAME).map(|e| unit(sub(e, at))).collect::<Vec<_>>()
    };
    for u in arms(one) {
        for v in arms(two) {
            let turn = cross(u, v);
            if turn.abs() < STRAIGHT {
                continue;
            }
            let middle = unit((u.0 + v.0, u.1 + v.1));
            let inside = (at.0 + SAME * middle.0, at.1 + SAME * middle.1);
            if !one.faces(inside) || !two.faces(inside) {
                continue;
            }
            let square = dot(u, v).abs() <= SQUARE;
            let both = one.surface.reflection() * two.surface.reflection() / (0.95 * 0.95);
            found.push(Corner {
                at,
                kind: if square { CornerKind::Right } else { CornerKind::Concave },
                arms: if turn > 0.0 { [u, v] } else { [v, u] },
                keeps: both,
                class: one.class.or(two.class),
            });
        }
    }
}
