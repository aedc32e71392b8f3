//! The numbers of a score over a set of cells.

use super::ScoredCells;
use super::levels::{NOT_COMPARED, Zones};
use super::probability::Quality;
use serde::Serialize;

/// A map's numbers over one set of cells. A ratio over no cells is `None`, `null` in JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Numbers {
    /// Cells compared.
    pub cells: u64,
    /// Cells that are occupied or empty both in the truth and in the map.
    pub known: u64,
    /// Cells of each error level.
    pub levels: [u64; 10],
    /// Cells of each zone.
    pub zones: Zones,
    /// Truly occupied cells compared.
    pub occupied: u64,
    /// Truly occupied cells that the map shows occupied.
    pub occupied_found: u64,
    /// Truly occupied cells that the map shows empty.
    pub o_to_e: u64,
    /// `o_to_e` ÷ truly occupied cells that both know.
    pub danger: Option<f64>,
    /// `o_to_e` ÷ all truly occupied cells compared, those that the map leaves unknown among them.
    pub freed: Option<f64>,
    /// Equal class ÷ cells that both know.
    pub accuracy: Option<f64>,
    /// Cells that the truth knows and the map leaves unknown ÷ cells that the truth knows.
    pub unknown: Option<f64>,
    /// Truly occupied cells with a cell shown occupied within the tolerance ÷ all truly occupied cells.
    pub recall_tolerant: Option<f64>,
    /// Cells shown occupied with a truly occupied one within the tolerance ÷ all cells shown occupied.
    pub precision_tolerant: Option<f64>,
    /// Harmonic mean of the two.
    pub f1_tolerant: Option<f64>,
    /// Truly occupied cells that the map shows occupied ÷ all truly occupied cells.
    pub recall: Option<f64>,
    /// Cells shown occupied that truly are ÷ all cells shown occupied.
    pub precision: Option<f64>,
    /// Harmonic mean of the two.
    pub f1: Option<f64>,
    /// Cells occupied in both ÷ cells occupied in either.
    pub iou: Option<f64>,
    /// The IoU with the tolerance: 1/(1/P + 1/R − 1) of the tolerant precision P and recall R.
    pub iou_tolerant: Option<f64>,
    /// The quality of the probabilities, over the cells that the truth knows.
    #[serde(flatten)]
    pub quality: Quality,
}

impl Numbers {
    /// The numbers over the compared cells, or over those whose centre lies in a box x0, y0, x1, y1, metres.
    pub fn of(cells: &ScoredCells, within: Option<[f64; 4]>) -> Numbers {
        let width = cells.grid.width;
        let inside = |k: usize| {
            let Some([x0, y0, x1, y1]) = within else { return true };
            let (x, y) = cells.grid.centre(k % width, k / width);
            let margin = 1e-6 * cells.grid.resolution;
            x >= x0 - margin && x <= x1 + margin && y >= y0 - margin && y <= y1 + margin
        };
        let mut levels = [0u64; 10];
        let (mut known, mut equal, mut unknown) = (0u64, 0u64, 0u64);
        let (mut occupied, mut shown, mut both, mut freed) = (0u64, 0u64, 0u64, 0u64);
        let (mut found, mut confirmed) = (0u64, 0u64);
        let mut probabilities = Vec::new();
        for k in (0..cells.levels.len()).filter(|&k| cells.levels[k] != NOT_COMPARED && inside(k)) {
            let (actual, obtained) = (cells.actual[k], cells.obtained[k]);
            levels[usize::from(cells.levels[k])] += 1;
            known += u64::from(actual != 0 && obtained != 0);
            equal += u64::from(actual != 0 && obtained == actual);
            unknown += u64::from(actual != 0 && obtained == 0);
            freed += u64::from(actual > 0 && obtained < 0);
            both += u64::from(actual > 0 && obtained > 0);
            if actual > 0 {
                occupied += 1;
                found += u64::from(cells.is_near_shown_wall(k));
            }
            if obtained > 0 {
                shown += 1;
                confirmed += u64::from(cells.is_near_true_wall(k));
            }
            if actual != 0 {
                probabilities.push((cells.probability[k], actual > 0));
            }
        }
        let compared = levels.iter().sum();
        let (recall, precision) = (ratio(both, occupied), ratio(both, shown));
        let (recall_tolerant, precision_tolerant) = (ratio(found, occupied), ratio(confirmed, shown));
        Numbers {
            cells: compared,
            known,
            levels,
            zones: Zones::of(&levels),
            occupied,
            occupied_found: both,
            o_to_e: freed,
            danger: ratio(freed, freed + both),
            freed: ratio(freed, occupied),
            accuracy: ratio(equal, known),
            unknown: ratio(unknown, known + unknown),
            recall_tolerant,
            precision_tolerant,
            f1_tolerant: harmonic(recall_tolerant, precision_tolerant),
            recall,
            precision,
            f1: harmonic(recall, precision),
            iou: ratio(both, occupied + shown - both),
            iou_tolerant: harmonic(recall_tolerant, precision_tolerant).map(|f1| f1 / (2.0 - f1)),
            quality: Quality::of(probabilities),
        }
    }
}

fn ratio(part: u64, all: u64) -> Option<f64> {
    (all > 0).then(|| part as f64 / all as f64)
}

/// The harmonic mean of two ratios.
fn harmonic(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let (a, b) = a.zip(b)?;
    Some(if a + b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 })
}
