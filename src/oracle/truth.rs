//! The laser truth, against which sonar maps are scored: hits and passes of the nearest beam of each laser scan.
//!
//! Wedges are half-open, so a cell lies in one beam of a scan at most; all is integer, so every bound is 0.

use super::cone::Cone;
use super::{MethodOutput, OracleLayer, UpdateCounts};
use crate::grid::GridSpec;

/// The least hits and passes of a known cell.
const KNOWN: u32 = 2;
/// The least hits of an occupied cell.
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

/// Maps the cones: layers hits and passes, and the classes.
pub(super) fn map(grid: &GridSpec, cones: &[Cone], counts: &mut UpdateCounts) -> MethodOutput {
    let mut cells = Vec::new();
    for cone in cones {
        let n = cone.cells(grid, &mut cells);
        counts.add(cone, &cells, n);
    }
    let class = counts.arc.iter().zip(&counts.interior).map(|(&hits, &passes)| decide(hits, passes)).collect();
    let layer = |name, counts: &[u32]| OracleLayer {
        name,
        values: counts.iter().map(|&c| f64::from(c)).collect(),
        bound: vec![0.0; counts.len()],
    };
    let layers = vec![layer("hits", &counts.arc), layer("passes", &counts.interior)];
    MethodOutput { layers, class, ambiguous: vec![false; grid.cells()] }
}
