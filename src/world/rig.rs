//! The sensors of the robot: a dense circular scan, a ring of sonars, a laser, or sensors one by one.

use super::index::ShapeIndex;
use super::path::TimedPose;
use super::sonar::Physics;
use crate::sensor::{AtMax, Description, Kind, Sensor, preset};
use crate::{Error, Result};
use std::f64::consts::{PI, TAU};

/// The rigs that `--rig` and `[rig] kind` know by name; `ringN`, a ring of N sonars, is another.
pub const RIGS: [&str; 4] = ["dense", "ring24", "ring8", "laser"];
/// Most sonars of a ring.
const MAX_SONARS: u32 = 360;

/// One transducer, and its readings in a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Transducer {
    /// Its mount on the robot, and its limits.
    pub sensor: Sensor,
    /// Readings in one scan; more than 1 if it turns.
    pub beams: u32,
    /// The angle from one reading to the next, radians.
    pub step: f64,
    /// Whether it turns about the robot's centre, from a random bearing; else it turns about itself, symmetrically to its axis.
    pub circles: bool,
    /// Range noise.
    pub noise: Noise,
}

/// The standard deviation of a range: `metres` + `share` × range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// The part that is the same at every range, metres.
    pub metres: f64,
    /// The part that grows with the range.
    pub share: f64,
}

/// The sensors of the robot, and the disturbances of its sonars.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// Its name.
    pub name: String,
    /// Its sensors, in the log's order.
    pub transducers: Vec<Transducer>,
    /// How sonar echoes are simulated.
    pub physics: Physics,
    /// The share of sonar readings that are a false echo at short range.
    pub spurious: f64,
    /// The share of sonar readings that are the echo of another beam.
    pub cross_talk: f64,
}

fn sonar(id: &str, radius: f64, axis: f64) -> Result<Sensor> {
    let r = |v: f64| (v * 1e9).round() / 1e9 + 0.0;
    let d = Description {
        id: Some(id.into()),
        kind: Some(Kind::Sonar),
        x: Some(r(radius * axis.cos())),
        y: Some(r(radius * axis.sin())),
        axis: Some(axis),
        ..Description::default()
    };
    d.complete(0).map_err(Error::Usage)
}

/// A transducer that does not turn. A missing echo has a mark of its own in the log, so that a range of `r_max` is an echo.
pub(super) fn fixed(sensor: Sensor) -> Transducer {
    let sensor = Sensor { at_r_max: AtMax::Hit, ..sensor };
    let (metres, share) = if sensor.kind == Kind::Sonar { (0.004, 0.002) } else { (0.01, 0.0) };
    let noise = Noise { metres, share };
    Transducer { sensor, beams: 1, step: 0.0, circles: false, noise }
}

impl Rig {
    /// One of [`RIGS`], or `ringN`: N sonars evenly on a circle of 0.18 m (`ring8` is the real ring).
    ///
    /// # Errors
    /// [`Error::Usage`] for any other name.
    pub fn named(name: &str) -> Result<Rig> {
        let sonars =
            name.strip_prefix("ring").and_then(|n| n.parse::<u32>().ok()).filter(|n| (1..=MAX_SONARS).contains(n));
        let transducers = match name {
            "dense" => {
                vec![Transducer { beams: 200, step: PI / 100.0, circles: true, ..fixed(sonar("dense", 0.14, 0.0)?) }]
            }
            "ring8" => {
                let ring = preset("sonar_ring_8")?;
                let one = |(k, d): (usize, &Description)| d.complete(k).map(fixed).map_err(Error::Usage);
                ring.iter().enumerate().map(one).collect::<Result<_>>()?
            }
            "laser" => {
                let d = Description {
                    id: Some("laser".into()),
                    kind: Some(Kind::Laser),
                    step: Some(PI / 360.0),
                    ..Description::default()
                };
                let sensor = d.complete(0).map_err(Error::Usage)?;
                vec![Transducer { beams: 361, step: PI / 360.0, ..fixed(sensor) }]
            }
            _ => {
                let Some(n) = sonars else {
                    let hint = crate::support::suggest::similar(name, &RIGS);
                    return Err(Error::Usage(format!(
                        "there is no rig {name:?}{hint}; ringN is a ring of 1 to {MAX_SONARS}"
                    )));
                };
                let one = |k: u32| Ok(fixed(sonar(&k.to_string(), 0.18, f64::from(k) * TAU / f64::from(n))?));
                (0..n).map(one).collect::<Result<_>>()?
            }
        };
        Ok(Rig { name: name.into(), transducers, physics: Physics::default(), spurious: 0.004, cross_talk: 0.004 })
    }

    /// The farthest distance of a transducer from the robot's centre, metres.
    pub fn spread(&self) -> f64 {
        self.transducers.iter().map(|t| t.sensor.x.hypot(t.sensor.y)).fold(0.0, f64::max)
    }

    /// The farthest range of its sonars, metres.
    pub fn sonar_reach(&self) -> f64 {
        let sonars = self.transducers.iter().filter(|t| t.sensor.kind == Kind::Sonar);
        sonars.map(|t| t.sensor.r_max).fold(0.0, f64::max)
    }

    /// Fails where a wall lies between the robot and one of its transducers.
    ///
    /// # Errors
    /// The message, without its place.
    pub(crate) fn check(&self, index: &ShapeIndex, trajectory: &[TimedPose]) -> std::result::Result<(), String> {
        let spread = self.spread();
        for (k, TimedPose { pose: robot, .. }) in trajectory.iter().enumerate() {
            let at = robot.position();
            let near = index.within(at, spread);
            if near.is_empty() {
                continue;
            }
            let beyond = self.transducers.iter().find(|t| {
                let place = robot.compose(t.sensor.x, t.sensor.y, 0.0).position();
                let radius = t.sensor.x.hypot(t.sensor.y);
                if t.circles { !index.within(at, radius).is_empty() } else { !index.unobstructed(at, place) }
            });
            if let Some(t) = beyond {
                let (id, off) = (&t.sensor.id, t.sensor.x.hypot(t.sensor.y));
                return Err(format!(
                    "scan {k} at [{}, {}]: a wall stands between the robot and its sensor {id:?}, {off:.2} m off: keep \
                     the path farther from walls, or carry a smaller rig",
                    at.x, at.y
                ));
            }
        }
        Ok(())
    }

    /// The number of readings in one scan.
    pub fn readings(&self) -> u64 {
        self.transducers.iter().map(|t| u64::from(t.beams)).sum()
    }
}
