//! The feature-based grid's parameters.

use crate::feature::Rules;
use crate::sensor::ParameterDoc;
use crate::{Error, Result};

/// Feature-based occupancy grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Features {
    /// How readings are associated, and when they are applied.
    pub rules: Rules,
    /// Murphy's Max_occ of the routine update: P(s|occupied) is at most this.
    pub max_occ: f64,
    /// A cell is occupied above this probability.
    pub p_occupied: f64,
    /// A cell is empty below this probability.
    pub p_empty: f64,
}

impl Default for Features {
    fn default() -> Self {
        Features { rules: Rules::default(), max_occ: 0.98, p_occupied: 0.6, p_empty: 0.4 }
    }
}

/// The keys of `--set`.
pub(super) const KEYS: &[ParameterDoc] = &[
    ParameterDoc::new(
        "rules",
        "ours|paper",
        "ours",
        "how readings are associated: ours, or those of the paper as they stand there",
    ),
    ParameterDoc::new("corners", "true|false", "true", "find concave corners"),
    ParameterDoc::new("points", "true|false", "true", "tell points from walls"),
    ParameterDoc::new("phantoms", "true|false", "true", "drop mirror images"),
    ParameterDoc::new("lines", "true|false", "true", "free nothing behind short lines between features' ends"),
    ParameterDoc::new(
        "wide",
        "true|false",
        "true",
        "safe lines join ends up to 90° off the axis, not in the cone alone",
    ),
    ParameterDoc::new("hold", "0..1000", "5", "metres of travel for which a reading is held"),
    ParameterDoc::new("max_occ", "0..1", "0.98", "largest P(s|occupied) on the arc of a routine update"),
    ParameterDoc::new("p_occupied", "0.5..1", "0.6", "a cell is occupied above this probability"),
    ParameterDoc::new("p_empty", "0..0.5", "0.4", "a cell is empty below this probability"),
];

impl Features {
    /// Sets one of its keys.
    pub(super) fn set(&mut self, key: &ParameterDoc, value: &str) -> Result<()> {
        let name = key.name;
        let wrong = || Error::Usage(format!("`{name}={value}`: {name} takes {}", key.values));
        let number =
            |low: f64, high: f64| value.parse::<f64>().ok().filter(|v| (low..=high).contains(v)).ok_or_else(wrong);
        let choice = |options: [&str; 2]| options.iter().position(|o| *o == value).map(|k| k == 1).ok_or_else(wrong);
        let rules = &mut self.rules;
        match name {
            "rules" => rules.paper = choice(["ours", "paper"])?,
            "corners" => rules.corners = choice(["false", "true"])?,
            "points" => rules.points = choice(["false", "true"])?,
            "phantoms" => rules.phantoms = choice(["false", "true"])?,
            "lines" => rules.lines = choice(["false", "true"])?,
            "wide" => rules.wide = choice(["false", "true"])?,
            "hold" => rules.hold = number(0.0, 1000.0)?,
            "max_occ" => self.max_occ = number(0.0, 1.0)?,
            "p_occupied" => self.p_occupied = number(0.5, 1.0)?,
            _ => self.p_empty = number(0.0, 0.5)?,
        }
        Ok(())
    }

    /// The values as text, in the order of the keys.
    pub(super) fn values(&self) -> Vec<String> {
        let Rules { paper, corners, points, phantoms, lines, wide, hold } = self.rules;
        let rules = if paper { "paper" } else { "ours" };
        let switches = [corners, points, phantoms, lines, wide].map(|v| v.to_string());
        let numbers = [hold, self.max_occ, self.p_occupied, self.p_empty].map(|v| v.to_string());
        std::iter::once(rules.to_string()).chain(switches).chain(numbers).collect()
    }
}
