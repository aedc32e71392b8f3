//! Certainty grid (Moravec & Elfes 1985): evidence of empty and of occupied, each enhanced by probabilistic addition.
//!
//! The kernels keep Q = 1 − Emp and S = 1 − Occ as products, free of cancellation; the reference keeps the literal
//! recursion, whose saturation at exactly 1 is part of its result. An interval (`interval`) encloses what a kernel may hold; a
//! value's bound is its distance from the farther end of that interval.

mod interval;

use super::bound::{U, angle_fraction, arc_offset, interior_fraction};
use super::cone::{Cell, Cone};
use super::{MethodOutput, OracleLayer, Region, UpdateCounts};
use crate::grid::GridSpec;
use crate::method::settings::{Certainty, Order};
use interval::{Interval, factor_bound, interval_around, profile_bound};

/// Emp_k, evidence of empty in the interior: [1 − ((d − r_min)/(R − ε − r_min))²]·[1 − (θ/β)²]. Metres, radians.
pub(super) fn emp_k(d: f64, theta: f64, span: f64, r_min: f64, beta: f64) -> f64 {
    let p = if d <= r_min || span <= 0.0 { 0.0 } else { (d - r_min) / span };
    (1.0 - p * p) * angular(theta, beta)
}

/// Occ_k, evidence of occupied on the arc: [1 − ((d − R)/ε)²]·[1 − (θ/β)²], not below 0. Metres, radians.
pub(super) fn occ_k(d: f64, theta: f64, range: f64, epsilon: f64, beta: f64) -> f64 {
    let z = if epsilon > 0.0 { (d - range) / epsilon } else { 0.0 };
    (1.0 - z * z).max(0.0) * angular(theta, beta)
}

/// 1 − (θ/β)², not below 0.
fn angular(theta: f64, beta: f64) -> f64 {
    let t = if beta > 0.0 { theta / beta } else { 0.0 };
    (1.0 - t * t).max(0.0)
}

/// Probabilistic addition: x ← x + (y − xy), so bracketed: where it saturates, the bracket is part of the result.
pub(super) fn enhance(x: f64, y: f64) -> f64 {
    x + (y - x * y)
}

/// The state of a map, one entry a cell: Emp and Occ by the literal recursion, and the intervals of a kernel's Q and S.
pub(super) struct State {
    pub emp: Vec<f64>,
    pub occ: Vec<f64>,
    q: Vec<Interval>,
    s: Vec<Interval>,
}

/// The evidence of one reading for one arc cell: cancelled by Emp, then normalised over the arc.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArcEvidence {
    pub index: usize,
    cancelled: f64,
    normalised: f64,
    /// The interval of a kernel's cancelled evidence; after normalising, of its normalised evidence.
    kernel: Interval,
}

impl State {
    /// The state before the first reading: Emp = Occ = 0, Q = S = 1.
    pub fn new(cells: usize) -> Self {
        let one = || vec![Interval { low: 1.0, high: 1.0 }; cells];
        State { emp: vec![0.0; cells], occ: vec![0.0; cells], q: one(), s: one() }
    }

    /// Step (a): adds the evidence of empty in the interior of one reading. A kernel computes Q ← Q·(1 − Emp_k), near 0 in whole
    /// units of 2⁻⁵³, as f64 does.
    pub fn free(&mut self, cone: &Cone, cells: &[Cell]) {
        for cell in cells.iter().filter(|c| c.region == Region::Interior) {
            let (d, theta) = cone.polar(cell.v);
            let evidence = emp_k(d, theta, cone.span, cone.r_min, cone.beta);
            let error = factor_bound(interior_fraction(cone, d), angle_fraction(theta, cone.beta));
            let factor = interval_around(1.0 - evidence, error + 1e-15, 1.0 + 4.0 * U);
            self.q[cell.index] = self.q[cell.index].enhanced(factor, 1.0);
            self.emp[cell.index] = enhance(self.emp[cell.index], evidence);
        }
    }

    /// Step (b), first half: writes the cancelled and normalised evidence of each arc cell of one reading to `arc`; returns the
    /// sum of the cancelled evidence.
    pub fn weigh(&self, cone: &Cone, cells: &[Cell], arc: &mut Vec<ArcEvidence>) -> f64 {
        arc.clear();
        for cell in cells.iter().filter(|c| c.region == Region::Arc) {
            let (d, theta) = cone.polar(cell.v);
            let own = occ_k(d, theta, cone.range, cone.epsilon, cone.beta);
            let error = profile_bound(arc_offset(cone, d), angle_fraction(theta, cone.beta));
            let kernel = self.q[cell.index].times(interval_around(own, error, 1.0 + 4.0 * U), 1.0);
            let cancelled = own * (1.0 - self.emp[cell.index]);
            arc.push(ArcEvidence { index: cell.index, cancelled, normalised: 0.0, kernel });
        }
        let sum: f64 = arc.iter().map(|a| a.cancelled).sum();
        let low: f64 = arc.iter().map(|a| a.kernel.low).sum();
        let high: f64 = arc.iter().map(|a| a.kernel.high).sum();
        // n terms, none negative, added in any order: n − 1 roundings; the division 5
        let slack = (arc.iter().filter(|a| a.kernel.high > 0.0).count() as f64 + 5.0) * U;
        for a in arc.iter_mut() {
            a.normalised = if sum > 0.0 { a.cancelled / sum } else { 0.0 };
            // v/(v + the others) grows with v
            let (others_high, others_low) = ((high - a.kernel.high).max(0.0), (low - a.kernel.low).max(0.0));
            let share = |v: f64, others: f64| if v > 0.0 { v / (v + others) } else { 0.0 };
            a.kernel = Interval {
                low: share(a.kernel.low, others_high) * (1.0 - slack),
                high: (share(a.kernel.high, others_low) * (1.0 + slack)).min(1.0),
            };
        }
        sum
    }

    /// Step (b), second half: enhances Occ by the normalised evidence w. A kernel computes S ← S·(1 − w).
    pub fn occupy(&mut self, arc: &[ArcEvidence]) {
        for a in arc {
            let rest = Interval { low: 1.0 - a.kernel.high, high: 1.0 - a.kernel.low };
            self.s[a.index] = self.s[a.index].enhanced(rest, 2.0);
            self.occ[a.index] = enhance(self.occ[a.index], a.normalised);
        }
    }
}

/// The state after all readings.
pub(super) fn run(grid: &GridSpec, cones: &[Cone], settings: &Certainty, counts: &mut UpdateCounts) -> State {
    let mut state = State::new(grid.cells());
    let (mut cells, mut arc) = (Vec::new(), Vec::new());
    for cone in cones {
        let n = cone.cells(grid, &mut cells);
        counts.add(cone, &cells, n);
        state.free(cone, &cells);
        if settings.order == Order::Sequential {
            state.weigh(cone, &cells, &mut arc);
            state.occupy(&arc);
        }
    }
    if settings.order == Order::Batch {
        for cone in cones.iter().filter(|c| c.hit) {
            cone.cells(grid, &mut cells);
            state.weigh(cone, &cells, &mut arc);
            state.occupy(&arc);
        }
    }
    state
}

/// Maps the cones, in their order: layers emp, occ and map, and the classes.
pub(super) fn map(grid: &GridSpec, cones: &[Cone], settings: &Certainty, counts: &mut UpdateCounts) -> MethodOutput {
    let State { emp, occ, q, s } = run(grid, cones, settings, counts);
    let count = grid.cells();
    let zero = || vec![0.0; count];
    let (mut values, mut bound, mut emp_bound, mut occ_bound) = (zero(), zero(), zero(), zero());
    let (mut class, mut ambiguous) = (vec![0; count], vec![false; count]);
    for k in (0..count).filter(|&k| counts.is_touched(k)) {
        // 1 − Q and 1 − S as layers of f32: rounded, and stored
        emp_bound[k] = q[k].max_error_of_complement(emp[k]) + 2.0 * U;
        occ_bound[k] = s[k].max_error_of_complement(occ[k]) + 2.0 * U;
        class[k] = if occ[k] >= emp[k] && occ[k] > 0.0 { 1 } else { -i8::from(emp[k] > occ[k]) };
        values[k] = if occ[k] >= emp[k] { occ[k] } else { -emp[k] };
        // a kernel decides on S ≤ Q and S < 1, not on the rounded layers
        let may_occupy = s[k].low <= q[k].high && s[k].low < 1.0;
        let may_free = q[k].low < s[k].high;
        let may_neither = s[k].high >= 1.0 && q[k].high >= 1.0;
        ambiguous[k] = match class[k] {
            1 => may_free || may_neither,
            0 => may_free || may_occupy,
            _ => may_occupy || may_neither,
        };
        bound[k] = match class[k] {
            _ if ambiguous[k] => occ[k] + emp[k] + emp_bound[k].max(occ_bound[k]),
            1 => occ_bound[k],
            _ => emp_bound[k],
        };
    }
    let layer = |name, values, bound| OracleLayer { name, values, bound };
    let layers = vec![layer("emp", emp, emp_bound), layer("occ", occ, occ_bound), layer("map", values, bound)];
    MethodOutput { layers, class, ambiguous }
}
