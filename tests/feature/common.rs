//! Readings, regions and walls made by hand.

use echogrid::feature::rcd::{Rcd, Source};
use echogrid::feature::{Ping, Wall};
use echogrid::geometry::plane::{Point, Vector};
use echogrid::log::reading::{Pose, Record};

/// Radius of a circular scan, metres.
pub const CIRCLE: f64 = 0.14;
/// Its bearings.
pub const BEARINGS: usize = 200;

/// Two coordinates, however they are written.
pub trait Coordinates {
    fn point(self) -> Point;
}

impl Coordinates for (f64, f64) {
    fn point(self) -> Point {
        Point::new(self.0, self.1)
    }
}

impl Coordinates for Point {
    fn point(self) -> Point {
        self
    }
}

impl Coordinates for Vector {
    fn point(self) -> Point {
        Point::from(self)
    }
}

/// The point (x, y).
pub fn p(x: f64, y: f64) -> Point {
    Point::new(x, y)
}

/// The unit vector of a bearing in degrees.
pub fn way(degrees: f64) -> Vector {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vector::new(cos, sin)
}

/// A reading of a sonar of β = 15° that hears up to 5 m; the robot is where the sensor is.
pub fn ping(at: impl Coordinates, degrees: f64, range: Option<f64>) -> Ping {
    let at = at.point();
    let pose = Pose { x: at.x, y: at.y, heading: degrees.to_radians() };
    let z = range.unwrap_or(f64::INFINITY);
    let record = Record { t: 0.0, scan: 0, sensor: 0, robot: pose, pose, range: z, label: None, line: 1 };
    Ping { record, number: 0, at, axis: way(degrees), range, half_width: 15f64.to_radians(), reach: 5.0, frees: 0.0 }
}

/// A dense circular scan: what is heard at each of its bearings, in degrees from 0 in steps of 1.8.
pub fn circle(centre: impl Coordinates, scan: u64, range: impl Fn(f64) -> Option<f64>) -> Vec<Ping> {
    let centre = centre.point();
    let one = |k: usize| {
        let degrees = k as f64 * 360.0 / BEARINGS as f64;
        let axis = way(degrees);
        let mut ping = ping(centre + CIRCLE * axis, degrees, range(degrees));
        ping.number = scan * BEARINGS as u64 + k as u64;
        ping.record.robot = Pose { x: centre.x, y: centre.y, heading: 0.0 };
        (ping.record.scan, ping.record.line) = (scan, 1 + ping.number);
        ping
    };
    (0..BEARINGS).map(one).collect()
}

/// How far a bearing is from another, degrees, 0 to 180.
pub fn off(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(360.0);
    d.min(360.0 - d)
}

/// What a circular scan hears of a plane `d` metres from its centre, up to so many degrees beside its normal.
pub fn plane(degrees: f64, normal: f64, d: f64, visible: f64) -> Option<f64> {
    let beside = off(degrees, normal);
    (beside <= visible + 1e-9).then(|| d - CIRCLE * beside.to_radians().cos())
}

/// A wall's region, seen from `centre` along a bearing in degrees.
pub fn region(centre: impl Coordinates, degrees: f64, range: f64, half: f64, scan: u64) -> Rcd {
    let (centre, normal) = (centre.point(), way(degrees));
    Rcd {
        centre,
        foot: centre + range * normal,
        normal,
        range,
        half,
        scan,
        source: Source::Wall,
        fitted: false,
        clear: true,
        lines: [10 * scan + 1, 10 * scan + 9],
        count: 9,
    }
}

/// The same of a point.
pub fn point(centre: impl Coordinates, degrees: f64, range: f64, scan: u64) -> Rcd {
    Rcd { source: Source::Point, ..region(centre, degrees, range, 0.1, scan) }
}

/// The wall at y from x = `from` to `to`, seen from below.
pub fn above(y: f64, from: f64, to: f64) -> Wall {
    Wall { normal: Vector::y(), offset: y, extent: [-to, -from], rcds: Vec::new() }
}

/// The wall at x from y = `from` to `to`, seen from the left.
pub fn right(x: f64, from: f64, to: f64) -> Wall {
    Wall { normal: Vector::x(), offset: x, extent: [from, to], rcds: Vec::new() }
}

pub fn gap(a: impl Coordinates, b: impl Coordinates) -> f64 {
    let d = a.point() - b.point();
    d.x.hypot(d.y)
}

#[track_caller]
pub fn near(a: impl Coordinates, b: impl Coordinates, most: f64) {
    let (a, b) = (a.point(), b.point());
    assert!(gap(a, b) <= most, "{a:?} is {} m from {b:?}", gap(a, b));
}

#[track_caller]
pub fn equal(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-9, "{a} is not {b}");
}

/// Pseudo-random numbers from 0 to 1, always the same.
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}
