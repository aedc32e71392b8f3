//! Snaps a scan to beams: lengths in µm, directions in integers, beams sorted by bearing.

use super::order::quarter;
use super::{Ray, Scan, Selection};
use crate::geometry::layout::{BEAM_SHIFT, Beam, IDLE, UNIT, YIELD};
use std::cmp::Ordering;

/// A snapped scan.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snapped {
    /// Position of the pose, µm in the world frame.
    pub pose: [i64; 2],
    /// Beams, sorted by the bearings of their bounds from +x.
    pub beams: Vec<Beam>,
    /// The largest distance from the pose at which a beam may touch a cell, µm.
    pub reach: i32,
}

/// Converts metres to µm, rounded half up.
pub fn micrometres(metres: f64) -> i64 {
    (metres * 1e6 + 0.5).floor() as i64
}

/// A beam before the bounds to its neighbours are known.
struct Directed {
    unit: [i32; 2],
    index: u32,
    ray: [[i32; 2]; 2],
    range: i32,
    id: u32,
}

/// Snaps a scan.
pub fn snap(scan: &Scan, selection: &Selection) -> Snapped {
    let place = |r: &Ray| [r.sensor.x, r.sensor.y];
    let together = scan.rays.windows(2).all(|w| place(&w[0]) == place(&w[1]));
    let at = match scan.rays.first() {
        Some(first) if together => place(first),
        _ => [scan.robot.x, scan.robot.y],
    };
    let pose = at.map(micrometres);
    let margin = selection.margin;
    let mut directed: Vec<Directed> =
        (0..).zip(&scan.rays).map(|(k, ray)| direct(ray, k, pose, together, selection)).collect();
    // Of several beams in one direction the first is always the nearest.
    directed.sort_by(|a, b| around(a.unit, b.unit).then(a.index.cmp(&b.index)));
    directed.dedup_by(|later, first| later.unit == first.unit);
    let reach = directed.iter().filter(|d| d.id & IDLE == 0).map(|d| d.range + margin).max().unwrap_or(0);
    Snapped { pose, beams: bounded(directed), reach }
}

/// Compares directions counter-clockwise from +x.
fn around(a: [i32; 2], b: [i32; 2]) -> Ordering {
    let cross = i64::from(a[0]) * i64::from(b[1]) - i64::from(a[1]) * i64::from(b[0]);
    quarter(a).cmp(&quarter(b)).then(0.cmp(&cross))
}

/// The direction of a vector, scaled to length [`UNIT`] and rounded half up.
fn unit([x, y]: [f64; 2]) -> [i32; 2] {
    let length = (x * x + y * y).sqrt();
    [x, y].map(|v| (v / length * f64::from(UNIT) + 0.5).floor() as i32)
}

fn direct(ray: &Ray, index: u32, pose: [i64; 2], together: bool, selection: &Selection) -> Directed {
    let heading = [ray.sensor.heading.cos(), ray.sensor.heading.sin()];
    let z = ray.range.filter(|z| *z < selection.z_max);
    let hit = z.map(|z| {
        let tip = [ray.sensor.x + z * heading[0], ray.sensor.y + z * heading[1]];
        [0, 1].map(|k| micrometres(tip[k]) - pose[k])
    });
    let hit = hit.filter(|h| h.iter().all(|v| v.abs() < 1 << 27) && *h != [0, 0]);
    let range = match (hit, z) {
        (Some(_), Some(z)) if together => micrometres(z),
        (Some([x, y]), _) => ((x * x + y * y) as f64).sqrt().round() as i64,
        _ => 0,
    };
    let z_max = micrometres(selection.z_max);
    let idle = hit.is_none() || range >= z_max;
    let unit = unit(hit.map_or(heading, |h| h.map(|v| v as f64)));
    let turned = |angle: f64| {
        let (s, c) = angle.sin_cos();
        let [x, y] = unit.map(f64::from);
        [c * x - s * y, s * x + c * y].map(|v| (v + 0.5).floor() as i32)
    };
    let ray_of = match selection.beam_width {
        None => [unit, hit.unwrap_or_default().map(|v| v as i32)],
        Some(width) => [turned(-width / 2.0), turned(width / 2.0)],
    };
    let id = u32::from(ray.label) | if idle { IDLE } else { 0 } | index << BEAM_SHIFT;
    Directed { unit, index, ray: ray_of, range: if idle { 0 } else { range as i32 }, id }
}

/// Adds the bounds between the beams. If the bound after the last beam lies beyond +x, that beam comes first.
fn bounded(mut directed: Vec<Directed>) -> Vec<Beam> {
    let n = directed.len();
    if let [first, .., last] = &directed[..]
        && around(bound(last.unit, first.unit), first.unit) == Ordering::Less
    {
        directed.rotate_right(1);
    }
    let beam = |k: usize| {
        let (this, next) = (&directed[k], &directed[(k + 1) % n]);
        let yields = if next.index < this.index { YIELD } else { 0 };
        let bound = if n > 1 { bound(this.unit, next.unit) } else { [1, 0] };
        Beam { bound, ray: this.ray, range: this.range, id: this.id | yields }
    };
    (0..n).map(beam).collect()
}

/// Length below which the sum of two nearly opposite directions is too short to give a direction.
const SHORT: i32 = 1 << 15;

/// The direction halfway along the counter-clockwise turn from one direction to another.
fn bound(from: [i32; 2], to: [i32; 2]) -> [i32; 2] {
    let sum = [from[0] + to[0], from[1] + to[1]];
    let cross = i64::from(from[0]) * i64::from(to[1]) - i64::from(from[1]) * i64::from(to[0]);
    if sum.iter().all(|v| v.abs() < SHORT) {
        [-from[1], from[0]]
    } else if cross > 0 {
        sum
    } else {
        sum.map(|v| -v)
    }
}
