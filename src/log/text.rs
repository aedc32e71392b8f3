//! Text logs that are read a line at a time: what all of them share. A format brings a [`LineParser`], which turns a line into records.

use super::format::{RecordQueue, ScanReader, Source};
use super::input::Input;
use super::lines::LineReader;
use super::mounting::MountedSensor;
use super::problem::{BadLine, Problem};
use crate::Result;
use crate::sensor::Description;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a format makes of its lines. A pass starts with a clone of it.
pub(super) trait LineParser: Clone + Send + Sync + 'static {
    /// Appends what a line holds. `false`: it is of another kind, to be counted as ignored. An error makes it a bad line.
    fn parse_line(
        &mut self,
        line: &str,
        number: u64,
        sensors: &[MountedSensor],
        items: &mut RecordQueue,
    ) -> std::result::Result<bool, String>;

    /// What a user should know after a pass.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Whether the sensors, once complete, say all that the lines don't.
    fn check_sensors(&self, _sensors: &[MountedSensor]) -> Result<()> {
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
    pub parser: P,
}

impl<P: LineParser> Source for TextLog<P> {
    fn sensors(&self) -> &[Description] {
        &self.sensors
    }

    fn has_beams(&self) -> bool {
        self.beams
    }

    fn has_poses(&self) -> bool {
        self.posed
    }

    fn check_sensors(&self, sensors: &[MountedSensor]) -> Result<()> {
        self.parser.check_sensors(sensors)
    }

    fn notes(&self) -> Vec<String> {
        self.notes.iter().cloned().chain(self.parser.notes()).collect()
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[MountedSensor]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>> {
        Ok(Box::new(TextReader { lines: self.input.lines()?, parser: self.parser.clone(), sensors, ignored }))
    }
}

struct TextReader<P> {
    lines: LineReader,
    parser: P,
    sensors: Arc<[MountedSensor]>,
    ignored: Arc<AtomicU64>,
}

impl<P: LineParser> ScanReader for TextReader<P> {
    fn fill(&mut self, items: &mut RecordQueue) -> bool {
        let number = self.lines.number() + 1;
        let before = items.len();
        let parsed = match self.lines.next() {
            None => return false,
            Some(Err(problem)) => {
                items.push_back(Err(problem));
                return true;
            }
            Some(Ok(line)) => self.parser.parse_line(line, number, &self.sensors, items),
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

/// Shows every readable line with its number, until `each` returns `false`.
pub(super) fn for_each_line(input: &Input, mut each: impl FnMut(&str, u64) -> bool) -> Result<()> {
    let mut lines = input.lines()?;
    loop {
        let number = lines.number() + 1;
        match lines.next() {
            None => return Ok(()),
            Some(Err(Problem::Fatal(error))) => return Err(error),
            Some(Err(Problem::Line(_))) => {}
            Some(Ok(line)) if each(line, number) => {}
            Some(Ok(_)) => return Ok(()),
        }
    }
}
