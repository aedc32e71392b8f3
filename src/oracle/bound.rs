//! The errors that a kernel in 32-bit floats may make: the constants of the running error analysis.
//!
//! u = 2⁻²⁴ is the unit roundoff. WGSL lets + − × round once or be fused, ÷ be off by 2.5 ULP (5 u), sqrt be
//! 1/inverseSqrt (2 + 2.5 ULP, 9 u). Constants count first-order terms and are rounded up.

use super::cone::Cone;

/// u, the unit roundoff of f32.
pub(super) const U: f64 = 1.0 / (1u64 << 24) as f64;

/// Relative error of d: d² to f32 from at most two words (2 u, halved by the root), the root 9 u, the metres of a
/// unit 1 u, the product 1 u.
const DISTANCE: f64 = 12.0 * U;

/// Relative error of θ = q·P(q²), at worst by q = cross/(|axis|·d + dot), both terms of the sum ≥ 0: cross 2 u, the sum 13 u,
/// the division 5 u, P 8 u and its argument's effect 3 u, the product 1 u; and 2.5e-8 for the polynomial itself. By
/// q = cross/dot the sum's 13 u are 2 u.
const THETA: f64 = 32.0 * U + 2.5e-8;

/// A value, and the bound of a kernel's error in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BoundedValue {
    /// The reference's value.
    pub value: f64,
    /// The largest difference of a kernel's value from it.
    pub bound: f64,
}

impl BoundedValue {
    /// The square.
    pub fn squared(self) -> BoundedValue {
        BoundedValue { value: self.value * self.value, bound: (2.0 * self.value.abs() + self.bound) * self.bound }
    }
}

/// θ/β, at most 1; 0 where β is 0 (only the axis lies in such a beam).
pub(super) fn angle_fraction(theta: f64, beta: f64) -> BoundedValue {
    let value = if beta > 0.0 { theta / beta } else { 0.0 };
    // 1/β rounded, the product
    BoundedValue { value: value.min(1.0), bound: value.min(2.0) * (THETA + 3.0 * U) }
}

/// d/R, at most 1, R = the sensor's largest range.
pub(super) fn range_fraction(cone: &Cone, d: f64) -> BoundedValue {
    let value = (d / cone.r_max).clamp(0.0, 1.0);
    BoundedValue { value, bound: value * (DISTANCE + 3.0 * U) }
}

/// Position in the interior: p = max(d − r_min, 0)/(R − ε − r_min), 0 where that span isn't positive. The difference cancels: its error is that of
/// d and r_min, magnified by the span.
pub(super) fn interior_fraction(cone: &Cone, d: f64) -> BoundedValue {
    if cone.span < 1e-9 {
        // the sign of a span of rounding noise may differ in a kernel
        return BoundedValue { value: 0.0, bound: if cone.span < -1e-9 { 0.0 } else { 1.0 } };
    }
    let value = ((d - cone.r_min) / cone.span).max(0.0);
    let bound = if d < cone.r_min * (1.0 - 16.0 * U) {
        0.0
    } else {
        (DISTANCE * d + U * cone.r_min) / cone.span + 4.0 * U * value
    };
    BoundedValue { value, bound: bound.min(1.0) }
}

/// Position on the arc: (d − R)/ε, within −1..1. The difference cancels: its error is that of d and R, magnified by 1/ε.
pub(super) fn arc_offset(cone: &Cone, d: f64) -> BoundedValue {
    if cone.epsilon <= 0.0 {
        return BoundedValue { value: 0.0, bound: 0.0 };
    }
    let value = (d - cone.range) / cone.epsilon;
    let bound = (DISTANCE * d + U * cone.range) / cone.epsilon + 4.0 * U * value.abs();
    BoundedValue { value, bound: bound.min(1.0) }
}
