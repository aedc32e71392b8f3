//! Everything that is counted over a set of cells.

use super::Cells;
use super::levels::{NOT_COMPARED, Zones};
use super::probability::Quality;
use serde::Serialize;

/// A map's numbers over one set of cells. A share of nothing is none, `null` in JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Numbers {
    /// Cells compared.
    pub cells: u64,
    /// Of these, cells that both know: occupied or empty in the truth and in the map.
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
    /// Truly occupied cells with an occupied one within the tolerance ÷ all of them.
    pub recall_tolerant: Option<f64>,
    /// Occupied cells with a truly occupied one within the tolerance ÷ all of them.
    pub precision_tolerant: Option<f64>,
    /// Harmonic mean of the two.
    pub f1_tolerant: Option<f64>,
    /// Truly occupied cells that the map shows occupied ÷ all of them.
    pub recall: Option<f64>,
    /// Occupied cells that truly are ÷ all of them.
    pub precision: Option<f64>,
    /// Harmonic mean of the two.
    pub f1: Option<f64>,
    /// Cells occupied in both ÷ cells occupied in either.
    pub iou: Option<f64>,
    /// The same with the tolerance: 1/(1/P + 1/R − 1) of the tolerant precision and recall.
    pub iou_tolerant: Option<f64>,
    /// Over the cells that the truth knows.
    #[serde(flatten)]
    pub quality: Quality,
}

impl Numbers {
    /// Counts over the compared cells, or over those of them whose centre lies in a box x0, y0, x1, y1, metres.
    pub fn of(cells: &Cells, within: Option<[f64; 4]>) -> Numbers {
        let width = cells.grid.width;
        let inside = |k: usize| {
            let Some([x0, y0, x1, y1]) = within else { return true };
            let (x, y) = cells.grid.centre(k % width, k / width);
            let hair = 1e-6 * cells.grid.resolution;
            x >= x0 - hair && x <= x1 + hair && y >= y0 - hair && y <= y1 + hair
        };
        let mut levels = [0u64; 10];
        let (mut known, mut equal, mut unknown) = (0u64, 0u64, 0u64);
        let (mut occupied, mut shown, mut both, mut freed) = (0u64, 0u64, 0u64, 0u64);
        let (mut found, mut confirmed) = (0u64, 0u64);
        let mut chances = Vec::new();
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
                found += u64::from(cells.found_near(k));
            }
            if obtained > 0 {
                shown += 1;
                confirmed += u64::from(cells.truly_near(k));
            }
            if actual != 0 {
                chances.push((cells.probability[k], actual > 0));
            }
        }
        let compared = levels.iter().sum();
        let (recall, precision) = (share(both, occupied), share(both, shown));
        let (recall_tolerant, precision_tolerant) = (share(found, occupied), share(confirmed, shown));
        Numbers {
            cells: compared,
            known,
            levels,
            zones: Zones::of(&levels),
            occupied,
            occupied_found: both,
            o_to_e: freed,
            danger: share(freed, freed + both),
            freed: share(freed, occupied),
            accuracy: share(equal, known),
            unknown: share(unknown, known + unknown),
            recall_tolerant,
            precision_tolerant,
            f1_tolerant: harmonic(recall_tolerant, precision_tolerant),
            recall,
            precision,
            f1: harmonic(recall, precision),
            iou: share(both, occupied + shown - both),
            iou_tolerant: harmonic(recall_tolerant, precision_tolerant).map(|f1| f1 / (2.0 - f1)),
            quality: Quality::of(chances),
        }
    }
}

fn share(part: u64, all: u64) -> Option<f64> {
    (all > 0).then(|| part as f64 / all as f64)
}

fn harmonic(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let (a, b) = a.zip(b)?;
    Some(if a + b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 })
}
