//! `working-N.png` and `working-N.json`: one reading explained by a picture of its cone over the grid, and by the numbers of the f64 oracle.
//!
//! The picture draws the snapped cone: a cell is coloured if its centre lies inside the outline, blue where the reading frees it, red where
//! it takes it for occupied.

mod canvas;
mod cone_outline;
mod picture;

use super::names::{WORKING, WORKING_PICTURE};
use super::report::{parameters, tidy};
use super::unwritable;
use crate::grid::{GridSpec, Map};
use crate::log::reading::{Outcome, Pose, Reading};
use crate::method::Method;
use crate::method::settings::Settings;
use crate::oracle::{self, CellTrace, ReadingTrace, Region};
use crate::sensor::{Kind, Sensor};
use crate::{Error, Result, method};
pub(crate) use cone_outline::ConeOutline;
use cone_outline::SnappedCone;
use picture::{Drawing, Layout, Panel};
use serde::Serialize;
use serde_json::{Map as Object, Value};
use std::path::{Path, PathBuf};

/// The first part of the JSON file; the cells follow, one per line.
#[derive(Serialize)]
struct WorkingHeader<'a> {
    reading: ReadingInfo<'a>,
    method: &'static str,
    parameters: Object<String, Value>,
    grid: GridInfo,
    snapped: SnappedCone,
    /// The number of cells that the reading frees.
    interior_cells: usize,
    /// The number of cells on its arc: 0 for a missing echo.
    arc_cells: usize,
    /// n: the number of arc cells; for a missing echo the number that an echo would have.
    n: usize,
    /// The meaning of `own`.
    own_is: &'static str,
    /// Σ of the cancelled evidence over the arc (certainty).
    #[serde(skip_serializing_if = "Option::is_none")]
    sum: Option<f64>,
    picture: &'a Layout,
}

#[derive(Serialize)]
struct ReadingInfo<'a> {
    /// N: the N-th used reading, from 1.
    number: usize,
    line: u64,
    scan: u64,
    t: f64,
    sensor: &'a str,
    kind: Kind,
    robot: [f64; 3],
    pose: [f64; 3],
    /// The log's range; null is no echo.
    z: f64,
    outcome: &'static str,
    /// R: z, or the sensor's `no_echo_range`.
    range: f64,
    half_width: f64,
}

#[derive(Serialize)]
struct GridInfo {
    x0: f64,
    y0: f64,
    resolution: f64,
    width: usize,
    height: usize,
}

#[derive(Serialize)]
struct CellInfo {
    column: usize,
    row: usize,
    x: f64,
    y: f64,
    region: &'static str,
    d: f64,
    theta: f64,
    own: f64,
    /// For a method that normalises evidence alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    cancelled: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    normalised: Option<f64>,
}

/// The reading to explain, and what it depends on.
#[derive(Debug, Clone, Copy)]
pub struct WorkingRequest<'a> {
    /// The grid.
    pub grid: &'a GridSpec,
    /// The log's sensors.
    pub sensors: &'a [Sensor],
    /// The used readings of the log.
    pub readings: &'a [Reading],
    /// The method and its parameters.
    pub settings: &'a Settings,
    /// For the laser truth the bearings (left, right) of each reading's wedge, radians: see [`oracle::map`].
    pub wedges: Option<&'a [(f64, f64)]>,
    /// The number of the reading, from 1.
    pub number: usize,
    /// The map before the reading, on the same grid, to be shown grey behind the cone.
    pub map: Option<&'a Map>,
}

/// Writes `working-N.png` and `working-N.json` of used reading N into a folder that exists, and returns their paths, the picture first.
///
/// # Errors
/// [`Error::Usage`] if there is no such reading, or it can't be mapped; [`Error::Resources`] if a file can't be written.
pub fn write_working(folder: &Path, request: &WorkingRequest) -> Result<[PathBuf; 2]> {
    let WorkingRequest { grid, sensors, readings, settings, wedges, number, map } = *request;
    let Some(reading) = number.checked_sub(1).and_then(|k| readings.get(k)) else {
        return Err(no_such_reading(number, readings.len()));
    };
    if map.is_some_and(|m| m.grid != *grid) {
        return Err(Error::Usage("the map behind the working view is on another grid than the reading".into()));
    }
    let method = method::make(*settings);
    // The readings before it count; with several sweeps over the log those after it, too.
    let until = if method.sweeps().len() > 1 { readings.len() } else { number };
    let trace = oracle::trace(&oracle::Setup { grid, sensors, settings }, &readings[..until], wedges, number - 1)?;
    let Some(sensor) = sensors.get(reading.record.sensor as usize) else {
        return Err(Error::Usage(format!("the reading of line {} names no sensor", reading.record.line)));
    };
    let wedge = wedges.and_then(|w| w.get(number - 1).copied());
    let (outline, snapped) = ConeOutline::of(grid, sensor, reading, method.footprint(), wedge)?;
    let weigh = weigher(settings);
    let panels = panels(method.as_ref(), reading);
    let layout = Layout::of(&outline, &trace, &panels, &weigh);
    let paths = [WORKING_PICTURE, WORKING].map(|name| folder.join(name.of(number)));
    let drawing = Drawing { grid, outline: &outline, trace: &trace, layout: &layout, weigh: &weigh, map };
    drawing.draw().save(&paths[0]).map_err(|e| unwritable(&paths[0], e))?;
    let steps = method.evidence().normalised;
    let is_arc = |c: &&CellTrace| c.update.region == Region::Arc;
    let arc_cells = trace.cells.iter().filter(is_arc).count();
    let header = WorkingHeader {
        reading: reading_info(number, reading, sensor),
        method: method::name(method.as_ref()),
        parameters: parameters(settings.values()),
        grid: GridInfo {
            x0: tidy(grid.x0()),
            y0: tidy(grid.y0()),
            resolution: grid.resolution,
            width: grid.width,
            height: grid.height,
        },
        snapped,
        interior_cells: trace.cells.len() - arc_cells,
        arc_cells,
        n: trace.arc_cells,
        own_is: own_is(settings),
        sum: steps.then_some(trace.sum),
        picture: &layout,
    };
    let save = || -> std::io::Result<()> { std::fs::write(&paths[1], text(grid, &header, &trace, steps)?) };
    save().map_err(|e| unwritable(&paths[1], e))?;
    Ok(paths)
}

/// The error about a number that no reading has.
fn no_such_reading(number: usize, readings: usize) -> Error {
    Error::Usage(match readings {
        0 => format!("`working {number}`: the log has no reading that is used"),
        _ => format!("`working {number}`: the log has {readings} readings that are used; give 1 to {readings}"),
    })
}

/// The strength of a value of a method's evidence, 0 or more, which its shade shows.
pub(crate) fn weigher(settings: &Settings) -> fn(f64) -> f64 {
    match method::make(*settings).evidence().probability {
        true => |p| (2.0 * p - 1.0).abs(),
        false => f64::abs,
    }
}

/// The panels of the picture, side by side: cancelled and normalised evidence are shown of a hit alone.
fn panels(method: &dyn Method, reading: &Reading) -> Vec<Panel> {
    match method.evidence().normalised && reading.outcome == Outcome::Hit {
        true => vec![Panel::Own, Panel::Cancelled, Panel::Normalised],
        false => vec![Panel::Own],
    }
}

fn reading_info<'a>(number: usize, reading: &Reading, sensor: &'a Sensor) -> ReadingInfo<'a> {
    let record = &reading.record;
    let place = |p: Pose| [p.x, p.y, p.heading];
    ReadingInfo {
        number,
        line: record.line,
        scan: record.scan,
        t: record.t,
        sensor: &sensor.id,
        kind: sensor.kind,
        robot: place(record.robot),
        pose: place(record.pose),
        z: record.range,
        outcome: if reading.outcome == Outcome::Hit { "hit" } else { "no_echo" },
        range: reading.range,
        half_width: sensor.half_width,
    }
}

/// The meaning of a reading's own evidence by a method.
pub(crate) fn own_is(settings: &Settings) -> &'static str {
    method::make(*settings).evidence().about
}

/// The text of the JSON file: the header over many lines, then one line per cell. `steps`: with the cancelled and the normalised evidence.
fn text(grid: &GridSpec, header: &WorkingHeader, trace: &ReadingTrace, steps: bool) -> std::io::Result<Vec<u8>> {
    let mut text = serde_json::to_vec_pretty(header)?;
    text.truncate(text.len() - "\n}".len());
    text.extend(b",\n  \"cells\": [");
    for (k, CellTrace { update, own, cancelled, normalised }) in trace.cells.iter().enumerate() {
        let (x, y) = grid.centre(update.column, update.row);
        let cell = CellInfo {
            column: update.column,
            row: update.row,
            x,
            y,
            region: if update.region == Region::Arc { "arc" } else { "interior" },
            d: update.d,
            theta: update.theta,
            own: *own,
            cancelled: steps.then_some(*cancelled),
            normalised: steps.then_some(*normalised),
        };
        text.extend(if k == 0 { "\n    " } else { ",\n    " }.as_bytes());
        serde_json::to_writer(&mut text, &cell)?;
    }
    text.extend(b"\n  ]\n}\n");
    Ok(text)
}
