//! The physics of one sonar reading: which echoes reach the transducer, by image sources, and which is heard first.
//!
//! A [`Scene`] holds what lies around one place of the robot; its sonars ask it one after the other. Amplitude of an echo
//! from `d` metres: A(d)·e^(−κ(θt² + θr²)/β²)·ρ, A(d) = e^(−0.36 d)/d, θt and θr the angles of departure and arrival off
//! the beam's axis. The shortest echo of at least A(r_max)/1.5 is heard.

use super::cone;
use super::corner::SAME;
use super::index::{Index, TRIM, crossing};
use super::random::Random;
use super::shape::{Arc, Corner, Surface, Wall};
use crate::geometry::plane::{Point, Wedge, add, distance, dot, from_segment, length, meet, mirror, sub, times, unit};

/// How echoes are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Physics {
    /// Events on an echo's way, 1 to 3: one keeps walls, corners, edges and arcs seen directly.
    pub bounces: u8,
    /// Whether walls mirror sound; `false`: every reading is the nearest distance in its cone.
    pub specular: bool,
    /// Deviation of an amplitude's logarithm.
    pub flutter: f64,
}

impl Default for Physics {
    fn default() -> Self {
        Physics { bounces: 3, specular: true, flutter: 0.15 }
    }
}

/// One sonar, ready to ping.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ping {
    pub at: Point,
    /// Unit vector.
    pub axis: Point,
    pub half_width: f64,
    pub r_min: f64,
    pub r_max: f64,
}

/// What was heard: metres, and the class of what sent it back.
pub(crate) type Heard = Option<(f64, Option<u16>)>;

/// An echo that may be heard.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Echo {
    pub d: f64,
    pub amplitude: f64,
    /// Where the sound goes from the transducer.
    pub way: [Point; 3],
    pub events: usize,
    /// Whether it comes back from the last place directly, not the way it went.
    pub round: bool,
    /// Whether the last place is a corner.
    pub corner: bool,
    pub class: Option<u16>,
}

/// A point reflector, seen through a mirror or directly.
#[derive(Debug, Clone, Copy)]
struct Target {
    /// Where it seems to be.
    image: Point,
    /// Where it is.
    corner: Corner,
    /// The mirror, and what it keeps both ways.
    mirror: Option<u32>,
    keeps: f64,
}

/// An arc, seen through a mirror or directly.
#[derive(Debug, Clone, Copy)]
struct Round {
    image: Point,
    arc: Arc,
    mirror: Option<u32>,
    keeps: f64,
}

/// A(d): what spreading and the air leave.
pub(crate) fn loss(d: f64) -> f64 {
    (-0.36 * d).exp() / d
}

/// The most that an amplitude's flutter can add: six deviations.
fn most(flutter: f64) -> f64 {
    (6.0 * flutter).exp()
}

/// What lies around one place of the robot.
#[derive(Debug)]
pub(crate) struct Scene {
    pub physics: Physics,
    pub walls: Vec<Wall>,
    /// How far each wall lies at least from every transducer, metres.
    pub far: Vec<f64>,
    /// Walls that can come after each wall on a sound's way.
    pub next: Vec<Vec<u32>>,
    arcs: Vec<Arc>,
    targets: Vec<Target>,
    rounds: Vec<Round>,
}

impl Scene {
    /// What sonars within `spread` of `centre` may hear from up to `reach` metres.
    pub fn new(index: &Index, corners: &[Corner], centre: Point, spread: f64, reach: f64, physics: Physics) -> Scene {
        let near = index.near(centre, reach + spread);
        let split = near.partition_point(|k| (*k as usize) < index.walls.len());
        let walls: Vec<Wall> = near[..split].iter().map(|k| index.walls[*k as usize]).collect();
        let arcs: Vec<Arc> = near[split..].iter().map(|k| index.arcs[*k as usize - index.walls.len()]).collect();
        let far = walls.iter().map(|w| from_segment(centre, w.a, w.b) - spread).collect();
        let mut scene = Scene { physics, walls, far, next: Vec::new(), arcs, targets: Vec::new(), rounds: Vec::new() };
        if !physics.specular {
            return scene;
        }
        scene.next = super::image::followers(&scene.walls, physics.bounces);
        let least = loss(reach) / 1.5 / most(physics.flutter);
        let within = |image: Point, rho: &dyn Fn(f64) -> f64| {
            let d = (distance(image, centre) - spread).max(0.05);
            d <= reach && loss(d) * rho(d) >= least
        };
        let near: Vec<&Corner> = corners.iter().filter(|c| distance(c.at, centre) <= reach + spread).collect();
        for corner in near {
            if within(corner.at, &|d| corner.reflection(d)) {
                scene.targets.push(Target { image: corner.at, corner: *corner, mirror: None, keeps: 1.0 });
            }
            for (k, wall) in scene.mirrors() {
                let (image, keeps) = (mirror(corner.at, wall.a, wall.b), wall.surface.reflection().powi(2));
                // a corner on the mirror's own line is its own image
                let apart = distance(image, corner.at) > 2.0 * SAME;
                if apart && wall.faces(corner.at) && within(image, &|d| keeps * corner.reflection(d)) {
                    scene.targets.push(Target { image, corner: *corner, mirror: Some(k), keeps });
                }
            }
        }
        for arc in scene.arcs.clone() {
            scene.rounds.push(Round { image: arc.centre, arc, mirror: None, keeps: 1.0 });
            for (k, wall) in scene.mirrors() {
                let (image, keeps) = (mirror(arc.centre, wall.a, wall.b), wall.surface.reflection().powi(2));
                let before = wall.faces(arc.centre) || distance(image, arc.centre) < 2.0 * arc.radius;
                if before && distance(image, centre) <= reach + spread + arc.radius {
                    scene.rounds.push(Round { image, arc, mirror: Some(k), keeps });
                }
            }
        }
        scene
    }

    /// The walls that can mirror a point reflector.
    fn mirrors(&self) -> Vec<(u32, Wall)> {
        if self.physics.bounces < 3 { Vec::new() } else { (0..).zip(self.walls.iter().copied()).collect() }
    }

    /// The first echo that a sonar hears.
    pub fn listen(&self, ping: &Ping, random: &mut Random) -> Heard {
        if !self.physics.specular {
            return cone::nearest(ping, &self.walls, &self.arcs);
        }
        let least = loss(ping.r_max) / 1.5;
        let worth = least / most(self.physics.flutter);
        let mut echoes: Vec<Echo> = Vec::with_capacity(16);
        self.point_echoes(ping, worth, &mut echoes);
        self.arc_echoes(ping, worth, &mut echoes);
        super::image::echoes(self, ping, worth, &mut echoes);
        self.scattered_echoes(ping, least, random, &mut echoes);
        echoes.retain(|e| e.d >= ping.r_min && e.d <= ping.r_max && e.amplitude >= worth);
        echoes.sort_unstable_by(|a, b| a.d.total_cmp(&b.d).then(a.amplitude.total_cmp(&b.amplitude)));
        let heard = echoes.iter().find(|e| {
            let amplitude = e.amplitude * (self.physics.flutter * random.normal()).exp();
            amplitude >= least && self.sees(ping.at, e)
        });
        heard.map(|e| (e.d, e.class))
    }

    /// Whether nothing stands in an echo's way.
    fn sees(&self, at: Point, echo: &Echo) -> bool {
        let way = &echo.way[..echo.events];
        let mut from = at;
        for (k, &to) in way.iter().enumerate() {
            // walls that make a corner may overlap by a hair
            let end = if k + 1 == way.len() && echo.corner { 1.1 * SAME } else { TRIM };
            if !self.clear(from, to, end) {
                return false;
            }
            from = to;
        }
        !echo.round || self.clear(from, at, TRIM)
    }

    /// Whether nothing stands between two points, but for what is within `end` metres of the second.
    fn clear(&self, p: Point, q: Point, end: f64) -> bool {
        let d = sub(q, p);
        let (low, high) = (TRIM / length(d), 1.0 - end / length(d));
        let blocks = |t: f64| t > low && t < high;
        low >= high
            || !(self.walls.iter().any(|w| blocks(crossing(w, p, q)))
                || self.arcs.iter().any(|a| a.meets(p, d).into_iter().any(blocks)))
    }

    fn point_echoes(&self, ping: &Ping, worth: f64, echoes: &mut Vec<Echo>) {
        for target in &self.targets {
            let Some((d, gain)) = ping.towards(target.image) else { continue };
            let amplitude = gain * gain * loss(d) * target.keeps * target.corner.reflection(d);
            if amplitude < worth {
                continue;
            }
            let at = target.corner.at;
            let Some((way, events, seen_from)) = self.through(ping.at, at, target.image, target.mirror) else {
                continue;
            };
            if target.corner.faces(seen_from) {
                let class = target.corner.class;
                echoes.push(Echo { d, amplitude, way, events, round: false, corner: true, class });
            }
        }
    }

    fn arc_echoes(&self, ping: &Ping, worth: f64, echoes: &mut Vec<Echo>) {
        for round in &self.rounds {
            let arc = &round.arc;
            let centre = distance(ping.at, round.image);
            let out = unit(sub(ping.at, round.image));
            let within = centre <= arc.radius;
            if arc.whole() && within != arc.inside {
                continue;
            }
            // the near point, and the far one where the arc is hollow towards the sound or open
            for near in [true, false] {
                if !near && arc.whole() && !within {
                    continue;
                }
                let seems = add(round.image, times(out, if near { arc.radius } else { -arc.radius }));
                let Some((d, gain)) = ping.towards(seems) else { continue };
                let bulges = near && !within;
                let bend = if bulges { (arc.radius / (arc.radius + d)).sqrt() } else { 1.0 };
                let amplitude = gain * gain * loss(d) * round.keeps * bend * arc.surface.reflection() / 0.95;
                if amplitude < worth {
                    continue;
                }
                let at = match round.mirror {
                    None => seems,
                    Some(k) => mirror(seems, self.walls[k as usize].a, self.walls[k as usize].b),
                };
                let Some((way, events, _)) = self.through(ping.at, at, seems, round.mirror) else { continue };
                if arc.spans(sub(at, arc.centre)) {
                    echoes.push(Echo { d, amplitude, way, events, round: false, corner: false, class: arc.class });
                }
            }
        }
    }

    /// Where rough surfaces send sound back: of each the nearest place that is heard, its flutter drawn once.
    fn scattered_echoes(&self, ping: &Ping, least: f64, random: &mut Random, echoes: &mut Vec<Echo>) {
        let walls = self.walls.iter().filter(|w| w.surface == Surface::Diffuse).map(|w| cone::on_wall(ping, w));
        let arcs = self.arcs.iter().filter(|a| a.surface == Surface::Diffuse).map(|a| cone::on_arc(ping, a));
        for mut places in walls.chain(arcs) {
            if places.is_empty() {
                continue;
            }
            let flutter = (self.physics.flutter * random.normal()).exp();
            places.retain(|e| e.d >= ping.r_min && e.amplitude * flutter >= least);
            places.sort_unstable_by(|a, b| a.d.total_cmp(&b.d));
            if let Some(heard) = places.into_iter().find(|e| self.sees(ping.at, e)) {
                // loud enough already: no flutter of the list's own may silence it
                echoes.push(Echo { amplitude: f64::INFINITY, ..heard });
            }
        }
    }

    /// The way to a point that seems to be at `image`, and the place from which it is reached.
    fn through(&self, from: Point, at: Point, image: Point, by: Option<u32>) -> Option<([Point; 3], usize, Point)> {
        let Some(k) = by else { return Some(([at; 3], 1, from)) };
        let wall = &self.walls[k as usize];
        if !wall.faces(from) || wall.side(from) != wall.side(at) {
            return None;
        }
        let (t, u) = meet(from, image, wall.a, wall.b)?;
        if !(0.0..=1.0).contains(&u) || !(0.0..=1.0).contains(&t) {
            return None;
        }
        let bounce = crate::geometry::plane::along(from, image, t);
        Some(([bounce, at, at], 2, bounce))
    }
}

impl Ping {
    /// Distance to a point, and what the beam leaves of the amplitude one way; `None` outside the beam.
    pub fn towards(&self, p: Point) -> Option<(f64, f64)> {
        let v = sub(p, self.at);
        let d = length(v);
        let gain = self.gain(times(v, 1.0 / d))?;
        (d <= self.r_max).then_some((d, gain))
    }

    /// e^(−κθ²/β²) for a unit direction; `None` outside the beam.
    pub fn gain(&self, direction: Point) -> Option<f64> {
        let cosine = dot(direction, self.axis);
        if cosine < 0.4 {
            return None; // beams are no wider than 60°
        }
        let angle = crate::geometry::plane::cross(self.axis, direction).atan2(cosine);
        let share = (angle / self.half_width).powi(2);
        (share <= 1.0).then(|| (-KAPPA * share).exp())
    }

    /// The beam as a wedge.
    pub fn wedge(&self) -> Wedge {
        let (s, c) = self.half_width.sin_cos();
        let (x, y) = self.axis;
        Wedge { apex: self.at, right: (c * x + s * y, c * y - s * x), left: (c * x - s * y, c * y + s * x) }
    }
}

/// κ = ½ ln(A(0.15)/A(5)).
const KAPPA: f64 = 2.626_278_948_659_99;
