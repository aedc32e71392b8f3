//! Echoes off one, two and three walls in turn, by the image method: the transducer is mirrored in one wall after the
//! other, and each wall is clipped to the part that the beam reaches through the walls before it.

use super::shape::Wall;
use super::sonar::{Beam, Echo, attenuation};
use crate::geometry::plane::{
    Point, Wedge, clip_to_non_negative, distance_to_segment, intersect_lines, lerp, reflect, unit,
};
use nalgebra::distance;

/// Cosine of 86°: two walls this close to perpendicular form a point reflector, which is a corner.
const PERPENDICULAR: f64 = 0.069_756_473_744_125_3;

/// The walls around a position of the robot, as mirrors of sound.
#[derive(Debug)]
pub(crate) struct Mirrors {
    pub walls: Vec<Wall>,
    /// Lower bound of the distance from each wall to every transducer, metres.
    clearances: Vec<f64>,
    /// The walls that an echo can reach from each wall.
    successors: Vec<Vec<u32>>,
    /// Most reflections of an echo.
    bounces: usize,
}

/// A chain of reflections under construction.
struct Trace<'a> {
    mirrors: &'a Mirrors,
    beam: &'a Beam,
    /// Fainter echoes are left out.
    threshold: f64,
    echoes: &'a mut Vec<Echo>,
    walls: [u32; 3],
    images: [Point; 3],
}

/// How far a chain of reflections has come.
struct Step<'a> {
    /// Number of walls before this one.
    depth: usize,
    /// The image of the transducer in the walls so far.
    source: Point,
    /// What the source illuminates.
    wedge: Wedge,
    /// The last wall, and the side of it on which the next one lies.
    behind: Option<(&'a Wall, f64)>,
    /// The product of the walls' reflection coefficients so far.
    reflection: f64,
}

impl Mirrors {
    /// The mirrors for sonars within `spread` metres of `centre`; `bounces` is the most reflections of an echo, and 0 where
    /// walls don't reflect.
    pub fn new(walls: Vec<Wall>, centre: Point, spread: f64, bounces: u8) -> Mirrors {
        let clearances = walls.iter().map(|w| distance_to_segment(centre, w.a, w.b) - spread).collect();
        let successors = if bounces < 2 {
            vec![Vec::new(); walls.len()]
        } else {
            let after = |one: &Wall| {
                let sees = |(_, two): &(u32, &Wall)| partly_in_front(one, two) && partly_in_front(two, one);
                (0..).zip(&walls).filter(sees).map(|(k, _)| k).collect()
            };
            walls.iter().map(after).collect()
        };
        Mirrors { walls, clearances, successors, bounces: usize::from(bounces) }
    }

    /// Adds every echo off walls alone that is no fainter than `threshold`.
    pub fn echoes(&self, beam: &Beam, threshold: f64, echoes: &mut Vec<Echo>) {
        let mut trace = Trace { mirrors: self, beam, threshold, echoes, walls: [0; 3], images: [beam.origin; 3] };
        for (k, wall) in (0..).zip(&self.walls) {
            if self.clearances[k as usize] <= beam.r_max && wall.faces(beam.origin) {
                let reflection = wall.surface.reflection();
                let wedge = beam.wedge();
                trace.extend(k, &Step { depth: 0, source: beam.origin, wedge, behind: None, reflection });
            }
        }
    }
}

/// Whether a part of wall `two` lies on a free side of wall `one`.
fn partly_in_front(one: &Wall, two: &Wall) -> bool {
    let e = one.b - one.a;
    let scale = 1e-9 * e.dot(&e);
    let beyond = |p: Point| {
        let c = e.perp(&(p - one.a));
        c > scale || (one.thin && c < -scale)
    };
    beyond(two.a) || beyond(two.b)
}

impl Trace<'_> {
    /// Adds wall `k` to the chain, and every echo that follows.
    fn extend(&mut self, k: u32, step: &Step<'_>) {
        let mirrors = self.mirrors;
        let wall = &mirrors.walls[k as usize];
        let Some(mut interval) = step.wedge.clip(wall.a, wall.b) else { return };
        if let Some((mirror, side)) = step.behind {
            let e = mirror.b - mirror.a;
            let at = |p: Point| side * e.perp(&(p - mirror.a));
            let Some(rest) = clip_to_non_negative(interval, at(wall.a), at(wall.b)) else { return };
            interval = rest;
        }
        let (a, b) = (lerp(wall.a, wall.b, interval.0), lerp(wall.a, wall.b, interval.1));
        if distance_to_segment(step.source, a, b) + mirrors.clearances[k as usize] > 2.0 * self.beam.r_max {
            return;
        }
        let image = reflect(step.source, wall.a, wall.b);
        self.walls[step.depth] = k;
        self.images[step.depth] = image;
        self.finish(step.depth + 1, step.reflection);
        if step.depth + 1 >= mirrors.bounces {
            return;
        }
        // seen from after this reflection the source is at `image`, and the next wall lies on the source's side
        let (wedge, side) = (Wedge::spanning(image, a, b), wall.side(step.source));
        for &next in &mirrors.successors[k as usize] {
            let follower = &mirrors.walls[next as usize];
            if follower.faces(image) {
                let reflection = step.reflection * follower.surface.reflection();
                let behind = Some((wall, side));
                self.extend(next, &Step { depth: step.depth + 1, source: image, wedge, behind, reflection });
            }
        }
    }

    /// Adds the echo off the first `n` walls, if its path closes.
    fn finish(&mut self, n: usize, reflection: f64) {
        let (walls, origin) = (&self.walls[..n], self.beam.origin);
        // a path and its reverse are one echo
        if n > 1 && walls[0] > walls[n - 1] {
            return;
        }
        let image = self.images[n - 1];
        let d = distance(&image, &origin) / 2.0;
        if d > self.beam.r_max || d <= 0.0 {
            return;
        }
        let Some(arrival) = self.beam.gain((image - origin) * (0.5 / d)) else { return };
        let wall = |k: u32| &self.mirrors.walls[k as usize];
        if n == 2 {
            let along = |k: u32| unit(wall(k).b - wall(k).a);
            if along(walls[0]).dot(&along(walls[1])).abs() <= PERPENDICULAR {
                return;
            }
        }
        // backwards from the transducer: each reflection lies on the line to the image before it
        let mut path = [origin; 3];
        let mut from = origin;
        for k in (0..n).rev() {
            let wall = wall(walls[k]);
            let Some((t, u)) = intersect_lines(from, self.images[k], wall.a, wall.b) else { return };
            if !(0.0..=1.0).contains(&u) || !(1e-9..=1.0).contains(&t) {
                return;
            }
            from = lerp(from, self.images[k], t);
            path[k] = from;
        }
        let Some(departure) = self.beam.gain(unit(path[0] - origin)) else { return };
        let amplitude = arrival * departure * attenuation(d) * reflection;
        if amplitude >= self.threshold {
            let class = wall(walls[0]).class;
            self.echoes.push(Echo {
                distance: d,
                amplitude,
                path,
                reflections: n,
                closed: n > 1,
                from_corner: false,
                class,
            });
        }
    }
}
