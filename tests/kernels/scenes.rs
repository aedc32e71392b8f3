//! Scenes: real logs, and made-up readings that go where real ones rarely do. All are the same at every run.

use crate::common::{Scene, data};
use echogrid::binning::snap::Edges;
use echogrid::binning::wedge;
use echogrid::feature::{Case, Fan, Origin, Part, Routine, Update};
use echogrid::geometry::plane::Point;
use echogrid::grid::GridSpec;
use echogrid::log::reading::{Outcome, Pose, Reading, Record, classify};
use echogrid::log::{Log, Options};
use echogrid::pipeline::readings::ReadingInput;
use echogrid::sensor::{AtMax, Kind, Sensor};

/// xorshift64*: the same numbers everywhere.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn word(&mut self) -> u32 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32) as u32
    }

    /// From `low` up to `high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.word()) / 4_294_967_296.0
    }

    pub fn below(&mut self, n: u32) -> u32 {
        self.word() % n
    }
}

/// A sonar at the robot's centre: β in degrees, everything up to `r_max` counts.
pub fn sonar(half_width_deg: f64, r_min: f64, r_max: f64) -> Sensor {
    Sensor {
        id: "s".into(),
        kind: Kind::Sonar,
        x: 0.0,
        y: 0.0,
        axis: 0.0,
        half_width: half_width_deg.to_radians(),
        r_min,
        r_max,
        at_r_max: AtMax::Hit,
        hit_range: r_max,
        no_echo_range: 0.8 * r_max,
        epsilon: None,
    }
}

pub fn laser(half_width_deg: f64, r_max: f64) -> Sensor {
    Sensor { id: "l".into(), kind: Kind::Laser, ..sonar(half_width_deg, 0.05, r_max) }
}

pub fn reading(sensor: usize, pose: (f64, f64, f64), range: f64, outcome: Outcome) -> Reading {
    let pose = Pose { x: pose.0, y: pose.1, heading: pose.2 };
    let record = Record { t: 0.0, scan: 0, sensor: sensor as u32, robot: pose, pose, range, label: None, line: 1 };
    Reading { record, outcome, range }
}

pub fn scene(name: &str, grid: GridSpec, sensors: Vec<Sensor>, readings: Vec<Reading>) -> Scene {
    Scene {
        name: name.into(),
        grid,
        sensors,
        items: readings.into_iter().map(|r| (r, None)).collect(),
        updates: Vec::new(),
    }
}

pub fn bounds(bounds: [f64; 4], resolution: f64) -> GridSpec {
    GridSpec::from_bounds(bounds, resolution).unwrap()
}

/// Random readings from inside a box; a fifth have no echo.
pub fn random(seed: u64, count: usize, area: [f64; 4], sensors: &[Sensor], shortest: f64) -> Vec<Reading> {
    let mut r = Random::new(seed);
    (0..count)
        .map(|_| {
            let k = r.below(sensors.len() as u32) as usize;
            let pose = (r.within(area[0], area[2]), r.within(area[1], area[3]), r.within(-7.0, 7.0));
            // Short ranges are commoner.
            let far = r.within(0.0, 1.0);
            let range = shortest + (sensors[k].hit_range - shortest) * far * far;
            match r.below(5) {
                0 if sensors[k].no_echo_range > 0.0 => reading(k, pose, sensors[k].no_echo_range, Outcome::NoEcho),
                _ => reading(k, pose, range, Outcome::Hit),
            }
        })
        .collect()
}

fn mixed() -> Vec<Sensor> {
    let mut lasers = laser(0.25, 7.0);
    lasers.no_echo_range = 3.0;
    vec![sonar(5.0, 0.17, 5.0), sonar(12.5, 0.17, 4.0), sonar(27.0, 0.3, 3.0), sonar(60.0, 0.1, 2.0), lasers]
}

/// 20,000 overlapping readings over 1024 × 1024 cells.
pub fn crowd() -> Scene {
    let sensors = mixed();
    let readings = random(1, 20_000, [-0.5, -0.5, 51.7, 51.7], &sensors, 0.2);
    let crowd = scene("crowd", bounds([0.0, 0.0, 51.2, 51.2], 0.05), sensors, readings);
    assert_eq!((crowd.grid.width, crowd.grid.height), (1024, 1024));
    crowd
}

/// A grid of neither whole tiles nor chunks, with sensors in and around it, some too far to reach it; narrow sonars among them.
pub fn ragged() -> Scene {
    let mut sensors = mixed();
    sensors.extend([sonar(0.7, 0.1, 5.0), sonar(3.0, 0.1, 5.0)]);
    let readings = random(2, 600, [-1.5, -1.5, 5.2, 6.8], &sensors, 0.2);
    let ragged = scene("ragged", bounds([0.0, 0.0, 3.7, 5.3], 0.1), sensors, readings);
    assert_eq!((ragged.grid.width, ragged.grid.height), (37, 53));
    ragged
}

/// Cones that hold whole tiles, of which some lie across the grid's edge.
pub fn large() -> Scene {
    let sensors = vec![sonar(25.0, 0.2, 7.0), sonar(9.0, 0.2, 7.0), laser(0.5, 7.0)];
    let readings = random(23, 240, [0.0, 0.0, 12.15, 11.35], &sensors, 3.0);
    scene("large", bounds([0.0, 0.0, 12.15, 11.35], 0.05), sensors, readings)
}

/// A parked robot: the same cells freed until nothing is left of their doubt, now and then an echo from among them.
pub fn parked() -> Scene {
    let sensors = vec![sonar(12.5, 0.17, 5.0)];
    let at = |k: usize| (1.013, 1.021, 0.3 + 0.02 * (k % 7) as f64);
    let range = |k: usize| if k % 10 == 9 { 1.0 + 0.15 * ((k / 10) % 9) as f64 } else { 3.0 + 0.01 * (k % 3) as f64 };
    let readings = (0..600).map(|k| reading(0, at(k), range(k), Outcome::Hit)).collect();
    scene("parked", bounds([0.0, 0.0, 5.0, 5.0], 0.05), sensors, readings)
}

/// Four chunks, the readings about the corner where they meet.
pub fn chunks() -> Scene {
    let sensors = mixed();
    let mut readings = random(3, 500, [47.2, 47.2, 55.2, 55.2], &sensors, 0.2);
    readings.extend(random(4, 60, [0.0, 0.0, 65.0, 58.0], &sensors, 0.2));
    scene("chunks", bounds([0.0, 0.0, 65.3, 58.1], 0.05), sensors, readings)
}

/// Readings that reach farther than 1024 cells, over a small grid: sonars near and far, lasers of 80 m.
pub fn wide() -> Scene {
    let mut far = sonar(8.0, 0.3, 60.0);
    far.epsilon = Some(0.4);
    let mut laser = laser(0.25, 80.0);
    laser.no_echo_range = 70.0;
    let mut broad = sonar(60.0, 0.3, 30.0);
    broad.no_echo_range = 0.0;
    let sensors = vec![far, laser.clone(), broad, Sensor { r_max: 600.0, hit_range: 600.0, ..laser }];
    let mut readings = random(5, 250, [-2.0, -2.0, 6.0, 5.0], &sensors[..3], 0.2);
    // From afar, so that arcs lie in the grid too.
    let mut r = Random::new(6);
    for k in 0..500 {
        let (bearing, d) = (r.within(0.0, std::f64::consts::TAU), r.within(18.0, 59.0));
        let (x, y) = (2.0 + d * bearing.cos(), 1.5 + d * bearing.sin());
        let aim = bearing + std::f64::consts::PI + r.within(-0.03, 0.03);
        let z = (d + r.within(-2.0, 2.0)).min(if k % 3 == 2 { 30.0 } else { 60.0 });
        readings.push(reading(k % 3, (x, y, aim), z, Outcome::Hit));
    }
    // So far that even products of a coordinate and a direction leave 32 bits.
    for _ in 0..60 {
        let (bearing, d) = (r.within(0.0, std::f64::consts::TAU), r.within(200.0, 590.0));
        let (x, y) = (r.within(0.0, 4.0) + d * bearing.cos(), r.within(0.0, 3.0) + d * bearing.sin());
        readings.push(reading(3, (x, y, bearing + std::f64::consts::PI), d + r.within(-1.0, 2.0), Outcome::Hit));
    }
    // On round numbers, where arcs pass through cell centres exactly.
    for k in 0..200 {
        let place = (0.01 + 0.02 * f64::from(r.below(200)), 0.01 + 0.02 * f64::from(r.below(150)));
        let (heading, d) = (std::f64::consts::FRAC_PI_2 * f64::from(k % 4), 25.0 + f64::from(k / 4));
        let from = [(-d, 0.0), (0.0, -d), (d, 0.0), (0.0, d)][k as usize % 4];
        readings.push(reading(
            1,
            (place.0 + from.0, place.1 + from.1, heading),
            d + 0.02 * f64::from(k % 3),
            Outcome::Hit,
        ));
    }
    scene("wide", bounds([0.0, 0.0, 4.0, 3.0], 0.02), sensors, readings)
}

/// Where rules change hands: β 0 and 60°, ranges below ε and r_min, sensors on cell centres, corners and edges, axes along
/// the axes and diagonals.
pub fn edges() -> Scene {
    let sonars = [0.0, 15.0, 45.0, 60.0].map(|beta| sonar(beta, 0.3, 4.0));
    let deep = Sensor { epsilon: Some(0.5), ..sonar(20.0, 0.3, 4.0) };
    let thin = Sensor { epsilon: Some(0.01), ..sonar(20.0, 0.3, 4.0) };
    let flat = Sensor { epsilon: Some(1e-4), ..sonar(20.0, 0.0, 4.0) };
    let mut sensors = sonars.to_vec();
    sensors.extend([deep, thin, flat, laser(0.0, 4.0), laser(1.0, 4.0)]);
    let ranges = [0.0, 0.02, 0.05, 0.1, 0.25, 0.3, 0.35, 0.399, 0.4, 0.401, 0.5, 1.0, 2.0, 3.2];
    let mut r = Random::new(7);
    let mut readings = Vec::new();
    for turn in 0..16 {
        for k in 0..sensors.len() {
            for z in ranges {
                let on = |n: u32| 0.05 * f64::from(n);
                let pose = (on(r.below(160)), on(r.below(160)), std::f64::consts::FRAC_PI_8 * f64::from(turn));
                let outcome = if r.below(6) == 0 { Outcome::NoEcho } else { Outcome::Hit };
                readings.push(reading(k, pose, z, outcome));
            }
        }
    }
    scene("edges", bounds([0.0, 0.0, 8.0, 8.0], 0.1), sensors, readings)
}

/// Readings of which none reaches the grid.
pub fn nowhere() -> Scene {
    let sensors = mixed();
    let mut readings = random(8, 40, [100.0, -3.0, 110.0, 7.0], &sensors, 0.2);
    // Near enough to be looked at, but turned away.
    readings.extend((0..40).map(|k| reading(0, (-0.5, 0.1 * f64::from(k), 3.0), 2.0, Outcome::Hit)));
    scene("nowhere", bounds([0.0, 0.0, 4.0, 4.0], 0.1), sensors, readings)
}

/// Laser scans with the wedges of their beams, to the bisectors with the neighbours; the fans stand on round bearings too.
pub fn fans() -> Scene {
    let sensors = vec![laser(0.5, 12.0)];
    let step = 1f64.to_radians();
    let mut r = Random::new(9);
    let mut items: Vec<ReadingInput> = Vec::new();
    for scan in 0..30 {
        let round = scan % 3 == 0;
        let place = |r: &mut Random| if round { 0.05 * f64::from(r.below(120)) } else { r.within(-1.0, 7.0) };
        let (x, y) = (place(&mut r), place(&mut r));
        let first = if round { -std::f64::consts::FRAC_PI_2 } else { r.within(-3.0, 3.0) };
        for beam in 0..180 {
            // Round fans have an edge on each of the world's axes.
            let h = first + (f64::from(beam) + 0.5) * step;
            let z = 0.3 + r.within(0.0, 6.0) * r.within(0.0, 1.0);
            items.push((reading(0, (x, y, h), z, Outcome::Hit), Some((h + 0.5 * step, h - 0.5 * step))));
        }
    }
    Scene { name: "fans".into(), grid: bounds([0.0, 0.0, 6.1, 5.9], 0.05), sensors, items, updates: Vec::new() }
}

/// Beams of 40 m in wedges, over a small grid: the laser truth in 64 bits.
pub fn wide_fans() -> Scene {
    let mut fans = fans();
    let mut r = Random::new(10);
    for (reading, edges) in &mut fans.items {
        let heading = reading.record.pose.heading;
        let d = r.within(0.0, 1.0) * 36.0;
        reading.record.pose.x = 2.0 - d * heading.cos() + r.within(-1.5, 1.5);
        reading.record.pose.y = 1.5 - d * heading.sin() + r.within(-1.5, 1.5);
        reading.range = d.max(20.0) + r.within(0.0, 3.0);
        *edges = Some((heading + 0.004, heading - 0.004));
    }
    fans.name = "wide fans".into();
    fans.grid = bounds([0.0, 0.0, 4.0, 3.0], 0.02);
    fans.sensors[0].r_max = 40.0;
    fans.sensors[0].hit_range = 40.0;
    fans
}

/// A real log's readings on its default grid. `literal`: the values of the specification's test, not the preset's.
pub fn real(name: &str, resolution: f64, literal: bool) -> Option<Scene> {
    let path = data(name)?;
    let mut options = Options::default();
    if literal {
        let keys = [("beta", "15deg"), ("mounts", "none"), ("r_min", "0.17")];
        let ranges = ["r_max", "hit_range", "no_echo_range"].map(|key| (key, "5"));
        for (key, value) in keys.into_iter().chain(ranges) {
            assert!(options.overrides.set(key, value).unwrap());
        }
    }
    let log = Log::open(&path, &options).unwrap();
    let sensors = log.header().sensors.clone();
    let judged = log.records().unwrap().map(|r| r.unwrap()).map(|r| classify(r, &sensors[r.sensor as usize]));
    let readings: Vec<Reading> = judged.filter_map(Result::ok).collect();
    let title = format!("{name} at {resolution} m{}", if literal { ", literal" } else { "" }).replace('/', "-");
    Some(scene(&title, around(&sensors, &readings, resolution), sensors, readings))
}

/// The default grid: the box of every sensor ± its reach.
pub fn around(sensors: &[Sensor], readings: &[Reading], resolution: f64) -> GridSpec {
    let mut b = [f64::MAX, f64::MAX, f64::MIN, f64::MIN];
    for r in readings {
        let reach = r.range + sensors[r.record.sensor as usize].epsilon(resolution);
        let p = r.record.pose;
        b = [b[0].min(p.x - reach), b[1].min(p.y - reach), b[2].max(p.x + reach), b[3].max(p.y + reach)];
    }
    GridSpec::around(b, resolution).unwrap()
}

/// Laser scans of the same run as the sonar log: every `step`th, on a grid of 5 cm cells.
pub fn real_lasers(step: u64) -> Option<Scene> {
    let path = data("sonar_ring_8/test1")?;
    let log = Log::open(&path, &Options { kind: Some(Kind::Laser), ..Options::default() }).unwrap();
    let sensors = log.header().sensors.clone();
    let records: Vec<Record> = log.records().unwrap().map(|r| r.unwrap()).filter(|r| r.scan % step == 0).collect();
    let scans = records.chunk_by(|a, b| a.scan == b.scan);
    let beams = scans.flat_map(|scan| scan.iter().copied().zip(wedge::edges(scan, &sensors)));
    let used = |(r, edges): (Record, Edges)| Some((classify(r, &sensors[r.sensor as usize]).ok()?, Some(edges)));
    let items: Vec<ReadingInput> = beams.filter_map(used).collect();
    assert!(items.len() > 1000);
    let readings: Vec<Reading> = items.iter().map(|i| i.0).collect();
    let grid = around(&sensors, &readings, 0.05);
    Some(Scene { name: "sonar_ring_8-test1 laser".into(), grid, sensors, items, updates: Vec::new() })
}

/// Scans of labelled beams that go where real ones rarely do: poses on a lattice, so that many are as near as others, some at one
/// place, some on a cell's centre; beams along the axes, in one direction, opposite, alone; mounts away from the robot's centre;
/// readings that came back from nowhere, and from the sensor itself.
pub fn scans() -> Scene {
    let mut random = Random::new(5);
    let sensors = vec![
        Sensor { no_echo_range: 0.0, r_min: 0.0, ..laser(0.5, 40.0) },
        Sensor { no_echo_range: 0.0, ..sonar(12.0, 0.0, 4.0) },
    ];
    let grid = GridSpec { anchor: (0.0, 0.0), resolution: 0.1, i0: -3, j0: 2, width: 43, height: 37 };
    let mut items: Vec<ReadingInput> = Vec::new();
    for scan in 0..150u64 {
        let lattice = |random: &mut Random| 0.05 * f64::from(random.below(80));
        let robot = match scan % 7 {
            0 => Pose { x: 1.65, y: 1.85, heading: 0.3 },
            1 => Pose { x: random.within(-1.0, 5.0), y: random.within(-1.0, 5.0), heading: random.within(-4.0, 4.0) },
            _ => Pose { x: lattice(&mut random), y: lattice(&mut random), heading: 0.0 },
        };
        let count = [1, 2, 3, 8, 24, 60][random.below(6) as usize];
        let quarter = std::f64::consts::FRAC_PI_2;
        for beam in 0..count {
            let bearing = match scan % 5 {
                0 => quarter * f64::from(random.below(5)),
                1 => random.within(-3.2, 3.2),
                2 if count == 2 => f64::from(beam) * 2.0 * quarter,
                _ => -quarter + 2.0 * quarter * f64::from(beam) / f64::from(count.max(2) - 1),
            };
            let range = match random.below(20) {
                0 => f64::INFINITY,
                1 => 0.0,
                2 => 35.0,
                3 => 0.05 * f64::from(random.below(60)),
                _ => random.within(0.2, 3.5),
            };
            let sonars = scan % 11 == 3;
            let pose = if sonars {
                robot.compose(0.2 * bearing.cos(), 0.2 * bearing.sin(), bearing)
            } else {
                robot.compose(0.0, 0.0, bearing)
            };
            let label = Some(random.below(7) as u16).filter(|l| *l > 0);
            let sensor = u32::from(sonars);
            let record = Record { t: 0.0, scan, sensor, robot, pose, range, label, line: scan + 1 };
            items.push((Reading { record, outcome: Outcome::Hit, range }, None));
        }
    }
    Scene { name: "scans".into(), grid, sensors, items, updates: Vec::new() }
}

/// Updates of every shape: fans of many triangles and of none, clockwise, of vertices on the sensor or behind one another, up to
/// 170° wide; lines along the axes and aslant, and points; limits to either side of the routine part, or none of it; half of all
/// on a lattice of half cells, so that cells lie exactly on edges; sensors in the grid, about it and far from it.
pub fn updates() -> Scene {
    let sensors = vec![sonar(15.0, 0.17, 5.0), sonar(40.0, 0.1, 2.0), sonar(5.0, 0.2, 4.0)];
    let grid = GridSpec { anchor: (0.0, 0.0), resolution: 0.1, i0: -31, j0: -27, width: 83, height: 61 };
    updates_on("updates", 11, 1200, grid, sensors)
}

/// The same on any grid.
pub fn updates_on(name: &str, seed: u64, count: u64, grid: GridSpec, sensors: Vec<Sensor>) -> Scene {
    let mut made = Made { random: Random::new(seed), half: grid.resolution / 2.0, lattice: false };
    let (x0, y0) = (grid.x0(), grid.y0());
    let [width, height] = [grid.width, grid.height].map(|n| n as f64 * grid.resolution);
    let (mut items, mut updates) = (Vec::new(), Vec::new());
    for number in 0..count {
        made.lattice = made.random.below(2) == 0;
        let far = if made.random.below(20) == 0 { 9.0 } else { 1.5 };
        let x = made.random.within(x0 - far, x0 + width + far);
        let y = made.random.within(y0 - far, y0 + height + far);
        let at = made.snap(Point::new(x, y));
        let heading = made.bearing();
        let k = made.random.below(sensors.len() as u32) as usize;
        let range = made.random.within(0.0, sensors[k].r_max);
        let outcome = if made.random.below(6) == 0 { Outcome::NoEcho } else { Outcome::Hit };
        let mut reading = reading(k, (at.x, at.y, heading), range, outcome);
        (reading.record.line, reading.record.scan) = (number + 1, number);
        updates.push(made.update(reading, number));
        items.push((reading, None));
    }
    Scene { name: name.into(), grid, sensors, items, updates }
}

/// Random updates under way.
struct Made {
    random: Random,
    /// Half a cell.
    half: f64,
    lattice: bool,
}

impl Made {
    fn snap(&self, p: Point) -> Point {
        let near = |v: f64| (v / self.half).round() * self.half;
        if self.lattice { p.map(near) } else { p }
    }

    fn bearing(&mut self) -> f64 {
        match self.random.below(4) {
            0 => std::f64::consts::FRAC_PI_4 * f64::from(self.random.below(8)),
            _ => self.random.within(-3.2, 3.2),
        }
    }

    /// A point that far at most from a sensor, in that direction.
    fn point(&mut self, sensor: Point, bearing: f64, most: f64) -> Point {
        let d = self.random.within(0.0, most);
        self.snap(Point::new(sensor.x + d * bearing.cos(), sensor.y + d * bearing.sin()))
    }

    fn fan(&mut self, sensor: Point, heading: f64, most: f64) -> Fan {
        let count = [0, 1, 2, 2, 2, 3, 4, 7, 20][self.random.below(9) as usize];
        let wide = [0.1, 0.5, 0.5, 1.0, 2.9][self.random.below(5) as usize];
        let mut vertices = Vec::new();
        let mut bearing = heading - wide / 2.0;
        for _ in 0..count {
            vertices.push(match self.random.below(12) {
                0 => sensor,
                _ => self.point(sensor, bearing, most),
            });
            // Now and then two behind one another.
            if self.random.below(4) > 0 {
                bearing += wide / f64::from(count);
            }
        }
        if self.random.below(15) == 0 {
            vertices.reverse();
        }
        Fan { vertices }
    }

    fn lines(&mut self, sensor: Point, heading: f64, most: f64) -> Vec<[Point; 2]> {
        let count = self.random.below(4);
        let line = |_| {
            let turn = self.random.within(-0.6, 0.6);
            let a = self.point(sensor, heading + turn, most);
            let along = self.random.within(0.0, 1.5);
            let b = match self.random.below(5) {
                0 => a,
                1 => Point::new(a.x + along, a.y),
                2 => Point::new(a.x, a.y - along),
                3 => Point::new(a.x + along, a.y + along),
                _ => self.point(sensor, heading - turn, most),
            };
            [a, self.snap(b)]
        };
        (0..count).map(line).collect()
    }

    fn update(&mut self, reading: Reading, number: u64) -> Update {
        let pose = reading.record.pose;
        let (sensor, most) = (pose.position(), 3.5);
        let count = self.random.below(3);
        let mut parts: Vec<Part> = Vec::new();
        for _ in 0..count {
            let free = (self.random.below(5) > 0).then(|| self.fan(sensor, pose.heading, most));
            let occupied = self.lines(sensor, pose.heading, most);
            parts.push(Part { origin: Origin::Wall, weight: self.random.within(0.0, 1.0), free, occupied });
        }
        let limit = |made: &mut Made| (made.random.below(2) == 0).then(|| made.fan(sensor, pose.heading, most));
        let weight = if count == 0 { 1.0 } else { self.random.within(0.0, 1.0) };
        let occupies = self.random.below(5) > 0;
        let routine = (count == 0 || self.random.below(4) > 0).then(|| Routine {
            weight,
            free: limit(self),
            arc: limit(self),
            occupies,
        });
        let sum = parts.iter().map(|p| p.weight).sum::<f64>() + routine.as_ref().map_or(0.0, |r| r.weight);
        parts.iter_mut().for_each(|p| p.weight /= sum);
        let routine = routine.map(|r| Routine { weight: r.weight / sum, ..r });
        Update { reading, number, case: Case::Associated, parts, routine }
    }
}
