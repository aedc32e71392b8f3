//! echogrid's own log as CSV: a row of names, then a row a reading. A first line `# {"echogrid_log":1,…}` carries the header
//! of the JSON Lines format; without it the sensors are unknown ones, found on a first scan of the `sensor` column.

use super::fields::{Builder, Fields, NAMES, SensorName};
use super::format::{Format, Items, Mounted, Place, Probe, Scans, Source, quote};
use super::input::Input;
use super::jsonl::Preamble;
use super::lines::Lines;
use super::{BadLine, Problem};
use crate::sensor::{Description, Kind, similar};
use crate::{Error, Result};
use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// No log has more sensors; a damaged one might.
const MOST_SENSORS: usize = 4096;

/// The format.
pub(crate) struct Csv;

impl Format for Csv {
    fn name(&self) -> &'static str {
        "echogrid-csv"
    }

    fn looks(&self) -> &'static str {
        "echogrid's CSV (a row of names: t,scan,sensor,px,py,ph,z)"
    }

    fn claims(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        let Some(first) = text.lines().find(|l| !l.trim().is_empty()) else { return false };
        let known = split(first).iter().filter(|name| NAMES.contains(&name.as_ref())).count();
        first.trim_start().strip_prefix('#').is_some_and(|rest| rest.trim_start().starts_with('{')) || known >= 3
    }

    fn open(&self, place: &Place, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let Place::File(input) = place else { return Err(Error::Usage("a CSV log is a file".into())) };
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
                    break columns(&line).map_err(|what| super::table::unnamed(input.path(), number, &line, &what))?;
                }
            }
        };
        let names = lines.number();
        // The kind that is asked for is what the unknown sensors are; only a header can tell it apart.
        let only = if header.is_some() { kind } else { None };
        let (header, line) = match header {
            Some((header, line)) => (header, Some(line)),
            None => (Preamble { sensors: unknown(lines, &columns, kind)?, classes: Vec::new() }, None),
        };
        Ok(Box::new(CsvLog { input: input.clone(), header, line, names, columns: columns.into(), only }))
    }
}

/// What each column holds: an index into [`NAMES`].
fn columns(line: &str) -> std::result::Result<Vec<usize>, String> {
    let mut columns = Vec::new();
    for name in split(line) {
        match NAMES.iter().position(|n| *n == name) {
            Some(column) if columns.contains(&column) => return Err(format!("two columns are called {name}")),
            Some(column) => columns.push(column),
            None => return Err(format!("unknown column {}{}", quote(&name), similar(&name, &NAMES))),
        }
    }
    for need in ["scan", "px", "py", "ph", "z"] {
        if !columns.iter().any(|c| NAMES[*c] == need) {
            return Err(format!("no column is called {need}"));
        }
    }
    Ok(columns)
}

/// The sensors of a log that describes none.
fn unknown(mut lines: Lines, columns: &[usize], kind: Option<Kind>) -> Result<Vec<Description>> {
    let mut seen = HashSet::new();
    let mut ids: Vec<String> = Vec::new();
    let column = columns.iter().position(|c| NAMES[*c] == "sensor");
    while let Some(line) = lines.next() {
        let line = match line {
            Err(Problem::Fatal(error)) => return Err(error),
            Err(Problem::Line(_)) => continue,
            Ok(line) => line.trim(),
        };
        if let Some(id) = column.and_then(|c| split(line).into_iter().nth(c))
            && !id.is_empty()
            && !line.starts_with('#')
            && ids.len() < MOST_SENSORS
            && seen.insert(id.to_string())
        {
            ids.push(id.into_owned());
        }
    }
    let ids = indices(ids);
    Ok(ids.into_iter().map(|id| Description { id: Some(id), kind, ..Description::default() }).collect())
}

/// Names of sensors; plain numbers are indices: sensor 7 alone still means that there are eight.
pub(super) fn indices(ids: Vec<String>) -> Vec<String> {
    let indices: Option<Vec<usize>> = ids.iter().map(|id| id.parse().ok().filter(|i| *i < MOST_SENSORS)).collect();
    match indices {
        Some(indices) => (0..=indices.into_iter().max().unwrap_or(0)).map(|i| i.to_string()).collect(),
        None => ids,
    }
}

/// The cells of a row.
fn split(line: &str) -> Vec<Cow<'_, str>> {
    if line.contains('"') {
        let mut reader = ::csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
        if let Some(Ok(row)) = reader.records().next() {
            return row.iter().map(|cell| Cow::Owned(cell.trim().to_string())).collect();
        }
    }
    line.split(',').map(|cell| Cow::Borrowed(cell.trim())).collect()
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

    fn scans(&self, sensors: Arc<[Mounted]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn Scans>> {
        let builder = Builder::new(sensors, self.header.classes.len(), self.only);
        let columns = self.columns.clone();
        Ok(Box::new(Pass { lines: self.input.lines()?, names: self.names, columns, builder, ignored }))
    }
}

struct Pass {
    lines: Lines,
    names: u64,
    columns: Arc<[usize]>,
    builder: Builder,
    ignored: Arc<AtomicU64>,
}

impl Scans for Pass {
    fn fill(&mut self, items: &mut Items) -> bool {
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
fn parse<'a>(line: &'a str, columns: &[usize]) -> std::result::Result<Fields<'a>, String> {
    let cells = split(line);
    if cells.len() != columns.len() {
        return Err(format!("expected {} cells, found {}", columns.len(), cells.len()));
    }
    let mut fields = Fields::default();
    for (cell, column) in cells.into_iter().zip(columns) {
        let name = NAMES[*column];
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
