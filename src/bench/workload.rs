//! Synthetic logs for benchmarks and tests: random overlapping cones, the same on every machine.

use crate::feature::{Case, Fan, Origin, Part, Routine, Update};
use crate::geometry::plane::Point;
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Pose, Reading, Record};
use crate::sensor::{AtMax, Kind, Sensor};
use crate::world::random::Random;

/// A log in memory: readings, their sensors, their grid.
#[derive(Debug, Clone)]
pub struct Workload {
    /// The name in tables.
    pub name: String,
    /// The grid.
    pub grid: GridSpec,
    /// The sensors.
    pub sensors: Vec<Sensor>,
    /// The readings.
    pub readings: Vec<Reading>,
}

/// Cones of one width and range, at random places of a square map in random directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomCones {
    /// Number of cones.
    pub count: usize,
    /// Width of the whole beam, radians.
    pub width: f64,
    /// Range, metres.
    pub range: f64,
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// Edge of the map, cells.
    pub cells: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// The workload of random cones.
pub fn cones(cones: RandomCones) -> Workload {
    let RandomCones { count, width, range, resolution, cells, seed } = cones;
    let mut random = Random::new(seed);
    let edge = cells as f64 * resolution;
    let sensor = Sensor {
        id: "cone".into(),
        kind: Kind::Sonar,
        x: 0.0,
        y: 0.0,
        axis: 0.0,
        half_width: width / 2.0,
        r_min: 0.17,
        r_max: 1.25 * range,
        at_r_max: AtMax::Hit,
        hit_range: 1.25 * range,
        no_echo_range: 0.0,
        epsilon: None,
    };
    let readings = (0..count as u64)
        .map(|k| {
            let (x, y) = (random.uniform(0.0, edge), random.uniform(0.0, edge));
            let pose = Pose { x, y, heading: random.uniform(0.0, std::f64::consts::TAU) };
            let record = Record { t: k as f64, scan: k, sensor: 0, robot: pose, pose, range, label: None, line: k + 1 };
            Reading { record, outcome: Outcome::Hit, range }
        })
        .collect();
    Workload {
        name: format!("{:.0}° {range} m, {:.0} cm", width.to_degrees(), 100.0 * resolution),
        grid: GridSpec { anchor: (0.0, 0.0), resolution, i0: 0, j0: 0, width: cells, height: cells },
        sensors: vec![sensor],
        readings,
    }
}

/// The four workloads of the benchmarks: 30° cones of 5 m and 2 m on cells of 5 cm and 2 cm.
pub fn standard(count: usize) -> Vec<Workload> {
    let width = 30f64.to_radians();
    [(5.0, 0.05), (2.0, 0.05), (5.0, 0.02), (2.0, 0.02)]
        .iter()
        .map(|&(range, resolution)| cones(RandomCones { count, width, range, resolution, cells: 1024, seed: 1 }))
        .collect()
}

/// Updates of a workload's readings, as if each came from one of two walls that meet on its axis, or from an obstacle before a free
/// limit of varying range.
pub fn walls(workload: &Workload) -> Vec<Update> {
    let update = |(number, reading): (u64, &Reading)| {
        let (pose, beta) = (reading.record.pose, workload.sensors[reading.record.sensor as usize].half_width);
        let at = |turn: f64, d: f64| {
            let bearing = pose.heading + turn;
            Point::new(pose.x + d * bearing.cos(), pose.y + d * bearing.sin())
        };
        // To the right of the axis and, aslant, to its left.
        let sides = [
            [at(-beta, reading.range), at(0.0, reading.range)],
            [at(0.0, reading.range), at(beta, 0.9 * reading.range)],
        ];
        let part = |side: [Point; 2]| Part {
            origin: Origin::Wall,
            weight: 0.35,
            free: Some(Fan { vertices: side.to_vec() }),
            occupied: vec![side],
        };
        let limit = |k: u32| at(beta * (f64::from(k) / 8.0 - 1.0), reading.range * if k % 4 < 2 { 1.0 } else { 0.7 });
        let limit = Some(Fan { vertices: (0..=16).map(limit).collect() });
        let routine = Some(Routine { weight: 0.3, free: limit.clone(), arc: limit, occupies: true });
        Update { reading: *reading, number, case: Case::Associated, parts: sides.map(part).into(), routine }
    };
    (0..).zip(&workload.readings).map(update).collect()
}

/// Beams of a synthetic laser scan, over half a circle.
const BEAMS: usize = 180;

/// Laser scans of 180 beams of 1 to 8 m, with class labels 1 to 6, along a walk of 10 cm a step over a square map: as many as
/// come to `count` readings, one at least. `resolution` is metres; the map's edge is `cells`.
pub fn scans(count: usize, resolution: f64, cells: usize, seed: u64) -> Workload {
    let mut random = Random::new(seed);
    let edge = cells as f64 * resolution;
    let step = std::f64::consts::PI / BEAMS as f64;
    let sensor = Sensor {
        id: "laser".into(),
        kind: Kind::Laser,
        x: 0.0,
        y: 0.0,
        axis: 0.0,
        half_width: step / 2.0,
        r_min: 0.05,
        r_max: 80.0,
        at_r_max: AtMax::NoEcho,
        hit_range: 80.0,
        no_echo_range: 0.0,
        epsilon: None,
    };
    let mut robot = Pose { x: edge / 2.0, y: edge / 2.0, heading: 0.0 };
    let mut readings = Vec::with_capacity(count);
    for scan in 0..(count / BEAMS).max(1) as u64 {
        robot.heading += random.uniform(-0.3, 0.3);
        let (x, y) = (robot.x + 0.1 * robot.heading.cos(), robot.y + 0.1 * robot.heading.sin());
        // The robot turns round at the edge.
        if x.min(y) < 0.0 || x.max(y) > edge {
            robot.heading += std::f64::consts::PI;
        } else {
            (robot.x, robot.y) = (x, y);
        }
        for beam in 0..BEAMS {
            let heading = robot.heading - std::f64::consts::FRAC_PI_2 + (beam as f64 + 0.5) * step;
            let range = random.uniform(1.0, 8.0);
            let label = Some((beam * 6 / BEAMS) as u16 + 1);
            let pose = Pose { heading, ..robot };
            let record = Record { t: scan as f64, scan, sensor: 0, robot, pose, range, label, line: scan + 1 };
            readings.push(Reading { record, outcome: Outcome::Hit, range });
        }
    }
    Workload {
        name: format!("scans of 180 beams, {:.0} cm", 100.0 * resolution),
        grid: GridSpec { anchor: (0.0, 0.0), resolution, i0: 0, j0: 0, width: cells, height: cells },
        sensors: vec![sensor],
        readings,
    }
}

/// The workloads of the methods that take scans: cells of 10 cm and 2 cm.
pub fn standard_scans(count: usize) -> Vec<Workload> {
    [(0.1, 256), (0.02, 1024)].iter().map(|&(resolution, cells)| scans(count, resolution, cells, 1)).collect()
}
