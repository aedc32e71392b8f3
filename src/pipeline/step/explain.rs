//! Explains the last item: its evidence of each cell that it changed, step by step, and the cell before and after.

use super::{Cell, Stepper, Touched};
use crate::Result;
use crate::grid::GridSpec;
use crate::log::reading::Pose;
use crate::oracle::{CellTrace, Region, Setup, trace_alone};
use crate::pipeline::readings::ReadingInput;
use std::collections::BTreeMap;

/// A cell that the item changed, with the item's evidence of it.
#[derive(Debug, Clone, PartialEq)]
pub struct CellStory {
    /// Column.
    pub column: usize,
    /// Row.
    pub row: usize,
    /// Whether the cell is on the arc; else it is in the interior.
    pub arc: bool,
    /// Distance of the cell's centre from the sensor, metres, and its angle off the axis, radians; for a scan from the robot's pose.
    pub polar: (f64, f64),
    /// The item's own evidence, the cancelled and the normalised ([`CellTrace`]); for an update three times its P(occupied). `None` for
    /// a scan, whose evidence [`crate::oracle::beam_contributions`] tells.
    pub evidence: Option<[f64; 3]>,
    /// The cell before the item.
    pub before: Cell,
    /// The cell after the item.
    pub after: Cell,
}

/// The explanation of an item, cell by cell.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Explained {
    /// The cells that it changed, row by row in each tile.
    pub cells: Vec<CellStory>,
    /// n: the number of its arc cells in the grid; for a missing echo the number that an echo would have.
    pub n: usize,
    /// Σ of the cancelled evidence over the arc, for a method that normalises by it (certainty).
    pub sum: Option<f64>,
}

/// Explains the item before the position; `None` at the beginning of the log.
///
/// # Errors
/// [`crate::Error::Usage`] for a reading that names no sensor.
pub fn explain(stepper: &Stepper) -> Result<Option<Explained>> {
    let Some(last) = stepper.position().checked_sub(1) else { return Ok(None) };
    let items = stepper.items();
    if let Some(update) = items.update(last) {
        let pose = update.reading.record.pose;
        let with_evidence = |story: CellStory| {
            let p = update_probability(stepper, &story.before, &story.after);
            CellStory { evidence: Some([p; 3]), ..story }
        };
        return Ok(Some(explained(stories(stepper, &pose).map(with_evidence).collect())));
    }
    if let Some(scan) = items.scan(last) {
        return Ok(Some(explained(stories(stepper, &scan.robot).collect())));
    }
    items.reading(last).map(|item| explain_reading(stepper, &item)).transpose()
}

fn explained(cells: Vec<CellStory>) -> Explained {
    Explained { n: cells.iter().filter(|c| c.arc).count(), cells, sum: None }
}

/// The changed cells before and after, seen from a pose.
fn stories<'a>(stepper: &'a Stepper, pose: &'a Pose) -> impl Iterator<Item = CellStory> + 'a {
    stepper.touched().iter().map(move |t| {
        let [before, after] = [&t.before, &t.after].map(|words| Cell::of(stepper.method(), Some(words)));
        let polar = polar(stepper.grid(), pose, t);
        CellStory { column: t.column, row: t.row, arc: t.arc, polar, evidence: None, before, after }
    })
}

fn explain_reading(stepper: &Stepper, (reading, wedge): &ReadingInput) -> Result<Explained> {
    let (grid, settings) = (stepper.grid(), stepper.method().settings());
    // A reading's own interior is no part of its arc: Emp is there after it what it was before.
    let emptiness = |cell: usize| {
        let words = stepper.words(cell % grid.width, cell / grid.width);
        f64::from(Cell::of(stepper.method(), words.as_deref()).values[0])
    };
    let setup = Setup { grid, sensors: stepper.sensors(), settings: &settings };
    let trace = trace_alone(&setup, reading, *wedge, &emptiness)?;
    let own: BTreeMap<[usize; 2], &CellTrace> =
        trace.cells.iter().map(|c| ([c.update.row, c.update.column], c)).collect();
    // In the 1985 order other readings' cells change, too.
    let tell = |story: CellStory| {
        let cell = own.get(&[story.row, story.column])?;
        Some(CellStory {
            arc: cell.update.region == Region::Arc,
            polar: (cell.update.d, cell.update.theta),
            evidence: Some([cell.own, cell.cancelled, cell.normalised]),
            ..story
        })
    };
    let cells = stories(stepper, &reading.record.pose).filter_map(tell).collect();
    let sum = stepper.method().evidence().normalised.then_some(trace.sum);
    Ok(Explained { cells, n: trace.arc_cells, sum })
}

/// P(occupied) of an update, from its change of a cell's log odds.
pub(super) fn update_probability(stepper: &Stepper, before: &Cell, after: &Cell) -> f64 {
    1.0 / (1.0 + (log_odds(stepper, before) - log_odds(stepper, after)).exp())
}

/// The log odds of occupied of a cell; 0 for a method without that layer.
fn log_odds(stepper: &Stepper, cell: &Cell) -> f64 {
    let place = stepper.method().layers().iter().position(|l| l.name == "log_odds");
    place.and_then(|k| cell.values.get(k)).map_or(0.0, |v| f64::from(*v))
}

/// Distance and angle off the axis of a cell's centre.
fn polar(grid: &GridSpec, pose: &Pose, at: &Touched) -> (f64, f64) {
    let (x, y) = grid.centre(at.column, at.row);
    let (dx, dy) = (x - pose.x, y - pose.y);
    let (sin, cos) = pose.heading.sin_cos();
    (dx.hypot(dy), (cos * dy - sin * dx).atan2(cos * dx + sin * dy).abs())
}
