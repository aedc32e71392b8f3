//! CARMEN text logs: `FLASER` and `RLASER` (180° in front and behind) and `ROBOTLASER1`. Other messages are ignored.
//!
//! Nothing in such a log lists its lasers, and some don't say at which range theirs gives up. So opening scans it once: each
//! layout of beams becomes one sensor, and a cap that nothing declares is found in the ranges.

use super::format::{Format, Items, Mounted, Place, Probe, Scans, Source, lasers_only};
use super::input::Input;
use super::lines::Lines;
use super::{BadLine, Problem};
use crate::reading::{Pose, Record};
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use message::{Layout, Message};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

mod message;

/// Ranges from here on are no return, metres: SICK's lasers, which nearly all of these logs come from, give up here.
const FARTHEST: f64 = 80.0;
/// So many equal largest ranges are a cap, not a wall …
const CAP_READINGS: u64 = 20;
/// … if they come from beams so far apart: a parked robot repeats the range of one beam, a cap shows anywhere.
const CAP_BEAMS: usize = 5;
/// No log has more layouts; a damaged one might.
const MOST_LAYOUTS: usize = 256;

/// The format.
pub(crate) struct Carmen;

impl Format for Carmen {
    fn name(&self) -> &'static str {
        "carmen"
    }

    fn looks(&self) -> &'static str {
        "a CARMEN text log (FLASER, RLASER or ROBOTLASER1 lines), plain or gzip"
    }

    fn claims(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        let tags = ["FLASER ", "RLASER ", "ROBOTLASER1 ", "PARAM ", "ODOM ", "SYNC ", "TRUEPOS ", "# CARMEN"];
        text.lines().any(|line| tags.iter().any(|tag| line.starts_with(tag)))
    }

    fn open(&self, place: &Place, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let Place::File(input) = place else { return Err(Error::Usage("a CARMEN log is a file".into())) };
        lasers_only(input, kind, self.name())?;
        let lasers = survey(input)?;
        if lasers.is_empty() {
            let what = "no readable FLASER, RLASER or ROBOTLASER1 line in this CARMEN log: nothing to map";
            return Err(Error::input(input.path(), what));
        }
        let sensors = lasers.iter().map(Laser::describe).collect();
        Ok(Box::new(CarmenLog { input: input.clone(), lasers: lasers.into(), sensors }))
    }
}

/// One laser of the log: a layout of beams, and from which range on it gives no return.
struct Laser {
    layout: Layout,
    /// Metres; at most [`FARTHEST`].
    cap: f64,
    /// The place of the first message in the robot's frame.
    mount: Pose,
    /// The largest range below [`FARTHEST`], how often it came, and from which beams.
    largest: f64,
    times: u64,
    beams: (usize, usize),
}

impl Laser {
    fn look(&mut self, ranges: &[f64]) {
        for (k, z) in ranges.iter().enumerate() {
            if *z >= FARTHEST || *z < self.largest || z.is_nan() {
                continue;
            }
            if *z > self.largest {
                (self.largest, self.times, self.beams) = (*z, 0, (k, k));
            }
            self.times += 1;
            self.beams = (self.beams.0.min(k), self.beams.1.max(k));
        }
    }

    fn describe(&self) -> Description {
        Description {
            id: Some(self.layout.id()),
            kind: Some(Kind::Laser),
            x: Some(self.mount.x),
            y: Some(self.mount.y),
            axis: Some(self.mount.heading),
            r_max: Some(self.cap),
            beams: Some(self.layout.count),
            first: Some(self.layout.first),
            step: Some(self.layout.step),
            ..Description::default()
        }
    }
}

/// The first scan: which lasers there are, and their caps.
fn survey(input: &Input) -> Result<Vec<Laser>> {
    let mut lasers: Vec<Laser> = Vec::new();
    let mut declared = [None, None];
    let mut lines = input.lines()?;
    let mut ranges = Vec::new();
    while let Some(line) = lines.next() {
        let line = match line {
            Ok(line) => line,
            Err(Problem::Line(_)) => continue,
            Err(Problem::Fatal(error)) => return Err(error),
        };
        if let Some((which, cap)) = message::cap(line) {
            declared[which] = Some(cap);
        }
        let Ok(Some(message)) = message::parse(line, &mut ranges) else { continue };
        let at = lasers.iter().position(|l| l.layout == message.layout);
        let at = match at {
            Some(at) => at,
            None if lasers.len() == MOST_LAYOUTS => continue,
            None => {
                let mount = message.mount();
                let layout = message.layout;
                lasers.push(Laser { layout, cap: FARTHEST, mount, largest: 0.0, times: 0, beams: (0, 0) });
                lasers.len() - 1
            }
        };
        if let Some(laser) = lasers.get_mut(at) {
            laser.look(&ranges);
        }
    }
    for laser in &mut lasers {
        let declared = laser.layout.cap.or(laser.layout.tag.declared(declared));
        let found = laser.times >= CAP_READINGS && laser.beams.1 - laser.beams.0 >= CAP_BEAMS;
        laser.cap = declared.or(found.then_some(laser.largest)).filter(|c| *c > 0.05).unwrap_or(FARTHEST).min(FARTHEST);
    }
    Ok(lasers)
}

struct CarmenLog {
    input: Input,
    lasers: Arc<[Laser]>,
    sensors: Vec<Description>,
}

impl Source for CarmenLog {
    fn sensors(&self) -> &[Description] {
        &self.sensors
    }

    fn has_beams(&self) -> bool {
        true
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[Mounted]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn Scans>> {
        let lasers = self.lasers.clone();
        Ok(Box::new(Pass { lines: self.input.lines()?, lasers, sensors, ignored, ranges: Vec::new(), scan: 0 }))
    }
}

struct Pass {
    lines: Lines,
    lasers: Arc<[Laser]>,
    sensors: Arc<[Mounted]>,
    ignored: Arc<AtomicU64>,
    ranges: Vec<f64>,
    scan: u64,
}

impl Scans for Pass {
    fn fill(&mut self, items: &mut Items) -> bool {
        let number = self.lines.number() + 1;
        let parsed = match self.lines.next() {
            None => return false,
            Some(Err(problem)) => {
                items.push_back(Err(problem));
                return true;
            }
            Some(Ok(line)) => message::parse(line, &mut self.ranges),
        };
        match parsed {
            Ok(None) => {
                self.ignored.fetch_add(1, Ordering::Relaxed);
            }
            Ok(Some(message)) => match self.emit(&message, number, items) {
                Ok(()) => self.scan += 1,
                Err(what) => items.push_back(Err(Problem::Line(BadLine { line: number, what }))),
            },
            Err(what) => items.push_back(Err(Problem::Line(BadLine { line: number, what }))),
        }
        true
    }
}

impl Pass {
    fn emit(&self, message: &Message, line: u64, items: &mut Items) -> std::result::Result<(), String> {
        let index = self.lasers.iter().position(|l| l.layout == message.layout);
        let found = index.and_then(|i| Some((i, self.lasers.get(i)?, self.sensors.get(i)?)));
        let (index, laser, mounted) =
            found.ok_or("more than 256 different layouts of laser beams: this one is left out")?;
        let beams = mounted.beams.unwrap_or(message.layout.beams());
        for (k, z) in self.ranges.iter().enumerate() {
            let off = beams.first + k as f64 * beams.step;
            items.push_back(Ok(Record {
                t: message.t,
                scan: self.scan,
                sensor: index as u32,
                robot: message.robot,
                pose: mounted.pose(&message.robot, Some(message.laser), off),
                range: if *z >= laser.cap { f64::INFINITY } else { *z },
                label: None,
                line,
            }));
        }
        Ok(())
    }
}
