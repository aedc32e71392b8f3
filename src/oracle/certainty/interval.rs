//! Interval arithmetic for the certainty grid: what a kernel's complements 1 − Emp and 1 − Occ may be, in f32.

use crate::oracle::bound::{BoundedValue, U};

/// An interval that encloses a kernel's value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interval {
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// The interval of a product that is rounded `roundings` times; a product below f32's normal numbers may be flushed to 0.
    pub fn times(self, other: Interval, roundings: f64) -> Interval {
        // the thousandth covers second order and the f64 of this product
        let slack = (roundings + 1e-3) * U;
        let (low, high) = (self.low * other.low * (1.0 - slack), self.high * other.high * (1.0 + slack));
        Interval { low: if low < f64::from(f32::MIN_POSITIVE) { 0.0 } else { low }, high }
    }

    /// The interval of a kernel's complement after one more reading. `factor`: the complement of the reading's evidence, rounded
    /// `roundings` times. The result is the product; below [`COUNTED_BELOW`] it is a whole number of units of 2⁻⁵³
    /// ([`units_left`]).
    pub fn enhanced(self, factor: Interval, roundings: f64) -> Interval {
        let whole = |v: f64| if v < COUNTED_BELOW { (v * UNITS).round_ties_even() / UNITS } else { v };
        let product = self.times(factor, roundings);
        let product = Interval { low: whole(product.low), high: whole(product.high) };
        if self.low >= COUNTED_BELOW {
            return product;
        }
        // The evidence as the kernel has it: the factor's roundings, 1 − factor, its product.
        let slack = (roundings + 1.0) * U;
        let least = (1.0 - factor.high - slack).max(0.0) * (1.0 - 2.0 * U);
        let most = (1.0 - factor.low + slack).min(1.0) * (1.0 + 2.0 * U);
        let (low, sure_low) = units_left(self.low * UNITS, most);
        let (high, sure_high) = units_left(self.high.min(COUNTED_BELOW) * UNITS, least);
        // A tie that f32 may break otherwise, or evidence on either side of a power of two: one unit more on each side.
        let same_ulp = ulp_in_units(least) == ulp_in_units(most);
        let widen = |sure: bool| if sure && same_ulp { 0.0 } else { 1.0 };
        let low = (low - widen(sure_low)).max(0.0) / UNITS;
        let high = (high + widen(sure_high)) / UNITS;
        if self.high < COUNTED_BELOW {
            return Interval { low, high };
        }
        Interval { low: low.min(product.low), high: high.max(product.high) }
    }

    /// The largest |1 − x − `reference`| of an x in the interval.
    pub fn max_error_of_complement(self, reference: f64) -> f64 {
        (1.0 - self.low - reference).abs().max((1.0 - self.high - reference).abs())
    }
}

/// Below this value a kernel keeps 1 − Emp as a whole number of units of 2⁻⁵³.
const COUNTED_BELOW: f64 = 1.0 / (1u64 << 31) as f64;
/// Units in 1.
const UNITS: f64 = (1u64 << 53) as f64;

/// The unit in the last place of Emp_k in f64, in units of 2⁻⁵³; at most 1, as for the product with an Emp below 1.
fn ulp_in_units(emp: f64) -> f64 {
    if emp > 0.0 { (emp.log2().floor() + 1.0).exp2().min(1.0) } else { f64::MIN_POSITIVE }
}

/// The units of 1 − Emp that remain after a reading, and whether f32 surely computes the same number: f64 rounds Emp·Emp_k to the
/// last place of Emp_k, and the sum to a whole unit.
fn units_left(units: f64, emp: f64) -> (f64, bool) {
    let ulp = ulp_in_units(emp);
    let gone = (emp * units / ulp).round_ties_even() * ulp;
    let rest = units - gone;
    let tie = (rest - rest.floor() - 0.5).abs() <= units * 4.0 * U;
    // Both break an exact tie of representable numbers in the same way.
    let exact = units <= ulp / U;
    (rest.round_ties_even(), exact || !tie)
}

/// The interval `value` ± `error`, cut to 0..=`most`.
pub(super) fn interval_around(value: f64, error: f64, most: f64) -> Interval {
    Interval { low: (value - error).max(0.0), high: (value + error).min(most) }
}

/// The error bound of a kernel's 1 − Emp_k = p² + t² − p²t².
pub(super) fn factor_bound(p: BoundedValue, t: BoundedValue) -> f64 {
    let (p2, t2) = (p.squared(), t.squared());
    let moved = p2.bound * (1.0 - t2.value).max(0.0) + t2.bound * (1.0 - p2.value).max(0.0) + p2.bound * t2.bound;
    moved + 8.0 * U * (p2.value + t2.value + p2.bound + t2.bound)
}

/// The error bound of a kernel's Occ_k = (1 − z²)(1 − t²).
pub(super) fn profile_bound(z: BoundedValue, t: BoundedValue) -> f64 {
    let (z2, t2) = (z.squared(), t.squared());
    let (a, b) = ((1.0 - z2.value).max(0.0), (1.0 - t2.value).max(0.0));
    b * z2.bound + a * t2.bound + z2.bound * t2.bound + 8.0 * U
}
