//! A comparison as a table for people.

use super::{Comparison, Worst};
use std::fmt;

impl fmt::Display for Comparison {
    /// A table, a layer a line, and the verdict.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(grids) = &self.grids {
            writeln!(f, "grids differ: {grids}")?;
        }
        if !self.layers.is_empty() {
            writeln!(f, "{:<12} {:>12} {:>12}  worst cell", "layer", "cells differ", "largest")?;
        }
        for layer in &self.layers {
            write!(f, "{:<12} {:>12} {:>12.6e}", layer.name, layer.differ, layer.largest)?;
            if let Some(Worst { column, row, x, y, a, b }) = layer.worst {
                write!(f, "  ({column}, {row}) at {x:.3}, {y:.3} m: {a} and {b}")?;
            }
            if let Some([a, b]) = layer.types {
                write!(f, "  types {a} and {b}")?;
            }
            writeln!(f)?;
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
