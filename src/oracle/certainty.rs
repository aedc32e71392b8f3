//! Certainty grid (Moravec & Elfes 1985): evidence of empty and of occupied, each enhanced by probabilistic addition.
//!
//! The kernels keep Q = 1 − Emp and S = 1 − Occ as products, free of cancellation; the reference keeps the literal
//! recursion, whose saturation at exactly 1 is part of its result. Intervals follow what a kernel may hold; a bound is the
//! farthest end of its interval from the reference.

use super::bound::{Approx, U, depth, offset, turn};
use super::cone::{Cell, Cone};
use super::{Finished, OracleLayer, Region, Tally};
use crate::grid::GridSpec;
use crate::method::settings::{Certainty, Order};

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

/// What a kernel's value lies between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    low: f64,
    high: f64,
}

impl Range {
    /// The range of a product that is rounded `roundings` times; what f32 can't hold may be 0.
    fn times(self, other: Range, roundings: f64) -> Range {
        // the thousandth covers second order and the f64 of this product
        let slack = (roundings + 1e-3) * U;
        let (low, high) = (self.low * other.low * (1.0 - slack), self.high * other.high * (1.0 + slack));
        Range { low: if low < f64::from(f32::MIN_POSITIVE) { 0.0 } else { low }, high }
    }

    /// A kernel's next complement, `factor` that of the evidence, rounded so often: the product; below [`NEARLY`] whole
    /// units of 2⁻⁵³ ([`units_left`]).
    fn enhanced(self, factor: Range, roundings: f64) -> Range {
        let whole = |v: f64| if v < NEARLY { (v * UNITS).round_ties_even() / UNITS } else { v };
        let product = self.times(factor, roundings);
        let product = Range { low: whole(product.low), high: whole(product.high) };
        if self.low >= NEARLY {
            return product;
        }
        // The evidence as the kernel has it: the factor's roundings, 1 − factor, its product.
        let slack = (roundings + 1.0) * U;
        let least = (1.0 - factor.high - slack).max(0.0) * (1.0 - 2.0 * U);
        let most = (1.0 - factor.low + slack).min(1.0) * (1.0 + 2.0 * U);
        let (low, sure_low) = units_left(self.low * UNITS, most);
        let (high, sure_high) = units_left(self.high.min(NEARLY) * UNITS, least);
        // Unsure: a tie that f32 may break otherwise, or evidence on either side of a power of two.
        let same_place = place(least) == place(most);
        let widen = |sure: bool| if sure && same_place { 0.0 } else { 1.0 };
        let low = (low - widen(sure_low)).max(0.0) / UNITS;
        let high = (high + widen(sure_high)) / UNITS;
        if self.high < NEARLY {
            return Range { low, high };
        }
        Range { low: low.min(product.low), high: high.max(product.high) }
    }

    /// The farthest that 1 − x lies from `reference`, x in the range.
    fn off_complement(self, reference: f64) -> f64 {
        (1.0 - self.low - reference).abs().max((1.0 - self.high - reference).abs())
    }
}

/// Below this a kernel counts 1 − Emp in units of 2⁻⁵³.
const NEARLY: f64 = 1.0 / (1u64 << 31) as f64;
/// Units in 1.
const UNITS: f64 = (1u64 << 53) as f64;

/// The last place of Emp_k in f64, in units of 2⁻⁵³; at most 1, that of the product with an Emp below 1.
fn place(emp: f64) -> f64 {
    if emp > 0.0 { (emp.log2().floor() + 1.0).exp2().min(1.0) } else { f64::MIN_POSITIVE }
}

/// What is left of so many units after a reading, and whether f32 is sure to find the same: f64 rounds Emp·Emp_k to the
/// last place of Emp_k, and the sum to a whole unit.
fn units_left(units: f64, emp: f64) -> (f64, bool) {
    let place = place(emp);
    let gone = (emp * units / place).round_ties_even() * place;
    let rest = units - gone;
    let tie = (rest - rest.floor() - 0.5).abs() <= units * 4.0 * U;
    // An exact tie of representable numbers is broken alike.
    let exact = units <= place / U;
    (rest.round_ties_even(), exact || !tie)
}

/// The state of a map: Emp and Occ by the literal recursion, and what a kernel's Q and S lie between.
pub(super) struct State {
    pub emp: Vec<f64>,
    pub occ: Vec<f64>,
    q: Vec<Range>,
    s: Vec<Range>,
}

/// Evidence of one arc cell on its way: after cancelling, after normalising.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    pub index: usize,
    cancelled: f64,
    normalised: f64,
    /// A kernel's cancelled evidence, then its normalised one.
    kernel: Range,
}

impl State {
    /// Nothing known.
    pub fn new(cells: usize) -> Self {
        let one = || vec![Range { low: 1.0, high: 1.0 }; cells];
        State { emp: vec![0.0; cells], occ: vec![0.0; cells], q: one(), s: one() }
    }

    /// Step (a): frees the interior of one reading. A kernel's Q ← Q·(1 − Emp_k), near 0 in whole units as f64 counts.
    pub fn free(&mut self, cone: &Cone, cells: &[Cell]) {
        for cell in cells.iter().filter(|c| c.region == Region::Interior) {
            let (d, theta) = cone.polar(cell.v);
            let evidence = emp_k(d, theta, cone.span, cone.r_min, cone.beta);
            let error = factor_bound(depth(cone, d), turn(theta, cone.beta));
            let factor = around(1.0 - evidence, error + 1e-15, 1.0 + 4.0 * U);
            self.q[cell.index] = self.q[cell.index].enhanced(factor, 1.0);
            self.emp[cell.index] = enhance(self.emp[cell.index], evidence);
        }
    }

    /// Step (b) up to the normalised evidence: of each arc cell of one reading, into `arc`; returns their sum.
    pub fn weigh(&self, cone: &Cone, cells: &[Cell], arc: &mut Vec<Arc>) -> f64 {
        arc.clear();
        for cell in cells.iter().filter(|c| c.region == Region::Arc) {
            let (d, theta) = cone.polar(cell.v);
            let own = occ_k(d, theta, cone.range, cone.epsilon, cone.beta);
            let error = profile_bound(offset(cone, d), turn(theta, cone.beta));
            let kernel = self.q[cell.index].times(around(own, error, 1.0 + 4.0 * U), 1.0);
            let cancelled = own * (1.0 - self.emp[cell.index]);
            arc.push(Arc { index: cell.index, cancelled, normalised: 0.0, kernel });
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
            a.kernel = Range {
                low: share(a.kernel.low, others_high) * (1.0 - slack),
                high: (share(a.kernel.high, others_low) * (1.0 + slack)).min(1.0),
            };
        }
        sum
    }

    /// Step (b), its end: enhances Occ by the normalised evidence. A kernel's S ← S·(1 − w).
    pub fn occupy(&mut self, arc: &[Arc]) {
        for a in arc {
            let rest = Range { low: 1.0 - a.kernel.high, high: 1.0 - a.kernel.low };
            self.s[a.index] = self.s[a.index].enhanced(rest, 2.0);
            self.occ[a.index] = enhance(self.occ[a.index], a.normalised);
        }
    }
}

/// A value that is known to `error`, not below 0, not above `most`.
fn around(value: f64, error: f64, most: f64) -> Range {
    Range { low: (value - error).max(0.0), high: (value + error).min(most) }
}

/// Bound of a kernel's 1 − Emp_k = p² + t² − p²t².
fn factor_bound(p: Approx, t: Approx) -> f64 {
    let (p2, t2) = (p.squared(), t.squared());
    let moved = p2.bound * (1.0 - t2.value).max(0.0) + t2.bound * (1.0 - p2.value).max(0.0) + p2.bound * t2.bound;
    moved + 8.0 * U * (p2.value + t2.value + p2.bound + t2.bound)
}

/// Bound of a kernel's Occ_k = (1 − z²)(1 − t²).
fn profile_bound(z: Approx, t: Approx) -> f64 {
    let (z2, t2) = (z.squared(), t.squared());
    let (a, b) = ((1.0 - z2.value).max(0.0), (1.0 - t2.value).max(0.0));
    b * z2.bound + a * t2.bound + z2.bound * t2.bound + 8.0 * U
}

/// The state after all readings.
pub(super) fn run(grid: &GridSpec, cones: &[Cone], settings: &Certainty, tally: &mut Tally) -> State {
    let mut state = State::new(grid.cells());
    let (mut cells, mut arc) = (Vec::new(), Vec::new());
    for cone in cones {
        let n = cone.cells(grid, &mut cells);
        tally.add(cone, &cells, n);
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

/// Layers emp, occ, map and the classes.
pub(super) fn map(grid: &GridSpec, cones: &[Cone], settings: &Certainty, tally: &mut Tally) -> Finished {
    let State { emp, occ, q, s } = run(grid, cones, settings, tally);
    let count = grid.cells();
    let zero = || vec![0.0; count];
    let (mut values, mut bound, mut emp_bound, mut occ_bound) = (zero(), zero(), zero(), zero());
    let (mut class, mut ambiguous) = (vec![0; count], vec![false; count]);
    for k in (0..count).filter(|&k| tally.is_touched(k)) {
        // 1 − Q and 1 − S as layers of f32: rounded, and stored
        emp_bound[k] = q[k].off_complement(emp[k]) + 2.0 * U;
        occ_bound[k] = s[k].off_complement(occ[k]) + 2.0 * U;
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
    Finished { layers, class, ambiguous }
}
