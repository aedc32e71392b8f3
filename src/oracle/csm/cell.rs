//! What a beam says of a cell.

use super::beam::{Beam, LENGTH, Vector, cross, dot, round};
use crate::method::settings::{Csm, FreeRule};
use crate::oracle::bound::U;
use std::f64::consts::TAU;

/// Increments of no more than this don't touch a cell.
pub(super) const LEAST: f64 = 1e-6;
/// Relative error of a kernel in f32, given its argument: its polynomial's, and the five products about it.
const KERNEL: f64 = 40.0 * U;
/// Absolute error of d/l: the root of a sum of squares, the product with 1/l; and what is cut off below 1/1024 µm.
const ARGUMENT: f64 = 16.0 * U;

/// k(d) for d/l (Melkumyan & Ramos 2009).
fn kernel(csm: &Csm, d: f64) -> f64 {
    let s = 1.0 - (d / csm.l).min(1.0);
    (csm.sigma0 * ((2.0 + (TAU * s).cos()) / 3.0 * s - (TAU * s).sin() / TAU)).max(0.0)
}

/// The most by which a kernel in f32 may differ: where its argument is off, its slope, which is nowhere more than 2.5.
fn kernel_bound(csm: &Csm, d: f64) -> f64 {
    let error = ARGUMENT + 1e-9 / csm.l;
    let s = 1.0 - (d / csm.l).min(1.0) + error;
    // k rises as s⁵ where it is small.
    let slope = (43.3 * s.powi(4)).min(2.5);
    csm.sigma0 * slope * error + KERNEL * kernel(csm, d)
}

/// A cell's α under way: labels, "free" last.
#[derive(Clone)]
pub(super) struct Cell {
    pub alpha: Vec<f64>,
    pub bound: Vec<f64>,
    pub interior: u32,
    pub arc: u32,
    pub marks: u32,
}

impl Cell {
    /// Nothing is said of it yet; so many classes, "free" among them.
    pub fn new(classes: usize) -> Cell {
        Cell { alpha: vec![0.0; classes], bound: vec![0.0; classes], interior: 0, arc: 0, marks: 0 }
    }

    fn add(&mut self, class: usize, value: f64, bound: f64) {
        self.alpha[class] += value;
        // The sum rounds anew with each increment.
        self.bound[class] += bound + U * (self.alpha[class] + self.bound[class]);
    }

    /// Whether it gained more than nothing to speak of.
    pub fn is_touched(&self) -> bool {
        self.interior + self.arc > 0 || is_faint(&self.alpha)
    }

    /// What a beam says.
    pub fn see(&mut self, csm: &Csm, resolution: f64, scan: usize, (index, beam): (usize, &Beam), v: Vector) {
        let Some((hit, range)) = beam.hit else { return };
        let before = (self.interior, self.arc);
        if csm.continuous {
            self.spread(csm, beam, hit, range, v);
        } else {
            self.count(csm, resolution, beam, range, v);
        }
        if before != (self.interior, self.arc) {
            self.marks = self.marks.wrapping_add(mark(scan as u32, (index as u32) << 16 | beam.label as u32));
        }
    }

    fn count(&mut self, csm: &Csm, resolution: f64, beam: &Beam, range: i128, v: Vector) {
        if cross(beam.right, v) < 0 || cross(beam.left, v) > 0 {
            return;
        }
        let half = (csm.w_obstacle.unwrap_or(2.0 * resolution) * 1e6 / 2.0).round() as i128;
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

    fn spread(&mut self, csm: &Csm, beam: &Beam, hit: Vector, range: i128, v: Vector) {
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

/// Whether the kernel is more than [`LEAST`] at a distance, µm, squared: at the largest whole one that is no farther.
fn touches(csm: &Csm, square: i128) -> bool {
    let mut d = (square as f64).sqrt() as i128;
    d += i128::from((d + 1) * (d + 1) <= square);
    d -= i128::from(d * d > square);
    let s = 1.0 - d as f64 * 1e-6 / csm.l;
    s > 0.0 && csm.sigma0 * ((2.0 + (TAU * s).cos()) / 3.0 * s - (TAU * s).sin() / TAU) > LEAST
}

/// Whether a cell gained more than nothing to speak of, if only by increments that are no updates each.
pub(in crate::oracle) fn is_faint(gains: &[f64]) -> bool {
    gains.iter().sum::<f64>() > LEAST
}

/// As the kernels mark a beam, label and all.
fn mark(scan: u32, id: u32) -> u32 {
    let mixed = (scan.wrapping_mul(0x9e37_79b1) ^ id).wrapping_mul(0x85eb_ca6b);
    (mixed ^ (mixed >> 15)).wrapping_mul(0xc2b2_ae35)
}
