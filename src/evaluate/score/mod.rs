//! How right a map is, and how dangerous: every cell against a true map.
//!
//! An error [`level`] from 0 (right) to 9 (a wall shown as free, with nothing near it) for every cell, summed to the zones
//! Z1 to Z5; what share of the cells is right, of the walls found, of the walls freed; and how good the method's
//! probabilities are. `docs/scores.md` says what each number means.

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

pub use cells::Cells;
pub use levels::{NOT_COMPARED, Zones, level};
pub use numbers::Numbers;
pub(crate) use picture::LEVELS;
pub use probability::{Quality, probabilities};
pub use report::write_report;
pub use require::{Check, Requirement};
pub use table::table;
pub use truth::{TrueCells, Truth, open_map, open_map_noting, reach, wider};

use crate::Result;
use crate::grid::Map;
use serde::Serialize;

/// How to score.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Cells, in x and in y, by which an occupied cell may lie beside a true one and still match it. 1: the eight
    /// neighbours.
    pub tolerance: usize,
    /// Decide each scored cell by its probability, occupied above the first, empty below the second, in place of the
    /// method's own rule.
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
    /// The map, as it was named.
    pub path: String,
    /// Its method.
    pub method: String,
    /// Over all cells compared.
    #[serde(flatten)]
    pub numbers: Numbers,
    /// The same over the world's bounding box and half a metre around it, where the truth is a world.
    pub near: Option<Numbers>,
    /// The cells themselves, for pictures.
    #[serde(skip)]
    pub cells: Cells,
}

/// Scores one map. `path` is what the score calls it.
pub fn score(path: &str, map: &Map, truth: &Truth, options: &Options) -> Result<Score> {
    let truth = truth.on(&map.grid)?;
    let cells = Cells::of(map, &truth, options)?;
    let numbers = Numbers::of(&cells, None);
    let near = truth.near.map(|near| Numbers::of(&cells, Some(near)));
    Ok(Score { path: path.into(), method: map.method.clone(), numbers, near, cells })
}
