//! Synthetic logs for benchmarks and tests: random overlapping cones, the same on every machine.

use crate::grid::GridSpec;
use crate::reading::{Outcome, Pose, Reading, Record};
use crate::sensor::{Kind, Sensor};
use crate::world::random::Random;

/// A log in memory: readings, their sensors, their grid.
#[derive(Debug, Clone)]
pub struct Workload {
    /// Its name in tables.
    pub name: String,
    /// The grid.
    pub grid: GridSpec,
    /// The sensors.
    pub sensors: Vec<Sensor>,
    /// The readings.
    pub readings: Vec<Reading>,
}

/// Cones of one width and range, anywhere over a square map in any direction.
///
/// `width` is the whole beam's, radians; `range` and `resolution` are metres; the map's edge is `cells`.
pub fn cones(count: usize, width: f64, range: f64, resolution: f64, cells: usize, seed: u64) -> Workload {
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
        .map(|&(range, resolution)| cones(count, width, range, resolution, 1024, 1))
        .collect()
}
