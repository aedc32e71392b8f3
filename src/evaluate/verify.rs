//! Verification on a user's own log: each backend's map is compared with that of the f64 oracle, cell by cell.
//!
//! Membership must not differ in any cell. Every layer must keep within the bound that the oracle derives for each cell. A class may differ
//! only where the cell stands on a decision boundary within those bounds.

mod cell_readings;
mod report;
mod table;

pub use report::{BackendCheck, CellDifference, LayerCheck, ReadingRef, Verification};

use crate::Result;
use crate::grid::Data;
use crate::oracle::{OracleLayer, OracleMap};
use crate::pipeline::finished::FinishedMap;
use crate::pipeline::session::Session;
use cell_readings::CellReadings;

/// One run of a backend.
#[derive(Debug)]
pub struct BackendRun<'a> {
    /// cpu or gpu.
    pub name: &'a str,
    /// The adapter that it ran on.
    pub adapter: String,
    /// Its map.
    pub finished: &'a FinishedMap,
    /// Readings that it and the oracle counted differently.
    pub wrong_counts: u64,
    /// Seconds from the log to the map.
    pub seconds: f64,
}

/// Compares a backend's map with the oracle's.
///
/// # Errors
/// The log's, which is read again to name the readings of cells that differ.
pub fn check_backend(session: &Session, oracle: &OracleMap, run: BackendRun) -> Result<BackendCheck> {
    let locate = Locator { session, readings: CellReadings::of(session)? };
    let map = &run.finished.map;
    let differing = membership_differences(oracle, run.finished);
    let membership_cell = differing.first().map(|&k| {
        let updates = |interior: &[u32], arc: &[u32]| f64::from(interior[k]) + f64::from(arc[k]);
        let visits = &run.finished.visits;
        let values = [updates(&oracle.interior, &oracle.arc), updates(&visits.interior, &visits.arc)];
        locate.cell(k, values, 0.0)
    });
    let membership_cell = membership_cell.transpose()?;
    let mut layers = Vec::new();
    for reference in &oracle.layers {
        let data = map.layer(reference.name).map(|l| &l.data);
        layers.push(check_layer(&locate, reference, data)?);
    }
    let (class, class_wrong) = class_differences(oracle, map.layer("class").map(|l| &l.data));
    let within = layers.iter().all(|l| l.beyond == 0);
    Ok(BackendCheck {
        backend: run.name.into(),
        adapter: run.adapter,
        membership: differing.len() as u64,
        membership_cell,
        counts: run.wrong_counts,
        layers,
        class,
        class_wrong,
        updates: map.updates,
        seconds: run.seconds,
        passed: differing.is_empty() && run.wrong_counts == 0 && class_wrong == 0 && within,
    })
}

/// The cells that other readings reach than in the oracle's map.
fn membership_differences(oracle: &OracleMap, finished: &FinishedMap) -> Vec<usize> {
    let visits = &finished.visits;
    let differs = |k: &usize| {
        let marks = visits.marks.get(*k) != oracle.marks.get(*k);
        visits.interior[*k] != oracle.interior[*k] || visits.arc[*k] != oracle.arc[*k] || marks
    };
    (0..oracle.grid.cells()).filter(differs).collect()
}

/// Compares one layer; one that the backend lacks is beyond every bound.
fn check_layer(locate: &Locator, reference: &OracleLayer, data: Option<&Data>) -> Result<LayerCheck> {
    let value = |k: usize| data.map_or(f64::NAN, |d| d.get(k));
    // The largest difference, the largest ratio of a difference to its bound, and their cells.
    let (mut largest, mut nearest) = ((0.0, None), (0.0, None));
    let mut beyond = 0;
    for (k, (&expected, &bound)) in reference.values.iter().zip(&reference.bound).enumerate() {
        let difference = difference(expected, value(k));
        beyond += u64::from(difference > bound);
        if difference > largest.0 {
            largest = (difference, Some(k));
        }
        let ratio = if difference == 0.0 { 0.0 } else { difference / bound };
        if ratio > nearest.0 {
            nearest = (ratio, Some(k));
        }
    }
    let cell =
        |k: Option<usize>| k.map(|k| locate.cell(k, [reference.values[k], value(k)], reference.bound[k])).transpose();
    Ok(LayerCheck {
        layer: reference.name.into(),
        largest: largest.0,
        bound: largest.1.map_or(0.0, |k| reference.bound[k]),
        beyond,
        largest_cell: cell(largest.1)?,
        worst: cell(nearest.1)?,
    })
}

/// Cells whose class differs, and those of them that do not stand on a decision boundary.
fn class_differences(oracle: &OracleMap, classes: Option<&Data>) -> (u64, u64) {
    let (mut differing, mut wrong) = (0, 0);
    for (k, &reference) in oracle.class.iter().enumerate() {
        if classes.map_or(f64::NAN, |d| d.get(k)) != f64::from(reference) {
            differing += 1;
            wrong += u64::from(!oracle.ambiguous[k]);
        }
    }
    (differing, wrong)
}

/// Describes cells: their place, and the readings that reached them.
struct Locator<'a> {
    session: &'a Session,
    readings: CellReadings,
}

impl Locator<'_> {
    /// A cell with the oracle's value and the backend's.
    fn cell(&self, k: usize, [oracle, value]: [f64; 2], bound: f64) -> Result<CellDifference> {
        let grid = &self.session.grid;
        let (column, row) = (k % grid.width, k / grid.width);
        let (x, y) = grid.centre(column, row);
        let last_readings = self.readings.last(self.session, column, row)?;
        let difference = difference(oracle, value);
        Ok(CellDifference { column, row, x, y, oracle, value, difference, bound, last_readings })
    }
}

/// The absolute difference of two values; infinite where one is NaN, so that it is beyond every bound.
fn difference(a: f64, b: f64) -> f64 {
    let difference = (a - b).abs();
    if difference.is_nan() { f64::INFINITY } else { difference }
}

/// Whether two maps hold the same bytes.
pub fn same_bytes(a: &FinishedMap, b: &FinishedMap) -> bool {
    let same = |k: usize| {
        let (a, b) = (&a.map.layers[k].data, &b.map.layers[k].data);
        a.len() == b.len() && (0..a.len()).all(|k| a.get(k).to_bits() == b.get(k).to_bits())
    };
    a.map.layers.len() == b.map.layers.len() && (0..a.map.layers.len()).all(same) && a.visits == b.visits
}
