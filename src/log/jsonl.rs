//! echogrid's own log, JSON Lines: a header that describes the sensors, then a line a reading.

use super::fields::RecordBuilder;
use super::format::{Format, LogPath, Probe, RecordQueue, ScanReader, Source};
use super::input::Input;
use super::json_line;
use super::lines::LineReader;
use super::mounting::MountedSensor;
use super::opening::require_file;
use super::preamble::Preamble;
use super::problem::{BadLine, Problem};
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The format.
pub(crate) struct JsonLines;

impl Format for JsonLines {
    fn name(&self) -> &'static str {
        "echogrid-jsonl"
    }

    fn describe(&self) -> &'static str {
        "echogrid's JSON Lines (first line {\"echogrid_log\":1,\"sensors\":[…]})"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        text.lines().map(str::trim_start).find(|line| !passed_over(line)).is_some_and(|line| line.starts_with('{'))
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = require_file(place, "JSON Lines")?;
        let mut lines = input.lines()?;
        let line = loop {
            match lines.next() {
                None => return Err(Error::input(input.path(), "is empty")),
                Some(Ok(line)) if passed_over(line.trim()) => {}
                Some(Ok(line)) => break line.to_string(),
                Some(Err(Problem::Line(bad))) => return Err(Error::at(input.path(), bad.line, bad.what)),
                Some(Err(Problem::Fatal(error))) => return Err(error),
            }
        };
        let at = lines.number();
        let header = Preamble::parse(&line).map_err(|what| Error::at(input.path(), at, what))?;
        header.offers(kind).map_err(|what| Error::at(input.path(), at, what))?;
        Ok(Box::new(JsonLog { input: input.clone(), header, line: at, kind }))
    }
}

/// Whether a line before the header is empty or a comment.
fn passed_over(line: &str) -> bool {
    line.is_empty() || line.starts_with('#')
}

struct JsonLog {
    input: Input,
    header: Preamble,
    line: u64,
    kind: Option<Kind>,
}

impl Source for JsonLog {
    fn sensors(&self) -> &[Description] {
        &self.header.sensors
    }

    fn sensor_line(&self) -> Option<u64> {
        Some(self.line)
    }

    fn has_beams(&self) -> bool {
        false
    }

    fn classes(&self) -> &[String] {
        &self.header.classes
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[MountedSensor]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>> {
        let builder = RecordBuilder::new(sensors, self.header.classes.len(), self.kind);
        Ok(Box::new(JsonReader { lines: self.input.lines()?, header: self.line, builder, ignored }))
    }
}

struct JsonReader {
    lines: LineReader,
    header: u64,
    builder: RecordBuilder,
    ignored: Arc<AtomicU64>,
}

impl ScanReader for JsonReader {
    fn fill(&mut self, items: &mut RecordQueue) -> bool {
        let number = self.lines.number() + 1;
        let made = match self.lines.next() {
            None => return false,
            Some(Err(problem)) => {
                items.push_back(Err(problem));
                return true;
            }
            Some(Ok(line)) if number <= self.header || line.trim().is_empty() => return true,
            Some(Ok(line)) => json_line::parse(line).and_then(|fields| self.builder.record(&fields, number)),
        };
        match made {
            Ok(Some(record)) => items.push_back(Ok(record)),
            Ok(None) => {
                self.ignored.fetch_add(1, Ordering::Relaxed);
            }
            Err(what) => items.push_back(Err(Problem::Line(BadLine { line: number, what }))),
        }
        true
    }
}
