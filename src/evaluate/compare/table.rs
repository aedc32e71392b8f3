//! A comparison as a text table.

use super::{Comparison, LargestDifference};
use crate::support::wrap::wrap;
use std::fmt;

impl fmt::Display for Comparison {
    /// A line for each layer, and the verdict.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(grids) = &self.grids {
            writeln!(f, "{}", wrap(&format!("grids differ: {grids}"), 2))?;
        }
        if !self.layers.is_empty() {
            writeln!(f, "{:<12} {:>12} {:>12}  worst cell", "layer", "cells differ", "largest")?;
        }
        for layer in &self.layers {
            let mut line = format!("{:<12} {:>12} {:>12}", layer.name, layer.differ, largest(layer.largest));
            if let Some(LargestDifference { column, row, x, y, a, b }) = layer.worst {
                let (a, b) = (short(a), short(b));
                line += &format!("  ({column}, {row}) at {x:.3}, {y:.3} m: {a} and {b}");
            }
            if let Some([a, b]) = layer.types {
                line += &format!("  types {a} and {b}");
            }
            writeln!(f, "{}", wrap(&line, 40))?;
        }
        for (names, which) in [(&self.only_a, "first"), (&self.only_b, "second")] {
            if !names.is_empty() {
                writeln!(f, "only in the {which} map: {}", names.join(", "))?;
            }
        }
        match (self.equal, self.tolerance) {
            (true, 0.0) => write!(f, "equal: {} cells, to the bit", self.cells),
            (true, t) => write!(f, "equal: {} cells, within {t}", self.cells),
            (false, _) if self.layers.is_empty() => write!(f, "different"),
            (false, _) => write!(
                f,
                "different: of {} cells {} touched by one map only, {} of another class",
                self.cells, self.touched, self.class
            ),
        }
    }
}

/// A difference with four digits; a whole number with all of its digits.
fn largest(difference: f64) -> String {
    let whole = difference.fract() == 0.0 && difference < 1e9;
    if whole { format!("{difference:.0}") } else { format!("{difference:.3e}") }
}

/// A value in its shortest digits: those of an f32 where it is one.
fn short(value: f64) -> String {
    let narrow = value as f32;
    if f64::from(narrow) == value { narrow.to_string() } else { value.to_string() }
}
