//! Dempster-Shafer evidential grid (Pagac, Nebot & Durrant-Whyte 1998); twin of `shaders/method/dempster_shafer.wgsl`.
//!
//! A reading's evidence is for empty or for full, never both, so Dempster's rule needs only two sums for each cell,
//! −Σ ln(1 − e) and −Σ ln(1 − f). They are kept in 64-bit fixed point, so they are exact, independent of the order, and the
//! same on every backend.

use super::settings::{DempsterShafer, MassModel, Rho, Settings};
use super::{Cost, Entry, Evidence, LayerSpec, Method, Pass, Rounds, Step, Steps};
use crate::binning::snap::Snapped;
use crate::geometry::layout::{COUNT, Cone, Frame};
use crate::geometry::profile::{log, murphy};
use crate::grid::{Class, Scale};
use crate::log::reading::Outcome;
use crate::method::driver::{Job, Kernel, Plane, Reached, WrongInput, walk};
use crate::sensor::Sensor;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16, u32x16};

/// The registry entry.
pub const ENTRY: Entry = Entry {
    name: "dempster-shafer",
    source: "Pagac, Nebot & Durrant-Whyte 1998",
    about: "masses of empty, full and unknown, and their accumulated conflict",
    wgsl: include_str!("../../shaders/method/dempster_shafer.wgsl"),
    cost: Cost { flop: 0, int: 52 },
    vec4s_per_thread: 8,
    make: |settings| match settings {
        Settings::DempsterShafer(d) => Some(Box::new(d)),
        _ => None,
    },
};

/// The unit of the sums.
const UNIT: f64 = 1.0 / (1u64 << 40) as f64;
/// One, in the units of a logarithm that a kernel computes itself.
const LOG_ONE: f32 = 16_777_216.0;
/// The difference below which two masses are a tie, so that the class is unknown.
const TIE: f64 = 1e-6;

/// The sums of a row, −Σ ln(1 − e) and −Σ ln(1 − f), as low and high words.
#[derive(Debug, Clone, Copy)]
pub struct CellStates<S: Simd> {
    empty: [u32x16<S>; 2],
    full: [u32x16<S>; 2],
}

/// −ln(1 − m) in units of 2⁻²⁴.
#[inline(always)]
fn weight<S: Simd>(m: f32x16<S>) -> u32x16<S> {
    let one = f32x16::splat(m.token(), 1.0);
    (-log(one - m) * LOG_ONE + 0.5).to_int()
}

/// Adds an addend to a 64-bit sum in the cells where `on` is set.
#[inline(always)]
fn add<S: Simd>(sum: &mut [u32x16<S>; 2], addend: [u32x16<S>; 2], on: mask32x16<S>) {
    let low = sum[0] + addend[0];
    let carried = on & low.simd_lt(sum[0]);
    let high = on.select(sum[1] + addend[1], sum[1]);
    *sum = [on.select(low, sum[0]), carried.select(high + 1, high)];
}

const fn layer(name: &'static str, about: &'static str, fill: f32, high: f64) -> LayerSpec {
    LayerSpec { name, about, fill, scale: Scale::Grey { low: 0.0, high }, integer: false }
}

/// The layers of the method.
const LAYERS: &[LayerSpec] = &[
    layer("empty", "mass of empty", 0.0, 1.0),
    layer("full", "mass of full", 0.0, 1.0),
    layer("unknown", "mass of {empty, full}", 1.0, 1.0),
    layer("conflict", "accumulated conflict, the sum of ln 1/(1 - K)", 0.0, 5.0),
];

impl Kernel for DempsterShafer {
    type CellStates<S: Simd> = CellStates<S>;

    #[inline(always)]
    fn polar(&self) -> bool {
        self.model == MassModel::Murphy
    }

    #[inline(always)]
    fn load<S: Simd>(simd: S, planes: &[Plane], row: usize) -> CellStates<S> {
        let empty = [u32x16::load_array(simd, planes[0][row]), u32x16::load_array(simd, planes[1][row])];
        CellStates { empty, full: [u32x16::load_array(simd, planes[2][row]), u32x16::load_array(simd, planes[3][row])] }
    }

    #[inline(always)]
    fn store<S: Simd>(cells: CellStates<S>, planes: &mut [Plane], row: usize) {
        cells.empty[0].store_array(&mut planes[0][row]);
        cells.empty[1].store_array(&mut planes[1][row]);
        cells.full[0].store_array(&mut planes[2][row]);
        cells.full[1].store_array(&mut planes[3][row]);
    }

    #[inline(always)]
    fn fuse_cells<S: Simd>(
        &self,
        frame: &Frame,
        cone: &Cone,
        row: &Reached<S>,
        share: &[u32; 4],
        cells: &mut CellStates<S>,
    ) {
        if self.model == MassModel::Pagac {
            let simd = row.distance.token();
            add(&mut cells.empty, [u32x16::splat(simd, share[0]), u32x16::splat(simd, share[1])], row.interior);
            add(&mut cells.full, [u32x16::splat(simd, share[2]), u32x16::splat(simd, share[3])], row.arc);
            return;
        }
        let [max_occ, cap, ..] = frame.constants[0];
        let (d, turn) = (row.distance, row.turn);
        let near = murphy(cone.profile[0], d, turn);
        let half = f32x16::splat(near.token(), 0.5);
        let m = near * row.arc.select(half * max_occ, half);
        let w = weight(m.max(0.0).min(cap));
        add(&mut cells.empty, [w << 16, w >> 16], row.interior);
        add(&mut cells.full, [w << 16, w >> 16], row.arc);
    }
}

impl Method for DempsterShafer {
    fn settings(&self) -> Settings {
        Settings::DempsterShafer(*self)
    }

    fn evidence(&self) -> Evidence {
        Evidence::magnitude("mass: of empty in the interior, of full on the arc")
    }

    fn planes(&self) -> usize {
        4
    }

    fn sweeps(&self) -> &'static [&'static [Step]] {
        match self.model {
            MassModel::Pagac => &[&[Step::Pass(Pass::Count, 0), Step::NormalizeByCount, Step::Pass(Pass::Fuse, COUNT)]],
            MassModel::Murphy => &[&[Step::Pass(Pass::Fuse, COUNT)]],
        }
    }

    fn rounds(&self) -> Option<Rounds> {
        const COUNTED: Steps = &[Step::Pass(Pass::Count, 0), Step::AccumulateCounts];
        const FUSE: Steps = &[Step::Pass(Pass::Fuse, COUNT)];
        Some(match self.model {
            MassModel::Pagac => &[&[COUNTED], &[FUSE]],
            MassModel::Murphy => &[&[FUSE]],
        })
    }

    fn constants(&self) -> [[f32; 4]; 2] {
        [[self.max_occ as f32, self.cap as f32, 0.0, 0.0], [0.0; 4]]
    }

    fn variant(&self) -> Option<(&'static str, bool)> {
        Some(("MURPHY", self.model == MassModel::Murphy))
    }

    fn profile(&self, sensor: &Sensor, _: &Snapped) -> [f32; 4] {
        [(1.0 / sensor.r_max) as f32, 0.0, 0.0, 0.0]
    }

    fn share(&self, count: u32, outcome: Outcome) -> [u32; 4] {
        // Without arc cells 1/n is undefined, so its evidence is left out.
        let one_over_n = if count == 0 { 0.0 } else { 1.0 / f64::from(count) };
        let rho = match self.rho {
            Rho::OneOverN => one_over_n,
            Rho::Constant(rho) => rho,
        };
        let words = |mass: f64| {
            let weight = (-(-mass.min(self.cap)).ln_1p() / UNIT).round() as u64;
            [weight as u32, (weight >> 32) as u32]
        };
        let [e, f] = [words(rho), words(if outcome == Outcome::Hit { one_over_n } else { 0.0 })];
        [e[0], e[1], f[0], f[1]]
    }

    fn layers(&self) -> Vec<LayerSpec> {
        LAYERS.to_vec()
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        let sum = |low: u32, high: u32| -((u64::from(high) << 32 | u64::from(low)) as f64) * UNIT;
        let (le, lf) = (sum(words[2], words[3]), sum(words[4], words[5]));
        // A = e^LE and B = e^LF are both divided by e^most, so that neither quotient is 0/0.
        let most = le.max(lf);
        let (a, b) = ((le - most).exp(), (lf - most).exp());
        let both = a * b * most.exp();
        let n = a + b - both;
        let (empty, full) = (b * -le.exp_m1() / n, a * -lf.exp_m1() / n);
        layers.copy_from_slice(&[empty, full, both / n, -(most + n.ln())].map(|v| v as f32));
        if (full - empty).abs() <= TIE {
            Class::Unknown
        } else if full > empty {
            Class::Occupied
        } else {
            Class::Empty
        }
    }

    fn combined(&self, layers: &[f32], _: Class) -> f32 {
        layers[1] - layers[0]
    }

    fn run(&self, pass: Pass, job: &Job, state: &mut [u32]) -> Result<(), WrongInput> {
        walk(self, pass, job, state)
    }
}
