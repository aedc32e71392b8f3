//! Text logs that are read a line at a time: what all of them share. A format brings a [`Parse`], which turns a line into records.

use super::format::{Items, Mounted, Scans, Source};
use super::input::Input;
use super::lines::Lines;
use super::{BadLine, Problem};
use crate::log::reading::{Pose, Record};
use crate::sensor::Description;
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a format makes of its lines. A pass starts with a clone of it.
pub(super) trait Parse: Clone + Send + Sync + 'static {
    /// Appends what a line holds. `false`: it is of another kind, to be counted as ignored. An error makes it a bad line.
    fn line(
        &mut self,
        line: &str,
        number: u64,
        sensors: &[Mounted],
        items: &mut Items,
    ) -> std::result::Result<bool, String>;

    /// What a user should know after a pass.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Whether the sensors, once complete, say all that the lines don't.
    fn ready(&self, _sensors: &[Mounted]) -> Result<()> {
        Ok(())
    }
}

/// A log of lines.
pub(super) struct TextLog<P> {
    /// The file.
    pub input: Input,
    /// Its sensors, as far as it describes them.
    pub sensors: Vec<Description>,
    /// Whether the sensors lay out the beams.
    pub beams: bool,
    /// Whether it has the robot's poses.
    pub posed: bool,
    /// What is known at its opening that a user should know.
    pub notes: Vec<String>,
    /// What reads its lines.
    pub parse: P,
}

impl<P: Parse> Source for TextLog<P> {
    fn sensors(&self) -> &[Description] {
        &self.sensors
    }

    fn has_beams(&self) -> bool {
        self.beams
    }

    fn has_poses(&self) -> bool {
        self.posed
    }

    fn ready(&self, sensors: &[Mounted]) -> Result<()> {
        self.parse.ready(sensors)
    }

    fn notes(&self) -> Vec<String> {
        self.notes.iter().cloned().chain(self.parse.notes()).collect()
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[Mounted]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn Scans>> {
        Ok(Box::new(Pass { lines: self.input.lines()?, parse: self.parse.clone(), sensors, ignored }))
    }
}

struct Pass<P> {
    lines: Lines,
    parse: P,
    sensors: Arc<[Mounted]>,
    ignored: Arc<AtomicU64>,
}

impl<P: Parse> Scans for Pass<P> {
    fn fill(&mut self, items: &mut Items) -> bool {
        let number = self.lines.number() + 1;
        let before = items.len();
        let parsed = match self.lines.next() {
            None => return false,
            Some(Err(problem)) => {
                items.push_back(Err(problem));
                return true;
            }
            Some(Ok(line)) => self.parse.line(line, number, &self.sensors, items),
        };
        match parsed {
            Ok(true) => {}
            Ok(false) => {
                self.ignored.fetch_add(1, Ordering::Relaxed);
            }
            Err(what) => {
                items.truncate(before);
                items.push_back(Err(Problem::Line(BadLine { line: number, what })));
            }
        }
        true
    }
}

/// Shows every readable line with its number, until `look` gives `false`.
pub(super) fn look(input: &Input, mut look: impl FnMut(&str, u64) -> bool) -> Result<()> {
    let mut lines = input.lines()?;
    loop {
        let number = lines.number() + 1;
        match lines.next() {
            None => return Ok(()),
            Some(Err(Problem::Fatal(error))) => return Err(error),
            Some(Err(Problem::Line(_))) => {}
            Some(Ok(line)) if look(line, number) => {}
            Some(Ok(_)) => return Ok(()),
        }
    }
}

/// What the readings of a scan share.
pub(super) struct Scan {
    /// Seconds.
    pub t: f64,
    /// Its number, from 0.
    pub number: u64,
    /// Index of its sensor.
    pub sensor: usize,
    /// The robot's pose.
    pub robot: Pose,
    /// The sensor's pose, if the log gives it.
    pub given: Option<Pose>,
    /// Its line.
    pub line: u64,
}

impl Scan {
    /// Appends a reading, `off` radians from the sensor's axis; a range of +∞ is no echo.
    pub fn push(&self, sensors: &[Mounted], off: f64, range: f64, items: &mut Items) {
        if let Some(mounted) = sensors.get(self.sensor) {
            items.push_back(Ok(Record {
                t: self.t,
                scan: self.number,
                sensor: self.sensor as u32,
                robot: self.robot,
                pose: mounted.pose(&self.robot, self.given, off),
                range,
                label: None,
                line: self.line,
            }));
        }
    }
}

/// A number as programs write it: also with infinity and not-a-number in the spellings of ROS, YAML, C and Octave.
pub(super) fn real(text: &str) -> Option<f64> {
    let text = text.trim();
    text.parse().ok().or_else(|| match text.to_ascii_lowercase().as_str() {
        ".inf" | "+.inf" | "1.#inf" | "1.#inf00" => Some(f64::INFINITY),
        "-.inf" | "-1.#inf" | "-1.#inf00" => Some(f64::NEG_INFINITY),
        ".nan" | "na" | "1.#qnan" | "-1.#ind" | "-1.#ind00" => Some(f64::NAN),
        _ => None,
    })
}

/// SICK's lasers send codes from here on in place of a range: 13 bits in mm or cm, 15 bits in mm.
pub(super) const SICK_CODES: [std::ops::RangeInclusive<f64>; 2] = [8183.0..=8191.0, 32759.0..=32767.0];

/// The first code of a SICK laser whose largest number is this, if it is such a code.
pub(super) fn sick_code(largest: f64) -> Option<f64> {
    SICK_CODES.iter().find(|codes| codes.contains(&largest)).map(|codes| *codes.start())
}

/// The error of a format that is a file and was given a folder.
pub(super) fn file_of<'a>(place: &'a super::format::Place, what: &str) -> Result<&'a Input> {
    match place {
        super::format::Place::File(input) => Ok(input),
        super::format::Place::Folder(_) => Err(Error::Usage(format!("a {what} log is a file"))),
    }
}
