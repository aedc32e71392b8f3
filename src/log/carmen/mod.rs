//! CARMEN text logs: every laser message with a place, `FLASER`, `RLASER`, `ROBOTLASER1` and on, `LASER_READING`, and, if the log has nothing
//! better, `RAWLASER1`, `RAWLASER2`, `LASER1` and `LASER2` with the odometry's poses. Ranges are passed on as they are.
//!
//! Nothing in such a log lists its lasers, and some don't say how their beams lie or at which range they give up. So opening scans it
//! once (`survey`): each layout of beams becomes one sensor.

use super::format::{Format, LogPath, Probe, RecordQueue, ScanReader, Source};
use super::input::Input;
use super::lines::LineReader;
use super::mounting::MountedSensor;
use super::opening::laser_file;
use super::problem::{BadLine, Problem};
use crate::log::reading::Record;
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use message::{CarmenLine, LaserMessage};
use odometry::OdometryReader;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use survey::LaserSurvey;
use tag::Tag;

mod beams;
mod laser;
mod message;
mod odometry;
mod rear;
mod survey;
mod tag;

/// The format.
pub(crate) struct Carmen;

impl Format for Carmen {
    fn name(&self) -> &'static str {
        "carmen"
    }

    fn describe(&self) -> &'static str {
        "a CARMEN text log (FLASER, RLASER, ROBOTLASER1 or other laser lines), plain or gzip"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        let others = ["PARAM", "ODOM", "SYNC", "TRUEPOS", "POSITION", "SONAR", "ODO_UPDATE", "SM_UPDATE"];
        text.lines().any(|line| {
            let mut words = line.split_ascii_whitespace();
            let word = words.next().unwrap_or_default();
            let is = Tag::of(word).is_some() || others.contains(&word);
            is && words.next().is_some() || line.starts_with("# CARMEN")
        })
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = laser_file(place, kind, "CARMEN", self.name())?;
        let survey = LaserSurvey::read(input)?;
        if survey.lasers.is_empty() {
            let none = "no readable laser message in this CARMEN log: nothing to map";
            let left = survey.left_out().map(|what| format!("; left out: {what}")).unwrap_or_default();
            return Err(match &survey.bad {
                Some((bad, count)) => {
                    let what =
                        format!("{}. There is {none} ({count} bad lines, of which this is the first){left}", bad.what);
                    Error::at(input.path(), bad.line, what)
                }
                None => Error::input(input.path(), format!("{none}{left}")),
            });
        }
        let sensors = survey.lasers.iter().map(laser::CarmenLaser::describe).collect();
        Ok(Box::new(CarmenLog { input: input.clone(), survey: Arc::new(survey), sensors }))
    }
}

struct CarmenLog {
    input: Input,
    survey: Arc<LaserSurvey>,
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
        self.survey.notes()
    }

    fn beams_origin(&self, sensor: usize) -> Option<(String, bool)> {
        let laser = self.survey.lasers.get(sensor)?;
        let plain = !laser.origin.contains("assumption") && !laser.origin.contains(';');
        Some((laser.origin.clone(), plain))
    }

    fn no_return_note(&self, sensor: usize) -> Option<String> {
        self.survey.no_return_note(sensor)
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[MountedSensor]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>> {
        let unposed = self.survey.lasers.iter().any(|laser| !laser.layout.posed);
        let odometry = if unposed { Some(OdometryReader::open(&self.input)?) } else { None };
        let (lines, survey) = (self.input.lines()?, self.survey.clone());
        Ok(Box::new(CarmenReader { lines, odometry, survey, sensors, ignored, ranges: Vec::new(), scan: 0 }))
    }
}

struct CarmenReader {
    lines: LineReader,
    odometry: Option<OdometryReader>,
    survey: Arc<LaserSurvey>,
    sensors: Arc<[MountedSensor]>,
    ignored: Arc<AtomicU64>,
    ranges: Vec<f64>,
    scan: u64,
}

impl ScanReader for CarmenReader {
    fn fill(&mut self, items: &mut RecordQueue) -> bool {
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
            Ok(CarmenLine::Laser(message)) => {
                match self.lines.is_unterminated() && message.t.is_none() && self.survey.timed(&message) {
                    true => Err("the file ends within this line".into()),
                    false => self.emit(&message, number, items),
                }
            }
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

impl CarmenReader {
    /// Appends a message's readings; `false`: it is left out.
    fn emit(
        &mut self,
        message: &LaserMessage,
        line: u64,
        items: &mut RecordQueue,
    ) -> std::result::Result<bool, String> {
        let index = self.survey.lasers.iter().position(|l| l.layout == message.layout);
        let survey = index.and_then(|i| Some((i, self.survey.lasers.get(i)?, self.sensors.get(i)?)));
        let Some((index, laser, mounted)) = survey else {
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
            _ => self.survey.rear.poses(message.layout.tag, message.place),
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
