//! CARMEN text logs: every laser message with a place, `FLASER`, `RLASER`, `ROBOTLASER1` and on, `LASER_READING`, and, if the log has nothing
//! better, `RAWLASER1`, `RAWLASER2`, `LASER1` and `LASER2` with the odometry's poses. Ranges are passed on as they are.
//!
//! Nothing in such a log lists its lasers, and some don't say how their beams lie or at which range they give up. So opening scans it
//! once (`found`): each layout of beams becomes one sensor.

use super::format::{Format, Items, Mounted, Place, Probe, Scans, Source, lasers_only};
use super::input::Input;
use super::lines::Lines;
use super::{BadLine, Problem};
use crate::log::reading::Record;
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use found::Found;
use message::{Line, Message};
use odometry::Odometry;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tag::Tag;

mod beams;
mod found;
mod message;
mod odometry;
mod rear;
mod tag;

/// The format.
pub(crate) struct Carmen;

impl Format for Carmen {
    fn name(&self) -> &'static str {
        "carmen"
    }

    fn looks(&self) -> &'static str {
        "a CARMEN text log (FLASER, RLASER, ROBOTLASER1 or other laser lines), plain or gzip"
    }

    fn claims(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        let others = ["PARAM", "ODOM", "SYNC", "TRUEPOS", "POSITION", "SONAR", "ODO_UPDATE", "SM_UPDATE"];
        text.lines().any(|line| {
            let mut words = line.split_ascii_whitespace();
            let word = words.next().unwrap_or_default();
            let is = Tag::of(word).is_some() || others.contains(&word);
            is && words.next().is_some() || line.starts_with("# CARMEN")
        })
    }

    fn open(&self, place: &Place, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let Place::File(input) = place else { return Err(Error::Usage("a CARMEN log is a file".into())) };
        lasers_only(input, kind, self.name())?;
        let found = Found::read(input)?;
        if found.lasers.is_empty() {
            let none = "no readable laser message in this CARMEN log: nothing to map";
            let left = found.left_out().map(|what| format!("; left out: {what}")).unwrap_or_default();
            return Err(match &found.bad {
                Some((bad, count)) => {
                    let what =
                        format!("{}. There is {none} ({count} bad lines, of which this is the first){left}", bad.what);
                    Error::at(input.path(), bad.line, what)
                }
                None => Error::input(input.path(), format!("{none}{left}")),
            });
        }
        let sensors = found.lasers.iter().map(found::Laser::describe).collect();
        Ok(Box::new(CarmenLog { input: input.clone(), found: Arc::new(found), sensors }))
    }
}

struct CarmenLog {
    input: Input,
    found: Arc<Found>,
    sensors: Vec<Description>,
}

impl Source for CarmenLog {
    fn sensors(&self) -> &[Description] {
        &self.sensors
    }

    fn has_beams(&self) -> bool {
        true
    }

    fn notes(&self) -> Vec<String> {
        self.found.notes()
    }

    fn beams_origin(&self, sensor: usize) -> Option<(String, bool)> {
        let laser = self.found.lasers.get(sensor)?;
        let plain = !laser.origin.contains("assumption") && !laser.origin.contains(';');
        Some((laser.origin.clone(), plain))
    }

    fn silence(&self, sensor: usize) -> Option<String> {
        self.found.silence(sensor)
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[Mounted]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn Scans>> {
        let unposed = self.found.lasers.iter().any(|laser| !laser.layout.posed);
        let odometry = if unposed { Some(Odometry::open(&self.input)?) } else { None };
        let (lines, found) = (self.input.lines()?, self.found.clone());
        Ok(Box::new(Pass { lines, odometry, found, sensors, ignored, ranges: Vec::new(), scan: 0 }))
    }
}

struct Pass {
    lines: Lines,
    odometry: Option<Odometry>,
    found: Arc<Found>,
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
            Some(Ok(line)) => match odometry::parse(line) {
                Some(Err(what)) if self.odometry.is_some() => Err(what),
                _ => message::parse(line, &mut self.ranges),
            },
        };
        let done = match parsed {
            Ok(Line::Laser(message)) => match self.lines.cut() && message.t.is_none() && self.found.timed(&message) {
                true => Err("the file ends within this line".into()),
                false => self.emit(&message, number, items),
            },
            Ok(_) => Ok(false),
            Err(what) => Err(what),
        };
        match done {
            Ok(true) => self.scan += 1,
            Ok(false) => {
                self.ignored.fetch_add(1, Ordering::Relaxed);
            }
            Err(what) => items.push_back(Err(Problem::Line(BadLine { line: number, what }))),
        }
        true
    }
}

impl Pass {
    /// Appends a message's readings; `false`: it is left out.
    fn emit(&mut self, message: &Message, line: u64, items: &mut Items) -> std::result::Result<bool, String> {
        let index = self.found.lasers.iter().position(|l| l.layout == message.layout);
        let found = index.and_then(|i| Some((i, self.found.lasers.get(i)?, self.sensors.get(i)?)));
        let Some((index, laser, mounted)) = found else {
            return match message.layout.posed {
                true => Err("more than 256 different layouts of laser beams: this one is left out".into()),
                false => Ok(false),
            };
        };
        let t = message.t.unwrap_or(0.0);
        let (pose, robot) = match &mut self.odometry {
            Some(odometry) if !message.layout.posed => {
                let robot = odometry.at(line, t).ok_or("no ODOM message gives its pose")?;
                (robot.compose(laser.mount.x, laser.mount.y, laser.mount.heading), robot)
            }
            _ => self.found.rear.poses(message.layout.tag, message.place),
        };
        let beams = mounted.beams.unwrap_or(laser.beams);
        for (k, range) in self.ranges.iter().enumerate() {
            let off = beams.first + k as f64 * beams.step;
            items.push_back(Ok(Record {
                t,
                scan: self.scan,
                sensor: index as u32,
                robot,
                pose: mounted.pose(&robot, Some(pose), off),
                range: *range,
                label: None,
                line,
            }));
        }
        Ok(true)
    }
}
