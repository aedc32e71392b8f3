//! One reading explained: a picture of its cone over the grid, and every number behind it, from the f64 reference.
//!
//! `working-N.png` and `working-N.json`. The picture holds what the snapped cone holds: a cell is coloured if its centre
//! lies inside the outline that is drawn, blue where the reading frees it, red where it takes it for occupied.

mod canvas;
mod outline;
mod picture;

use super::names::{WORKING, WORKING_PICTURE};
use super::report::{parameters, tidy};
use super::unwritable;
use crate::grid::{GridSpec, Map};
use crate::log::reading::{Outcome, Pose, Reading};
use crate::method::settings::{Order, Settings};
use crate::oracle::{self, CellTrace, ReadingTrace, Region};
use crate::sensor::{Kind, Sensor};
use crate::{Error, Result, method};
pub(crate) use outline::Outline;
use outline::Snapped;
use picture::{Layout, Panel};
use serde::Serialize;
use serde_json::{Map as Object, Value};
use std::path::{Path, PathBuf};

/// The file's first part; the cells follow, one a line.
#[derive(Serialize)]
struct Head<'a> {
    reading: ReadingInfo<'a>,
    method: &'static str,
    parameters: Object<String, Value>,
    grid: GridInfo,
    snapped: Snapped,
    /// Cells that the reading frees.
    interior_cells: usize,
    /// Cells on its arc: 0 for a missing echo.
    arc_cells: usize,
    /// n: the arc cells, of a missing echo those that it would have.
    n: usize,
    /// What `own` is.
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
    /// Certainty alone has these steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    cancelled: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    normalised: Option<f64>,
}

/// Writes `working-N.png` and `working-N.json` of used reading `number` (from 1) into a folder that exists, and returns
/// their paths, the picture first.
///
/// `wedges` is for the laser truth alone, one pair (left, right) a reading: see [`oracle::map`]. `map` is the map before
/// the reading, shown grey behind the cone; it must be on the same grid.
///
/// # Errors
/// [`Error::Usage`] if there is no such reading, or it can't be mapped; [`Error::Resources`] if a file can't be written.
#[expect(clippy::too_many_arguments, reason = "what a map needs, the reading and where to")]
pub fn write_working(
    folder: &Path,
    grid: &GridSpec,
    sensors: &[Sensor],
    readings: &[Reading],
    settings: &Settings,
    wedges: Option<&[(f64, f64)]>,
    number: usize,
    map: Option<&Map>,
) -> Result<[PathBuf; 2]> {
    let Some(reading) = number.checked_sub(1).and_then(|k| readings.get(k)) else {
        return Err(none(number, readings.len()));
    };
    if map.is_some_and(|m| m.grid != *grid) {
        return Err(Error::Usage("the map behind the working view is on another grid than the reading".into()));
    }
    // All that stand before it count, and in the 1985 order those after it too.
    let whole = matches!(settings, Settings::Certainty(c) if c.order == Order::Batch);
    let until = if whole { readings.len() } else { number };
    let trace = oracle::trace(&oracle::Setup { grid, sensors, settings }, &readings[..until], wedges, number - 1)?;
    let Some(sensor) = sensors.get(reading.record.sensor as usize) else {
        return Err(Error::Usage(format!("the reading of line {} names no sensor", reading.record.line)));
    };
    let method = method::make(*settings);
    let wedge = wedges.and_then(|w| w.get(number - 1).copied());
    let (outline, snapped) = Outline::of(grid, sensor, reading, method.footprint(), wedge)?;
    let weigh = weigher(settings);
    let panels = panels(settings, reading);
    let layout = Layout::of(&outline, &trace, &panels, &weigh);
    let paths = [WORKING_PICTURE, WORKING].map(|name| folder.join(name.of(number)));
    picture::draw(grid, &outline, &trace, &layout, &weigh, map)
        .save(&paths[0])
        .map_err(|e| unwritable(&paths[0], e))?;
    let steps = matches!(settings, Settings::Certainty(_));
    let is_arc = |c: &&CellTrace| c.update.region == Region::Arc;
    let arc_cells = trace.cells.iter().filter(is_arc).count();
    let head = Head {
        reading: about(number, reading, sensor),
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
    let save = || -> std::io::Result<()> { std::fs::write(&paths[1], text(grid, &head, &trace, steps)?) };
    save().map_err(|e| unwritable(&paths[1], e))?;
    Ok(paths)
}

/// The error about a number that is no reading's.
fn none(number: usize, readings: usize) -> Error {
    Error::Usage(match readings {
        0 => format!("`working {number}`: the log has no reading that is used"),
        _ => format!("`working {number}`: the log has {readings} readings that are used; give 1 to {readings}"),
    })
}

/// How strong a value of a method is, 0 or more: what its shade shows.
pub(crate) fn weigher(settings: &Settings) -> fn(f64) -> f64 {
    match settings {
        Settings::Bayes(_) | Settings::Features(_) => |p| (2.0 * p - 1.0).abs(),
        _ => f64::abs,
    }
}

/// What the picture shows side by side: only a certainty grid's hit has steps between.
fn panels(settings: &Settings, reading: &Reading) -> Vec<Panel> {
    match settings {
        Settings::Certainty(_) if reading.outcome == Outcome::Hit => {
            vec![Panel::Own, Panel::Cancelled, Panel::Normalised]
        }
        _ => vec![Panel::Own],
    }
}

fn about<'a>(number: usize, reading: &Reading, sensor: &'a Sensor) -> ReadingInfo<'a> {
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

/// What a reading's own evidence is, by method.
pub(crate) fn own_is(settings: &Settings) -> &'static str {
    match settings {
        Settings::Certainty(_) => "certainty: Emp_k in the interior, Occ_k on the arc",
        Settings::DempsterShafer(_) => "mass: of empty in the interior, of full on the arc",
        Settings::Bayes(_) => "P(s|occupied)",
        Settings::Himm(_) => "step of the count: -1 before the hit, +3 at it",
        Settings::Truth => "count: 1 pass in the interior, 1 hit on the arc",
        Settings::Csm(_) => "what the beam that the cell takes gives to its α",
        Settings::Features(_) => "P(occupied) that the update says, its parts together",
    }
}

/// The JSON: the head over many lines, then a line a cell; `steps`: with the evidence cancelled and normalised.
fn text(grid: &GridSpec, head: &Head, trace: &ReadingTrace, steps: bool) -> std::io::Result<Vec<u8>> {
    let mut text = serde_json::to_vec_pretty(head)?;
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
