//! What the robot carries: a dense circular scan, a ring of sonars, a laser, or sensors one by one.

use super::echo::Physics;
use super::index::Index;
use super::path::Stop;
use super::text::Part;
use crate::sensor::{AtMax, Description, Kind, Sensor, preset};
use crate::{Error, Result};
use std::f64::consts::{PI, TAU};

/// The rigs that `--rig` and `[rig] kind` know; besides, `ringN` is a ring of N sonars.
pub const RIGS: [&str; 4] = ["dense", "ring24", "ring8", "laser"];
/// The most sonars of a ring.
const MOST: u32 = 360;
/// Keys of a sensor's table.
const SENSOR: [&str; 15] = [
    "id",
    "kind",
    "x",
    "y",
    "displacement",
    "axis",
    "half_width",
    "r_min",
    "r_max",
    "hit_range",
    "no_echo_range",
    "beams",
    "step",
    "noise",
    "noise_share",
];
const RIG: [&str; 15] = [
    "kind",
    "radius",
    "step",
    "half_width",
    "r_min",
    "r_max",
    "hit_range",
    "no_echo_range",
    "noise",
    "noise_share",
    "bounces",
    "specular",
    "spurious",
    "cross_talk",
    "flutter",
];

/// One transducer and how it is used in a scan.
#[derive(Debug, Clone, PartialEq)]
pub struct Transducer {
    /// Where it sits, and its limits.
    pub sensor: Sensor,
    /// Readings in one scan: more than 1 if it turns.
    pub beams: u32,
    /// From one of them to the next, radians.
    pub step: f64,
    /// Whether it turns about the robot's centre, from a random bearing; else about itself, evenly about its axis.
    pub circles: bool,
    /// Deviation of a range: metres, and a share of the range.
    pub noise: (f64, f64),
}

/// What the robot carries, and what can go wrong with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// Its name.
    pub name: String,
    /// Its sensors, in the log's order.
    pub transducers: Vec<Transducer>,
    /// Sonar's physics.
    pub physics: Physics,
    /// Share of sonar readings replaced by a short false echo.
    pub spurious: f64,
    /// Share of sonar readings that hear another beam.
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

/// A transducer that does not turn. Its silence has a mark of its own in the log: a range of just `r_max` is an echo.
fn fixed(sensor: Sensor) -> Transducer {
    let sensor = Sensor { at_r_max: AtMax::Hit, ..sensor };
    let noise = if sensor.kind == Kind::Sonar { (0.004, 0.002) } else { (0.01, 0.0) };
    Transducer { sensor, beams: 1, step: 0.0, circles: false, noise }
}

impl Rig {
    /// One of [`RIGS`], or `ringN`: N sonars evenly on a circle of 0.18 m (`ring8` is the real ring).
    ///
    /// # Errors
    /// [`Error::Usage`] for any other name.
    pub fn named(name: &str) -> Result<Rig> {
        let sonars = name.strip_prefix("ring").and_then(|n| n.parse::<u32>().ok()).filter(|n| (1..=MOST).contains(n));
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
                    let hint = crate::support::similar::similar(name, &RIGS);
                    return Err(Error::Usage(format!(
                        "there is no rig {name:?}{hint}; ringN is a ring of 1 to {MOST}"
                    )));
                };
                let one = |k: u32| Ok(fixed(sonar(&k.to_string(), 0.18, f64::from(k) * TAU / f64::from(n))?));
                (0..n).map(one).collect::<Result<_>>()?
            }
        };
        Ok(Rig { name: name.into(), transducers, physics: Physics::default(), spurious: 0.004, cross_talk: 0.004 })
    }

    /// How far its transducers sit from the robot's centre at most, metres.
    pub fn spread(&self) -> f64 {
        self.transducers.iter().map(|t| t.sensor.x.hypot(t.sensor.y)).fold(0.0, f64::max)
    }

    /// The farthest range of its sonars, metres.
    pub fn sonar_reach(&self) -> f64 {
        let sonars = self.transducers.iter().filter(|t| t.sensor.kind == Kind::Sonar);
        sonars.map(|t| t.sensor.r_max).fold(0.0, f64::max)
    }

    /// Whether a wall stands between the robot and one of its transducers at one of these stops; what to say of it.
    pub(crate) fn check(&self, index: &Index, stops: &[Stop]) -> std::result::Result<(), String> {
        let spread = self.spread();
        for (k, (_, robot)) in stops.iter().enumerate() {
            let at = (robot.x, robot.y);
            let near = index.near(at, spread);
            if near.is_empty() {
                continue;
            }
            let beyond = self.transducers.iter().find(|t| {
                let place = robot.compose(t.sensor.x, t.sensor.y, 0.0);
                let radius = t.sensor.x.hypot(t.sensor.y);
                if t.circles { !index.near(at, radius).is_empty() } else { !index.reaches(at, (place.x, place.y)) }
            });
            if let Some(t) = beyond {
                let (id, off) = (&t.sensor.id, t.sensor.x.hypot(t.sensor.y));
                return Err(format!(
                    "scan {k} at [{}, {}]: a wall stands between the robot and its sensor {id:?}, {off:.2} m off: keep \
                     the path farther from walls, or carry a smaller rig",
                    at.0, at.1
                ));
            }
        }
        Ok(())
    }

    /// Readings of one scan.
    pub fn readings(&self) -> u64 {
        self.transducers.iter().map(|t| u64::from(t.beams)).sum()
    }

    /// Reads `[rig]` and `[[sensor]]`; without either the dense scan.
    pub(crate) fn read(part: Option<&Part<'_>>, sensors: &[Part<'_>]) -> Result<Rig> {
        let mut rig = Rig::named("dense")?;
        if let Some(part) = part {
            part.check(&RIG)?;
            if let Some((name, at)) = part.word("kind")? {
                rig = Rig::named(name).map_err(|e| part.text.fail(&at, format!("kind: {e}")))?;
            }
        }
        if !sensors.is_empty() {
            rig.name = "sensors".into();
            rig.transducers.clear();
            for part in sensors {
                let next = read_sensor(part, rig.transducers.len())?;
                if rig.transducers.iter().any(|t| t.sensor.id == next.sensor.id) {
                    return Err(part
                        .text
                        .fail(&part.at, format!("two sensors are called {:?}: give each its id", next.sensor.id)));
                }
                rig.transducers.push(next);
            }
        }
        if let Some(part) = part {
            rig.adjust(part)?;
        }
        Ok(rig)
    }

    /// Lays the values of `[rig]` over every sensor.
    fn adjust(&mut self, part: &Part<'_>) -> Result<()> {
        if let Some(bounces) = part.count("bounces")? {
            if !(1..=3).contains(&bounces) {
                return Err(part.text.fail(&part.place("bounces"), format!("bounces = {bounces}: takes 1, 2 or 3")));
            }
            self.physics.bounces = bounces as u8;
        }
        self.physics.specular = part.flag("specular")?.unwrap_or(self.physics.specular);
        for (key, slot, most) in [
            ("spurious", &mut self.spurious, 0.5),
            ("cross_talk", &mut self.cross_talk, 0.5),
            ("flutter", &mut self.physics.flutter, 1.0),
        ] {
            if let Some(share) = part.length(key)? {
                if !(0.0..=most).contains(&share) {
                    return Err(part.text.fail(&part.place(key), format!("{key} = {share}: takes 0 to {most}")));
                }
                *slot = share;
            }
        }
        let radius = part.length("radius")?;
        if let Some(r) = radius.filter(|r| *r < 0.0) {
            return Err(part.text.fail(&part.place("radius"), format!("radius = {r:?}: takes 0 or more")));
        }
        let step = part.angle("step")?;
        if step.is_some() && self.transducers.iter().all(|t| t.beams == 1) {
            let what = format!("step is for sensors that turn, as in dense and laser; those of {} do not", self.name);
            return Err(part.text.fail(&part.place("step"), what));
        }
        for t in &mut self.transducers {
            if let Some(r) = radius {
                (t.sensor.x, t.sensor.y) = (r * t.sensor.axis.cos(), r * t.sensor.axis.sin());
            }
            if let Some(step) = step.filter(|_| t.beams > 1) {
                if !(1e-4..=1.0).contains(&step) {
                    return Err(part.text.fail(&part.place("step"), "step takes 0.006deg to 57deg"));
                }
                t.beams = if t.circles { (TAU / step).round() as u32 } else { (PI / step).round() as u32 + 1 };
                t.step = step;
            }
            let mut upper = Description::default();
            for key in ["half_width", "r_min", "r_max", "hit_range", "no_echo_range"] {
                if let Some(value) = part.value(key)? {
                    upper.set(key, &value).map_err(|what| part.text.fail(&part.place(key), what))?;
                }
            }
            t.sensor = laid(&t.sensor, &upper).map_err(|what| part.text.fail(&part.at, what))?;
            noise(part, &mut t.noise)?;
        }
        Ok(())
    }
}

/// A sensor with a description laid over it.
fn laid(s: &Sensor, upper: &Description) -> std::result::Result<Sensor, String> {
    let mut d = Description {
        id: Some(s.id.clone()),
        kind: Some(s.kind),
        x: Some(s.x),
        y: Some(s.y),
        axis: Some(s.axis),
        half_width: Some(s.half_width),
        r_min: Some(s.r_min),
        r_max: Some(s.r_max),
        at_r_max: Some(s.at_r_max),
        hit_range: Some(s.hit_range).filter(|h| *h != s.r_max),
        no_echo_range: Some(s.no_echo_range),
        ..Description::default()
    };
    d.merge(upper);
    d.complete(0)
}

/// Reads one `[[sensor]]`.
fn read_sensor(part: &Part<'_>, index: usize) -> Result<Transducer> {
    part.check(&SENSOR)?;
    let mut d = Description::default();
    for key in SENSOR.iter().filter(|k| !k.starts_with("noise")) {
        if let Some(value) = part.value(key)? {
            d.set(key, &value).map_err(|what| part.text.fail(&part.place(key), what))?;
        }
    }
    let sensor = d.complete(index).map_err(|what| part.text.fail(&part.at, what))?;
    let mut t = fixed(sensor);
    if let Some(beams) = d.beams {
        t.beams = beams;
        t.step = part.need("step", d.step, "\"0.5deg\"")?;
    }
    noise(part, &mut t.noise)?;
    Ok(t)
}

fn noise(part: &Part<'_>, noise: &mut (f64, f64)) -> Result<()> {
    for (key, slot) in [("noise", &mut noise.0), ("noise_share", &mut noise.1)] {
        if let Some(v) = part.length(key)? {
            if !(0.0..=1.0).contains(&v) {
                return Err(part.text.fail(&part.place(key), format!("{key} = {v}: takes 0 to 1")));
            }
            *slot = v;
        }
    }
    Ok(())
}
