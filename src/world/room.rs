//! The demo's world: a room of 5 × 4 m with a box in it, and a robot with the ring of eight sonars that drives once round and back.
//!
//! A small stand-in, not the physical simulator: one echo a reading, the nearest wall that its cone meets within 30° of
//! the wall's normal, or a corner in sight; no second bounces, no phantoms, no loss of amplitude. The same seed gives the
//! same log on every machine: noise comes from integers, poses are rounded to 1 µm and ranges to 10 mm.

use super::random::Random;
use crate::grid::{Class, GridSpec};
use crate::reading::{Pose, Record};
use crate::sensor::{Sensor, preset};
use crate::{Error, Result};

type Point = (f64, f64);

/// The room's inside and the box: left, bottom, right, top, metres. Off the grid, as rooms are.
const ROOM: [f64; 4] = [0.02, 0.03, 5.02, 4.03];
const BOX: [f64; 4] = [2.13, 1.72, 2.88, 2.31];
/// The corners of the robot's way: round the box, and back.
const WAY: [Point; 8] =
    [(0.9, 0.8), (2.5, 1.1), (4.2, 0.7), (3.8, 2.0), (4.3, 3.2), (2.4, 2.9), (0.8, 3.3), (1.2, 2.0)];
/// Metres from one scan to the next, and the most that the robot turns between two, radians.
const STEP: f64 = 0.035;
const TURN: f64 = 0.15;
/// Seconds between scans.
const SCAN_TIME: f64 = 0.1;
/// A smooth wall sends an echo back up to this angle off its normal (cosine of 30°).
const COS_SPECULAR: f64 = 0.866_025_403_784_438_6;
/// Rays on either side of a beam's axis.
const RAYS: i32 = 16;
/// The ranges' deviation, and what they are rounded to, metres.
const NOISE: f64 = 0.008;
const QUANTUM: f64 = 0.01;

/// The log: the preset's ring of eight, and its records scan by scan; a missing echo's range is +∞.
///
/// # Errors
/// [`Error::Usage`] if the ring's preset doesn't hold.
pub fn records(seed: u64) -> Result<(Vec<Sensor>, Vec<Record>)> {
    let ring = preset("sonar_ring_8")?;
    let complete = |(k, d): (usize, &crate::sensor::Description)| d.complete(k).map_err(Error::Usage);
    let sensors = ring.iter().enumerate().map(complete).collect::<Result<Vec<Sensor>>>()?;
    let mut random = Random::new(seed);
    let mut records = Vec::new();
    for (scan, robot) in (0..).zip(poses()) {
        for (index, sensor) in (0..).zip(&sensors) {
            let pose = rounded(robot.compose(sensor.x, sensor.y, sensor.axis));
            let noise = NOISE * random.normal();
            let range = echo(pose, sensor.half_width)
                .map(|d| ((d + noise) / QUANTUM).round() * QUANTUM)
                .map(|z| (z * 100.0).round() / 100.0)
                .filter(|z| (sensor.r_min..=sensor.r_max).contains(z))
                .unwrap_or(f64::INFINITY);
            let line = records.len() as u64 + 2; // as a log on disk has it, after its header
            let t = scan as f64 * SCAN_TIME;
            records.push(Record { t, scan, sensor: index, robot, pose, range, label: None, line });
        }
    }
    Ok((sensors, records))
}

/// The true class of each cell: occupied where a wall passes through it, empty where its centre lies in the room and not
/// in the box, else unknown. Row by row from the bottom.
pub fn truth(grid: &GridSpec) -> Vec<i8> {
    let within = |[x0, y0, x1, y1]: [f64; 4], (x, y): Point| x0 < x && x < x1 && y0 < y && y < y1;
    let class = |k| {
        let free = Some(grid.centre(k % grid.width, k / grid.width)).filter(|c| within(ROOM, *c) && !within(BOX, *c));
        free.map_or(Class::Unknown, |_| Class::Empty) as i8
    };
    let mut classes: Vec<i8> = (0..grid.cells()).map(class).collect();
    let column = |x: f64| ((x - grid.x0()) / grid.resolution).floor() as i64;
    let row = |y: f64| ((y - grid.y0()) / grid.resolution).floor() as i64;
    for (a, b) in walls() {
        for j in row(a.1.min(b.1))..=row(a.1.max(b.1)) {
            for i in column(a.0.min(b.0))..=column(a.0.max(b.0)) {
                if (0..grid.width as i64).contains(&i) && (0..grid.height as i64).contains(&j) {
                    classes[j as usize * grid.width + i as usize] = Class::Occupied as i8;
                }
            }
        }
    }
    classes
}

/// The robot's poses: along each side of its way, turning at the corners.
fn poses() -> Vec<Pose> {
    let mut poses = Vec::new();
    for (k, from) in WAY.iter().enumerate() {
        let [to, after] = [1, 2].map(|n| WAY[(k + n) % WAY.len()]);
        let heading = |a: Point, b: Point| (b.1 - a.1).atan2(b.0 - a.0);
        let (along, next) = (heading(*from, to), heading(to, after));
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let steps = (dx.hypot(dy) / STEP).floor() as u32;
        for n in 0..steps {
            let part = f64::from(n) / f64::from(steps);
            poses.push(rounded(Pose { x: from.0 + part * dx, y: from.1 + part * dy, heading: along }));
        }
        let turn = (next - along).rem_euclid(std::f64::consts::TAU);
        let turns = (turn / TURN).ceil() as u32;
        for n in 0..turns {
            let heading = along + turn * f64::from(n) / f64::from(turns);
            poses.push(rounded(Pose { x: to.0, y: to.1, heading }));
        }
    }
    poses
}

/// To 1 µm and 1 µrad: where machines' sines differ, their logs don't.
fn rounded(pose: Pose) -> Pose {
    let round = |v: f64| (v * 1e6).round() / 1e6;
    Pose { x: round(pose.x), y: round(pose.y), heading: round(pose.heading) }
}

/// The room's corners and the box's, each in turn.
fn corners() -> [[Point; 4]; 2] {
    [ROOM, BOX].map(|[x0, y0, x1, y1]| [(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
}

/// Every wall, along one of the axes.
fn walls() -> impl Iterator<Item = (Point, Point)> {
    corners().into_iter().flat_map(|outline| (0..4).map(move |k| (outline[k], outline[(k + 1) % 4])))
}

/// The distance of the nearest echo in a beam, if there is one.
fn echo(pose: Pose, half_width: f64) -> Option<f64> {
    let ray = |k: i32| pose.heading + half_width * f64::from(k) / f64::from(RAYS);
    let smooth = (-RAYS..=RAYS).filter_map(|k| {
        let (sin, cos) = ray(k).sin_cos();
        nearest(pose, (cos, sin)).filter(|(_, incidence)| *incidence >= COS_SPECULAR).map(|(d, _)| d)
    });
    let limit = half_width.cos();
    let (sin, cos) = pose.heading.sin_cos();
    let edges = corners().into_iter().flatten().filter_map(|corner| {
        let (dx, dy) = (corner.0 - pose.x, corner.1 - pose.y);
        let d = dx.hypot(dy);
        let in_beam = dx * cos + dy * sin >= limit * d;
        let hidden = || nearest(pose, (dx / d, dy / d)).is_some_and(|(wall, _)| wall < d - QUANTUM);
        (in_beam && !hidden()).then_some(d)
    });
    smooth.chain(edges).min_by(f64::total_cmp)
}

/// The first wall in a direction: its distance, and the cosine of the angle to its normal.
fn nearest(pose: Pose, (cos, sin): Point) -> Option<(f64, f64)> {
    let meet = |(a, b): (Point, Point)| {
        let upright = a.0 == b.0;
        let (towards, gap) = if upright { (cos, a.0 - pose.x) } else { (sin, a.1 - pose.y) };
        let d = gap / towards;
        let (at, low, high) = if upright {
            (pose.y + d * sin, a.1.min(b.1), a.1.max(b.1))
        } else {
            (pose.x + d * cos, a.0.min(b.0), a.0.max(b.0))
        };
        (towards != 0.0 && d > 0.0 && (low..=high).contains(&at)).then_some((d, towards.abs()))
    };
    walls().filter_map(meet).min_by(|a, b| a.0.total_cmp(&b.0))
}
