//! The item that was applied last, as the page draws it: the cone of a reading, the beams of a scan, the shapes that features made.

use super::lane::Lane;
use crate::binning::scan::Scan;
use crate::feature::{Case, Fan, Origin, Update};
use crate::geometry::plane::Point;
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Pose};
use crate::output::ConeOutline;
use crate::pipeline::readings::ReadingInput;
use crate::sensor::Kind;
use crate::view::protocol::{
    Beam, CellPoint, Current, CurrentReading, CurrentScan, EchoOutcome, FeatureCase, FeatureCaseName, FeatureKind,
    FeaturePart, Outline, RoutinePart, SensorKind, WorldPose, finite,
};

/// The last item of a lane; `None` at the log's beginning.
pub fn current_item(lane: &Lane) -> Option<Current> {
    let last = lane.stepper.position().checked_sub(1)?;
    let items = lane.stepper.items();
    if let Some(scan) = items.scan(last) {
        return Some(Current::Scan(current_scan(lane, last, scan)));
    }
    let item = items.reading(last)?;
    current_reading(lane, last, &item).map(|reading| Current::Reading(Box::new(reading)))
}

/// A pose as the page takes it.
fn world_pose(p: &Pose) -> WorldPose {
    WorldPose([p.x, p.y, p.heading])
}

/// A point of the world frame in cells.
fn cell_point(grid: &GridSpec, p: Point) -> CellPoint {
    CellPoint([(p.x - grid.x0()) / grid.resolution, (p.y - grid.y0()) / grid.resolution])
}

/// A sensor's kind.
pub fn sensor_kind(kind: Kind) -> SensorKind {
    if kind == Kind::Sonar { SensorKind::Sonar } else { SensorKind::Laser }
}

/// Hit or no echo.
pub fn echo_outcome(outcome: Outcome) -> EchoOutcome {
    match outcome {
        Outcome::Hit => EchoOutcome::Hit,
        Outcome::NoEcho => EchoOutcome::NoEcho,
    }
}

fn current_reading(lane: &Lane, last: usize, (reading, wedge): &ReadingInput) -> Option<CurrentReading> {
    let (grid, record) = (lane.stepper.grid(), &reading.record);
    let sensor = lane.stepper.sensors().get(record.sensor as usize)?;
    let footprint = lane.stepper.method().footprint();
    let point = |p: &(f64, f64)| CellPoint([p.0, p.1]);
    let outline = ConeOutline::of(grid, sensor, reading, footprint, *wedge).ok().map(|(o, _)| Outline {
        sensor: point(&o.sensor),
        axis: o.axis.map(|p| point(&p)),
        lines: o.lines.iter().map(|line| line.iter().map(point).collect()).collect(),
    });
    Some(CurrentReading {
        number: last + 1,
        line: record.line,
        scan: record.scan,
        t: finite(record.t),
        sensor: sensor.id.clone(),
        sensor_kind: sensor_kind(sensor.kind),
        robot: world_pose(&record.robot),
        pose: world_pose(&record.pose),
        z: finite(record.range),
        outcome: echo_outcome(reading.outcome),
        range: finite(reading.range),
        half_width: finite(sensor.half_width),
        outline,
        case: lane.stepper.items().update(last).map(|u| feature_case(grid, u)),
    })
}

/// What features made of a reading.
fn feature_case(grid: &GridSpec, update: &Update) -> FeatureCase {
    let sensor = Point::new(update.reading.record.pose.x, update.reading.record.pose.y);
    let polygon = |fan: &Option<Fan>| -> Option<Vec<CellPoint>> {
        let fan = fan.as_ref()?;
        Some(std::iter::once(sensor).chain(fan.vertices.iter().copied()).map(|p| cell_point(grid, p)).collect())
    };
    let (name, about) = match update.case {
        Case::Associated => (FeatureCaseName::Associated, "(i) from a feature, and nothing hides it"),
        Case::Outlier => (FeatureCaseName::Outlier, "(ii) from behind a wall: it only frees, up to the wall"),
        Case::Behind => (FeatureCaseName::Behind, "(iii) from behind a safe line: it only frees, up to the line"),
        Case::Routine => {
            (FeatureCaseName::Routine, "(iv) from no known feature: the Bayesian update, cut off at the free limit")
        }
    };
    let parts = update.parts.iter().map(|part| FeaturePart {
        feature: match part.origin {
            Origin::Wall => FeatureKind::Wall,
            Origin::Corner => FeatureKind::Corner,
            Origin::Point => FeatureKind::Point,
        },
        weight: part.weight,
        free: polygon(&part.free),
        occupied: part.occupied.iter().map(|line| line.map(|p| cell_point(grid, p))).collect(),
    });
    let routine = update.routine.as_ref().map(|r| RoutinePart {
        weight: r.weight,
        free: polygon(&r.free),
        arc: polygon(&r.arc),
        occupies: r.occupies,
    });
    FeatureCase { name, about, parts: parts.collect(), routine }
}

fn current_scan(lane: &Lane, last: usize, scan: &Scan) -> CurrentScan {
    let grid = lane.stepper.grid();
    CurrentScan {
        number: last + 1,
        line: scan.rays.last().map_or(0, |r| r.source.1),
        scan: last,
        t: None,
        robot: world_pose(&scan.robot),
        robot_cell: cell_point(grid, Point::new(scan.robot.x, scan.robot.y)),
        beams: (0..scan.rays.len()).filter_map(|k| beam(lane, scan, k)).collect(),
    }
}

/// A beam of a scan, from its sensor to its hit, or where nothing came back as far as its sensor hears.
pub fn beam(lane: &Lane, scan: &Scan, k: usize) -> Option<Beam> {
    let ray = scan.rays.get(k)?;
    let (grid, at) = (lane.stepper.grid(), &ray.sensor);
    let far = ray.range.or_else(|| lane.stepper.sensors().get(ray.source.0 as usize).map(|s| s.r_max)).unwrap_or(0.0);
    let (sin, cos) = at.heading.sin_cos();
    Some(Beam {
        line: ray.source.1,
        pose: world_pose(at),
        range: ray.range,
        label: (ray.label > 0).then_some(ray.label.into()),
        ray: [Point::new(at.x, at.y), Point::new(at.x + far * cos, at.y + far * sin)].map(|p| cell_point(grid, p)),
    })
}
