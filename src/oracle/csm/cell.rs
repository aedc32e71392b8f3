//! A cell of a counting sensor model: what a beam adds to its α.

use super::beam::{Beam, LENGTH, Vector, cross, dot, round};
use crate::method::settings::{Csm, FreeRule};
use crate::oracle::bound::U;
use std::f64::consts::TAU;

/// A cell whose α gained no more than this in all is untouched.
pub(super) const MIN_INCREMENT: f64 = 1e-6;
/// Relative error of a kernel in f32, given its argument: its polynomial's, and the five products about it.
const KERNEL: f64 = 40.0 * U;
/// Absolute error of d/l: the root of a sum of squares, the product with 1/l, and the truncation below 1/1024 µm.
const ARGUMENT: f64 = 16.0 * U;

/// k(d) for d/l (Melkumyan & Ramos 2009).
fn kernel(csm: &Csm, d: f64) -> f64 {
    let s = 1.0 - (d / csm.l).min(1.0);
    (csm.sigma0 * ((2.0 + (TAU * s).cos()) / 3.0 * s - (TAU * s).sin() / TAU)).max(0.0)
}

/// The error bound of k(d) in f32: the error of its argument times its slope, which is 2.5 at most, and its own rounding.
fn kernel_bound(csm: &Csm, d: f64) -> f64 {
    let error = ARGUMENT + 1e-9 / csm.l;
    let s = 1.0 - (d / csm.l).min(1.0) + error;
    // k rises as s⁵ where it is small.
    let slope = (43.3 * s.powi(4)).min(2.5);
    csm.sigma0 * slope * error + KERNEL * kernel(csm, d)
}

/// A beam beside a cell.
pub(super) struct BeamAtCell<'a> {
    /// The scan's index, and the beam's in it.
    pub index: (usize, usize),
    pub beam: &'a Beam,
    /// The cell's centre from the scan's pose, µm.
    pub v: Vector,
}

/// A hit of a beam: its position from the pose, and its range, µm.
type Hit = (Vector, i128);

/// The α of a cell: labels, "free" last.
#[derive(Clone)]
pub(super) struct DirichletCell {
    pub alpha: Vec<f64>,
    pub bound: Vec<f64>,
    pub interior: u32,
    pub arc: u32,
    pub marks: u32,
}

impl DirichletCell {
    /// A cell before the first beam. `classes`: the labels and "free".
    pub fn new(classes: usize) -> DirichletCell {
        DirichletCell { alpha: vec![0.0; classes], bound: vec![0.0; classes], interior: 0, arc: 0, marks: 0 }
    }

    fn add(&mut self, class: usize, value: f64, bound: f64) {
        self.alpha[class] += value;
        // The sum rounds anew with each increment.
        self.bound[class] += bound + U * (self.alpha[class] + self.bound[class]);
    }

    /// Whether a beam updated it, or its α gained more than [`MIN_INCREMENT`] in all.
    pub fn is_touched(&self) -> bool {
        self.interior + self.arc > 0 || has_subthreshold_evidence(&self.alpha)
    }

    /// Applies a beam. `resolution`: the edge of a cell, metres.
    pub fn apply(&mut self, csm: &Csm, resolution: f64, at: &BeamAtCell) {
        let Some(hit) = at.beam.hit else { return };
        let before = (self.interior, self.arc);
        if csm.continuous {
            self.apply_continuous(csm, at, hit);
        } else {
            let width = csm.w_obstacle.unwrap_or(2.0 * resolution);
            self.apply_discrete(width, at, hit.1);
        }
        if before != (self.interior, self.arc) {
            let (scan, index) = at.index;
            self.marks = self.marks.wrapping_add(mark(scan as u32, (index as u32) << 16 | at.beam.label as u32));
        }
    }

    /// Counts the cell as occupied within half of `width`, metres, of the range, µm; as free before it.
    fn apply_discrete(&mut self, width: f64, &BeamAtCell { beam, v, .. }: &BeamAtCell, range: i128) {
        if cross(beam.right, v) < 0 || cross(beam.left, v) > 0 {
            return;
        }
        let half = (width * 1e6 / 2.0).round() as i128;
        let (d, inner, outer) = (dot(v, v), (range - half).max(0), range + half);
        if d > inner * inner && d < outer * outer {
            if beam.label > 0 {
                self.arc += 1;
                self.alpha[beam.label - 1] += 1.0;
            }
        } else if d <= inner * inner {
            self.interior += 1;
            let free = self.alpha.len() - 1;
            self.alpha[free] += 1.0;
        }
    }

    /// Adds the kernel's value at the distance from the hit, and at those from the free part of the beam.
    fn apply_continuous(&mut self, csm: &Csm, &BeamAtCell { beam, v, .. }: &BeamAtCell, (hit, range): Hit) {
        let length = LENGTH as i128;
        let (along, l) = (dot(beam.unit, v), round(csm.l * 1e6));
        if csm.free == FreeRule::Projection && along < 0 {
            return;
        }
        let e = [v[0] - hit[0], v[1] - hit[1]];
        if beam.label > 0 && e[0].abs().max(e[1].abs()) < l {
            let d = (dot(e, e) as f64).sqrt() * 1e-6;
            self.add(beam.label - 1, kernel(csm, d), kernel_bound(csm, d));
            self.arc += u32::from(touches(csm, dot(e, e)));
        }
        let across = cross(beam.unit, v).abs();
        let metre = along.div_euclid(length);
        let mut free = |offset: i128| {
            let p = across as f64 / LENGTH * 1e-6;
            let d = p.hypot(offset as f64 * 1e-6);
            let last = self.alpha.len() - 1;
            self.add(last, kernel(csm, d), kernel_bound(csm, d));
            let whole = across / length;
            self.interior += u32::from(touches(csm, whole * whole + offset * offset));
        };
        if across >= l * length {
            return;
        }
        match csm.free {
            FreeRule::Projection if along <= range * length => free(0),
            FreeRule::Projection => {}
            FreeRule::Clamp => {
                let offset = metre - metre.clamp(0, (range - l).max(0));
                if offset.abs() < l {
                    free(offset);
                }
            }
            FreeRule::Sample => {
                let step = round(csm.step * 1e6);
                (0..=range / step).map(|k| metre - k * step).filter(|o| o.abs() < l).for_each(free);
            }
        }
    }
}

/// Whether the kernel exceeds [`MIN_INCREMENT`] at a distance given by its square, µm²; the distance is rounded down to whole µm.
fn touches(csm: &Csm, square: i128) -> bool {
    let mut d = (square as f64).sqrt() as i128;
    d += i128::from((d + 1) * (d + 1) <= square);
    d -= i128::from(d * d > square);
    let s = 1.0 - d as f64 * 1e-6 / csm.l;
    s > 0.0 && csm.sigma0 * ((2.0 + (TAU * s).cos()) / 3.0 * s - (TAU * s).sin() / TAU) > MIN_INCREMENT
}

/// Whether the α of a cell gained more than [`MIN_INCREMENT`] in all; each increment may be too small to count as an update.
pub(in crate::oracle) fn has_subthreshold_evidence(gains: &[f64]) -> bool {
    gains.iter().sum::<f64>() > MIN_INCREMENT
}

/// The mark of a beam with its label, the same as the kernels': [`crate::method::Method::marks`].
fn mark(scan: u32, id: u32) -> u32 {
    let mixed = (scan.wrapping_mul(0x9e37_79b1) ^ id).wrapping_mul(0x85eb_ca6b);
    (mixed ^ (mixed >> 15)).wrapping_mul(0xc2b2_ae35)
}
