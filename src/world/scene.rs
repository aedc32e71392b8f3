//! The surroundings of one position of the robot, as its sonars hear them: image sources of walls, corners and arcs, and
//! which echo is detected. The shortest echo of at least A(r_max)/1.5 is.

use super::cone;
use super::corner::SAME;
use super::image::Mirrors;
use super::index::{ShapeIndex, TRIM, crossing};
use super::random::Random;
use super::shape::{Arc, Corner, Surface, Wall};
use super::sonar::{Beam, Detection, Echo, Physics, attenuation};
use crate::geometry::plane::{Point, intersect_lines, lerp, reflect, unit};
use nalgebra::distance;

/// A corner, seen in a mirror or directly.
#[derive(Debug, Clone, Copy)]
struct CornerImage {
    /// Its apparent position.
    image: Point,
    corner: Corner,
    /// The wall that mirrors it.
    mirror: Option<u32>,
    /// What the mirror leaves of the amplitude, there and back.
    gain: f64,
}

/// An arc, seen in a mirror or directly.
#[derive(Debug, Clone, Copy)]
struct ArcImage {
    /// The apparent position of its centre.
    image: Point,
    arc: Arc,
    /// The wall that mirrors it.
    mirror: Option<u32>,
    /// What the mirror leaves of the amplitude, there and back.
    gain: f64,
}

/// The most that flutter adds to an amplitude, as a factor: six standard deviations.
fn largest_flutter(flutter: f64) -> f64 {
    (6.0 * flutter).exp()
}

/// Where the robot's sonars are, and how far they hear. World frame, metres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Listener {
    /// The robot.
    pub centre: Point,
    /// The farthest transducer from `centre`.
    pub spread: f64,
    /// The farthest range of a transducer.
    pub reach: f64,
}

/// What a path to a point looks like: its reflections, how many, and the position from which the point is reached.
type Approach = ([Point; 3], usize, Point);

/// What surrounds one position of the robot.
#[derive(Debug)]
pub(crate) struct Scene {
    physics: Physics,
    mirrors: Mirrors,
    arcs: Vec<Arc>,
    corner_images: Vec<CornerImage>,
    arc_images: Vec<ArcImage>,
}

impl Scene {
    /// What a listener may hear; `corners` are those of the world, or enough of them.
    pub fn new(index: &ShapeIndex, corners: &[Corner], listener: Listener, physics: Physics) -> Scene {
        let Listener { centre, spread, reach } = listener;
        let near = index.within(centre, reach + spread);
        let split = near.partition_point(|k| (*k as usize) < index.walls.len());
        let walls: Vec<Wall> = near[..split].iter().map(|k| index.walls[*k as usize]).collect();
        let arcs: Vec<Arc> = near[split..].iter().map(|k| index.arcs[*k as usize - index.walls.len()]).collect();
        let bounces = if physics.specular { physics.bounces } else { 0 };
        let mirrors = Mirrors::new(walls, centre, spread, bounces);
        let mut scene = Scene { physics, mirrors, arcs, corner_images: Vec::new(), arc_images: Vec::new() };
        if physics.specular {
            scene.add_corner_images(corners, listener);
            scene.add_arc_images(listener);
        }
        scene
    }

    fn add_corner_images(&mut self, corners: &[Corner], Listener { centre, spread, reach }: Listener) {
        let least = attenuation(reach) / 1.5 / largest_flutter(self.physics.flutter);
        let audible = |image: Point, reflection: &dyn Fn(f64) -> f64| {
            let d = (distance(&image, &centre) - spread).max(0.05);
            d <= reach && attenuation(d) * reflection(d) >= least
        };
        for corner in corners.iter().filter(|c| distance(&c.at, &centre) <= reach + spread) {
            if audible(corner.at, &|d| corner.reflection(d)) {
                self.corner_images.push(CornerImage { image: corner.at, corner: *corner, mirror: None, gain: 1.0 });
            }
            for (k, wall) in self.point_mirrors() {
                let (image, gain) = (reflect(corner.at, wall.a, wall.b), wall.surface.reflection().powi(2));
                // a corner on the mirror's own line is its own image
                let apart = distance(&image, &corner.at) > 2.0 * SAME;
                if apart && wall.faces(corner.at) && audible(image, &|d| gain * corner.reflection(d)) {
                    self.corner_images.push(CornerImage { image, corner: *corner, mirror: Some(k), gain });
                }
            }
        }
    }

    fn add_arc_images(&mut self, Listener { centre, spread, reach }: Listener) {
        for arc in self.arcs.clone() {
            self.arc_images.push(ArcImage { image: arc.centre, arc, mirror: None, gain: 1.0 });
            for (k, wall) in self.point_mirrors() {
                let (image, gain) = (reflect(arc.centre, wall.a, wall.b), wall.surface.reflection().powi(2));
                let before = wall.faces(arc.centre) || distance(&image, &arc.centre) < 2.0 * arc.radius;
                if before && distance(&image, &centre) <= reach + spread + arc.radius {
                    self.arc_images.push(ArcImage { image, arc, mirror: Some(k), gain });
                }
            }
        }
    }

    /// The walls that can mirror corners and arcs: such an echo has three reflections.
    fn point_mirrors(&self) -> Vec<(u32, Wall)> {
        if self.physics.bounces < 3 { Vec::new() } else { (0..).zip(self.mirrors.walls.iter().copied()).collect() }
    }

    /// The first echo that a sonar detects.
    pub fn detect(&self, beam: &Beam, random: &mut Random) -> Option<Detection> {
        if !self.physics.specular {
            return cone::nearest_surface(beam, &self.mirrors.walls, &self.arcs);
        }
        let threshold = attenuation(beam.r_max) / 1.5;
        // what is fainter is not detected whatever its flutter
        let faintest = threshold / largest_flutter(self.physics.flutter);
        let mut echoes: Vec<Echo> = Vec::with_capacity(16);
        self.corner_echoes(beam, faintest, &mut echoes);
        self.arc_echoes(beam, faintest, &mut echoes);
        self.mirrors.echoes(beam, faintest, &mut echoes);
        self.scattered_echoes(beam, threshold, random, &mut echoes);
        echoes.retain(|e| e.distance >= beam.r_min && e.distance <= beam.r_max && e.amplitude >= faintest);
        echoes.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.amplitude.total_cmp(&b.amplitude)));
        let first = echoes.iter().find(|e| {
            let amplitude = e.amplitude * (self.physics.flutter * random.normal()).exp();
            amplitude >= threshold && self.unobstructed(beam.origin, e)
        });
        first.map(|e| Detection { distance: e.distance, class: e.class })
    }

    /// Whether nothing obstructs the path of an echo.
    fn unobstructed(&self, origin: Point, echo: &Echo) -> bool {
        let path = &echo.path[..echo.reflections];
        let mut from = origin;
        for (k, &to) in path.iter().enumerate() {
            // walls that form a corner may overlap slightly
            let end = if k + 1 == path.len() && echo.from_corner { 1.1 * SAME } else { TRIM };
            if !self.clear(from, to, end) {
                return false;
            }
            from = to;
        }
        !echo.closed || self.clear(from, origin, TRIM)
    }

    /// Whether nothing lies between two points, except within `end` metres of the second.
    fn clear(&self, p: Point, q: Point, end: f64) -> bool {
        let d = q - p;
        let (low, high) = (TRIM / d.norm(), 1.0 - end / d.norm());
        let blocks = |t: f64| t > low && t < high;
        low >= high
            || !(self.mirrors.walls.iter().any(|w| blocks(crossing(w, p, q)))
                || self.arcs.iter().any(|a| a.intersections(p, d).into_iter().any(blocks)))
    }

    fn corner_echoes(&self, beam: &Beam, faintest: f64, echoes: &mut Vec<Echo>) {
        for seen in &self.corner_images {
            let Some((distance, gain)) = beam.towards(seen.image) else { continue };
            let amplitude = gain * gain * attenuation(distance) * seen.gain * seen.corner.reflection(distance);
            if amplitude < faintest {
                continue;
            }
            let approach = self.approach(beam.origin, seen.corner.at, seen.image, seen.mirror);
            let Some((path, reflections, seen_from)) = approach else { continue };
            if seen.corner.faces(seen_from) {
                let class = seen.corner.class;
                echoes.push(Echo { distance, amplitude, path, reflections, closed: false, from_corner: true, class });
            }
        }
    }

    fn arc_echoes(&self, beam: &Beam, faintest: f64, echoes: &mut Vec<Echo>) {
        for seen in &self.arc_images {
            let arc = &seen.arc;
            let to_centre = distance(&beam.origin, &seen.image);
            let outward = unit(beam.origin - seen.image);
            let within = to_centre <= arc.radius;
            if arc.is_circle() && within != arc.inside {
                continue;
            }
            // the near point, and the far one where the arc is concave towards the beam or open
            for near in [true, false] {
                if !near && arc.is_circle() && !within {
                    continue;
                }
                let apparent = seen.image + outward * if near { arc.radius } else { -arc.radius };
                let Some((distance, gain)) = beam.towards(apparent) else { continue };
                let convex = near && !within;
                let spread = if convex { (arc.radius / (arc.radius + distance)).sqrt() } else { 1.0 };
                let amplitude =
                    gain * gain * attenuation(distance) * seen.gain * spread * arc.surface.reflection() / 0.95;
                if amplitude < faintest {
                    continue;
                }
                let at = match seen.mirror {
                    None => apparent,
                    Some(k) => {
                        let wall = &self.mirrors.walls[k as usize];
                        reflect(apparent, wall.a, wall.b)
                    }
                };
                let approach = self.approach(beam.origin, at, apparent, seen.mirror);
                let Some((path, reflections, _)) = approach else { continue };
                if arc.spans(at - arc.centre) {
                    let class = arc.class;
                    let (closed, from_corner) = (false, false);
                    echoes.push(Echo { distance, amplitude, path, reflections, closed, from_corner, class });
                }
            }
        }
    }

    /// The echoes that rough surfaces scatter: of each surface the nearest one that is detected, its flutter drawn once.
    fn scattered_echoes(&self, beam: &Beam, threshold: f64, random: &mut Random, echoes: &mut Vec<Echo>) {
        let rough_walls = self.mirrors.walls.iter().filter(|w| w.surface == Surface::Diffuse);
        let rough_arcs = self.arcs.iter().filter(|a| a.surface == Surface::Diffuse);
        let by_walls = rough_walls.map(|w| cone::scattered_by_wall(beam, w));
        let by_arcs = rough_arcs.map(|a| cone::scattered_by_arc(beam, a));
        for mut samples in by_walls.chain(by_arcs) {
            if samples.is_empty() {
                continue;
            }
            let flutter = (self.physics.flutter * random.normal()).exp();
            samples.retain(|e| e.distance >= beam.r_min && e.amplitude * flutter >= threshold);
            samples.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance));
            if let Some(detected) = samples.into_iter().find(|e| self.unobstructed(beam.origin, e)) {
                // its flutter is drawn already: that of the whole list must not silence it
                echoes.push(Echo { amplitude: f64::INFINITY, ..detected });
            }
        }
    }

    /// The path to a point whose apparent position is `image`, by way of the wall `mirror`; `None` if there is none.
    fn approach(&self, from: Point, at: Point, image: Point, mirror: Option<u32>) -> Option<Approach> {
        let Some(k) = mirror else { return Some(([at; 3], 1, from)) };
        let wall = &self.mirrors.walls[k as usize];
        if !wall.faces(from) || wall.side(from) != wall.side(at) {
            return None;
        }
        let (t, u) = intersect_lines(from, image, wall.a, wall.b)?;
        if !(0.0..=1.0).contains(&u) || !(0.0..=1.0).contains(&t) {
            return None;
        }
        let bounce = lerp(from, image, t);
        Some(([bounce, at, at], 2, bounce))
    }
}
