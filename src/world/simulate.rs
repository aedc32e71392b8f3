//! Drives a rig through a world. Every reading has a generator of its own, seeded by (seed, scan, number), so that a log
//! is the same for a seed whatever the number of threads.

use super::World;
use super::echo::{Ping, Scene};
use super::path::rounded;
use super::random::Random;
use super::rig::{Rig, Transducer};
use crate::log::Writer;
use crate::log::reading::{Pose, Record};
use crate::sensor::Kind;
use crate::{Error, Result};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::io::Write;

/// Scans simulated at a time, before they are written.
const CHUNK: u64 = 256;
/// Ranges are whole multiples of 1/this metres.
const PER_METRE: f64 = 100.0;
/// False echoes come from no farther, metres.
const FALSE_REACH: f64 = 1.5;

/// How a simulation went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Simulated {
    /// Scans.
    pub scans: u64,
    /// Readings written.
    pub readings: u64,
    /// Of them, those without an echo.
    pub no_echo: u64,
}

/// Simulates `scans` scans (by default one at each of the path's stops; more go round the path again) and writes them as
/// they come. `progress` gets the number of scans done.
///
/// # Errors
/// [`Error::Usage`] if the rig does not fit through the world; [`Error::Resources`] if the log can't be written.
pub fn simulate<W: Write>(
    world: &World,
    rig: &Rig,
    seed: u64,
    scans: Option<u64>,
    out: W,
    progress: &dyn Fn(u64),
) -> Result<(Simulated, W)> {
    if *rig != world.rig {
        rig.check(&world.index, &world.stops).map_err(Error::Usage)?;
    }
    let sensors: Vec<_> = rig.transducers.iter().map(|t| t.sensor.clone()).collect();
    let mut writer = Writer::new(out, &sensors, &world.classes)?;
    let scans = scans.unwrap_or(world.stops.len() as u64);
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

/// The readings of one scan, in the rig's order; a missing echo's range is +∞.
pub fn scan(world: &World, rig: &Rig, seed: u64, scan: u64) -> Vec<Record> {
    let Some((robot, t)) = world.stop(scan) else { return Vec::new() };
    let reach = rig.sonar_reach();
    let scene = (reach > 0.0).then(|| {
        let [low, high] = [-1.0, 1.0].map(|s| robot.x + s * (reach + rig.spread()));
        let corners = world.corners_between(low, high);
        Scene::new(&world.index, corners, (robot.x, robot.y), rig.spread(), reach, rig.physics)
    });
    let start = Random::new(mix(seed, scan, u64::MAX)).uniform(0.0, TAU);
    let mut records = Vec::with_capacity(rig.readings() as usize);
    for (index, transducer) in (0..).zip(&rig.transducers) {
        for beam in 0..transducer.beams {
            let pose = transducer.pose(robot, start, beam);
            let number = records.len() as u64;
            let mut random = Random::new(mix(seed, scan, number));
            let heard = match (transducer.sensor.kind, &scene) {
                (Kind::Sonar, Some(scene)) => sonar(scene, rig, transducer, pose, &mut random),
                _ => laser(world, transducer, pose, &mut random),
            };
            let (range, label) = heard.unwrap_or((f64::INFINITY, None));
            let line = scan * rig.readings() + number + 2; // as the log on disk has it, after its header
            records.push(Record { t, scan, sensor: index, robot, pose, range, label, line });
        }
    }
    records
}

impl Transducer {
    /// Its pose for one of its readings.
    fn pose(&self, robot: Pose, start: f64, beam: u32) -> Pose {
        let turn = f64::from(beam) * self.step;
        if self.circles {
            let centre = Pose { heading: (start + turn).rem_euclid(TAU), ..robot };
            return rounded(centre.compose(self.sensor.x, self.sensor.y, self.sensor.axis));
        }
        let off = turn - f64::from(self.beams - 1) * self.step / 2.0;
        rounded(robot.compose(self.sensor.x, self.sensor.y, self.sensor.axis + off))
    }

    /// A range as the sensor reports it; `None` beyond its limits.
    fn report(&self, d: f64, random: &mut Random) -> Option<f64> {
        let noisy = d + (self.noise.0 + self.noise.1 * d) * random.normal();
        let z = (noisy * PER_METRE).round() / PER_METRE;
        (z >= self.sensor.r_min && z <= self.sensor.r_max).then_some(z)
    }
}

/// What a sonar reports: an echo, now and then a false one or another beam's.
fn sonar(scene: &Scene, rig: &Rig, t: &Transducer, pose: Pose, random: &mut Random) -> Option<(f64, Option<u16>)> {
    let s = &t.sensor;
    let fate = random.unit();
    if fate < rig.spurious {
        let d = random.uniform(s.r_min, FALSE_REACH.clamp(s.r_min, s.r_max));
        return t.report(d, random).map(|z| (z, None));
    }
    let stray = fate < rig.spurious + rig.cross_talk;
    let heading = if stray { random.uniform(0.0, TAU) } else { pose.heading };
    let (sin, cos) = heading.sin_cos();
    let ping =
        Ping { at: (pose.x, pose.y), axis: (cos, sin), half_width: s.half_width, r_min: s.r_min, r_max: s.r_max };
    let (d, class) = scene.listen(&ping, random)?;
    t.report(d, random).map(|z| (z, class.filter(|_| !stray)))
}

/// What a laser beam reports.
fn laser(world: &World, t: &Transducer, pose: Pose, random: &mut Random) -> Option<(f64, Option<u16>)> {
    let (sin, cos) = pose.heading.sin_cos();
    let met = world.index.ray((pose.x, pose.y), (cos, sin), t.sensor.r_max)?;
    t.report(met.distance, random).map(|z| (z, met.class))
}

/// One seed from three numbers.
fn mix(seed: u64, scan: u64, number: u64) -> u64 {
    let a = Random::new(seed).bits();
    let b = Random::new(a ^ scan.wrapping_mul(0x9E37_79B9_7F4A_7C15)).bits();
    Random::new(b ^ number.wrapping_mul(0xD1B5_4A32_D192_ED03)).bits()
}
