//! Simulates the log of a rig that follows a world's trajectory. Every reading has a random generator of its own, seeded by
//! (seed, scan, number), so that a log depends on the seed and not on the number of threads.

use super::model::World;
use super::path::rounded;
use super::random::Random;
use super::rig::{Rig, Transducer};
use super::scene::{Listener, Scene};
use super::sonar::{Beam, Detection};
use crate::log::Writer;
use crate::log::reading::{Pose, Record};
use crate::sensor::Kind;
use crate::{Error, Result};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::io::Write;

/// Scans that are simulated before they are written.
const CHUNK: u64 = 256;
/// Steps of a reported range in one metre.
const STEPS_PER_METRE: f64 = 100.0;
/// The farthest false echo, metres.
const FALSE_ECHO_RANGE: f64 = 1.5;

/// What a simulation wrote.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Simulated {
    /// Scans.
    pub scans: u64,
    /// Readings written.
    pub readings: u64,
    /// Of them, those without an echo.
    pub no_echo: u64,
}

/// What to simulate.
#[derive(Debug, Clone, Copy)]
pub struct Simulation<'a> {
    /// The world.
    pub world: &'a World,
    /// The robot's sensors.
    pub rig: &'a Rig,
    /// The seed of all random numbers.
    pub seed: u64,
    /// The number of scans; `None`: one at each pose of the trajectory. More repeat the trajectory.
    pub scans: Option<u64>,
}

/// Simulates a log and writes it to `out`, in constant memory. `progress` gets the number of scans done.
///
/// # Errors
/// [`Error::Usage`] if the rig does not fit through the world, or no scan is asked for; [`Error::Resources`] if the log
/// can't be written.
pub fn simulate<W: Write>(simulation: &Simulation<'_>, out: W, progress: &dyn Fn(u64)) -> Result<(Simulated, W)> {
    let Simulation { world, rig, seed, scans } = *simulation;
    if *rig != world.rig {
        rig.check(&world.index, &world.trajectory).map_err(Error::Usage)?;
    }
    let sensors: Vec<_> = rig.transducers.iter().map(|t| t.sensor.clone()).collect();
    let mut writer = Writer::new(out, &sensors, &world.classes)?;
    let scans = scans.unwrap_or(world.trajectory.len() as u64);
    let mut done = Simulated { scans, ..Simulated::default() };
    let mut first = 0;
    while first < scans {
        let next = scans.min(first + CHUNK);
        let chunk: Vec<Vec<Record>> = (first..next).into_par_iter().map(|k| scan(world, rig, seed, k)).collect();
        for record in chunk.iter().flatten() {
            writer.write(record)?;
            done.no_echo += u64::from(record.range == f64::INFINITY);
        }
        first = next;
        progress(first);
    }
    done.readings = writer.records();
    if done.readings == 0 {
        return Err(Error::Usage("no scan was asked for: give --scans 1 or more".into()));
    }
    Ok((done, writer.finish()?))
}

/// The readings of one scan, in the order of the rig; the range of a missing echo is +∞.
pub fn scan(world: &World, rig: &Rig, seed: u64, scan: u64) -> Vec<Record> {
    let Some((robot, t)) = world.scan_pose(scan) else { return Vec::new() };
    let reach = rig.sonar_reach();
    let scene = (reach > 0.0).then(|| {
        let [low, high] = [-1.0, 1.0].map(|s| robot.x + s * (reach + rig.spread()));
        let corners = world.corners_between(low, high);
        let listener = Listener { centre: robot.position(), spread: rig.spread(), reach };
        Scene::new(&world.index, corners, listener, rig.physics)
    });
    let start = Random::new(mix(seed, scan, u64::MAX)).uniform(0.0, TAU);
    let mut records = Vec::with_capacity(rig.readings() as usize);
    for (index, transducer) in (0..).zip(&rig.transducers) {
        for beam in 0..transducer.beams {
            let pose = transducer.pose(robot, start, beam);
            let number = records.len() as u64;
            let mut random = Random::new(mix(seed, scan, number));
            let detected = match (transducer.sensor.kind, &scene) {
                (Kind::Sonar, Some(scene)) => sonar(scene, rig, transducer, pose, &mut random),
                _ => laser(world, transducer, pose, &mut random),
            };
            let Detection { distance: range, class: label } =
                detected.unwrap_or(Detection { distance: f64::INFINITY, class: None });
            let line = scan * rig.readings() + number + 2; // its line in the log, after the header
            records.push(Record { t, scan, sensor: index, robot, pose, range, label, line });
        }
    }
    records
}

impl Transducer {
    /// Its pose for one of its readings; `start` is the bearing at which a circular scan begins, radians.
    fn pose(&self, robot: Pose, start: f64, beam: u32) -> Pose {
        let turn = f64::from(beam) * self.step;
        if self.circles {
            let centre = Pose { heading: (start + turn).rem_euclid(TAU), ..robot };
            return rounded(centre.compose(self.sensor.x, self.sensor.y, self.sensor.axis));
        }
        let off = turn - f64::from(self.beams - 1) * self.step / 2.0;
        rounded(robot.compose(self.sensor.x, self.sensor.y, self.sensor.axis + off))
    }

    /// The range that the sensor reports of a distance, with noise, metres; `None` beyond its limits.
    fn report(&self, d: f64, random: &mut Random) -> Option<f64> {
        let noisy = d + (self.noise.metres + self.noise.share * d) * random.normal();
        let z = (noisy * STEPS_PER_METRE).round() / STEPS_PER_METRE;
        (z >= self.sensor.r_min && z <= self.sensor.r_max).then_some(z)
    }
}

/// What a sonar reports: an echo, a false one, or the echo of another beam.
fn sonar(scene: &Scene, rig: &Rig, t: &Transducer, pose: Pose, random: &mut Random) -> Option<Detection> {
    let s = &t.sensor;
    let chance = random.unit();
    if chance < rig.spurious {
        let d = random.uniform(s.r_min, FALSE_ECHO_RANGE.clamp(s.r_min, s.r_max));
        return t.report(d, random).map(|distance| Detection { distance, class: None });
    }
    let cross_talk = chance < rig.spurious + rig.cross_talk;
    let heading = if cross_talk { random.uniform(0.0, TAU) } else { pose.heading };
    let axis = Pose { heading, ..pose }.direction();
    let beam = Beam { origin: pose.position(), axis, half_width: s.half_width, r_min: s.r_min, r_max: s.r_max };
    let Detection { distance, class } = scene.detect(&beam, random)?;
    t.report(distance, random).map(|distance| Detection { distance, class: class.filter(|_| !cross_talk) })
}

/// What a laser beam reports.
fn laser(world: &World, t: &Transducer, pose: Pose, random: &mut Random) -> Option<Detection> {
    let hit = world.index.cast_ray(pose.position(), pose.direction(), t.sensor.r_max)?;
    t.report(hit.distance, random).map(|distance| Detection { distance, class: hit.class })
}

/// One seed from three numbers.
fn mix(seed: u64, scan: u64, number: u64) -> u64 {
    let a = Random::new(seed).bits();
    let b = Random::new(a ^ scan.wrapping_mul(0x9E37_79B9_7F4A_7C15)).bits();
    Random::new(b ^ number.wrapping_mul(0xD1B5_4A32_D192_ED03)).bits()
}
