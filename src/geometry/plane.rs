//! Plane geometry that the world's files share: points, segments, wedges. World frame, metres.

/// A point or a vector: metres right and up.
pub type Point = (f64, f64);

pub(crate) fn add(a: Point, b: Point) -> Point {
    (a.0 + b.0, a.1 + b.1)
}

pub(crate) fn sub(a: Point, b: Point) -> Point {
    (a.0 - b.0, a.1 - b.1)
}

pub(crate) fn times(a: Point, k: f64) -> Point {
    (a.0 * k, a.1 * k)
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a.0 * b.0 + a.1 * b.1
}

/// Positive where `b` lies to the left of `a`.
pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a.0 * b.1 - a.1 * b.0
}

pub(crate) fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    length(sub(a, b))
}

pub(crate) fn unit(a: Point) -> Point {
    times(a, 1.0 / length(a).max(f64::MIN_POSITIVE))
}

/// The point at share `t` of the way from `a` to `b`.
pub(crate) fn along(a: Point, b: Point, t: f64) -> Point {
    add(a, times(sub(b, a), t))
}

/// The image of `p` in the line through `a` and `b`.
pub(crate) fn mirror(p: Point, a: Point, b: Point) -> Point {
    let e = sub(b, a);
    let v = sub(p, a);
    let n = (-e.1, e.0);
    sub(p, times(n, 2.0 * dot(v, n) / dot(e, e)))
}

/// Where the line from `p` through `q` meets the line from `a` through `b`, as shares of both ways; `None` if parallel.
pub(crate) fn meet(p: Point, q: Point, a: Point, b: Point) -> Option<(f64, f64)> {
    let (d, e, w) = (sub(q, p), sub(b, a), sub(a, p));
    let den = cross(d, e);
    if den * den < 1e-24 * dot(d, d) * dot(e, e) {
        return None;
    }
    Some((cross(w, e) / den, cross(w, d) / den))
}

/// The share of a segment nearest to a point.
pub(crate) fn nearest_share(p: Point, a: Point, b: Point) -> f64 {
    let e = sub(b, a);
    (dot(sub(p, a), e) / dot(e, e).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// How far a point lies from a segment, metres.
pub(crate) fn from_segment(p: Point, a: Point, b: Point) -> f64 {
    distance(p, along(a, b, nearest_share(p, a, b)))
}

/// A wedge of less than 180°: what is seen from `apex` between `right` and `left`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wedge {
    pub apex: Point,
    pub right: Point,
    pub left: Point,
}

impl Wedge {
    /// The wedge from `apex` over a segment.
    pub fn over(apex: Point, a: Point, b: Point) -> Wedge {
        let (a, b) = (sub(a, apex), sub(b, apex));
        let (right, left) = if cross(a, b) >= 0.0 { (a, b) } else { (b, a) };
        Wedge { apex, right, left }
    }

    /// The part of a segment inside, as shares of it; `None` if there is none.
    pub fn clip(&self, a: Point, b: Point) -> Option<(f64, f64)> {
        let (va, vb) = (sub(a, self.apex), sub(b, self.apex));
        let span = cut((0.0, 1.0), cross(self.right, va), cross(self.right, vb))?;
        cut(span, -cross(self.left, va), -cross(self.left, vb))
    }
}

/// Keeps the shares where the linear function that is `at_a` at 0 and `at_b` at 1 isn't negative.
pub(crate) fn cut((low, high): (f64, f64), at_a: f64, at_b: f64) -> Option<(f64, f64)> {
    let span = match (at_a >= 0.0, at_b >= 0.0) {
        (true, true) => (low, high),
        (false, false) => return None,
        (true, false) => (low, high.min(at_a / (at_a - at_b))),
        (false, true) => (low.max(at_a / (at_a - at_b)), high),
    };
    (span.0 < span.1).then_some(span)
}
