//! Plane geometry on nalgebra's types: lines, segments, reflections and wedges. World frame, metres.
//!
//! Tests compare maps and simulated logs bit for bit, so each function keeps one order of operations. A comment says where
//! a similar function of nalgebra has another order.

use nalgebra::{Point2, Vector2};

/// A position: metres to the right, metres up.
pub type Point = Point2<f64>;
/// A displacement or a direction: metres, or a unit vector.
pub type Vector = Vector2<f64>;

/// The unit vector of a direction; the zero vector for the zero vector.
///
/// It takes one division and two products. `Vector2::normalize` divides each component, which rounds differently.
pub fn unit(v: Vector) -> Vector {
    v * (1.0 / v.norm().max(f64::MIN_POSITIVE))
}

/// A vector turned left by 90°.
pub fn left_normal(v: Vector) -> Vector {
    Vector::new(-v.y, v.x)
}

/// The point at parameter `t` of the segment from `a` (0) to `b` (1).
///
/// `Point2::lerp` computes a·(1 − t) + b·t, which rounds differently.
pub fn lerp(a: Point, b: Point, t: f64) -> Point {
    a + (b - a) * t
}

/// The mirror image of `p` in the line through `a` and `b`.
pub fn reflect(p: Point, a: Point, b: Point) -> Point {
    let e = b - a;
    let n = left_normal(e);
    p - n * (2.0 * (p - a).dot(&n) / e.dot(&e))
}

/// The intersection of the line through `p` and `q` with the line through `a` and `b`, as parameters of both: 0 at `p` and
/// `a`, 1 at `q` and `b`; `None` if they are parallel.
pub fn intersect_lines(p: Point, q: Point, a: Point, b: Point) -> Option<(f64, f64)> {
    let (d, e, w) = (q - p, b - a, a - p);
    let den = d.perp(&e);
    if den * den < 1e-24 * d.dot(&d) * e.dot(&e) {
        return None;
    }
    Some((w.perp(&e) / den, w.perp(&d) / den))
}

/// The distance from `origin` along the unit vector `direction` to a segment, metres; `None` if the ray misses it.
#[inline]
pub fn intersect_ray(origin: Point, direction: Vector, [a, b]: [Point; 2]) -> Option<f64> {
    let (e, w) = (b - a, a - origin);
    let den = direction.perp(&e);
    if den == 0.0 {
        return None;
    }
    let (t, u) = (w.perp(&e) / den, w.perp(&direction) / den);
    (t > 0.0 && (0.0..=1.0).contains(&u)).then_some(t)
}

/// The parameter of the point of the segment from `a` to `b` that is nearest to `p`, 0 to 1.
pub fn nearest_parameter(p: Point, a: Point, b: Point) -> f64 {
    let e = b - a;
    ((p - a).dot(&e) / e.dot(&e).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// The distance from a point to the segment from `a` to `b`, metres.
pub fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    nalgebra::distance(&p, &lerp(a, b, nearest_parameter(p, a, b)))
}

/// A wedge of less than 180°: the region visible from `apex` between two directions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wedge {
    pub apex: Point,
    /// Direction of the right edge.
    pub right: Vector,
    /// Direction of the left edge.
    pub left: Vector,
}

impl Wedge {
    /// The wedge from `apex` that spans a segment.
    pub fn spanning(apex: Point, a: Point, b: Point) -> Wedge {
        let (a, b) = (a - apex, b - apex);
        let (right, left) = if a.perp(&b) >= 0.0 { (a, b) } else { (b, a) };
        Wedge { apex, right, left }
    }

    /// The part of a segment inside the wedge, as parameters of the segment; `None` if it lies outside.
    pub fn clip(&self, a: Point, b: Point) -> Option<(f64, f64)> {
        let (va, vb) = (a - self.apex, b - self.apex);
        let interval = clip_to_non_negative((0.0, 1.0), self.right.perp(&va), self.right.perp(&vb))?;
        clip_to_non_negative(interval, -self.left.perp(&va), -self.left.perp(&vb))
    }
}

/// The part of an interval where a linear function is not negative; the function is `at_0` at 0 and `at_1` at 1. `None` if
/// there is none.
pub(crate) fn clip_to_non_negative((low, high): (f64, f64), at_0: f64, at_1: f64) -> Option<(f64, f64)> {
    let clipped = match (at_0 >= 0.0, at_1 >= 0.0) {
        (true, true) => (low, high),
        (false, false) => return None,
        (true, false) => (low, high.min(at_0 / (at_0 - at_1))),
        (false, true) => (low.max(at_0 / (at_0 - at_1)), high),
    };
    (clipped.0 < clipped.1).then_some(clipped)
}
