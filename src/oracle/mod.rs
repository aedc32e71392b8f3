//! The f64 reference: one reading at a time, straight from the equations, sharing no code with the kernels.
//!
//! Besides each value it carries a rigorous bound on what a kernel in 32-bit floats may differ by, found by running
//! error analysis (`bound` holds what a kernel is allowed), and says which cells stand on a decision boundary.

mod bayes;
mod bound;
mod certainty;
mod cone;
mod csm;
mod dempster_shafer;
mod features;
mod himm;
mod truth;
mod working;

#[cfg(test)]
mod in_f32;
#[cfg(test)]
mod laws;
#[cfg(test)]
mod real_log;
#[cfg(test)]
mod vectors;

pub use csm::{Given, beams_of, given, map_scans};
pub use features::{map_updates, reaches};
pub use working::{Working, WorkingCell, working, working_of};

use crate::grid::GridSpec;
use crate::log::reading::Reading;
use crate::method::settings::Settings;
use crate::sensor::Sensor;
use crate::{Error, Result};
use cone::{Cell, Cone, Rule};

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

/// One layer of the reference map.
#[derive(Debug, Clone, PartialEq)]
pub struct OracleLayer {
    /// The layer's name, the same as the method's.
    pub name: &'static str,
    /// Values, row by row from the bottom.
    pub values: Vec<f64>,
    /// For each value, the most by which a kernel's may differ from it.
    pub bound: Vec<f64>,
}

/// The reference map of a log. All vectors hold one entry a cell, row by row from the bottom.
#[derive(Debug, Clone, PartialEq)]
pub struct OracleMap {
    /// Where the cells are.
    pub grid: GridSpec,
    /// The method's layers, in its order, without `touched` and `class`.
    pub layers: Vec<OracleLayer>,
    /// Class by the method's decision rule: 1 occupied, 0 unknown, −1 empty.
    pub class: Vec<i8>,
    /// The decision lies within the bounds of its threshold: a kernel may rightly decide otherwise.
    pub ambiguous: Vec<bool>,
    /// Interior updates that a cell got.
    pub interior: Vec<u32>,
    /// Arc updates that a cell got.
    pub arc: Vec<u32>,
    /// Sums of marks of what each cell took; empty for methods without ([`crate::method::Method::marks`]).
    pub marks: Vec<u32>,
    /// What each cell's α gained, labels and then "free"; empty for methods without α.
    pub gains: Vec<Vec<f64>>,
    /// Cells that got an update.
    pub touched: u64,
    /// All (reading, cell) pairs with the cell in the interior or on the arc.
    pub updates: u64,
    /// Readings with no cell of the grid.
    pub outside: u64,
    /// Hits with interior cells but no arc cell.
    pub empty_arc: u64,
    /// Readings with a cell of the grid that reach beyond 1024 cells.
    pub wide: u64,
}

impl OracleMap {
    /// The layer of that name.
    pub fn layer(&self, name: &str) -> Option<&OracleLayer> {
        self.layers.iter().find(|l| l.name == name)
    }

    /// Whether a reading reached cell `k`.
    pub fn is_touched(&self, k: usize) -> bool {
        self.interior[k] + self.arc[k] > 0 || self.gains.get(k).is_some_and(|gains| csm::is_faint(gains))
    }
}

/// What a method hands back: its layers, the classes, the ambiguous cells.
struct Finished {
    layers: Vec<OracleLayer>,
    class: Vec<i8>,
    ambiguous: Vec<bool>,
}

/// Who reached which cell, counted while the readings pass.
struct Tally {
    interior: Vec<u32>,
    arc: Vec<u32>,
    updates: u64,
    outside: u64,
    empty_arc: u64,
    wide: u64,
}

impl Tally {
    fn new(cells: usize) -> Self {
        Tally { interior: vec![0; cells], arc: vec![0; cells], updates: 0, outside: 0, empty_arc: 0, wide: 0 }
    }

    /// Counts one reading's cells; `n` is its number of arc cells.
    fn add(&mut self, cone: &Cone, cells: &[Cell], n: usize) {
        for cell in cells {
            match cell.region {
                Region::Interior => self.interior[cell.index] += 1,
                Region::Arc => self.arc[cell.index] += 1,
            }
        }
        self.updates += cells.len() as u64;
        self.outside += u64::from(cells.is_empty());
        self.empty_arc += u64::from(cone.hit && n == 0 && !cells.is_empty());
        self.wide += u64::from(cone.wide && !cells.is_empty());
    }

    fn is_touched(&self, k: usize) -> bool {
        self.interior[k] + self.arc[k] > 0
    }
}

/// The map of `readings`, in their order, by the method of `settings`.
///
/// `wedges` is for [`Settings::Truth`] alone: for each reading the bearings of its wedge's edges in the world frame,
/// (left, right) in radians. Without it the truth is refused; the other methods ignore it.
pub fn map(
    grid: &GridSpec,
    sensors: &[Sensor],
    readings: &[Reading],
    settings: &Settings,
    wedges: Option<&[(f64, f64)]>,
) -> Result<OracleMap> {
    let cones = cones(grid, sensors, readings, settings, wedges)?;
    let mut tally = Tally::new(grid.cells());
    let finished = match settings {
        Settings::Certainty(s) => certainty::map(grid, &cones, s, &mut tally),
        Settings::DempsterShafer(s) => dempster_shafer::map(grid, &cones, s, &mut tally),
        Settings::Bayes(s) => bayes::map(grid, &cones, s, &mut tally),
        Settings::Himm(s) => himm::map(grid, &cones, s, &mut tally),
        Settings::Truth => truth::map(grid, &cones, &mut tally),
        Settings::Csm(_) => {
            return Err(Error::Usage("a counting sensor model takes scans: see map_scans".into()));
        }
        Settings::Features(_) => {
            return Err(Error::Usage("the feature-based grid takes updates: see map_updates".into()));
        }
    };
    Ok(assemble(grid, finished, tally, Vec::new()))
}

/// A method's map and who reached which cell; `marks`, where it has them.
fn assemble(grid: &GridSpec, finished: Finished, tally: Tally, marks: Vec<u32>) -> OracleMap {
    let touched = (0..grid.cells()).filter(|&k| tally.is_touched(k)).count() as u64;
    let Finished { layers, class, ambiguous } = finished;
    let Tally { interior, arc, updates, outside, empty_arc, wide } = tally;
    OracleMap {
        grid: *grid,
        layers,
        class,
        ambiguous,
        interior,
        arc,
        marks,
        gains: Vec::new(),
        touched,
        updates,
        outside,
        empty_arc,
        wide,
    }
}

/// The cells of the grid that one reading updates, by the method of `settings`. `wedge`: see [`map`].
pub fn cells_of(
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

/// A wedge counts for the laser truth alone.
fn wedge_of(settings: &Settings, wedge: Option<(f64, f64)>) -> Option<(f64, f64)> {
    wedge.filter(|_| *settings == Settings::Truth)
}
