//! Bayes (Elfes; Murphy 2000, expressions 11.1 to 11.6): log odds of occupied, 0 at the start.

use super::bound::{BoundedValue, U, angle_fraction, range_fraction};
use super::cone::Cone;
use super::{MethodOutput, OracleLayer, Region, UpdateCounts};
use crate::grid::GridSpec;
use crate::method::settings::{Bayes, Likelihood};

/// P(s|·) is clamped to this..=1 − this: no later evidence could change a probability of 0 or 1.
const CLAMP: f64 = 0.02;
/// Relative roundings of an update in a kernel's two products: 1 − p, and a product each.
const ROUNDINGS: f64 = 3.0;

/// Murphy's expressions 11.1 and 11.2: ½[(R − d)/R + (β − |θ|)/β]·`most`, d within 0..R, β − |θ| ≥ 0; R is the sensor's
/// largest range.
pub(super) fn murphy_expression(cone: &Cone, (d, theta): (f64, f64), most: f64) -> BoundedValue {
    let (range, angle) = (range_fraction(cone, d), angle_fraction(theta, cone.beta));
    BoundedValue {
        value: 0.5 * ((1.0 - range.value) + (1.0 - angle.value)) * most,
        bound: 0.5 * (range.bound + angle.bound) * most + 6.0 * U,
    }
}

/// P(s|occupied) of a cell, with a kernel's bound.
pub(super) fn likelihood(settings: &Bayes, cone: &Cone, region: Region, polar: (f64, f64)) -> BoundedValue {
    if settings.likelihood() == Likelihood::Constant {
        let value = if region == Region::Arc { settings.p_hit } else { settings.p_miss };
        return BoundedValue { value: value.clamp(CLAMP, 1.0 - CLAMP), bound: 0.0 };
    }
    let (most, floor) = match region {
        Region::Arc => (settings.max_occ, settings.region_one_floor),
        Region::Interior => (1.0, settings.region_two_floor),
    };
    let raw = murphy_expression(cone, polar, most);
    let kept = |p: f64| p.max(floor).clamp(CLAMP, 1.0 - CLAMP);
    let p = kept(raw.value);
    let (low, high) = (kept(raw.value - raw.bound), kept(raw.value + raw.bound));
    // a floor or clamp reaches the kernel as the nearest f32
    let rounded = if low < high || f64::from(p as f32) != p { U * p } else { 0.0 };
    let bound = (high - p).max(p - low) + rounded;
    BoundedValue { value: if region == Region::Arc { p } else { 1.0 - p }, bound }
}

/// ln(p/(1 − p)) and its bound.
fn logit(settings: &Bayes, p: BoundedValue) -> BoundedValue {
    let value = p.value.ln() - (1.0 - p.value).ln();
    if settings.likelihood() == Likelihood::Constant {
        // counted exactly, multiplied on the host in f64
        return BoundedValue { value, bound: 0.0 };
    }
    if p.value == 0.5 && p.bound == 0.0 {
        return BoundedValue { value: 0.0, bound: 0.0 };
    }
    let steepest = |x: f64| 1.0 / (x * (1.0 - x));
    let slope = steepest(p.value - p.bound).max(steepest(p.value + p.bound));
    BoundedValue { value, bound: p.bound * slope + (ROUNDINGS + 0.01) * U }
}

/// P(H|s_n), the probability after one more reading, from that before: the recursion 11.6.
#[cfg(test)]
pub(super) fn recursion(before: f64, given_occupied: f64) -> f64 {
    let occupied = given_occupied * before;
    occupied / (occupied + (1.0 - given_occupied) * (1.0 - before))
}

/// The log odds of each cell so far, and the bound of a kernel's error in them.
pub(super) struct LogOdds {
    odds: Vec<f64>,
    error: Vec<f64>,
}

impl LogOdds {
    pub fn new(cells: usize) -> LogOdds {
        LogOdds { odds: vec![0.0; cells], error: vec![0.0; cells] }
    }

    /// Adds the evidence of one more P(occupied) to a cell.
    pub fn add(&mut self, settings: &Bayes, index: usize, p: BoundedValue) {
        let add = logit(settings, p);
        if add.value == 0.0 && add.bound == 0.0 {
            return;
        }
        let sum = self.odds[index] + add.value;
        // a kernel's products round relatively, however large the odds; this sum rounds too
        self.error[index] += add.bound + 1e-15 * (1.0 + sum.abs());
        self.odds[index] = sum;
    }

    /// The layers log_odds, p_occ and p_emp, and the classes.
    pub fn finish(self, settings: &Bayes, counts: &UpdateCounts) -> MethodOutput {
        let LogOdds { odds, error } = self;
        let count = odds.len();
        let p_occ: Vec<f64> = odds.iter().map(|l| 1.0 / (1.0 + (-l).exp())).collect();
        let p_emp = odds.iter().map(|l| 1.0 / (1.0 + l.exp())).collect();
        let p_bound: Vec<f64> = error.iter().map(|e| 0.25 * e + 2.0 * U).collect();
        let (mut class, mut ambiguous) = (vec![0; count], vec![false; count]);
        for k in (0..count).filter(|&k| counts.is_touched(k)) {
            let p = p_occ[k];
            class[k] = i8::from(p > settings.p_occupied) - i8::from(p < settings.p_empty);
            let near = |threshold: f64| (p - threshold).abs() <= p_bound[k];
            ambiguous[k] = near(settings.p_occupied) || near(settings.p_empty);
        }
        let odds_bound = error.iter().zip(&odds).map(|(e, l)| e + U * l.abs()).collect();
        let layer = |name, values, bound| OracleLayer { name, values, bound };
        let layers = vec![
            layer("log_odds", odds, odds_bound),
            layer("p_occ", p_occ, p_bound.clone()),
            layer("p_emp", p_emp, p_bound),
        ];
        MethodOutput { layers, class, ambiguous }
    }
}

/// Maps the cones, in their order.
pub(super) fn map(grid: &GridSpec, cones: &[Cone], settings: &Bayes, counts: &mut UpdateCounts) -> MethodOutput {
    let (mut odds, mut cells) = (LogOdds::new(grid.cells()), Vec::new());
    for cone in cones {
        let n = cone.cells(grid, &mut cells);
        counts.add(cone, &cells, n);
        for cell in &cells {
            odds.add(settings, cell.index, likelihood(settings, cone, cell.region, cone.polar(cell.v)));
        }
    }
    odds.finish(settings, counts)
}
