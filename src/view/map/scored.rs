//! A map held against the truth: its score, its cells' error levels, the true classes.

use super::plane::{Laid, Plane};
use crate::evaluate::score::{LEVELS, NOT_COMPARED, Options, Truth, score};
use crate::grid::Palette;
use crate::output::{Stored, read_map};
use crate::world::Shipped;
use crate::{Error, Result};
use serde_json::{Value, json};
use std::path::Path;

/// Bytes a cell beside the layers: what is compared, and its probabilities while they are counted.
const CELL: u64 = 40;

/// What each level means.
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

/// What a comparison with the truth leaves.
pub(super) struct Scored {
    /// The truth, as it is called.
    pub name: String,
    /// Of each cell its label: 10 less its level, so that the most dangerous is the strongest; 0: not compared.
    pub levels: Plane,
    /// True classes: 1, −1; 0 unknown.
    pub truth: Plane,
    /// The numbers, as `echogrid score --json` gives them.
    pub numbers: Value,
    /// What a user should know of the truth.
    pub notes: Vec<String>,
}

impl Scored {
    /// Scores a map as `echogrid score` does. All of it is read: that it fits in memory is checked first.
    pub fn of(stored: &Stored, name: &str, truth: &Path, cap: Option<u64>) -> Result<Scored> {
        let other = if truth.is_dir() && Shipped::named(truth).is_none() { Stored::open(truth)?.bytes() } else { 0 };
        let needed = stored.bytes() + other + CELL * stored.grid.cells() as u64;
        let remedy = "look at it without --truth, or map it with smaller --bounds or a coarser --resolution";
        stored.grid.check_memory(needed, cap, remedy)?;
        let mut notes = Vec::new();
        let opened = Truth::open_noting(truth, None, &mut |what| notes.push(what))?;
        let map = read_map(&stored.path)?.map;
        let score = score(name, &map, &opened, &Options::default()).map_err(|e| match e {
            Error::Usage(what) => Error::Usage(format!("{name}: {what}")),
            other => other,
        })?;
        let mut numbers = serde_json::to_value(&score).unwrap_or_default();
        numbers["truth"] = json!({"path": truth.display().to_string(), "kind": opened.kind(), "r_max": opened.r_max()});
        let cells = score.cells;
        let laid = Laid::of(&stored.grid, &cells.grid, "the truth")?;
        let label = |level: u8| if level == NOT_COMPARED { 0 } else { 10 - level as i8 };
        Ok(Scored {
            name: super::name_of(truth),
            levels: Plane { laid, values: cells.levels.into_iter().map(label).collect() },
            truth: Plane { laid, values: cells.actual },
            numbers,
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
