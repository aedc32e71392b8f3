//! The feature-based grid's parameters.

use super::{Key, key};
use crate::{Error, Result};

/// Feature-based occupancy grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Features {
    /// Murphy's Max_occ of the routine update: P(s|occupied) is at most this.
    pub max_occ: f64,
    /// A cell is occupied above this probability.
    pub p_occupied: f64,
    /// A cell is empty below this probability.
    pub p_empty: f64,
}

impl Default for Features {
    fn default() -> Self {
        Features { max_occ: 0.98, p_occupied: 0.6, p_empty: 0.4 }
    }
}

/// The keys of `--set`.
pub(super) const KEYS: &[Key] = &[
    key("max_occ", "0..1", "0.98", "largest P(s|occupied) on the arc of a routine update"),
    key("p_occupied", "0.5..1", "0.6", "a cell is occupied above this probability"),
    key("p_empty", "0..0.5", "0.4", "a cell is empty below this probability"),
];

impl Features {
    /// Sets one of its keys.
    pub(super) fn set(&mut self, key: &Key, value: &str) -> Result<()> {
        let name = key.name;
        let number = |low: f64, high: f64| {
            let parsed = value.parse::<f64>().ok().filter(|v| (low..=high).contains(v));
            parsed.ok_or_else(|| Error::Usage(format!("--set {name}={value}: {name} takes {}", key.values)))
        };
        match name {
            "max_occ" => self.max_occ = number(0.0, 1.0)?,
            "p_occupied" => self.p_occupied = number(0.5, 1.0)?,
            _ => self.p_empty = number(0.0, 0.5)?,
        }
        Ok(())
    }

    /// Their values as texts, in the order of the keys.
    pub(super) fn values(&self) -> Vec<String> {
        [self.max_occ, self.p_occupied, self.p_empty].iter().map(f64::to_string).collect()
    }
}
