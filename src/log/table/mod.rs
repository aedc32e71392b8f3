//! Plain tables (CSV and the like) whose columns the user names with `--columns`.

use super::format::{LogPath, Source};
use super::mounting::Beams;
use super::opening::require_file;
use super::options::Options;
use super::text::TextLog;
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use columns::{ColumnRole, Columns};
use parser::{RangeLayout, TableParser};
use separator::Separator;
use start::{TableStart, names};
use std::path::Path;
use std::sync::Arc;

pub(super) mod columns;
mod parser;
pub(super) mod separator;
mod start;
pub(super) mod suggest;

/// The format's name, in reports.
pub(super) const NAME: &str = "table";
/// Opens a table.
///
/// # Errors
/// [`Error::Usage`] if the columns do not fit; [`Error::Input`] if the table does not fit the columns.
pub(super) fn open(place: &LogPath, options: &Options, text: &str) -> Result<Box<dyn Source>> {
    let input = require_file(place, "table")?;
    let usage = |what: String| Error::Usage(format!("--columns {text}: {what}"));
    let columns = Columns::parse(text).map_err(usage)?;
    columns.gives_readings().map_err(usage)?;
    let first = TableStart::of(input, &columns)?;
    let count = first.columns.iter().filter(|column| column.role == ColumnRole::Range).count();
    let layout = match (count, columns.has(ColumnRole::Angle), options.kind) {
        (1, ..) | (_, true, _) => RangeLayout::Own,
        (_, false, Some(Kind::Laser)) => RangeLayout::Beams,
        (_, false, Some(Kind::Sonar)) => RangeLayout::Ring,
        (_, false, None) => {
            return Err(usage(format!(
                "{count} ranges in a row: say --sensor laser, with --set fov=…, if they are the beams of one laser, or --sensor \
                 sonar, with a --sensor-file, if each is a sensor"
            )));
        }
    };
    if layout == RangeLayout::Ring && (columns.has(ColumnRole::Sensor) || columns.has(ColumnRole::X)) {
        return Err(usage("each range is a sensor of its own: it takes no sensor column and no sensor's pose".into()));
    }
    let kind = options.kind.or((count > 1).then_some(Kind::Laser));
    let sensors = match (layout, columns.has(ColumnRole::Sensor)) {
        (RangeLayout::Ring, _) => (1..=count).map(|k| Some(format!("range{k}"))).collect(),
        (_, true) => names(input, &first)?.into_iter().map(Some).collect(),
        (_, false) => vec![Some("sensor".to_string())],
    };
    let (first_bearing, step) = match (layout, options.overrides.fov) {
        (RangeLayout::Beams, Some(fov)) => {
            let beams = Beams::over(fov, count as u32);
            (Some(beams.first), Some(beams.step))
        }
        _ => (None, None),
    };
    let describe = |id: Option<String>| Description {
        id,
        kind,
        beams: (layout == RangeLayout::Beams).then_some(count as u32),
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
        beams: layout == RangeLayout::Beams,
        posed: columns.has(ColumnRole::Px),
        notes,
        parser: TableParser {
            path: input.path().into(),
            columns: first.columns.into(),
            rows: first.rows,
            from: first.line,
            layout,
            several: columns.has(ColumnRole::Sensor),
            ids: Arc::new(ids),
            scan: 0,
            last: None,
        },
        sensors,
    }))
}

/// The error about a table without named columns, with a suggestion for its header.
pub(super) fn columns_needed(path: &Path, line: u64, header: &str, what: &str) -> Error {
    let rows = Separator::of(header);
    let cells = rows.split(header);
    let spec = suggest::columns_for(&cells);
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
