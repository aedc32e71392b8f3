//! The item that was applied last, as the page draws it: its cone, its beams, the shapes that features gave it.

use super::lane::Lane;
use super::number;
use crate::binning::scan::Scan;
use crate::feature::{Case, Fan, Origin, Update};
use crate::geometry::plane::Point;
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Pose};
use crate::output::ConeOutline;
use crate::pipeline::mapper::Item;
use crate::sensor::Kind;
use serde_json::{Value, json};

/// The last item; null at the log's beginning.
pub fn current(lane: &Lane) -> Value {
    let Some(last) = lane.stepper.position().checked_sub(1) else { return Value::Null };
    let items = lane.stepper.items();
    if let Some(scan) = items.scan(last) {
        return of_scan(lane, last, scan);
    }
    items.reading(last).map_or(Value::Null, |item| of_reading(lane, last, &item))
}

/// A pose: metres, metres, radians.
pub fn pose(p: &Pose) -> Value {
    json!([p.x, p.y, p.heading])
}

/// A place of the world frame in cells.
fn cell(grid: &GridSpec, p: Point) -> [f64; 2] {
    [(p.x - grid.x0()) / grid.resolution, (p.y - grid.y0()) / grid.resolution]
}

fn of_reading(lane: &Lane, last: usize, (reading, wedge): &Item) -> Value {
    let (grid, record) = (lane.stepper.grid(), &reading.record);
    let Some(sensor) = lane.stepper.sensors().get(record.sensor as usize) else { return Value::Null };
    let footprint = lane.stepper.method().footprint();
    let outline = ConeOutline::of(grid, sensor, reading, footprint, *wedge).ok().map(|(o, _)| {
        let lines: Vec<Vec<[f64; 2]>> = o.lines.iter().map(|line| line.iter().map(|p| [p.0, p.1]).collect()).collect();
        json!({"sensor": [o.sensor.0, o.sensor.1], "axis": o.axis.map(|p| [p.0, p.1]), "lines": lines})
    });
    json!({
        "kind": "reading",
        "number": last + 1,
        "line": record.line,
        "scan": record.scan,
        "t": number(record.t),
        "sensor": sensor.id,
        "sensor_kind": if sensor.kind == Kind::Sonar { "sonar" } else { "laser" },
        "robot": pose(&record.robot),
        "pose": pose(&record.pose),
        "z": number(record.range),
        "outcome": outcome(reading.outcome),
        "range": number(reading.range),
        "half_width": number(sensor.half_width),
        "outline": outline,
        "case": lane.stepper.items().update(last).map(|u| case(grid, u)),
    })
}

/// Hit or no echo.
pub fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Hit => "hit",
        Outcome::NoEcho => "no_echo",
    }
}

/// What features made of a reading.
fn case(grid: &GridSpec, update: &Update) -> Value {
    let sensor = update.reading.record.pose.position();
    let fan = |fan: &Option<Fan>| {
        let fan = fan.as_ref()?;
        Some(std::iter::once(sensor).chain(fan.vertices.iter().copied()).map(|p| cell(grid, p)).collect::<Vec<_>>())
    };
    let (name, about) = match update.case {
        Case::Associated => ("associated", "(i) from a feature, and nothing hides it"),
        Case::Outlier => ("outlier", "(ii) from behind a wall: it only frees, up to the wall"),
        Case::Behind => ("behind", "(iii) from behind a safe line: it only frees, up to the line"),
        Case::Routine => ("routine", "(iv) from no known feature: the Bayesian update, cut off at the free limit"),
    };
    let parts: Vec<Value> = update
        .parts
        .iter()
        .map(|part| {
            let feature = match part.origin {
                Origin::Wall => "wall",
                Origin::Corner => "corner",
                Origin::Point => "point",
            };
            let occupied: Vec<[[f64; 2]; 2]> = part.occupied.iter().map(|line| line.map(|p| cell(grid, p))).collect();
            json!({"feature": feature, "weight": part.weight, "free": fan(&part.free), "occupied": occupied})
        })
        .collect();
    let routine = update
        .routine
        .as_ref()
        .map(|r| json!({"weight": r.weight, "free": fan(&r.free), "arc": fan(&r.arc), "occupies": r.occupies}));
    json!({"name": name, "about": about, "parts": parts, "routine": routine})
}

fn of_scan(lane: &Lane, last: usize, scan: &Scan) -> Value {
    let grid = lane.stepper.grid();
    let beams: Vec<Value> = (0..scan.rays.len()).filter_map(|k| beam(lane, scan, k)).collect();
    let line = scan.rays.last().map_or(0, |r| r.source.1);
    json!({
        "kind": "scan",
        "number": last + 1,
        "line": line,
        "scan": last,
        "t": null,
        "robot": pose(&scan.robot),
        "robot_cell": cell(grid, scan.robot.position()),
        "beams": beams,
    })
}

/// A beam of a scan, from its sensor to its hit, or where nothing came back as far as its sensor hears.
pub fn beam(lane: &Lane, scan: &Scan, k: usize) -> Option<Value> {
    let ray = scan.rays.get(k)?;
    let (grid, at) = (lane.stepper.grid(), &ray.sensor);
    let far = ray.range.or_else(|| lane.stepper.sensors().get(ray.source.0 as usize).map(|s| s.r_max)).unwrap_or(0.0);
    let (sin, cos) = at.heading.sin_cos();
    let ends = [at.position(), Point::new(at.x + far * cos, at.y + far * sin)].map(|p| cell(grid, p));
    let label = if ray.label > 0 { json!(ray.label) } else { Value::Null };
    Some(json!({"line": ray.source.1, "pose": pose(at), "range": ray.range, "label": label, "ray": ends}))
}
