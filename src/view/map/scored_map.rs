//! A map scored against the truth: its score, the error levels of its cells, and the true classes.

use super::alignment::{GridAlignment, LabelGrid};
use crate::evaluate::score::{LEVELS, NOT_COMPARED, Options, Truth, score};
use crate::grid::Palette;
use crate::output::{Stored, read_map};
use crate::world::Shipped;
use crate::{Error, Result};
use serde_json::{Value, json};
use std::path::Path;

/// Bytes of a cell beside the layers: what is compared, and the probabilities while they are counted.
const CELL_BYTES: u64 = 40;

/// The meaning of each error level.
const MEANINGS: [&str; 10] = [
    "0 right (Z1)",
    "1 occupied beside a true wall (Z1)",
    "2 wall left unknown, occupied beside it (Z3)",
    "3 free left unknown (Z3)",
    "4 wall left unknown (Z3)",
    "5 occupied where nothing is known (Z4)",
    "6 occupied where it is free (Z4)",
    "7 empty where nothing is known (Z5, danger)",
    "8 wall shown empty, occupied beside it (Z5, danger)",
    "9 wall shown empty (Z5, danger)",
];

/// The score of a map against a truth.
pub(super) struct ScoredMap {
    /// The truth's name.
    pub name: String,
    /// Each cell's label, 10 minus its error level, so that a reduction keeps the most dangerous; 0: not compared.
    pub levels: LabelGrid,
    /// True classes: 1, −1; 0 unknown.
    pub truth: LabelGrid,
    /// The score as JSON, as `echogrid score --json` gives it.
    pub score: Value,
    /// Notes on the truth for the user.
    pub notes: Vec<String>,
}

impl ScoredMap {
    /// Scores a map as `echogrid score` does. It reads the whole map, and checks first that it fits in memory.
    pub fn of(stored: &Stored, name: &str, truth: &Path, cap: Option<u64>) -> Result<ScoredMap> {
        let other = if truth.is_dir() && Shipped::named(truth).is_none() { Stored::open(truth)?.bytes() } else { 0 };
        let needed = stored.bytes() + other + CELL_BYTES * stored.grid.cells() as u64;
        let remedy = "look at it without --truth, or map it with smaller --bounds or a coarser --resolution";
        stored.grid.check_memory(needed, cap, remedy)?;
        let mut notes = Vec::new();
        let opened = Truth::open_with_notes(truth, None, &mut |what| notes.push(what))?;
        let map = read_map(&stored.path)?.map;
        let score = score(name, &map, &opened, &Options::default()).map_err(|e| match e {
            Error::Usage(what) => Error::Usage(format!("{name}: {what}")),
            other => other,
        })?;
        let mut numbers = serde_json::to_value(&score).unwrap_or_default();
        numbers["truth"] = json!({"path": truth.display().to_string(), "kind": opened.kind(), "r_max": opened.r_max()});
        let cells = score.cells;
        let alignment = GridAlignment::of(&stored.grid, &cells.grid, "the truth")?;
        let label = |level: u8| if level == NOT_COMPARED { 0 } else { 10 - level as i8 };
        Ok(ScoredMap {
            name: super::name_of(truth),
            levels: LabelGrid { alignment, values: cells.levels.into_iter().map(label).collect() },
            truth: LabelGrid { alignment, values: cells.actual },
            score: numbers,
            notes,
        })
    }

    /// A cell's error level.
    pub fn level(&self, cell: [usize; 2]) -> Option<i8> {
        Some(self.levels.at(cell)).filter(|label| *label > 0).map(|label| 10 - label)
    }
}

/// The levels' colours, by label.
pub(super) fn palette() -> Palette {
    let mut colours = LEVELS;
    colours.reverse();
    Palette::of(&colours).unwrap_or(Palette::plain())
}

/// The levels' names and colours, from right to most dangerous.
pub(super) fn legend() -> impl Iterator<Item = (String, [u8; 3])> {
    MEANINGS.iter().map(|m| m.to_string()).zip(LEVELS)
}
