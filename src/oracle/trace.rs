//! The trace of one reading: its evidence for each of its cells, step by step, given the readings before it.

use super::cone::Cone;
use super::map::UpdateCounts;
use super::{CellUpdate, Region, bayes, certainty, cones, dempster_shafer};
use crate::grid::GridSpec;
use crate::log::reading::Reading;
use crate::method::settings::{Order, Settings};
use crate::sensor::Sensor;
use crate::{Error, Result};

/// How every reading of a log is applied.
#[derive(Debug, Clone, Copy)]
pub struct Setup<'a> {
    /// The cells.
    pub grid: &'a GridSpec,
    /// The sensors that readings name by their index.
    pub sensors: &'a [Sensor],
    /// The method and its parameters.
    pub settings: &'a Settings,
}

/// The evidence of one reading for one cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellTrace {
    /// The cell, and its position in the beam.
    pub update: CellUpdate,
    /// The reading's own evidence: Emp_k or Occ_k, the mass m_s, P(s|occupied), HIMM's step, 1 for a hit or a pass.
    pub own: f64,
    /// After cancelling by Emp (certainty grid, arc); elsewhere the same as `own`.
    pub cancelled: f64,
    /// After normalising over the arc (certainty grid, arc); elsewhere the same as `own`.
    pub normalised: f64,
}

/// The evidence of one reading, cell by cell.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingTrace {
    /// Its cells, row by row from the bottom.
    pub cells: Vec<CellTrace>,
    /// n, the number of its arc cells in the grid; of a missing echo, of a hit of the same range.
    pub arc_cells: usize,
    /// Sum of the cancelled evidence over the arc, the divisor of the normalising (certainty grid; else 0).
    pub sum: f64,
}

/// Traces reading `index` of `readings`, applied as [`super::map`] applies it. `wedges`: see there.
///
/// # Errors
/// [`Error::Usage`] where there is no such reading, and as [`super::map`].
pub fn trace(setup: &Setup, readings: &[Reading], wedges: Option<&[(f64, f64)]>, index: usize) -> Result<ReadingTrace> {
    let Setup { grid, sensors, settings } = *setup;
    let all = cones(grid, sensors, readings, settings, wedges)?;
    let Some(cone) = all.get(index) else {
        return Err(Error::Usage(format!("there is no reading {index}: the log has {}", readings.len())));
    };
    let Settings::Certainty(certainty) = settings else { return Ok(trace_cone(grid, cone, settings, &|_| 0.0)) };
    // The reading's own interior is no part of its arc: Emp of its arc cells is the same before and after it.
    let until = if certainty.order == Order::Batch { all.len() } else { index };
    let state = certainty::run(grid, &all[..until], certainty, &mut UpdateCounts::new(grid.cells()));
    Ok(trace_cone(grid, cone, settings, &|cell| state.emp[cell]))
}

/// Traces one reading without a log; `emptiness`: Emp of a cell (row by row from the bottom) on its arc, for the certainty grid.
///
/// # Errors
/// [`Error::Usage`] for a reading that names no sensor, and as [`super::map`].
pub fn trace_alone(
    setup: &Setup,
    reading: &Reading,
    wedge: Option<(f64, f64)>,
    emptiness: &dyn Fn(usize) -> f64,
) -> Result<ReadingTrace> {
    let wedge = wedge.map(|w| [w]);
    let wedges = wedge.as_ref().map(|w| &w[..]);
    let all = cones(setup.grid, setup.sensors, std::slice::from_ref(reading), setup.settings, wedges)?;
    Ok(trace_cone(setup.grid, &all[0], setup.settings, emptiness))
}

fn trace_cone(grid: &GridSpec, cone: &Cone, settings: &Settings, emptiness: &dyn Fn(usize) -> f64) -> ReadingTrace {
    let mut cells = Vec::new();
    let arc_cells = cone.cells(grid, &mut cells);
    let trace = |cell| {
        let update = cone.update(grid, cell);
        let own = own(cone, settings, &update, arc_cells);
        CellTrace { update, own, cancelled: own, normalised: own }
    };
    let mut traces: Vec<CellTrace> = cells.iter().map(trace).collect();
    let mut sum = 0.0;
    if let Settings::Certainty(_) = settings {
        let is_arc = |c: &&mut CellTrace| c.update.region == Region::Arc;
        for cell in traces.iter_mut().filter(is_arc) {
            cell.cancelled = cell.own * (1.0 - emptiness(cell.update.row * grid.width + cell.update.column));
            sum += cell.cancelled;
        }
        for cell in traces.iter_mut().filter(is_arc) {
            cell.normalised = if sum > 0.0 { cell.cancelled / sum } else { 0.0 };
        }
    }
    ReadingTrace { cells: traces, arc_cells, sum }
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
