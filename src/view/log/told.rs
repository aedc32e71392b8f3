//! What is told of cells: their state, their history, and what the last item said of each.

use super::current::{beam, outcome};
use super::lane::Lane;
use super::{EVENTS, MOST_EVENTS, number, short};
use crate::grid::Class;
use crate::method::settings::Settings;
use crate::output::{own_is, weigher};
use crate::pipeline::step::{Cell, CellStory, Event, explain};
use crate::view::Ask;
use crate::{Error, Result, oracle};
use serde_json::{Map, Value, json};

/// Cells of one item that are told at most.
const MOST: usize = 20_000;

/// The cell that is asked for.
fn asked(lane: &Lane, ask: &Ask) -> Result<[usize; 2]> {
    let (grid, [column, row]) = (lane.stepper.grid(), [ask.number("column")?, ask.number("row")?]);
    if column >= grid.width || row >= grid.height {
        let (width, height) = (grid.width, grid.height);
        return Err(Error::Usage(format!("there is no cell {column}, {row}: the grid has {width} × {height}")));
    }
    Ok([column, row])
}

/// A cell's state in every lane.
pub fn cell(lanes: &[Lane], ask: &Ask) -> Result<Value> {
    let [column, row] = asked(&lanes[0], ask)?;
    let (x, y) = lanes[0].stepper.grid().centre(column, row);
    let source = |lane: &Lane| {
        let method = lane.stepper.method();
        let cell = Cell::of(method, lane.stepper.words(column, row).as_deref());
        let class = match cell.class {
            Class::Occupied => "occupied",
            Class::Empty => "empty",
            Class::Unknown => "unknown",
        };
        let values = method.layers().into_iter().zip(&cell.values).map(|(l, v)| json!([l.name, short(*v)]));
        let mut values: Vec<Value> = values.collect();
        values.push(json!(["combined", short(cell.combined)]));
        let mut told = Map::from_iter([
            ("name".to_string(), json!(lane.name())),
            ("touched".to_string(), json!(cell.touched)),
            ("class".to_string(), json!(class)),
            ("interior".to_string(), json!(cell.interior)),
            ("arc".to_string(), json!(cell.arc)),
            ("values".to_string(), json!(values)),
        ]);
        if let Some(chosen) = chosen(lane, column, row) {
            told.insert("chosen".into(), chosen);
        }
        Value::Object(told)
    };
    let sources: Vec<Value> = lanes.iter().map(source).collect();
    Ok(json!({"column": column, "row": row, "x": x, "y": y, "sources": sources}))
}

/// The poses and beams that speak of a cell, for a counting sensor model.
fn chosen(lane: &Lane, column: usize, row: usize) -> Option<Value> {
    let crate::pipeline::step::Items::Scans(scans) = lane.stepper.items() else { return None };
    let known = &scans.all[..lane.stepper.position()];
    let given = oracle::given(lane.stepper.grid(), known, &scans.csm, (column, row));
    let tell = |given: &oracle::Given| {
        let mut told = beam(lane, &known[given.beam.0], given.beam.1)?;
        told["scan"] = json!(given.beam.0);
        told["beam"] = json!(given.beam.1);
        let names = classes(lane, given.gained.len());
        told["gained"] = given.gained.iter().zip(names).map(|(gain, name)| json!([name, number(*gain)])).collect();
        Some(told)
    };
    Some(json!(given.iter().filter_map(tell).collect::<Vec<_>>()))
}

/// The names of so many α: labels, then "free".
fn classes(lane: &Lane, count: usize) -> Vec<String> {
    let named = lane.stepper.session().classes.as_ref().map_or(&[][..], |c| &c.names);
    let name = |k: usize| match named.get(k) {
        Some(name) if k + 1 < count => name.clone(),
        _ if k + 1 == count => "free".into(),
        _ if count == 2 => "occupied".into(),
        _ => format!("class {}", k + 1),
    };
    (0..count).map(name).collect()
}

fn layers(lane: &Lane) -> Vec<&'static str> {
    lane.stepper.method().layers().iter().map(|l| l.name).collect()
}

/// How many arc cells a reading has, where the method asks: certainty of an echo, Dempster-Shafer of a missing one, too.
fn n(settings: &Settings, n: usize, arcs: usize) -> Option<usize> {
    match settings {
        Settings::DempsterShafer(_) => Some(n),
        Settings::Certainty(_) => Some(n).filter(|_| arcs > 0),
        _ => None,
    }
}

/// How strongly an item speaks of a cell, and what that is.
fn strength(settings: &Settings, story: &CellStory) -> f64 {
    match story.evidence {
        Some(evidence) => weigher(settings)(evidence[0]),
        None => f64::from((story.after.combined - story.before.combined).abs()),
    }
}

fn strength_is(settings: &Settings) -> &'static str {
    match settings {
        Settings::Bayes(_) | Settings::Features(_) => "|2·own − 1|",
        Settings::Csm(_) => "how far the combined picture moved",
        _ => "own",
    }
}

/// What the last item said of each cell that it changed.
pub fn working(lane: &Lane) -> Result<Value> {
    let (stepper, settings) = (&lane.stepper, lane.stepper.method().settings());
    let explained = explain(stepper)?.unwrap_or_default();
    let steps = matches!(settings, Settings::Certainty(_));
    let arcs = explained.cells.iter().filter(|c| c.arc).count();
    let all = &explained.cells[..explained.cells.len().min(MOST)];
    let each = |of: &dyn Fn(&CellStory) -> Value| Value::Array(all.iter().map(of).collect());
    let evidence = |c: &CellStory, k: usize| c.evidence.map_or(Value::Null, |e| number(e[k]));
    let most = all.iter().map(|c| strength(&settings, c)).filter(|s| s.is_finite()).fold(0.0, f64::max);
    let shade = |c: &CellStory| number(if most > 0.0 { strength(&settings, c) / most } else { 0.0 });
    let names = layers(lane);
    let values = |of: &dyn Fn(&CellStory) -> &Cell| -> Vec<Value> {
        (0..names.len()).map(|k| each(&|c| short(of(c).values[k]))).collect()
    };
    let mut told = json!({
        "position": stepper.position(),
        "interior": explained.cells.len() - arcs,
        "arc": arcs,
        "n": n(&settings, explained.n, arcs),
        "sum": explained.sum.map(number),
        "own_is": own_is(&settings),
        "layers": names,
        "steps": if steps { &["own", "cancelled", "normalised"][..] } else { &["own"] },
        "truncated": all.len() < explained.cells.len(),
        "column": each(&|c| json!(c.column)),
        "row": each(&|c| json!(c.row)),
        "region": each(&|c| json!(u8::from(c.arc))),
        "d": each(&|c| number(c.polar.0)),
        "theta": each(&|c| number(c.polar.1)),
        "own": each(&|c| evidence(c, 0)),
        "strength": each(&shade),
        "strongest": number(most),
        "strength_is": strength_is(&settings),
        "before": values(&|c| &c.before),
        "after": values(&|c| &c.after),
    });
    if steps {
        // Only what an arc says is cancelled and normalised.
        for (k, step) in [(1, "cancelled"), (2, "normalised")] {
            told[step] = each(&|c| if c.arc { evidence(c, k) } else { Value::Null });
        }
    }
    Ok(told)
}

/// A cell's history.
pub fn history(lane: &Lane, ask: &Ask) -> Result<Value> {
    let [column, row] = asked(lane, ask)?;
    let count = match ask.query.contains_key("count") {
        true => ask.number("count")?.min(MOST_EVENTS),
        false => EVENTS,
    };
    let history = lane.stepper.history(column, row, count)?;
    let is_scans = matches!(lane.stepper.items(), crate::pipeline::step::Items::Scans(_));
    let note = is_scans.then_some(
        "the beams that the cell takes now, one of each of its nearest poses; before and after are what each gained of α",
    );
    let names = match is_scans {
        true => lane.stepper.method().layers().iter().map(|l| l.name).filter(|n| n.starts_with("alpha")).collect(),
        false => layers(lane),
    };
    let events: Vec<Value> = history.events.iter().map(|e| event(lane, e, names.len())).collect();
    Ok(json!({"total": history.total, "layers": names, "events": events, "note": note}))
}

fn event(lane: &Lane, event: &Event, layers: usize) -> Value {
    let items = lane.stepper.items();
    let values = |cell: &Option<Cell>| match (cell, &event.given) {
        (Some(cell), _) => cell.values.iter().map(|v| short(*v)).collect::<Vec<_>>(),
        (None, _) => vec![json!(0.0); layers],
    };
    let mut told = json!({
        "number": event.item + 1,
        "region": if event.arc { "arc" } else { "interior" },
        "own": event.own.map(number),
        "before": values(&event.before),
        "after": values(&event.after),
    });
    if let Some((reading, _)) = items.reading(event.item) {
        let record = &reading.record;
        let sensor = lane.stepper.sensors().get(record.sensor as usize).map_or("", |s| s.id.as_str());
        told["line"] = json!(record.line);
        told["scan"] = json!(record.scan);
        told["t"] = number(record.t);
        told["sensor"] = json!(sensor);
        told["outcome"] = json!(outcome(reading.outcome));
        told["range"] = number(reading.range);
    }
    if let (Some(given), Some(scan)) = (&event.given, items.scan(event.item)) {
        let ray = scan.rays.get(given.beam.1);
        let sensor = ray.and_then(|r| lane.stepper.sensors().get(r.source.0 as usize)).map_or("", |s| s.id.as_str());
        told["line"] = json!(ray.map_or(0, |r| r.source.1));
        told["scan"] = json!(event.item);
        told["t"] = Value::Null;
        told["sensor"] = json!(sensor);
        told["outcome"] = json!(if ray.is_some_and(|r| r.range.is_some()) { "hit" } else { "no_echo" });
        told["range"] = json!(ray.and_then(|r| r.range));
        told["after"] = json!(given.gained.iter().map(|g| number(*g)).collect::<Vec<_>>());
    }
    told
}
