//! The shapes of a world: walls, arcs and the corners that they form, each with a surface and perhaps a class.

use crate::geometry::plane::{Point, Vector};
use nalgebra::distance;
use std::f64::consts::TAU;

/// How a surface reflects sound and light. `docs/worlds.md` has the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surface {
    /// Sound is reflected as by a mirror: an echo returns along the normal only. Light scatters.
    Specular,
    /// Rough: sound returns from everywhere in the beam, weaker.
    Diffuse,
    /// A mirror to sound; light passes through unless it arrives within 10° of the normal.
    Glass,
    /// Soft: a weak mirror to sound.
    Absorbing,
}

/// The surfaces by their names in a world's file.
pub(crate) const SURFACES: [(&str, Surface); 4] = [
    ("specular", Surface::Specular),
    ("diffuse", Surface::Diffuse),
    ("glass", Surface::Glass),
    ("absorbing", Surface::Absorbing),
];

impl Surface {
    /// The reflection coefficient: what a mirror image keeps of a sound's amplitude.
    pub fn reflection(self) -> f64 {
        match self {
            Surface::Specular | Surface::Glass => 0.95,
            Surface::Diffuse => 0.3,
            Surface::Absorbing => 0.2,
        }
    }
}

/// A straight wall from `a` to `b`, metres. Its free side is to the left of the direction from `a` to `b`; if it is `thin`, both
/// sides are free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// The first end.
    pub a: Point,
    /// The second end.
    pub b: Point,
    /// How it reflects.
    pub surface: Surface,
    /// Its class, from 1.
    pub class: Option<u16>,
    /// Whether both sides are free.
    pub thin: bool,
}

impl Wall {
    /// +1 left of the wall, −1 right of it.
    pub(crate) fn side(&self, p: Point) -> f64 {
        if (self.b - self.a).perp(&(p - self.a)) >= 0.0 { 1.0 } else { -1.0 }
    }

    /// Whether a point lies on a free side.
    pub(crate) fn faces(&self, p: Point) -> bool {
        let c = (self.b - self.a).perp(&(p - self.a));
        c > 0.0 || (self.thin && c < 0.0)
    }
}

/// An arc of a circle, radians counter-clockwise from +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// The circle's centre, metres.
    pub centre: Point,
    /// Its radius, metres.
    pub radius: f64,
    /// Where the arc begins.
    pub from: f64,
    /// How far it goes, up to 2π.
    pub sweep: f64,
    /// How it reflects.
    pub surface: Surface,
    /// Its class, from 1.
    pub class: Option<u16>,
    /// Whether the free side is inside.
    pub inside: bool,
}

impl Arc {
    /// Whether the arc has a point in this direction from its centre.
    pub(crate) fn spans(&self, direction: Vector) -> bool {
        self.is_circle() || (direction.y.atan2(direction.x) - self.from).rem_euclid(TAU) <= self.sweep
    }

    /// The point at an angle from the arc's beginning.
    pub(crate) fn at(&self, angle: f64) -> Point {
        let (s, c) = (self.from + angle).sin_cos();
        self.centre + self.radius * Vector::new(c, s)
    }

    /// The intersections with the line through `p` along `d`, as multiples of `d`, the smaller first; NaN where there is none.
    pub(crate) fn intersections(&self, p: Point, d: Vector) -> [f64; 2] {
        let w = p - self.centre;
        let (a, b, c) = (d.dot(&d), w.dot(&d), w.dot(&w) - self.radius * self.radius);
        let root = (b * b - a * c).sqrt();
        [(-b - root) / a, (-b + root) / a].map(|t| if t.is_finite() && self.spans(w + t * d) { t } else { f64::NAN })
    }

    /// The arc as chords no farther from it than `sagitta` metres, free side to the left, each with the angles of its ends from
    /// the beginning of the arc.
    pub(crate) fn facets(&self, sagitta: f64) -> Vec<(Wall, f64, f64)> {
        let step = 2.0 * (1.0 - (sagitta / self.radius).min(0.5)).acos();
        let count = (self.sweep / step).ceil().clamp(4.0, 4096.0) as usize;
        let angle = |k: usize| self.sweep * k as f64 / count as f64;
        let thin = !self.is_circle();
        let facet = |k: usize| {
            let (from, to) = if self.inside { (angle(k), angle(k + 1)) } else { (angle(k + 1), angle(k)) };
            let (a, b) = (self.at(from), self.at(to));
            (Wall { a, b, surface: self.surface, class: self.class, thin }, from, to)
        };
        (0..count).map(facet).collect()
    }

    /// The distance to a point, metres.
    pub(crate) fn distance_to(&self, p: Point) -> f64 {
        let outward = p - self.centre;
        if self.spans(outward) {
            return (outward.norm() - self.radius).abs();
        }
        distance(&p, &self.at(0.0)).min(distance(&p, &self.at(self.sweep)))
    }

    /// Whether it is a whole circle, with one solid side; a part of one is thin, with both sides free.
    pub(crate) fn is_circle(&self) -> bool {
        self.sweep >= TAU
    }
}

/// How a corner reflects sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CornerKind {
    /// Concave, 90 ± 4°: returns every sound to where it came from.
    Right,
    /// Concave, of another angle: a weak echo.
    Concave,
    /// Convex, or a wall's end: a weak echo.
    Edge,
}

/// A corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Its position, metres.
    pub at: Point,
    /// How it reflects.
    pub kind: CornerKind,
    /// Unit vectors along its two walls, away from it; the free side lies between them, counter-clockwise.
    pub arms: [Vector; 2],
    /// What its walls keep of a sound's amplitude, relative to specular ones.
    pub gain: f64,
    /// Its class, from 1.
    pub class: Option<u16>,
}

impl Corner {
    /// Whether a point lies on its free side.
    pub(crate) fn faces(&self, p: Point) -> bool {
        let (v, [right, left]) = (p - self.at, self.arms);
        match self.kind {
            // all but the solid sector, of less than 180°
            CornerKind::Edge => !(left.perp(&v) > 0.0 && v.perp(&right) > 0.0),
            _ => right.perp(&v) > 0.0 && v.perp(&left) > 0.0,
        }
    }

    /// The reflection coefficient ρ of an echo from `d` metres.
    pub fn reflection(&self, d: f64) -> f64 {
        self.gain
            * match self.kind {
                CornerKind::Right => 0.9 * 0.95 * 0.95,
                CornerKind::Concave => 0.05 / d.sqrt(),
                CornerKind::Edge => 0.10 / d.sqrt(),
            }
    }
}
