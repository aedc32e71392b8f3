//! Dempster-Shafer (Pagac, Nebot & Durrant-Whyte 1998; Murphy 2000): masses of empty, full and unknown.
//!
//! Kept as two sums of logarithms, LE = Σ ln(1 − e) and LF = Σ ln(1 − f), which is the combination itself, free of
//! order. The kernels keep the same sums in fixed point: their only error is one rounding a reading.

use super::bound::{BoundedValue, U};
use super::cone::Cone;
use super::{MethodOutput, OracleLayer, Region, UpdateCounts, bayes};
use crate::grid::GridSpec;
use crate::method::settings::{DempsterShafer, MassModel, Rho};

/// Rounding of a logarithm to the kernels' fixed point of 2⁻⁴⁰, model pagac.
const PAGAC_UNIT: f64 = 0.5 / (1u64 << 40) as f64;
/// Rounding of a logarithm to the kernels' fixed point of 2⁻²⁴, model murphy.
const MURPHY_UNIT: f64 = 1.0 / (1u64 << 24) as f64;
/// The largest difference of the masses full and empty that counts as a tie: unknown.
const TIE: f64 = 1e-6;

/// Masses of empty and full and the accumulated conflict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Masses {
    pub empty: f64,
    pub full: f64,
    pub unknown: f64,
    pub conflict: f64,
}

/// Masses from the two sums: A = e^LE, B = e^LF, N = A + B − AB; scaled by e^−max(LE, LF).
pub(super) fn masses(le: f64, lf: f64) -> Masses {
    let top = le.max(lf);
    let (a, b) = ((le - top).exp(), (lf - top).exp());
    let n = a + b - a * b * top.exp();
    Masses {
        empty: -b * le.exp_m1() / n,
        full: -a * lf.exp_m1() / n,
        unknown: a * b * top.exp() / n,
        conflict: -top - n.ln(),
    }
}

/// A reading's mass in a region, with a kernel's error of ln(1 − mass). n = the reading's arc cells.
pub(super) fn mass(
    settings: &DempsterShafer,
    cone: &Cone,
    region: Region,
    polar: (f64, f64),
    n: usize,
) -> BoundedValue {
    let even = if n > 0 { 1.0 / n as f64 } else { 0.0 };
    let pagac = |m: f64| BoundedValue { value: m.min(settings.cap), bound: PAGAC_UNIT };
    match (settings.model, region, settings.rho) {
        (MassModel::Pagac, Region::Interior, Rho::Constant(rho)) => pagac(rho),
        (MassModel::Pagac, ..) => pagac(even),
        (MassModel::Murphy, ..) => {
            let p = bayes::murphy_expression(cone, polar, if region == Region::Arc { settings.max_occ } else { 1.0 });
            let m = p.value.clamp(0.0, settings.cap);
            let (low, high) =
                ((p.value - p.bound).clamp(0.0, settings.cap), (p.value + p.bound).clamp(0.0, settings.cap));
            // the mass's error, 1 − mass rounded, the logarithm, the fixed point
            let moved = (-high).ln_1p() - (-low).ln_1p();
            let rest = 2.0 * U / (1.0 - high) + 8.0 * U * (-high).ln_1p().abs() + MURPHY_UNIT;
            BoundedValue { value: m, bound: moved.abs() + rest }
        }
    }
}

/// Maps the cones, in their order: layers empty, full, unknown and conflict, and the classes.
pub(super) fn map(
    grid: &GridSpec,
    cones: &[Cone],
    settings: &DempsterShafer,
    counts: &mut UpdateCounts,
) -> MethodOutput {
    let count = grid.cells();
    let (mut le, mut lf, mut error) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    let mut cells = Vec::new();
    for cone in cones {
        let n = cone.cells(grid, &mut cells);
        counts.add(cone, &cells, n);
        for cell in &cells {
            let polar = if settings.model == MassModel::Murphy { cone.polar(cell.v) } else { (0.0, 0.0) };
            let m = mass(settings, cone, cell.region, polar, n);
            let sums = if cell.region == Region::Interior { &mut le } else { &mut lf };
            sums[cell.index] += (-m.value).ln_1p();
            error[cell.index] += if m.value > 0.0 || settings.model == MassModel::Murphy { m.bound } else { 0.0 };
        }
    }
    let names = ["empty", "full", "unknown", "conflict"];
    let mut layers: Vec<OracleLayer> =
        names.iter().map(|&name| OracleLayer { name, values: vec![0.0; count], bound: vec![0.0; count] }).collect();
    layers[2].values.fill(1.0);
    let (mut class, mut ambiguous) = (vec![0; count], vec![false; count]);
    for k in (0..count).filter(|&k| counts.is_touched(k)) {
        let m = masses(le[k], lf[k]);
        // the reference's own sums
        let e = error[k] + 1e-15 * (le[k].abs() + lf[k].abs() + 1.0);
        // |∂E|, |∂F| ≤ AB/N² ≤ min(A, B)/max(A, B); |∂U| ≤ U; |∂Con| ≤ 1; all along the segment
        let mass_bound = e * (e - (le[k] - lf[k]).abs()).exp().min(1.0);
        let unknown_bound = e * (m.unknown * e.exp()).min(1.0);
        let values = [m.empty, m.full, m.unknown, m.conflict];
        let bounds = [mass_bound, mass_bound, unknown_bound, e];
        for ((layer, value), bound) in layers.iter_mut().zip(values).zip(bounds) {
            layer.values[k] = value;
            // computed from the sums in f64, stored as f32
            layer.bound[k] = bound + U * value.abs() + 1e-15;
        }
        let lead = m.full - m.empty;
        class[k] = if lead.abs() <= TIE { 0 } else { lead.signum() as i8 };
        let doubt = 2.0 * mass_bound + U * (m.full + m.empty) + 2e-15;
        ambiguous[k] = (lead.abs() - TIE).abs() <= doubt;
    }
    MethodOutput { layers, class, ambiguous }
}
