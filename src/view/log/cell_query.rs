//! `api/cell` and `api/history`: a cell's state in every lane, and the readings that touched it.

use super::current_item::{beam, echo_outcome};
use super::lane::Lane;
use crate::grid::Class;
use crate::pipeline::step::{Cell, Event, LogInputs};
use crate::view::Request;
use crate::view::protocol::{
    self, CellClass, CellSource, ChosenBeam, EchoOutcome, History, HistoryEvent, NamedValue, Region, finite,
};
use crate::{Error, Result, oracle};
use serde_json::Number;

/// Events of a cell's history, unless the request gives a number, and at most.
const EVENTS: usize = 100;
const MOST_EVENTS: usize = 10_000;

/// The column and row that a request gives.
fn requested_cell(lane: &Lane, request: &Request) -> Result<[usize; 2]> {
    let (grid, [column, row]) = (lane.stepper.grid(), [request.query_number("column")?, request.query_number("row")?]);
    if column >= grid.width || row >= grid.height {
        let (width, height) = (grid.width, grid.height);
        return Err(Error::Usage(format!("there is no cell {column}, {row}: the grid has {width} × {height}")));
    }
    Ok([column, row])
}

/// A cell's state in every lane.
pub fn cell(lanes: &[Lane], request: &Request) -> Result<protocol::Cell> {
    let [column, row] = requested_cell(&lanes[0], request)?;
    let (x, y) = lanes[0].stepper.grid().centre(column, row);
    let sources = lanes.iter().map(|lane| cell_source(lane, column, row)).collect();
    Ok(protocol::Cell { column, row, x, y, sources })
}

fn cell_source(lane: &Lane, column: usize, row: usize) -> CellSource {
    let method = lane.stepper.method();
    let cell = Cell::of(method, lane.stepper.words(column, row).as_deref());
    let value = |name: &str, v: f32| NamedValue(name.into(), Number::from_f64(v.into()));
    let layers = method.layers().into_iter().zip(&cell.values).map(|(l, v)| value(l.name, *v));
    CellSource {
        name: lane.name().into(),
        touched: cell.touched,
        class: match cell.class {
            Class::Occupied => CellClass::Occupied,
            Class::Empty => CellClass::Empty,
            Class::Unknown => CellClass::Unknown,
        },
        interior: Some(cell.interior),
        arc: Some(cell.arc),
        values: layers.chain([value("combined", cell.combined)]).collect(),
        chosen: chosen_beams(lane, column, row),
    }
}

/// The beams that a cell of a counting sensor model counts; `None` for other methods.
fn chosen_beams(lane: &Lane, column: usize, row: usize) -> Option<Vec<ChosenBeam>> {
    let LogInputs::Scans(scans) = lane.stepper.items() else { return None };
    let known = &scans.all[..lane.stepper.position()];
    let given = oracle::beam_contributions(lane.stepper.grid(), known, &scans.csm, (column, row));
    let chosen = |given: &oracle::BeamContribution| {
        let names = class_names(lane, given.gained.len());
        Some(ChosenBeam {
            ray: beam(lane, &known[given.beam.0], given.beam.1)?,
            scan: given.beam.0,
            beam: given.beam.1,
            gained: names.into_iter().zip(given.gained.iter().map(|gain| finite(*gain))).collect(),
        })
    };
    Some(given.iter().filter_map(chosen).collect())
}

/// The names of `count` classes: labels, then "free".
fn class_names(lane: &Lane, count: usize) -> Vec<String> {
    let named = lane.stepper.session().classes.as_ref().map_or(&[][..], |c| &c.names);
    let name = |k: usize| match named.get(k) {
        Some(name) if k + 1 < count => name.clone(),
        _ if k + 1 == count => "free".into(),
        _ if count == 2 => "occupied".into(),
        _ => format!("class {}", k + 1),
    };
    (0..count).map(name).collect()
}

/// A cell's history.
pub fn history(lane: &Lane, request: &Request) -> Result<History> {
    let [column, row] = requested_cell(lane, request)?;
    let count = match request.query.contains_key("count") {
        true => request.query_number("count")?.min(MOST_EVENTS),
        false => EVENTS,
    };
    let history = lane.stepper.history(column, row, count)?;
    let is_scans = matches!(lane.stepper.items(), LogInputs::Scans(_));
    let note = is_scans.then_some(
        "the beams that the cell takes now, one of each of its nearest poses; before and after are what each gained of α",
    );
    let layers: Vec<&'static str> = match is_scans {
        true => lane.stepper.method().layers().iter().map(|l| l.name).filter(|n| n.starts_with("alpha")).collect(),
        false => lane.layer_names(),
    };
    let events = history.events.iter().map(|e| history_event(lane, e, layers.len())).collect::<Result<_>>()?;
    Ok(History { total: history.total, layers, events, note })
}

fn history_event(lane: &Lane, event: &Event, layers: usize) -> Result<HistoryEvent> {
    let (items, sensors) = (lane.stepper.items(), lane.stepper.sensors());
    let values = |cell: &Option<Cell>| match cell {
        Some(cell) => cell.values.iter().map(|v| finite((*v).into())).collect(),
        None => vec![Some(0.0); layers],
    };
    let sensor = |index: u32| sensors.get(index as usize).map_or(String::new(), |s| s.id.clone());
    let number = event.item + 1;
    let region = if event.arc { Region::Arc } else { Region::Interior };
    let (own, before, after) = (event.own.and_then(finite), values(&event.before), values(&event.after));
    if let (Some(given), Some(scan)) = (&event.given, items.scan(event.item)) {
        let ray = scan.rays.get(given.beam.1);
        let hit = ray.is_some_and(|r| r.range.is_some());
        return Ok(HistoryEvent {
            number,
            line: ray.map_or(0, |r| r.source.1),
            scan: event.item as u64,
            t: None,
            sensor: ray.map_or(String::new(), |r| sensor(r.source.0)),
            outcome: if hit { EchoOutcome::Hit } else { EchoOutcome::NoEcho },
            range: ray.and_then(|r| r.range),
            region,
            own,
            before,
            after: given.gained.iter().map(|g| finite(*g)).collect(),
        });
    }
    let no_reading = || Error::Resources(format!("item {number} of the log is neither a reading nor a scan"));
    let (reading, _) = items.reading(event.item).ok_or_else(no_reading)?;
    let record = &reading.record;
    Ok(HistoryEvent {
        number,
        line: record.line,
        scan: record.scan,
        t: finite(record.t),
        sensor: sensor(record.sensor),
        outcome: echo_outcome(reading.outcome),
        range: finite(reading.range),
        region,
        own,
        before,
        after,
    })
}
