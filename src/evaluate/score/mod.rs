//! Scores a map against a truth, cell by cell: how accurate it is, and how dangerous its errors are.
//!
//! Every cell gets an error [`level`] from 0 (right) to 9 (a wall shown as free, with nothing near it). The levels are summed to the zones
//! Z1 to Z5. Further numbers are the accuracy, recall and precision of walls, and the quality of the method's probabilities.
//! `docs/scores.md` defines each number.

mod cells;
mod chart;
mod levels;
mod numbers;
mod picture;
mod probability;
mod report;
mod require;
mod table;
mod truth;

pub use cells::ScoredCells;
pub use levels::{NOT_COMPARED, Zones, level};
pub use numbers::Numbers;
pub(crate) use picture::LEVELS;
pub use probability::{Quality, probabilities};
pub use report::write_report;
pub use require::{Check, Requirement};
pub use table::table;
pub use truth::{TrueCells, Truth, extended_box, open_map, open_map_with_notes, sensor_range};

use crate::Result;
use crate::grid::Map;
use serde::Serialize;

/// How to score.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Cells, in x and in y, by which an occupied cell may be displaced from a true one and still match it. 1: the eight neighbours.
    pub tolerance: usize,
    /// Thresholds of the probability, occupied above the first and empty below the second, in place of the method's decision rule.
    pub decide: Option<(f64, f64)>,
}

impl Default for Options {
    fn default() -> Self {
        Options { tolerance: 1, decide: None }
    }
}

/// One map's score.
#[derive(Debug, Clone, Serialize)]
pub struct Score {
    /// The map's name.
    pub path: String,
    /// Its method.
    pub method: String,
    /// The numbers over all compared cells.
    #[serde(flatten)]
    pub numbers: Numbers,
    /// The numbers over the world's bounding box and half a metre around it, where the truth is a world.
    pub near: Option<Numbers>,
    /// The compared cells.
    #[serde(skip)]
    pub cells: ScoredCells,
}

/// Scores one map. `path` is its name in the score.
///
/// # Errors
/// Those of [`Truth::on`] and [`ScoredCells::of`].
pub fn score(path: &str, map: &Map, truth: &Truth, options: &Options) -> Result<Score> {
    let truth = truth.on(&map.grid)?;
    let cells = ScoredCells::of(map, &truth, options)?;
    let numbers = Numbers::of(&cells, None);
    let near = truth.near.map(|near| Numbers::of(&cells, Some(near)));
    Ok(Score { path: path.into(), method: map.method.clone(), numbers, near, cells })
}
