//! The laser truth: hits and passes of the nearest beam of each laser scan; what a sonar map is scored against.
//!
//! Wedges are half-open, so a cell lies in one beam of a scan at most; all is integer, so every bound is 0.

use super::cone::Cone;
use super::{Finished, OracleLayer, Tally};
use crate::grid::GridSpec;

/// Known from so many hits and passes.
const KNOWN: u32 = 2;
/// Occupied from so many hits.
const HITS: u32 = 2;

/// 1 occupied, −1 empty, 0 unknown: occupied at 2 hits that are 30 % of all.
pub(super) fn decide(hits: u32, passes: u32) -> i8 {
    let all = u64::from(hits) + u64::from(passes);
    if all < u64::from(KNOWN) {
        0
    } else if hits >= HITS && 10 * u64::from(hits) >= 3 * all {
        1
    } else {
        -1
    }
}

/// Layers hits, passes and the classes.
pub(super) fn map(grid: &GridSpec, cones: &[Cone], tally: &mut Tally) -> Finished {
    let mut cells = Vec::new();
    for cone in cones {
        let n = cone.cells(grid, &mut cells);
        tally.add(cone, &cells, n);
    }
    let class = tally.arc.iter().zip(&tally.interior).map(|(&hits, &passes)| decide(hits, passes)).collect();
    let layer = |name, counts: &[u32]| OracleLayer {
        name,
        values: counts.iter().map(|&c| f64::from(c)).collect(),
        bound: vec![0.0; counts.len()],
    };
    let layers = vec![layer("hits", &tally.arc), layer("passes", &tally.interior)];
    Finished { layers, class, ambiguous: vec![false; grid.cells()] }
}
