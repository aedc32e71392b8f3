//! Certainty grid (Moravec & Elfes 1985); twin of `shaders/method/certainty.wgsl`.
//!
//! Emptiness never depends on occupancy. For a whole batch, each reading's Σ Occ_k therefore follows from a pass over
//! emptiness alone (weigh). A second pass (fuse) uses the sums and updates both. The result is that of sequential updates.
//!
//! A cell keeps the complements 1 − Emp and 1 − Occ, which are products: 1 − (E + e − E·e) = (1 − E)(1 − e). So 1 − Emp
//! keeps its relative precision where Emp is nearly 1, and cancelling there means something in f32. Very near 1 both follow
//! IEEE double precision, in which a certainty moves by whole units of 2⁻⁵³ and stops at 1: a cell surely empty takes no
//! occupancy.

use super::settings::{Certainty, Order, Settings};
use super::{Cost, Entry, Evidence, LayerSpec, Method, Pass, Rounds, Step, Steps};
use crate::binning::snap::Snapped;
use crate::geometry::layout::{COUNT, Cone, FREE, Frame, OCCUPY};
use crate::geometry::profile::{ONE_BITS, from_one, to_one};
use crate::grid::{Class, Scale};
use crate::method::driver::{Job, Kernel, Plane, Reached, WrongInput, walk};
use crate::sensor::Sensor;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, u32x16};

/// The registry entry.
pub const ENTRY: Entry = Entry {
    name: "certainty",
    source: "Moravec & Elfes 1985",
    about: "certainties of empty and of occupied, the occupied of each reading cancelled and normalised over its arc",
    wgsl: include_str!("../../shaders/method/certainty.wgsl"),
    cost: Cost { flop: 65, int: 44 },
    vec4s_per_thread: 4,
    make: |settings| match settings {
        Settings::Certainty(c) => Some(Box::new(c)),
        _ => None,
    },
};

/// The bound below which a complement is counted in units of 2⁻⁵³.
const NEARLY: f32 = 4.656_613e-10;
/// Number of units of 2⁻⁵³ in 1.
const UNITS: f32 = 9.007_199e15;

/// The complements of a row's certainties.
#[derive(Debug, Clone, Copy)]
pub struct CellStates<S: Simd> {
    /// 1 − Emp.
    open: f32x16<S>,
    /// 1 − Occ.
    clear: f32x16<S>,
}

/// 1 − Emp_k, without cancellation: Emp_k = (1 − p²)(1 − t²), p = (d − r_min)/(R − ε − r_min), t = θ/β.
#[inline(always)]
fn not_emp<S: Simd>(profile: [f32; 4], d: f32x16<S>, turn: f32x16<S>) -> f32x16<S> {
    let one = f32x16::splat(d.token(), 1.0);
    let p = (d - profile[0]).max(0.0) * profile[1];
    let p2 = (p * p).min(1.0);
    let t2 = (turn * turn).min(1.0);
    p2 + t2 * (one - p2)
}

/// The complement of E + (e − E·e), from those of E and of e: their product, and where E is nearly 1 what f64 makes of it.
#[inline(always)]
fn enhanced<S: Simd>(rest: f32x16<S>, not_e: f32x16<S>) -> f32x16<S> {
    let product = rest * not_e;
    let nearly = rest.min(product).simd_lt(NEARLY);
    // Most rows have no cell that is nearly certain.
    if nearly.any_true() { nearly.select(in_units(rest, not_e), product) } else { product }
}

/// [`enhanced`] near certainty: the bracket is rounded to the last place of e, the sum to that of E, both half to even.
#[inline(always)]
fn in_units<S: Simd>(rest: f32x16<S>, not_e: f32x16<S>) -> f32x16<S> {
    let e = f32x16::splat(rest.token(), 1.0) - not_e;
    let exponent = (e.bitcast::<i32x16<S>>() >> 23).min(126);
    let place: f32x16<S> = ((exponent + 1) << 23).bitcast();
    let per_place: f32x16<S> = ((i32x16::splat(rest.token(), 253) - exponent) << 23).bitcast();
    let units = rest * UNITS;
    let gone = (e * units * per_place).round_ties_even() * place;
    let left = rest.simd_lt(NEARLY).select(units - gone, rest * not_e * UNITS);
    left.round_ties_even() * (1.0 / UNITS)
}

/// Occ_k = (1 − ((d − R)/ε)²)(1 − t²).
#[inline(always)]
fn occ<S: Simd>(profile: [f32; 4], d: f32x16<S>, turn: f32x16<S>) -> f32x16<S> {
    let one = f32x16::splat(d.token(), 1.0);
    let e = (d - profile[2]) * profile[3];
    (one - e * e).max(0.0) * (one - turn * turn).max(0.0)
}

const GREY: Scale = Scale::Grey { low: 0.0, high: 1.0 };

const fn layer(name: &'static str, about: &'static str, scale: Scale) -> LayerSpec {
    LayerSpec { name, about, fill: 0.0, scale, integer: false }
}

/// The layers of the method.
const LAYERS: &[LayerSpec] = &[
    layer("emp", "certainty of empty, 0 to 1", GREY),
    layer("occ", "certainty of occupied, 0 to 1", GREY),
    layer("map", "occ where occ >= emp, else -emp", Scale::Signed { limit: 1.0 }),
];

/// 1 − Occ_k/Σ Occ_k: 0 for a cell that has all of it, 1 for every cell if there is none.
#[inline(always)]
fn not_normalised<S: Simd>(evidence: f32x16<S>, sum: f32) -> f32x16<S> {
    let one = f32x16::splat(evidence.token(), 1.0);
    let part = evidence.simd_lt(sum).select(evidence / sum, one);
    if sum > 0.0 { one - part } else { one }
}

impl Kernel for Certainty {
    type CellStates<S: Simd> = CellStates<S>;

    #[inline(always)]
    fn polar(&self) -> bool {
        true
    }

    #[inline(always)]
    fn load<S: Simd>(simd: S, planes: &[Plane], row: usize) -> CellStates<S> {
        CellStates {
            open: from_one(u32x16::load_array(simd, planes[0][row])),
            clear: from_one(u32x16::load_array(simd, planes[1][row])),
        }
    }

    #[inline(always)]
    fn store<S: Simd>(cells: CellStates<S>, planes: &mut [Plane], row: usize) {
        to_one(cells.open).store_array(&mut planes[0][row]);
        to_one(cells.clear).store_array(&mut planes[1][row]);
    }

    #[inline(always)]
    fn weigh_cells<S: Simd>(
        &self,
        frame: &Frame,
        cone: &Cone,
        row: &Reached<S>,
        cells: &mut CellStates<S>,
    ) -> f32x16<S> {
        let (d, turn) = (row.distance, row.turn);
        if frame.mode & FREE != 0 {
            let open = enhanced(cells.open, not_emp(cone.profile, d, turn));
            cells.open = row.interior.select(open, cells.open);
        }
        let occupied = occ(cone.profile, d, turn) * cells.open;
        row.arc.select(occupied, f32x16::splat(occupied.token(), 0.0))
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
        let evidence = self.weigh_cells(frame, cone, row, cells);
        if frame.mode & OCCUPY == 0 || !row.arc.any_true() {
            return;
        }
        let clear = enhanced(cells.clear, not_normalised(evidence, f32::from_bits(share[0])));
        cells.clear = row.arc.select(clear, cells.clear);
    }
}

impl Method for Certainty {
    fn settings(&self) -> Settings {
        Settings::Certainty(*self)
    }

    fn evidence(&self) -> Evidence {
        Evidence { about: "certainty: Emp_k in the interior, Occ_k on the arc", probability: false, normalised: true }
    }

    fn planes(&self) -> usize {
        2
    }

    fn sweeps(&self) -> &'static [&'static [Step]] {
        match self.order {
            Order::Sequential => {
                &[&[Step::Pass(Pass::Weigh, FREE), Step::Sum, Step::Pass(Pass::Fuse, FREE | OCCUPY | COUNT)]]
            }
            Order::Batch => &[
                &[Step::Pass(Pass::Fuse, FREE | COUNT)],
                &[Step::Pass(Pass::Weigh, 0), Step::Sum, Step::Pass(Pass::Fuse, OCCUPY)],
            ],
        }
    }

    fn rounds(&self) -> Option<Rounds> {
        // Emptiness never depends on occupancy: the sums of every reading come first, chunk by chunk.
        const WEIGH: Steps = &[Step::Pass(Pass::Weigh, FREE), Step::Sum, Step::ReadBack, Step::Pass(Pass::Fuse, FREE)];
        const FREE_FIRST: Steps = &[Step::Pass(Pass::Fuse, FREE)];
        const THEN_WEIGH: Steps = &[Step::Pass(Pass::Weigh, 0), Step::Sum, Step::ReadBack];
        Some(match self.order {
            Order::Sequential => &[&[WEIGH], &[&[Step::Pass(Pass::Fuse, FREE | OCCUPY | COUNT)]]],
            Order::Batch => &[
                &[FREE_FIRST, THEN_WEIGH],
                &[&[Step::Pass(Pass::Fuse, FREE | COUNT)], &[Step::Pass(Pass::Fuse, OCCUPY)]],
            ],
        })
    }

    fn profile(&self, sensor: &Sensor, snapped: &Snapped) -> [f32; 4] {
        let span = snapped.range - snapped.epsilon - sensor.r_min;
        let per_span = if span > 0.0 { 1.0 / span } else { 0.0 };
        let per_epsilon = if snapped.epsilon > 0.0 { 1.0 / snapped.epsilon } else { 0.0 };
        [sensor.r_min, per_span, snapped.range, per_epsilon].map(|v| v as f32)
    }

    fn layers(&self) -> Vec<LayerSpec> {
        LAYERS.to_vec()
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        let (open, clear) = (f32::from_bits(words[2] ^ ONE_BITS), f32::from_bits(words[3] ^ ONE_BITS));
        let (emp, occ) = (1.0 - open, 1.0 - clear);
        let occupied = clear <= open;
        layers.copy_from_slice(&[emp, occ, if occupied { occ } else { -emp }]);
        match (occupied, clear < 1.0) {
            (true, true) => Class::Occupied,
            (true, false) => Class::Unknown,
            (false, _) => Class::Empty,
        }
    }

    fn combined(&self, layers: &[f32], _: Class) -> f32 {
        layers[2]
    }

    fn run(&self, pass: Pass, job: &Job, state: &mut [u32]) -> Result<(), WrongInput> {
        walk(self, pass, job, state)
    }
}
