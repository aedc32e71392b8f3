//! Scans in integers, and the beam nearest in bearing.

use crate::binning::scan::Scan;
use crate::method::settings::Csm;

/// Length of a direction.
pub(super) const LENGTH: f64 = 33_554_432.0;

pub(super) type Vector = [i128; 2];

pub(super) fn cross(a: Vector, b: Vector) -> i128 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn dot(a: Vector, b: Vector) -> i128 {
    a[0] * b[0] + a[1] * b[1]
}

/// The nearest integer; halves up.
pub(super) fn round(v: f64) -> i128 {
    (v + 0.5).floor() as i128
}

/// A beam: its directions in 1/2²⁵, and its hit from the pose with the range, µm, if it has one.
pub(super) struct Beam {
    pub unit: Vector,
    pub right: Vector,
    pub left: Vector,
    pub hit: Option<(Vector, i128)>,
    pub label: usize,
}

/// A scan in integers: its pose in µm, and its beams in the log's order.
pub(super) struct SnappedScan {
    pub pose: Vector,
    pub beams: Vec<Beam>,
}

/// Snaps a scan: the pose is the sensor's where all beams have the same one, else the robot's.
pub(super) fn snap_scan(scan: &Scan, csm: &Csm) -> SnappedScan {
    let first = scan.rays.first().map(|r| (r.sensor.x, r.sensor.y));
    let one = scan.rays.iter().all(|r| Some((r.sensor.x, r.sensor.y)) == first);
    let (x, y) = first.filter(|_| one).unwrap_or((scan.robot.x, scan.robot.y));
    let pose = [round(x * 1e6), round(y * 1e6)];
    let beams = scan.rays.iter().map(|ray| {
        let (s, c) = ray.sensor.heading.sin_cos();
        let ends = ray.range.filter(|z| *z < csm.z_max).and_then(|z| {
            let hit = [round((ray.sensor.x + z * c) * 1e6) - pose[0], round((ray.sensor.y + z * s) * 1e6) - pose[1]];
            let range = if one { round(z * 1e6) } else { (dot(hit, hit) as f64).sqrt().round() as i128 };
            let far = hit.iter().any(|v| v.abs() >= 1 << 27) || hit == [0, 0];
            (!far).then_some((hit, range))
        });
        let along = ends.map_or([c, s], |(hit, _)| hit.map(|v| v as f64));
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        let unit = along.map(|v| round(v / length * LENGTH));
        let edge = |angle: f64| {
            let (s, c) = angle.sin_cos();
            let [x, y] = unit.map(|v| v as f64);
            [round(c * x - s * y), round(s * x + c * y)]
        };
        let hit = ends.filter(|(_, range)| *range < round(csm.z_max * 1e6));
        Beam { unit, right: edge(-csm.w_beam / 2.0), left: edge(csm.w_beam / 2.0), hit, label: usize::from(ray.label) }
    });
    SnappedScan { pose, beams: beams.collect() }
}

/// Whether `a` turns less far than `b` to reach `v`, counter-clockwise.
pub(super) fn turns_less(a: Vector, b: Vector, v: Vector) -> bool {
    // Less than half a turn, or more; then by the side on which one lies of the other.
    let half = |u: Vector| cross(u, v) < 0 || (cross(u, v) == 0 && dot(u, v) < 0);
    (half(a), cross(a, b)) < (half(b), 0)
}

/// The index of the beam whose direction is nearest to that of `v`; of two equally near, the lower index.
pub(super) fn nearest_beam(beams: &[Beam], v: Vector) -> usize {
    // The next beam clockwise of v, and the next counter-clockwise.
    let turn = |better: &dyn Fn(Vector, Vector) -> bool| {
        (1..beams.len()).fold(0, |best, k| if better(beams[k].unit, beams[best].unit) { k } else { best })
    };
    let right = turn(&|a, b| turns_less(a, b, v));
    let mirror = |u: Vector| [u[0], -u[1]];
    let left = turn(&|a, b| turns_less(mirror(a), mirror(b), mirror(v)));
    let (from, to) = (beams[right].unit, beams[left].unit);
    if from == to || cross(from, v) == 0 && dot(from, v) > 0 {
        return right.min(if from == to { left } else { right });
    }
    let sum = [from[0] + to[0], from[1] + to[1]];
    let middle = if sum.iter().all(|s| s.abs() < 1 << 15) {
        [-from[1], from[0]]
    } else if cross(from, to) > 0 {
        sum
    } else {
        [-sum[0], -sum[1]]
    };
    match cross(middle, v).signum() {
        -1 => right,
        1 => left,
        _ if dot(middle, v) > 0 => right.min(left),
        _ => right,
    }
}
