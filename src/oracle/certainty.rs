//! Certainty grid (Moravec & Elfes 1985): evidence of empty and of occupied, each enhanced by probabilistic addition.
//!
//! The kernels keep Q = 1 − Emp and S = 1 − Occ as products, free of cancellation; the reference keeps the literal
//! recursion, whose saturation at exactly 1 is part of its result. The bounds cover both.

use super::bound::{Approx, CUT, STEP_F64, U, depth, offset, turn};
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

/// Probabilistic addition: x ← x + y − xy.
pub(super) fn enhance(x: f64, y: f64) -> f64 {
    x + y - x * y
}

/// The state of a map: Emp and Occ, and the bounds of a kernel's Q and S.
pub(super) struct State {
    pub emp: Vec<f64>,
    pub occ: Vec<f64>,
    emp_bound: Vec<f64>,
    occ_bound: Vec<f64>,
}

/// Evidence of one arc cell on its way: its own, after cancelling, after normalising.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    pub index: usize,
    pub own: f64,
    pub cancelled: Approx,
    pub normalised: Approx,
}

impl State {
    /// Nothing known.
    pub fn new(cells: usize) -> Self {
        let zero = || vec![0.0; cells];
        State { emp: zero(), occ: zero(), emp_bound: zero(), occ_bound: zero() }
    }

    /// Step (a): frees the interior of one reading.
    pub fn free(&mut self, cone: &Cone, cells: &[Cell]) {
        for cell in cells.iter().filter(|c| c.region == Region::Interior) {
            let (d, theta) = cone.polar(cell.v);
            let evidence = emp_k(d, theta, cone.span, cone.r_min, cone.beta);
            let (q, factor) = (1.0 - self.emp[cell.index], 1.0 - evidence);
            let error = factor_bound(depth(cone, d), turn(theta, cone.beta));
            // |Q̂F̂(1 + 2u) − QF|, the cut, and the reference's own noise
            let bound = &mut self.emp_bound[cell.index];
            let moved = *bound * (factor + error) + q.abs() * error;
            *bound = (moved + 2.0 * U * (q.abs() + *bound) * (factor + error) + CUT + STEP_F64).min(1.0);
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
            let (q, q_error) = (1.0 - self.emp[cell.index], self.emp_bound[cell.index]);
            let value = own * q;
            let bound = own * q_error + (q.abs() + q_error) * error + 2.0 * U * value.abs();
            let cancelled = Approx { value, bound };
            arc.push(Arc { index: cell.index, own, cancelled, normalised: Approx { value: 0.0, bound: 0.0 } });
        }
        let sum: f64 = arc.iter().map(|a| a.cancelled.value).sum();
        // n terms, none negative, added in any order: (n − 1) u of their sum
        let order = arc.len() as f64 * U * arc.iter().map(|a| a.cancelled.value.abs() + a.cancelled.bound).sum::<f64>();
        let sum_bound = arc.iter().map(|a| a.cancelled.bound).sum::<f64>() + order;
        for a in arc.iter_mut() {
            let value = if sum > 0.0 { a.cancelled.value / sum } else { 0.0 };
            let bound = if sum > sum_bound {
                (a.cancelled.bound + value.abs() * sum_bound) / (sum - sum_bound) * (1.0 + 6.0 * U)
                    + 6.0 * U * value.abs()
            } else {
                1.0
            };
            a.normalised = Approx { value, bound: bound.min(1.0) };
        }
        sum
    }

    /// Step (b), its end: enhances Occ by the normalised evidence.
    pub fn occupy(&mut self, arc: &[Arc]) {
        for a in arc {
            let s = (1.0 - self.occ[a.index]).abs();
            let Approx { value: w, bound: w_error } = a.normalised;
            let bound = &mut self.occ_bound[a.index];
            // |Ŝ(1 − ŵ)(1 + 2u) − S(1 − w)|, 1 − ŵ rounded
            let moved = *bound * (1.0 - w + w_error) + s * w_error;
            *bound = (moved + 4.0 * U * (s + *bound) + STEP_F64).min(1.0);
            self.occ[a.index] = enhance(self.occ[a.index], w);
        }
    }
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
    let State { emp, occ, emp_bound, occ_bound } = run(grid, cones, settings, tally);
    let count = grid.cells();
    let (mut values, mut bound) = (vec![0.0; count], vec![0.0; count]);
    let (mut class, mut ambiguous) = (vec![0; count], vec![false; count]);
    // 1 − Q and 1 − S as layers of f32: rounded, and stored
    let stored = |b: Vec<f64>| -> Vec<f64> {
        b.into_iter().enumerate().map(|(k, b)| if tally.is_touched(k) { b + 2.0 * U } else { 0.0 }).collect()
    };
    let (emp_bound, occ_bound) = (stored(emp_bound), stored(occ_bound));
    for k in (0..count).filter(|&k| tally.is_touched(k)) {
        class[k] = if occ[k] >= emp[k] && occ[k] > 0.0 { 1 } else { -i8::from(emp[k] > occ[k]) };
        values[k] = if occ[k] >= emp[k] { occ[k] } else { -emp[k] };
        let either = emp_bound[k] + occ_bound[k];
        ambiguous[k] = (occ[k] - emp[k]).abs() <= either;
        bound[k] = match class[k] {
            _ if ambiguous[k] => occ[k] + emp[k] + either,
            1 => occ_bound[k],
            _ => emp_bound[k],
        };
    }
    let layer = |name, values, bound| OracleLayer { name, values, bound };
    let layers = vec![layer("emp", emp, emp_bound), layer("occ", occ, occ_bound), layer("map", values, bound)];
    Finished { layers, class, ambiguous }
}
