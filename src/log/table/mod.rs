//! Plain tables (CSV and the like) whose columns the user names with `--columns`.

use super::format::{Beams, Items, Mounted, Place, Source, check_pose, quote};
use super::input::Input;
use super::text::{Parse, Scan, TextLog, file_of, look};
use super::{Options, csv};
use crate::log::reading::Pose;
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use columns::{Column, Role};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(super) use columns::Columns;
pub(super) use columns::Role as ColumnRole;
pub(super) use columns::scale;
pub(super) use rows::Rows;

mod columns;
mod rows;
pub(super) mod suggest;

/// The format's name, in reports.
pub(super) const NAME: &str = "table";
/// No log has more sensors; a damaged one might.
const MOST_SENSORS: usize = 4096;

/// How the ranges of a row belong to sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    /// One range, or several with an angle each.
    Own,
    /// The beams of one laser.
    Beams,
    /// A sonar each.
    Ring,
}

/// Opens a table. The text of `--columns` is wrong in ways that only the file can show: then the error names both.
pub(super) fn open(place: &Place, options: &Options, text: &str) -> Result<Box<dyn Source>> {
    let input = file_of(place, "table")?;
    let usage = |what: String| Error::Usage(format!("--columns {text}: {what}"));
    let columns = Columns::parse(text).map_err(usage)?;
    columns.gives_readings().map_err(usage)?;
    let first = First::of(input, &columns)?;
    let count = first.columns.iter().filter(|column| column.role == Role::Range).count();
    let layout = match (count, columns.has(Role::Angle), options.kind) {
        (1, ..) | (_, true, _) => Layout::Own,
        (_, false, Some(Kind::Laser)) => Layout::Beams,
        (_, false, Some(Kind::Sonar)) => Layout::Ring,
        (_, false, None) => {
            return Err(usage(format!(
                "{count} ranges in a row: say --sensor laser, with --set fov=…, if they are the beams of one laser, or --sensor \
                 sonar, with a --sensor-file, if each is a sensor"
            )));
        }
    };
    if layout == Layout::Ring && (columns.has(Role::Sensor) || columns.has(Role::X)) {
        return Err(usage("each range is a sensor of its own: it takes no sensor column and no sensor's pose".into()));
    }
    let kind = options.kind.or((count > 1).then_some(Kind::Laser));
    let sensors = match (layout, columns.has(Role::Sensor)) {
        (Layout::Ring, _) => (1..=count).map(|k| Some(format!("range{k}"))).collect(),
        (_, true) => names(input, &first)?.into_iter().map(Some).collect(),
        (_, false) => vec![Some("sensor".to_string())],
    };
    let (first_bearing, step) = match (layout, options.overrides.fov) {
        (Layout::Beams, Some(fov)) => {
            let beams = Beams::over(fov, count as u32);
            (Some(beams.first), Some(beams.step))
        }
        _ => (None, None),
    };
    let describe = |id: Option<String>| Description {
        id,
        kind,
        beams: (layout == Layout::Beams).then_some(count as u32),
        first: first_bearing,
        step,
        ..Description::default()
    };
    let sensors: Vec<Description> = sensors.into_iter().map(describe).collect();
    let mut notes = Vec::new();
    if first.commas {
        notes.push("its numbers have decimal commas: they are read as points".into());
    }
    if kind.is_none() && options.sensor_file.is_none() && options.overrides.beta.is_none() {
        notes.push(
            "its readings are taken to be a sonar's, 15° wide to either side: --sensor laser, a --sensor-file or --set beta=… \
             say otherwise"
                .into(),
        );
    }
    let ids = sensors.iter().enumerate().filter_map(|(i, d)| Some((d.id.clone()?, i))).collect();
    Ok(Box::new(TextLog {
        input: input.clone(),
        beams: layout == Layout::Beams,
        posed: columns.has(Role::Px),
        notes,
        parse: Table {
            path: input.path().into(),
            columns: first.columns.into(),
            rows: first.rows,
            from: first.line,
            layout,
            several: columns.has(Role::Sensor),
            ids: Arc::new(ids),
            scan: 0,
            last: None,
        },
        sensors,
    }))
}

/// The error about a table whose columns nobody named, with a line that fits its header.
pub(super) fn unnamed(path: &Path, line: u64, header: &str, what: &str) -> Error {
    let rows = Rows::of(header);
    let cells = rows.split(header);
    let spec = suggest::spec(&cells);
    let missing = match Columns::parse(&spec).and_then(|columns| columns.gives_readings()) {
        Ok(()) => String::new(),
        Err(why) => format!(" ({why})"),
    };
    Error::at(
        path,
        line,
        format!(
            "{what}{} Name its columns: --columns {spec}{missing}; - skips one, units as in x:mm or heading:deg \
             (docs/formats.md)",
            if what.ends_with('?') { "" } else { "." }
        ),
    )
}

/// What the first lines tell.
struct First {
    rows: Rows,
    columns: Vec<Column>,
    /// The first line of data.
    line: u64,
    /// Numbers have decimal commas.
    commas: bool,
}

impl First {
    fn of(input: &Input, columns: &Columns) -> Result<First> {
        let mut found = None;
        let mut headers = 0;
        look(input, |line, number| {
            let text = line.trim();
            if text.is_empty() || comment(text) {
                return true;
            }
            let rows = Rows::of(text);
            if headers == 0 && rows.is_header(line, columns) {
                headers = 1;
                return true;
            }
            // Blanks at its end may be empty cells between tabs.
            let cells = rows.split(line).len();
            found = Some(match columns.of(cells) {
                Ok(columns) => Ok(First { rows, columns, line: number, commas: rows.has_commas(text) }),
                Err(what) => Err(Error::at(input.path(), number, format!("{what}: {}", quote(text)))),
            });
            false
        })?;
        found.unwrap_or_else(|| Err(Error::input(input.path(), "has no row of numbers")))
    }
}

fn comment(text: &str) -> bool {
    text.starts_with('#') || text.starts_with('%') || text.starts_with("//")
}

/// The names in the column of sensors.
fn names(input: &Input, first: &First) -> Result<Vec<String>> {
    let column = first.columns.iter().position(|column| column.role == Role::Sensor);
    let mut names: Vec<String> = Vec::new();
    look(input, |line, number| {
        if number < first.line || comment(line.trim()) {
            return true;
        }
        let cells = first.rows.split(line);
        if let Some(name) = column.and_then(|i| cells.get(i)).filter(|name| !name.is_empty())
            && cells.len() == first.columns.len()
            && names.len() < MOST_SENSORS
            && !names.iter().any(|known| known == name)
        {
            names.push(name.to_string());
        }
        true
    })?;
    Ok(csv::indices(names))
}

#[derive(Clone)]
struct Table {
    path: PathBuf,
    columns: Arc<[Column]>,
    rows: Rows,
    from: u64,
    layout: Layout,
    several: bool,
    ids: Arc<HashMap<String, usize>>,
    scan: u64,
    /// The time and the robot's pose of the row before.
    last: Option<(f64, Pose)>,
}

impl Parse for Table {
    fn line(
        &mut self,
        line: &str,
        at: u64,
        sensors: &[Mounted],
        items: &mut Items,
    ) -> std::result::Result<bool, String> {
        if at < self.from || line.trim().is_empty() || comment(line.trim()) {
            return Ok(true);
        }
        let cells = self.rows.split(line);
        if cells.len() != self.columns.len() {
            return Err(format!("expected {} cells, found {}", self.columns.len(), cells.len()));
        }
        let (mut t, mut scan, mut sensor, mut label) = (None, None, 0, None);
        let (mut robot, mut given) = ([0.0; 3], [0.0; 3]);
        let (mut ranges, mut angles) = (Vec::new(), Vec::new());
        for (cell, column) in cells.iter().zip(self.columns.iter()) {
            let value = |name: &str| self.rows.value(cell, column.scale, name);
            match column.role {
                Role::Skip => {}
                Role::T => t = Some(value("t")?),
                Role::Scan => scan = Some(whole(value("scan")?, cell, "scan")?),
                Role::Label if cell.is_empty() => {}
                Role::Label => label = Some(whole(value("label")?, cell, "label")?),
                Role::Sensor => {
                    let plain = || self.ids.get(&cell.parse::<usize>().ok()?.to_string());
                    let index = self.ids.get(cell.as_ref()).or_else(plain);
                    sensor = *index
                        .ok_or_else(|| format!("sensor {} is not among the first {MOST_SENSORS}", quote(cell)))?;
                }
                Role::Px => robot[0] = value("x")?,
                Role::Py => robot[1] = value("y")?,
                Role::Ph => robot[2] = value("heading")?,
                Role::X => given[0] = value("the sensor's x")?,
                Role::Y => given[1] = value("the sensor's y")?,
                Role::H => given[2] = value("the sensor's heading")?,
                Role::Range if cell.is_empty() || cell == "null" => ranges.push(f64::INFINITY),
                Role::Range => ranges.push(value("range")?),
                Role::Angle => angles.push(value("angle")?),
            }
        }
        let pose = |[x, y, heading]: [f64; 3]| Pose { x, y, heading };
        let robot = pose(robot);
        check_pose("the robot's", &robot)?;
        let given = self.columns.iter().any(|c| c.role == Role::X).then(|| pose(given));
        if let Some(given) = &given {
            check_pose("the sensor's", given)?;
        }
        let time = t.unwrap_or(0.0);
        if !time.is_finite() {
            return Err(format!("t is {time}"));
        }
        if let Some(angle) = angles.iter().find(|angle| !angle.is_finite()) {
            return Err(format!("angle is {angle}"));
        }
        let label = match label {
            None => None,
            Some(label) => Some(u16::try_from(label).ok().filter(|l| *l > 0).ok_or("labels are 1 to 65535")?),
        };
        // Rows of one time, or without times of one place, are a scan; a row of several ranges is one.
        let moved = match (&self.last, t) {
            (None, _) => false,
            (Some((last, _)), Some(t)) => *last != t,
            (Some((_, last)), None) => *last != robot,
        };
        self.scan += u64::from(moved || (self.last.is_some() && ranges.len() > 1 && !self.several));
        self.last = Some((time, robot));
        let mut scan = Scan { t: time, number: scan.unwrap_or(self.scan), sensor, robot, given, line: at };
        let beams = sensors.get(sensor).and_then(|m| m.beams);
        let before = items.len();
        for (k, range) in ranges.iter().enumerate() {
            let off = match (self.layout, beams) {
                (Layout::Beams, Some(beams)) => beams.first + k as f64 * beams.step,
                _ => angles.get(k).copied().unwrap_or(0.0),
            };
            if self.layout == Layout::Ring {
                scan.sensor = k;
            }
            scan.push(sensors, off, *range, items);
        }
        if label.is_some() {
            for record in items.iter_mut().skip(before).flatten() {
                record.label = label;
            }
        }
        Ok(true)
    }

    fn ready(&self, sensors: &[Mounted]) -> Result<()> {
        let count = self.columns.iter().filter(|column| column.role == Role::Range).count();
        match self.layout {
            Layout::Beams if sensors.iter().any(|m| m.beams.is_none()) => Err(Error::input(
                &self.path,
                format!(
                    "nothing says where the {count} beams of a row look: give --set fov=180deg (their field of view, the first \
                     beam on the right), columns of angles, or a --sensor-file with first and step"
                ),
            )),
            Layout::Ring if !sensors.iter().any(|m| m.placed) => Err(Error::input(
                &self.path,
                format!(
                    "nothing says where the {count} sonars of a row sit and look: describe them in a --sensor-file, one \
                     [[sensor]] each with x, y and axis (docs/formats.md)"
                ),
            )),
            _ => Ok(()),
        }
    }
}

fn whole(value: f64, cell: &str, name: &str) -> std::result::Result<u64, String> {
    match value.fract() == 0.0 && (0.0..9e15).contains(&value) {
        true => Ok(value as u64),
        false => Err(format!("{name} is {}, not a count", quote(cell))),
    }
}
