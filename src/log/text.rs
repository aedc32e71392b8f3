//! Text logs that are read line by line. A format provides a [`LineParser`], which turns a line into records.

use super::format::{RecordQueue, ScanReader, Source};
use super::input::Input;
use super::lines::LineReader;
use super::mounting::MountedSensor;
use super::problem::{BadLine, Problem};
use crate::Result;
use crate::sensor::Description;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Parses the lines of a format. Each pass starts with a clone.
pub(super) trait LineParser: Clone + Send + Sync + 'static {
    /// Appends the records of a line. `false`: the line is of another kind, and is counted as ignored.
    ///
    /// # Errors
    /// A text that says why it is a bad line.
    fn parse_line(
        &mut self,
        line: &str,
        number: u64,
        sensors: &[MountedSensor],
        items: &mut RecordQueue,
    ) -> std::result::Result<bool, String>;

    /// Notes for the user after a pass.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Checks that the completed sensors give what the lines do not.
    ///
    /// # Errors
    /// As of [`Source::check_sensors`].
    fn check_sensors(&self, _sensors: &[MountedSensor]) -> Result<()> {
        Ok(())
    }
}

/// A log of lines.
pub(super) struct TextLog<P> {
    /// The file.
    pub input: Input,
    /// Its sensors, as far as the log describes them.
    pub sensors: Vec<Description>,
    /// Whether the bearings of beams come from the sensors.
    pub beams: bool,
    /// Whether it has the robot's poses.
    pub posed: bool,
    /// Notes for the user, known when the log is opened.
    pub notes: Vec<String>,
    /// Parses its lines.
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

/// Calls `each` with every readable line and its number, until `each` returns `false`.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the log can't be read on.
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
