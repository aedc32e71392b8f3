//! Bayesian occupancy grid (Elfes 1989; likelihoods of Murphy 2000, expressions 11.1 to 11.6); twin of
//! `shaders/method/bayes.wgsl`.
//!
//! A cell keeps the pair that Murphy's book keeps, not normalised: the products of the likelihoods given occupied and given empty.
//! The logarithm of their ratio is the log odds, taken once, on the host: an update is two products. Their exponents go to a
//! word of their own before they can leave f32's range. The constant model, for lasers, needs nothing but the two counts that every method keeps: exact, whatever the order.

use super::settings::{Bayes, Likelihood, Settings};
use super::{Cost, Entry, LayerSpec, Method, Pass, Step};
use crate::grid::{Class, Scale};
use crate::kernels::cpu::{Job, Kernel, Plane, Reached, walk};
use crate::layout::{COUNT, Cone, Frame};
use crate::profile::{ONE_BITS, from_one, murphy, to_one};
use crate::sensor::Sensor;
use crate::snap::Snapped;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

/// The registry's line.
pub const ENTRY: Entry = Entry {
    name: "bayes",
    source: "Elfes 1989; Murphy 2000",
    about: "log odds of occupied from each reading's likelihoods",
    wgsl: include_str!("../../shaders/method/bayes.wgsl"),
    cost: Cost { flop: 23, int: 22 },
    groups: 8,
    make: |settings| match settings {
        Settings::Bayes(b) => Some(Box::new(b)),
        _ => None,
    },
};

/// P(s|·) is kept within these: certainty would leave no way back.
const LEAST: f64 = 0.02;
const MOST: f32 = 0.98;

/// The bits of a number's fraction.
const MANTISSA: i32 = 0x7f_ffff;

/// The products of a row's likelihoods.
#[derive(Debug, Clone, Copy)]
pub struct Cells<S: Simd> {
    /// Π P(s|occupied).
    occupied: f32x16<S>,
    /// Π P(s|empty).
    empty: f32x16<S>,
    /// The power of two by which `occupied` over `empty` is to be multiplied.
    scale: i32x16<S>,
}

/// P(s|occupied) on the arc (region I), P(s|empty) in the interior (region II), by Murphy's profile.
#[inline(always)]
fn likelihood<S: Simd>(frame: &Frame, near: f32x16<S>, arc: mask32x16<S>) -> f32x16<S> {
    let [[part_one, part_two, floor_one, floor_two], _] = frame.constants;
    let splat = |x: f32| f32x16::splat(near.token(), x);
    let part = arc.select(splat(part_one), splat(part_two));
    let floor = arc.select(splat(floor_one), splat(floor_two));
    (near * part).max(floor).min(MOST)
}

const fn layer(name: &'static str, about: &'static str, fill: f32, scale: Scale) -> LayerSpec {
    LayerSpec { name, about, fill, scale, integer: false }
}

/// The layers.
const LAYERS: &[LayerSpec] = &[
    layer("log_odds", "log odds of occupied", 0.0, Scale::Signed { limit: 6.0 }),
    layer("p_occ", "probability of occupied", 0.5, Scale::Grey { low: 0.0, high: 1.0 }),
    layer("p_emp", "probability of empty", 0.5, Scale::Grey { low: 0.0, high: 1.0 }),
];

impl Kernel for Bayes {
    type Cells<S: Simd> = Cells<S>;

    #[inline(always)]
    fn polar(&self) -> bool {
        self.model == Likelihood::Murphy
    }

    #[inline(always)]
    fn load<S: Simd>(simd: S, planes: &[Plane], row: usize) -> Cells<S> {
        let (occupied, empty) = (u32x16::load_array(simd, planes[0][row]), u32x16::load_array(simd, planes[1][row]));
        Cells {
            occupied: from_one(occupied),
            empty: from_one(empty),
            scale: u32x16::load_array(simd, planes[2][row]).bitcast(),
        }
    }

    #[inline(always)]
    fn store<S: Simd>(cells: Cells<S>, planes: &mut [Plane], row: usize) {
        to_one(cells.occupied).store_array(&mut planes[0][row]);
        to_one(cells.empty).store_array(&mut planes[1][row]);
        cells.scale.bitcast::<u32x16<S>>().store_array(&mut planes[2][row]);
    }

    #[inline(always)]
    fn fuse<S: Simd>(&self, frame: &Frame, cone: &Cone, row: &Reached<S>, _: &[u32; 4], cells: &mut Cells<S>) {
        if self.model == Likelihood::Constant {
            return;
        }
        let (d, turn) = (row.distance, row.turn);
        let p = likelihood(frame, murphy(cone.profile[0], d, turn), row.arc);
        let other = f32x16::splat(p.token(), 1.0) - p;
        let member = row.interior | row.arc;
        let occupied = cells.occupied * row.arc.select(p, other);
        let empty = cells.empty * row.arc.select(other, p);
        cells.occupied = member.select(occupied, cells.occupied);
        cells.empty = member.select(empty, cells.empty);
    }

    #[inline(always)]
    fn settle<S: Simd>(&self, cells: &mut Cells<S>) {
        let (occupied, empty) = (cells.occupied.bitcast::<i32x16<S>>(), cells.empty.bitcast::<i32x16<S>>());
        cells.scale = cells.scale + (occupied >> 23) - (empty >> 23);
        cells.occupied = ((occupied & MANTISSA) | ONE_BITS.cast_signed()).bitcast();
        cells.empty = ((empty & MANTISSA) | ONE_BITS.cast_signed()).bitcast();
    }
}

impl Method for Bayes {
    fn settings(&self) -> Settings {
        Settings::Bayes(*self)
    }

    fn planes(&self) -> usize {
        3
    }

    fn sweeps(&self) -> &'static [&'static [Step]] {
        &[&[Step::Pass(Pass::Fuse, COUNT)]]
    }

    fn constants(&self) -> [[f32; 4]; 2] {
        let floor = |p: f64| p.max(LEAST);
        let [one, two] = [floor(self.region_one_floor), floor(self.region_two_floor)];
        [[0.5 * self.max_occ, 0.5, one, two].map(|v| v as f32), [0.0; 4]]
    }

    fn variant(&self) -> Option<(&'static str, bool)> {
        Some(("CONSTANT", self.model == Likelihood::Constant))
    }

    fn profile(&self, sensor: &Sensor, _: &Snapped) -> [f32; 4] {
        [(1.0 / sensor.r_max) as f32, 0.0, 0.0, 0.0]
    }

    fn layers(&self) -> Vec<LayerSpec> {
        LAYERS.to_vec()
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        let logit = |p: f64| (p / (1.0 - p)).ln();
        let odds = match self.model {
            Likelihood::Murphy => {
                let [occupied, empty] = [words[2], words[3]].map(|word| f64::from(f32::from_bits(word ^ ONE_BITS)));
                (occupied / empty).ln() + f64::from(words[4].cast_signed()) * std::f64::consts::LN_2
            }
            Likelihood::Constant => f64::from(words[1]) * logit(self.p_hit) + f64::from(words[0]) * logit(self.p_miss),
        };
        let p = 1.0 / (1.0 + (-odds).exp());
        layers.copy_from_slice(&[odds, p, 1.0 / (1.0 + odds.exp())].map(|v| v as f32));
        if words[0] + words[1] == 0 {
            Class::Unknown
        } else if p > self.p_occupied {
            Class::Occupied
        } else if p < self.p_empty {
            Class::Empty
        } else {
            Class::Unknown
        }
    }

    fn combined(&self, layers: &[f32], _: Class) -> f32 {
        layers[1] - layers[2]
    }

    fn run(&self, pass: Pass, job: &Job, state: &mut [u32]) {
        walk(self, pass, job, state);
    }
}
