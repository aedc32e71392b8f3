//! What a world is made of: walls, arcs, and the corners they make, each with a surface and perhaps a class.

use crate::geometry::plane::{Point, cross, distance, dot, length, sub};
use std::f64::consts::TAU;

/// How a surface answers. `worlds.md` has the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surface {
    /// A mirror to sound: an echo comes back along the normal only. Light scatters.
    Specular,
    /// Rough: sound comes back from everywhere in the beam, weaker.
    Diffuse,
    /// A mirror to sound; light goes through unless it falls within 10° of the normal.
    Glass,
    /// Soft: a weak mirror to sound.
    Absorbing,
}

/// The names that a world's file takes, in the order of [`Surface`].
pub(crate) const SURFACES: [(&str, Surface); 4] = [
    ("specular", Surface::Specular),
    ("diffuse", Surface::Diffuse),
    ("glass", Surface::Glass),
    ("absorbing", Surface::Absorbing),
];

impl Surface {
    /// The share of a sound's amplitude that its mirror image keeps.
    pub fn reflection(self) -> f64 {
        match self {
            Surface::Specular | Surface::Glass => 0.95,
            Surface::Diffuse => 0.3,
            Surface::Absorbing => 0.2,
        }
    }
}

/// A straight wall from `a` to `b`, metres. Its free side is to the left of the way from `a` to `b`; both are, if `thin`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// One end.
    pub a: Point,
    /// The other.
    pub b: Point,
    /// How it answers.
    pub surface: Surface,
    /// Its class, from 1.
    pub class: Option<u16>,
    /// Whether both sides are free.
    pub thin: bool,
}

impl Wall {
    /// +1 left of the wall, −1 right of it.
    pub(crate) fn side(&self, p: Point) -> f64 {
        if cross(sub(self.b, self.a), sub(p, self.a)) >= 0.0 { 1.0 } else { -1.0 }
    }

    /// Whether a point lies on a free side.
    pub(crate) fn faces(&self, p: Point) -> bool {
        let c = cross(sub(self.b, self.a), sub(p, self.a));
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
    /// How it answers.
    pub surface: Surface,
    /// Its class, from 1.
    pub class: Option<u16>,
    /// Whether the free side is inside.
    pub inside: bool,
}

impl Arc {
    /// Whether the arc has a point in this direction from its centre.
    pub(crate) fn spans(&self, direction: Point) -> bool {
        self.whole() || (direction.1.atan2(direction.0) - self.from).rem_euclid(TAU) <= self.sweep
    }

    /// The point at an angle from the arc's beginning.
    pub(crate) fn at(&self, angle: f64) -> Point {
        let (s, c) = (self.from + angle).sin_cos();
        (self.centre.0 + self.radius * c, self.centre.1 + self.radius * s)
    }

    /// Where a ray from `p` along the vector `d` meets it, as shares of `d`, the nearer first; NaN where it doesn't.
    pub(crate) fn meets(&self, p: Point, d: Point) -> [f64; 2] {
        let w = sub(p, self.centre);
        let (a, b, c) = (dot(d, d), dot(w, d), dot(w, w) - self.radius * self.radius);
        let root = (b * b - a * c).sqrt();
        [(-b - root) / a, (-b + root) / a].map(|t| {
            let at = (w.0 + t * d.0, w.1 + t * d.1);
            if t.is_finite() && self.spans(at) { t } else { f64::NAN }
        })
    }

    /// The arc as walls that leave it by no more than `sagitta` metres, free side to the left, each with the angles from
    /// the arc's beginning at which it starts and ends.
    pub(crate) fn facets(&self, sagitta: f64) -> Vec<(Wall, f64, f64)> {
        let step = 2.0 * (1.0 - (sagitta / self.radius).min(0.5)).acos();
        let count = (self.sweep / step).ceil().clamp(4.0, 4096.0) as usize;
        let angle = |k: usize| self.sweep * k as f64 / count as f64;
        let thin = !self.whole();
        let facet = |k: usize| {
            let (from, to) = if self.inside { (angle(k), angle(k + 1)) } else { (angle(k + 1), angle(k)) };
            let (a, b) = (self.at(from), self.at(to));
            (Wall { a, b, surface: self.surface, class: self.class, thin }, from, to)
        };
        (0..count).map(facet).collect()
    }

    /// How far a point lies from it, metres.
    pub(crate) fn off(&self, p: Point) -> f64 {
        let out = sub(p, self.centre);
        if self.spans(out) {
            return (length(out) - self.radius).abs();
        }
        distance(p, self.at(0.0)).min(distance(p, self.at(self.sweep)))
    }

    /// Whether it is a whole circle, one side of it solid; a part of one is thin, both sides free.
    pub(crate) fn whole(&self) -> bool {
        self.sweep >= TAU
    }
}

/// What a corner does to sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CornerKind {
    /// Concave, 90 ± 4°: sends every sound back where it came from.
    Right,
    /// Concave, of another angle: a weak echo.
    Concave,
    /// Convex, or a wall's end: a weak echo.
    Edge,
}

/// A corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Where, metres.
    pub at: Point,
    /// What it does.
    pub kind: CornerKind,
    /// Unit vectors along its two walls, away from it; the free side lies between them, counter-clockwise.
    pub arms: [Point; 2],
    /// The share of a sound's amplitude that it keeps: of its two walls' reflections, as against specular ones.
    pub keeps: f64,
    /// Its class, from 1.
    pub class: Option<u16>,
}

impl Corner {
    /// Whether a point lies on its free side.
    pub(crate) fn faces(&self, p: Point) -> bool {
        let (v, [right, left]) = (sub(p, self.at), self.arms);
        match self.kind {
            // what isn't in the sector behind it, of less than 180°
            CornerKind::Edge => !(cross(left, v) > 0.0 && cross(v, right) > 0.0),
            _ => cross(right, v) > 0.0 && cross(v, left) > 0.0,
        }
    }

    /// ρ of an echo from `d` metres.
    pub fn reflection(&self, d: f64) -> f64 {
        self.keeps
            * match self.kind {
                CornerKind::Right => 0.9 * 0.95 * 0.95,
                CornerKind::Concave => 0.05 / d.sqrt(),
                CornerKind::Edge => 0.10 / d.sqrt(),
            }
    }
}
