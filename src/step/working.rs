//! The last item explained: what it says of each cell that it changed, step by step, and the cell before and after.

use super::{Cell, Stepper, Touched};
use crate::Result;
use crate::grid::GridSpec;
use crate::mapper::Item;
use crate::oracle::{Region, WorkingCell, working_of};
use crate::reading::Pose;
use std::collections::BTreeMap;

/// A cell that the item changed.
#[derive(Debug, Clone, PartialEq)]
pub struct CellStory {
    /// Column.
    pub column: usize,
    /// Row.
    pub row: usize,
    /// On the arc; else in the interior.
    pub arc: bool,
    /// Distance of the cell's centre from the sensor, metres, and its angle off the axis, radians; of a scan's cells from the robot, 0.
    pub polar: (f64, f64),
    /// The item's own evidence, cancelled, and normalised ([`WorkingCell`]); of an update P(occupied) that it says, thrice. `None` for a scan, of
    /// which a cell takes what its beam gives ([`crate::oracle::given`]).
    pub evidence: Option<[f64; 3]>,
    /// Before it.
    pub before: Cell,
    /// After it.
    pub after: Cell,
}

/// An item, cell by cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Explained {
    /// Its cells, row by row in each tile.
    pub cells: Vec<CellStory>,
    /// n: a reading's arc cells in the grid (of a missing echo, those that it would have).
    pub n: usize,
    /// Σ of the cancelled evidence over the arc (certainty).
    pub sum: Option<f64>,
}

/// Explains the item before the position; `None` at the log's beginning.
///
/// # Errors
/// [`crate::Error::Usage`] for a reading that names no sensor.
pub fn explain(stepper: &Stepper) -> Result<Option<Explained>> {
    let Some(last) = stepper.position().checked_sub(1) else { return Ok(None) };
    let method = stepper.method();
    let stories = |evidence: &dyn Fn(&Touched, &Cell, &Cell) -> ((f64, f64), Option<[f64; 3]>)| {
        let story = |t: &Touched| {
            let [before, after] = [&t.before, &t.after].map(|words| Cell::of(method, Some(words)));
            let (polar, evidence) = evidence(t, &before, &after);
            CellStory { column: t.column, row: t.row, arc: t.arc, polar, evidence, before, after }
        };
        stepper.touched().iter().map(story).collect::<Vec<_>>()
    };
    let grid = stepper.grid();
    let arcs = |cells: &[CellStory]| cells.iter().filter(|c| c.arc).count();
    if let Some(update) = stepper.items().update(last) {
        let pose = update.reading.record.pose;
        let cells = stories(&|t, before, after| {
            let said = 1.0 / (1.0 + f64::from(log_odds(stepper, before) - log_odds(stepper, after)).exp());
            (polar(grid, &pose, t), Some([said; 3]))
        });
        return Ok(Some(Explained { n: arcs(&cells), cells, sum: None }));
    }
    if let Some(scan) = stepper.items().scan(last) {
        let cells = stories(&|t, _, _| (polar(grid, &scan.robot, t), None));
        return Ok(Some(Explained { n: arcs(&cells), cells, sum: None }));
    }
    let Some((reading, wedge)) = stepper.items().reading(last) else { return Ok(None) };
    explain_reading(stepper, &(reading, wedge), &stories)
}

type Stories<'a> = dyn Fn(&dyn Fn(&Touched, &Cell, &Cell) -> ((f64, f64), Option<[f64; 3]>)) -> Vec<CellStory> + 'a;

fn explain_reading(stepper: &Stepper, (reading, wedge): &Item, stories: &Stories) -> Result<Option<Explained>> {
    let (grid, settings) = (stepper.grid(), stepper.method().settings());
    // A reading's own interior is no part of its arc: Emp is there after it what it was before.
    let emptiness = |cell: usize| {
        let words = stepper.words(cell % grid.width, cell / grid.width);
        f64::from(Cell::of(stepper.method(), words.as_deref()).values[0])
    };
    let working = working_of(grid, stepper.sensors(), reading, &settings, *wedge, &emptiness)?;
    let at: BTreeMap<[usize; 2], &WorkingCell> =
        working.cells.iter().map(|c| ([c.update.row, c.update.column], c)).collect();
    let mut cells = stories(&|t, _, _| match at.get(&[t.row, t.column]) {
        Some(c) => ((c.update.d, c.update.theta), Some([c.own, c.cancelled, c.normalised])),
        None => (polar(grid, &reading.record.pose, t), None),
    });
    for cell in &mut cells {
        // In the 1985 order other readings' cells change, too, and interiors only through them.
        if let Some(own) = at.get(&[cell.row, cell.column]) {
            cell.arc = own.update.region == Region::Arc;
        }
    }
    cells.retain(|c| at.contains_key(&[c.row, c.column]));
    let sum = matches!(settings, crate::method::settings::Settings::Certainty(_)).then_some(working.sum);
    Ok(Some(Explained { cells, n: working.arc_cells, sum }))
}

/// A cell's log odds of occupied, for methods that keep them.
fn log_odds(stepper: &Stepper, cell: &Cell) -> f32 {
    let place = stepper.method().layers().iter().position(|l| l.name == "log_odds");
    place.and_then(|k| cell.values.get(k)).copied().unwrap_or(0.0)
}

/// Distance and angle off the axis of a cell's centre.
fn polar(grid: &GridSpec, pose: &Pose, at: &Touched) -> (f64, f64) {
    let (x, y) = grid.centre(at.column, at.row);
    let (dx, dy) = (x - pose.x, y - pose.y);
    let (sin, cos) = pose.heading.sin_cos();
    (dx.hypot(dy), (cos * dy - sin * dx).atan2(cos * dx + sin * dy).abs())
}
