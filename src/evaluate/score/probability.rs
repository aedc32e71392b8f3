//! The probabilities of occupied of a map, and measures of their quality.

use crate::grid::Map;
use serde::Serialize;

/// Bins of the expected calibration error.
const BINS: usize = 10;
/// The log loss clamps probabilities to this distance from 0 and 1: it would be infinite there.
const CLAMP: f64 = 1e-6;

/// Each cell's probability of occupied; 0.5 where no reading reached.
///
/// bayes: `p_occ`. certainty: (1 + `map`)/2. dempster-shafer: `full` + `unknown`/2. himm: `count`/15. truth:
/// `hits`/(`hits` + `passes`). Another map has only its classes: 1, 0.5, 0.
pub fn probabilities(map: &Map) -> Vec<f32> {
    let get = |name: &str| map.layer(name).map(|l| &l.data);
    let touched = get("touched");
    let two = |a, b| Some((get(a)?, get(b)?));
    let of: Box<dyn Fn(usize) -> f64> = if let Some(p) = get("p_occ") {
        Box::new(|k| p.get(k))
    } else if let Some((full, unknown)) = two("full", "unknown") {
        Box::new(|k| full.get(k) + unknown.get(k) / 2.0)
    } else if let (Some(_), Some(certainty)) = (get("occ"), get("map")) {
        Box::new(|k| (1.0 + certainty.get(k)) / 2.0)
    } else if let Some(count) = get("count") {
        Box::new(|k| count.get(k) / 15.0)
    } else if let Some((hits, passes)) = two("hits", "passes") {
        Box::new(|k| hits.get(k) / (hits.get(k) + passes.get(k)))
    } else if let Some(class) = get("class") {
        Box::new(|k| (1.0 + class.get(k)) / 2.0)
    } else {
        Box::new(|_| 0.5)
    };
    let value = |k: usize| match touched.is_none_or(|t| t.get(k) != 0.0) {
        true => Some(of(k)).filter(|p| !p.is_nan()).map_or(0.5, |p| p.clamp(0.0, 1.0)),
        false => 0.5,
    };
    (0..map.grid.cells()).map(|k| value(k) as f32).collect()
}

/// Measures of probabilities; `None` where there are no cells to measure.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Quality {
    /// Mean (p − y)², y = 1 for a truly occupied cell, 0 for an empty one.
    pub brier: Option<f64>,
    /// Mean −ln of the probability given to what is true, natural logarithm.
    pub log_loss: Option<f64>,
    /// Area under the ROC curve: how often an occupied cell has a higher probability than an empty one, ties counted half.
    pub auc: Option<f64>,
    /// Expected calibration error: |mean p − share occupied|, over ten equal bins of p, weighted by their cells.
    pub ece: Option<f64>,
}

impl Quality {
    /// The measures of cells, given by their probabilities and whether they are truly occupied.
    pub fn of(mut cells: Vec<(f32, bool)>) -> Quality {
        if cells.is_empty() {
            return Quality::default();
        }
        // Sorted by p, so that the sums do not depend on the cells' order.
        cells.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let n = cells.len() as f64;
        let (mut squares, mut loss) = (0.0, 0.0);
        let mut bins = [(0u64, 0.0, 0u64); BINS];
        for &(p, occupied) in &cells {
            let p = f64::from(p);
            let right = if occupied { p } else { 1.0 - p };
            squares += (1.0 - right).powi(2);
            loss -= right.clamp(CLAMP, 1.0 - CLAMP).ln();
            let bin = &mut bins[((p * BINS as f64) as usize).min(BINS - 1)];
            *bin = (bin.0 + 1, bin.1 + p, bin.2 + u64::from(occupied));
        }
        let calibration: f64 = bins.iter().map(|&(_, p, occupied)| (p - occupied as f64).abs()).sum();
        Quality { brier: Some(squares / n), log_loss: Some(loss / n), auc: auc(&cells), ece: Some(calibration / n) }
    }
}

/// Area under the ROC curve, of cells sorted by p.
fn auc(cells: &[(f32, bool)]) -> Option<f64> {
    let occupied = cells.iter().filter(|c| c.1).count() as f64;
    let empty = cells.len() as f64 - occupied;
    let (mut below, mut won) = (0.0, 0.0);
    for tied in cells.chunk_by(|a, b| a.0 == b.0) {
        let here = tied.iter().filter(|c| c.1).count() as f64;
        let others = tied.len() as f64 - here;
        won += here * (below + others / 2.0);
        below += others;
    }
    (occupied > 0.0 && empty > 0.0).then(|| won / (occupied * empty))
}
