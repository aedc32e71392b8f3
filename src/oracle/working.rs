//! One reading explained: what it says of each of its cells, step by step, given the readings before it.

use super::cone::Cone;
use super::{CellUpdate, Region, Tally, bayes, certainty, cones, dempster_shafer};
use crate::grid::GridSpec;
use crate::log::reading::Reading;
use crate::method::settings::{Order, Settings};
use crate::sensor::Sensor;
use crate::{Error, Result};

/// What one reading says of one cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkingCell {
    /// The cell, and where it lies in the beam.
    pub update: CellUpdate,
    /// The reading's own evidence: Emp_k or Occ_k, the mass m_s, P(s|occupied), HIMM's step, 1 for a hit or a pass.
    pub own: f64,
    /// After cancelling by Emp (certainty grid, arc); elsewhere the same as `own`.
    pub cancelled: f64,
    /// After normalising over the arc (certainty grid, arc); elsewhere the same as `own`.
    pub normalised: f64,
}

/// One reading, cell by cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Working {
    /// Its cells, row by row from the bottom.
    pub cells: Vec<WorkingCell>,
    /// n: its arc cells in the grid (of a missing echo, those that it would have).
    pub arc_cells: usize,
    /// Σ of the cancelled evidence over the arc, which normalises (certainty grid; else 0).
    pub sum: f64,
}

/// Explains reading `index` of `readings`, as [`super::map`] would apply it.
pub fn working(
    grid: &GridSpec,
    sensors: &[Sensor],
    readings: &[Reading],
    settings: &Settings,
    wedges: Option<&[(f64, f64)]>,
    index: usize,
) -> Result<Working> {
    let all = cones(grid, sensors, readings, settings, wedges)?;
    let Some(cone) = all.get(index) else {
        return Err(Error::Usage(format!("there is no reading {index}: the log has {}", readings.len())));
    };
    let Settings::Certainty(certainty) = settings else { return Ok(explain(grid, cone, settings, &|_| 0.0)) };
    // the reading's own interior is no part of its arc: Emp before it and after it are the same there
    let until = if certainty.order == Order::Batch { all.len() } else { index };
    let state = certainty::run(grid, &all[..until], certainty, &mut Tally::new(grid.cells()));
    Ok(explain(grid, cone, settings, &|cell| state.emp[cell]))
}

/// Explains one reading alone; `emptiness`: Emp of a cell (row by row from the bottom) on its arc, for the certainty grid.
///
/// # Errors
/// [`Error::Usage`] for a reading that names no sensor.
pub fn working_of(
    grid: &GridSpec,
    sensors: &[Sensor],
    reading: &Reading,
    settings: &Settings,
    wedge: Option<(f64, f64)>,
    emptiness: &dyn Fn(usize) -> f64,
) -> Result<Working> {
    let wedge = wedge.map(|w| [w]);
    let all = cones(grid, sensors, std::slice::from_ref(reading), settings, wedge.as_ref().map(|w| &w[..]))?;
    Ok(explain(grid, &all[0], settings, emptiness))
}

fn explain(grid: &GridSpec, cone: &Cone, settings: &Settings, emptiness: &dyn Fn(usize) -> f64) -> Working {
    let mut cells = Vec::new();
    let arc_cells = cone.cells(grid, &mut cells);
    let explain = |cell| {
        let update = cone.update(grid, cell);
        let own = own(cone, settings, &update, arc_cells);
        WorkingCell { update, own, cancelled: own, normalised: own }
    };
    let mut explained: Vec<WorkingCell> = cells.iter().map(explain).collect();
    let mut sum = 0.0;
    if let Settings::Certainty(_) = settings {
        let is_arc = |c: &&mut WorkingCell| c.update.region == Region::Arc;
        for cell in explained.iter_mut().filter(is_arc) {
            cell.cancelled = cell.own * (1.0 - emptiness(cell.update.row * grid.width + cell.update.column));
            sum += cell.cancelled;
        }
        for cell in explained.iter_mut().filter(is_arc) {
            cell.normalised = if sum > 0.0 { cell.cancelled / sum } else { 0.0 };
        }
    }
    Working { cells: explained, arc_cells, sum }
}

/// The reading's own evidence of a cell.
fn own(cone: &Cone, settings: &Settings, update: &CellUpdate, n: usize) -> f64 {
    let (d, theta, region) = (update.d, update.theta, update.region);
    match (settings, region) {
        (Settings::Certainty(_), Region::Interior) => certainty::emp_k(d, theta, cone.span, cone.r_min, cone.beta),
        (Settings::Certainty(_), Region::Arc) => certainty::occ_k(d, theta, cone.range, cone.epsilon, cone.beta),
        (Settings::DempsterShafer(s), _) => dempster_shafer::mass(s, cone, region, (d, theta), n).value,
        (Settings::Bayes(s), _) => bayes::likelihood(s, cone, region, (d, theta)).value,
        (Settings::Himm(_), Region::Interior) => -1.0,
        (Settings::Himm(_), Region::Arc) => 3.0,
        (Settings::Truth | Settings::Csm(_) | Settings::Features(_), _) => 1.0,
    }
}
