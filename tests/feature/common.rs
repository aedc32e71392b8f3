//! Readings, regions and walls made by hand.

use echogrid::feature::rcd::{Rcd, Source};
use echogrid::feature::{Ping, Wall};
use echogrid::geometry::plane::Point;
use echogrid::log::reading::{Pose, Record};

/// Radius of a circular scan, metres.
pub const CIRCLE: f64 = 0.14;
/// Its bearings.
pub const BEARINGS: usize = 200;

/// The direction of a bearing in degrees.
pub fn way(degrees: f64) -> Point {
    let (sin, cos) = degrees.to_radians().sin_cos();
    (cos, sin)
}

/// A reading of a sonar of β = 15° that hears up to 5 m; the robot is where the sensor is.
pub fn ping(at: Point, degrees: f64, range: Option<f64>) -> Ping {
    let pose = Pose { x: at.0, y: at.1, heading: degrees.to_radians() };
    let z = range.unwrap_or(f64::INFINITY);
    let record = Record { t: 0.0, scan: 0, sensor: 0, robot: pose, pose, range: z, label: None, line: 1 };
    Ping { record, number: 0, at, axis: way(degrees), range, half_width: 15f64.to_radians(), reach: 5.0, frees: 0.0 }
}

/// A dense circular scan: what is heard at each of its bearings, in degrees from 0 in steps of 1.8.
pub fn circle(centre: Point, scan: u64, range: impl Fn(f64) -> Option<f64>) -> Vec<Ping> {
    let one = |k: usize| {
        let degrees = k as f64 * 360.0 / BEARINGS as f64;
        let axis = way(degrees);
        let at = (centre.0 + CIRCLE * axis.0, centre.1 + CIRCLE * axis.1);
        let mut ping = ping(at, degrees, range(degrees));
        ping.number = scan * BEARINGS as u64 + k as u64;
        ping.record.robot = Pose { x: centre.0, y: centre.1, heading: 0.0 };
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
pub fn region(centre: Point, degrees: f64, range: f64, half: f64, scan: u64) -> Rcd {
    let normal = way(degrees);
    Rcd {
        centre,
        foot: (centre.0 + range * normal.0, centre.1 + range * normal.1),
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
pub fn point(centre: Point, degrees: f64, range: f64, scan: u64) -> Rcd {
    Rcd { source: Source::Point, ..region(centre, degrees, range, 0.1, scan) }
}

/// The wall at y from x = `from` to `to`, seen from below.
pub fn above(y: f64, from: f64, to: f64) -> Wall {
    Wall { normal: (0.0, 1.0), offset: y, extent: [-to, -from], rcds: Vec::new() }
}

/// The wall at x from y = `from` to `to`, seen from the left.
pub fn right(x: f64, from: f64, to: f64) -> Wall {
    Wall { normal: (1.0, 0.0), offset: x, extent: [from, to], rcds: Vec::new() }
}

pub fn gap(a: Point, b: Point) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

#[track_caller]
pub fn near(a: Point, b: Point, most: f64) {
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
