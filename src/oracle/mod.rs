//! The f64 reference: one reading at a time, straight from the equations, sharing no code with the kernels.
//!
//! Besides each value it computes a rigorous bound of the difference of a kernel in 32-bit floats, by running error analysis
//! (`bound` holds the errors of a kernel's operations), and marks the cells on a decision boundary.

mod bayes;
mod bound;
mod certainty;
mod cone;
mod csm;
mod dempster_shafer;
mod features;
mod himm;
mod map;
mod trace;
mod truth;

#[cfg(test)]
mod f32_kernels;
#[cfg(test)]
mod laws;
#[cfg(test)]
mod real_log;
#[cfg(test)]
mod vectors;

pub use csm::{BeamContribution, beam_contributions, contributing_beams, map_scans};
pub use features::{map_updates, update_touches};
pub use map::{OracleLayer, OracleMap};
pub use trace::{CellTrace, ReadingTrace, Setup, trace, trace_alone};

use crate::grid::GridSpec;
use crate::log::reading::Reading;
use crate::method::settings::Settings;
use crate::sensor::Sensor;
use crate::{Error, Result};
use cone::{Cone, Rule};
use map::{MethodOutput, UpdateCounts, assemble};

/// Where a cell lies in a reading's beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Region {
    /// Nearer than the echo: evidence of empty.
    Interior,
    /// At the echo's range: evidence of occupied. For HIMM the hit cell, for the laser truth a hit.
    Arc,
}

/// A cell that a reading reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellUpdate {
    /// Column, 0 at the left.
    pub column: usize,
    /// Row, 0 at the bottom.
    pub row: usize,
    /// Interior or arc.
    pub region: Region,
    /// Distance of the cell's centre from the sensor, metres.
    pub d: f64,
    /// Angle of the cell's centre off the beam's axis, radians; 0 for a narrow beam.
    pub theta: f64,
}

/// Maps `readings`, in their order, by the method of `settings`.
///
/// `wedges` is for [`Settings::Truth`] alone: for each reading the bearings of its wedge's edges in the world frame,
/// (left, right) in radians. The other methods ignore it.
///
/// # Errors
/// [`Error::Usage`] for a reading without a sensor or a finite pose, or out of range; for the laser truth without wedges; for a
/// method that takes scans ([`map_scans`]) or updates ([`map_updates`]).
pub fn map(
    grid: &GridSpec,
    sensors: &[Sensor],
    readings: &[Reading],
    settings: &Settings,
    wedges: Option<&[(f64, f64)]>,
) -> Result<OracleMap> {
    let cones = cones(grid, sensors, readings, settings, wedges)?;
    let mut counts = UpdateCounts::new(grid.cells());
    let output = match settings {
        Settings::Certainty(s) => certainty::map(grid, &cones, s, &mut counts),
        Settings::DempsterShafer(s) => dempster_shafer::map(grid, &cones, s, &mut counts),
        Settings::Bayes(s) => bayes::map(grid, &cones, s, &mut counts),
        Settings::Himm(s) => himm::map(grid, &cones, s, &mut counts),
        Settings::Truth => truth::map(grid, &cones, &mut counts),
        Settings::Csm(_) => {
            return Err(Error::Usage("a counting sensor model takes scans: see map_scans".into()));
        }
        Settings::Features(_) => {
            return Err(Error::Usage("the feature-based grid takes updates: see map_updates".into()));
        }
    };
    Ok(assemble(grid, output, counts, Vec::new()))
}

/// The cells of the grid that one reading updates, by the method of `settings`. `wedge`: see [`map`].
pub fn updated_cells(
    grid: &GridSpec,
    sensor: &Sensor,
    reading: &Reading,
    settings: &Settings,
    wedge: Option<(f64, f64)>,
) -> Result<Vec<CellUpdate>> {
    let cone = Cone::new(grid, sensor, reading, rule(sensor, settings, wedge)?, wedge_of(settings, wedge))?;
    let mut cells = Vec::new();
    cone.cells(grid, &mut cells);
    Ok(cells.iter().map(|cell| cone.update(grid, cell)).collect())
}

/// Every reading's cone.
fn cones(
    grid: &GridSpec,
    sensors: &[Sensor],
    readings: &[Reading],
    settings: &Settings,
    wedges: Option<&[(f64, f64)]>,
) -> Result<Vec<Cone>> {
    let snap = |(k, reading): (usize, &Reading)| {
        let index = reading.record.sensor;
        let Some(sensor) = sensors.get(index as usize) else {
            let (line, known) = (reading.record.line, sensors.len());
            return Err(Error::Usage(format!("the reading of line {line} names sensor {index}, of {known}")));
        };
        let wedge = wedges.and_then(|w| w.get(k).copied());
        Cone::new(grid, sensor, reading, rule(sensor, settings, wedge)?, wedge_of(settings, wedge))
    };
    readings.iter().enumerate().map(snap).collect()
}

/// The membership rule of a method.
fn rule(sensor: &Sensor, settings: &Settings, wedge: Option<(f64, f64)>) -> Result<Rule> {
    match settings {
        Settings::Himm(_) => Ok(Rule::Axis),
        Settings::Truth if wedge.is_none() => {
            Err(Error::Usage("the laser truth needs each reading's wedge: left and right bearing".into()))
        }
        Settings::Truth => Ok(Rule::Wedge),
        _ if sensor.narrow() => Ok(Rule::Narrow),
        _ => Ok(Rule::Cone),
    }
}

/// The wedge for [`Cone::new`]: only the laser truth has one.
fn wedge_of(settings: &Settings, wedge: Option<(f64, f64)>) -> Option<(f64, f64)> {
    wedge.filter(|_| *settings == Settings::Truth)
}
