//! Echoes off one, two and three walls in turn: repeated images of the transducer, each wall clipped to what the beam can
//! reach through the walls before it.

use super::echo::{Echo, Ping, Scene, loss};
use super::shape::Wall;
use crate::geometry::plane::{
    Point, Wedge, along, cross, cut, distance, dot, from_segment, meet, mirror, sub, times, unit,
};

/// Cosine of 86°: two walls this near to square make a point reflector, not an image.
const SQUARE: f64 = 0.069_756_473_744_125_3;

/// For each wall, those that sound can reach next: each lies, in part, on the other's free side.
pub(crate) fn followers(walls: &[Wall], bounces: u8) -> Vec<Vec<u32>> {
    let sees = |one: &Wall, two: &Wall| {
        let e = sub(one.b, one.a);
        let scale = 1e-9 * dot(e, e);
        let beyond = |p: Point| {
            let c = cross(e, sub(p, one.a));
            c > scale || (one.thin && c < -scale)
        };
        beyond(two.a) || beyond(two.b)
    };
    let after =
        |one: &Wall| (0..).zip(walls).filter(|(_, two)| sees(one, two) && sees(two, one)).map(|(k, _)| k).collect();
    if bounces < 2 { vec![Vec::new(); walls.len()] } else { walls.iter().map(after).collect() }
}

/// A way under construction.
struct Trace<'a> {
    scene: &'a Scene,
    ping: &'a Ping,
    worth: f64,
    echoes: &'a mut Vec<Echo>,
    walls: [u32; 3],
    images: [Point; 3],
}

/// Adds every echo off walls alone.
pub(crate) fn echoes(scene: &Scene, ping: &Ping, worth: f64, echoes: &mut Vec<Echo>) {
    let beam = ping.wedge();
    let mut trace = Trace { scene, ping, worth, echoes, walls: [0; 3], images: [ping.at; 3] };
    for (k, wall) in (0..).zip(&scene.walls) {
        if scene.far[k as usize] <= ping.r_max && wall.faces(ping.at) {
            trace.extend(0, k, ping.at, &beam, None, wall.surface.reflection());
        }
    }
}

impl Trace<'_> {
    /// Adds wall `k` as event `n` of a way whose last image is `source`, through `wedge` and in front of `behind`.
    fn extend(&mut self, n: usize, k: u32, source: Point, wedge: &Wedge, behind: Option<(&Wall, f64)>, rho: f64) {
        let scene = self.scene;
        let wall = &scene.walls[k as usize];
        let Some(mut span) = wedge.clip(wall.a, wall.b) else { return };
        if let Some((mirror, side)) = behind {
            let e = sub(mirror.b, mirror.a);
            let at = |p: Point| side * cross(e, sub(p, mirror.a));
            let Some(rest) = cut(span, at(wall.a), at(wall.b)) else { return };
            span = rest;
        }
        let (a, b) = (along(wall.a, wall.b, span.0), along(wall.a, wall.b, span.1));
        if from_segment(source, a, b) + scene.far[k as usize] > 2.0 * self.ping.r_max {
            return;
        }
        let image = mirror(source, wall.a, wall.b);
        self.walls[n] = k;
        self.images[n] = image;
        self.finish(n + 1, rho);
        if n + 1 >= usize::from(scene.physics.bounces) {
            return;
        }
        // in the frame of this event the source seems to be at `image`, and what follows lies on the source's side
        let (through, side) = (Wedge::over(image, a, b), wall.side(source));
        for &next in &scene.next[k as usize] {
            let follower = &scene.walls[next as usize];
            if follower.faces(image) {
                let rho = rho * follower.surface.reflection();
                self.extend(n + 1, next, image, &through, Some((wall, side)), rho);
            }
        }
    }

    /// The echo off the first `n` walls, if its way closes.
    fn finish(&mut self, n: usize, rho: f64) {
        let (walls, at) = (&self.walls[..n], self.ping.at);
        // a way and its reverse are one echo
        if n > 1 && walls[0] > walls[n - 1] {
            return;
        }
        let image = self.images[n - 1];
        let d = distance(image, at) / 2.0;
        if d > self.ping.r_max || d <= 0.0 {
            return;
        }
        let Some(arrives) = self.ping.gain(times(sub(image, at), 0.5 / d)) else { return };
        let wall = |k: u32| &self.scene.walls[k as usize];
        if n == 2 {
            let run = |k: u32| unit(sub(wall(k).b, wall(k).a));
            if dot(run(walls[0]), run(walls[1])).abs() <= SQUARE {
                return;
            }
        }
        // backwards from the transducer: each bounce lies on the way to the image before it
        let mut way = [at; 3];
        let mut from = at;
        for k in (0..n).rev() {
            let wall = wall(walls[k]);
            let Some((t, u)) = meet(from, self.images[k], wall.a, wall.b) else { return };
            if !(0.0..=1.0).contains(&u) || !(1e-9..=1.0).contains(&t) {
                return;
            }
            from = along(from, self.images[k], t);
            way[k] = from;
        }
        let Some(departs) = self.ping.gain(unit(sub(way[0], at))) else { return };
        let amplitude = arrives * departs * loss(d) * rho;
        if amplitude >= self.worth {
            let class = wall(walls[0]).class;
            self.echoes.push(Echo { d, amplitude, way, events: n, round: n > 1, corner: false, class });
        }
    }
}
