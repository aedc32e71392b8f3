//! echogrid's own log as CSV: a row of names, then a row a reading. A first line `# {"echogrid_log":1,…}` carries the header
//! of the JSON Lines format; without it the sensors are unknown ones, found on a first scan of the `sensor` column.

use super::cells::split_cells;
use super::fields::{FIELD_NAMES, ReadingFields, RecordBuilder, SensorName};
use super::format::{Format, LogPath, Probe, RecordQueue, ScanReader, Source};
use super::input::Input;
use super::lines::LineReader;
use super::mounting::MountedSensor;
use super::opening::require_file;
use super::preamble::Preamble;
use super::problem::{BadLine, Problem};
use super::sensor_ids::{MAX_SENSORS, expand_indices};
use super::values::quote;
use crate::sensor::{Description, Kind};
use crate::support::suggest::similar;
use crate::{Error, Result};
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The format.
pub(crate) struct Csv;

impl Format for Csv {
    fn name(&self) -> &'static str {
        "echogrid-csv"
    }

    fn describe(&self) -> &'static str {
        "echogrid's CSV (a row of names: t,scan,sensor,px,py,ph,z)"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        let Some(first) = text.lines().find(|l| !l.trim().is_empty()) else { return false };
        let known = split_cells(first, b',').iter().filter(|name| FIELD_NAMES.contains(&name.as_ref())).count();
        first.trim_start().strip_prefix('#').is_some_and(|rest| rest.trim_start().starts_with('{')) || known >= 3
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = require_file(place, "CSV")?;
        let at = |line, what| Error::at(input.path(), line, what);
        let mut lines = input.lines()?;
        let mut header = None;
        let columns = loop {
            let line = match lines.next() {
                None => return Err(Error::input(input.path(), "no row of column names")),
                Some(Ok(line)) => line.trim().to_string(),
                Some(Err(Problem::Line(bad))) => return Err(at(bad.line, bad.what)),
                Some(Err(Problem::Fatal(error))) => return Err(error),
            };
            let number = lines.number();
            match line.strip_prefix('#').map(str::trim) {
                Some(json) if json.starts_with('{') && header.is_none() => {
                    let parsed = Preamble::parse(json).map_err(|what| at(number, what))?;
                    parsed.offers(kind).map_err(|what| at(number, what))?;
                    header = Some((parsed, number));
                }
                Some(_) => {}
                None if line.is_empty() => {}
                None => {
                    break columns(&line)
                        .map_err(|what| super::table::columns_needed(input.path(), number, &line, &what))?;
                }
            }
        };
        let names = lines.number();
        // Without a header all sensors are taken to be of the requested kind.
        let only = if header.is_some() { kind } else { None };
        let (header, line) = match header {
            Some((header, line)) => (header, Some(line)),
            None => (Preamble { sensors: unknown(lines, &columns, kind)?, classes: Vec::new() }, None),
        };
        Ok(Box::new(CsvLog { input: input.clone(), header, line, names, columns: columns.into(), only }))
    }
}

/// The field of each column, an index into [`FIELD_NAMES`].
fn columns(line: &str) -> std::result::Result<Vec<usize>, String> {
    let mut columns = Vec::new();
    for name in split_cells(line, b',') {
        match FIELD_NAMES.iter().position(|n| *n == name) {
            Some(column) if columns.contains(&column) => return Err(format!("two columns are called {name}")),
            Some(column) => columns.push(column),
            None => return Err(format!("unknown column {}{}", quote(&name), similar(&name, &FIELD_NAMES))),
        }
    }
    for need in ["scan", "px", "py", "ph", "z"] {
        if !columns.iter().any(|c| FIELD_NAMES[*c] == need) {
            return Err(format!("no column is called {need}"));
        }
    }
    Ok(columns)
}

/// The sensors of a log without a header: the ids of the column `sensor`.
fn unknown(mut lines: LineReader, columns: &[usize], kind: Option<Kind>) -> Result<Vec<Description>> {
    let mut seen = HashSet::new();
    let mut ids: Vec<String> = Vec::new();
    let column = columns.iter().position(|c| FIELD_NAMES[*c] == "sensor");
    while let Some(line) = lines.next() {
        let line = match line {
            Err(Problem::Fatal(error)) => return Err(error),
            Err(Problem::Line(_)) => continue,
            Ok(line) => line.trim(),
        };
        if let Some(id) = column.and_then(|c| split_cells(line, b',').into_iter().nth(c))
            && !id.is_empty()
            && !line.starts_with('#')
            && ids.len() < MAX_SENSORS
            && seen.insert(id.to_string())
        {
            ids.push(id.into_owned());
        }
    }
    let ids = expand_indices(ids);
    Ok(ids.into_iter().map(|id| Description { id: Some(id), kind, ..Description::default() }).collect())
}

struct CsvLog {
    input: Input,
    header: Preamble,
    line: Option<u64>,
    names: u64,
    columns: Arc<[usize]>,
    only: Option<Kind>,
}

impl Source for CsvLog {
    fn sensors(&self) -> &[Description] {
        &self.header.sensors
    }

    fn sensor_line(&self) -> Option<u64> {
        self.line
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
        let builder = RecordBuilder::new(sensors, self.header.classes.len(), self.only);
        let columns = self.columns.clone();
        Ok(Box::new(CsvReader { lines: self.input.lines()?, names: self.names, columns, builder, ignored }))
    }
}

struct CsvReader {
    lines: LineReader,
    names: u64,
    columns: Arc<[usize]>,
    builder: RecordBuilder,
    ignored: Arc<AtomicU64>,
}

impl ScanReader for CsvReader {
    fn fill(&mut self, items: &mut RecordQueue) -> bool {
        let number = self.lines.number() + 1;
        let made = match self.lines.next() {
            None => return false,
            Some(Err(problem)) => {
                items.push_back(Err(problem));
                return true;
            }
            Some(Ok(_)) if number <= self.names => return true,
            Some(Ok(line)) if line.trim().is_empty() || line.starts_with('#') => return true,
            Some(Ok(line)) => parse(line, &self.columns).and_then(|f| self.builder.record(&f, number)),
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

/// The fields of a row. An empty cell is a missing value, and no echo in the column z.
fn parse<'a>(line: &'a str, columns: &[usize]) -> std::result::Result<ReadingFields<'a>, String> {
    let cells = split_cells(line, b',');
    if cells.len() != columns.len() {
        return Err(format!("expected {} cells, found {}", columns.len(), cells.len()));
    }
    let mut fields = ReadingFields::default();
    for (cell, column) in cells.into_iter().zip(columns) {
        let name = FIELD_NAMES[*column];
        if cell.is_empty() || cell == "null" {
            if name == "z" {
                fields.z = Some(f64::INFINITY);
            }
            continue;
        }
        let number = || cell.parse::<f64>().map_err(|_| format!("{name} is {}, not a number", quote(&cell)));
        // Spreadsheets and data frames write 3 as 3.0.
        let count = || match cell.parse::<f64>() {
            Ok(n) if n.fract() == 0.0 && (0.0..9e15).contains(&n) => Ok(n as u64),
            _ => Err(format!("{name} is {}, not a count", quote(&cell))),
        };
        match name {
            "t" => fields.t = Some(number()?),
            "scan" => fields.scan = Some(count()?),
            "px" => fields.robot[0] = Some(number()?),
            "py" => fields.robot[1] = Some(number()?),
            "ph" => fields.robot[2] = Some(number()?),
            "x" => fields.pose[0] = Some(number()?),
            "y" => fields.pose[1] = Some(number()?),
            "h" => fields.pose[2] = Some(number()?),
            "z" => fields.z = Some(number()?),
            "label" => fields.label = Some(count()?),
            _ => fields.sensor = Some(SensorName::Id(cell)),
        }
    }
    Ok(fields)
}
