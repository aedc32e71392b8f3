//! Bayesian occupancy grid (Elfes 1989; likelihoods of Murphy 2000, expressions 11.1 to 11.6); twin of
//! `shaders/method/bayes.wgsl`.
//!
//! A cell keeps the log odds of occupied. Murphy's profile needs a logarithm a cell update, its main cost. The constant model,
//! for lasers, needs nothing but the two counts that every method keeps: exact, whatever the order.

use super::settings::{Bayes, Likelihood, Settings};
use super::{Cost, Entry, LayerSpec, Method, Pass, Step};
use crate::cone::Row;
use crate::grid::{Class, Scale};
use crate::kernels::cpu::{Job, Kernel, walk};
use crate::layout::{COUNT, Cone, Frame, TILE};
use crate::profile::{log, max, min, murphy, polar};
use crate::sensor::Sensor;
use crate::snap::Snapped;

/// The registry's line.
pub const ENTRY: Entry = Entry {
    name: "bayes",
    source: "Elfes 1989; Murphy 2000",
    about: "log odds of occupied from each reading's likelihoods",
    wgsl: include_str!("../../shaders/method/bayes.wgsl"),
    cost: Cost { flop: 45, int: 22 },
    make: |settings| match settings {
        Settings::Bayes(b) => Some(Box::new(b)),
        _ => None,
    },
};

/// P(s|·) is kept within these: certainty would leave no way back.
const LEAST: f32 = 0.02;
const MOST: f32 = 0.98;

/// What a reading adds to the log odds of occupied, by Murphy's profile.
#[inline(always)]
fn evidence(frame: &Frame, near: f32, arc: bool) -> f32 {
    let [max_occ, floor_one, floor_two, _] = frame.constants[0];
    // Region I: P(s|occupied); region II: P(s|empty).
    let p = if arc { max(near * max_occ, floor_one) } else { max(near, floor_two) };
    let p = min(max(p, LEAST), MOST);
    let l = log(p / (1.0 - p));
    if arc { l } else { -l }
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
    type Cells = [f32; TILE];

    #[inline(always)]
    fn load(planes: &[[u32; TILE]], row: usize) -> [f32; TILE] {
        planes[row].map(f32::from_bits)
    }

    #[inline(always)]
    fn store(cells: &[f32; TILE], planes: &mut [[u32; TILE]], row: usize) {
        planes[row] = cells.map(f32::to_bits);
    }

    #[inline(always)]
    fn fuse(&self, frame: &Frame, cone: &Cone, row: &Row, _: &[u32; 4], odds: &mut [f32; TILE]) {
        if self.model == Likelihood::Constant {
            return;
        }
        let (d, turn) = polar(frame, cone, row);
        for k in 0..TILE {
            let l = evidence(frame, murphy(cone.profile[0], d[k], turn[k]), row.arc[k] != 0);
            odds[k] += if row.interior[k] | row.arc[k] != 0 { l } else { 0.0 };
        }
    }
}

impl Method for Bayes {
    fn settings(&self) -> Settings {
        Settings::Bayes(*self)
    }

    fn start(&self) -> &'static [u32] {
        &[0]
    }

    fn sweeps(&self) -> &'static [&'static [Step]] {
        &[&[Step::Pass(Pass::Fuse, COUNT)]]
    }

    fn constants(&self) -> [[f32; 4]; 2] {
        [[self.max_occ, self.region_one_floor, self.region_two_floor, 0.0].map(|v| v as f32), [0.0; 4]]
    }

    fn variant(&self) -> Option<(&'static str, bool)> {
        Some(("CONSTANT", self.model == Likelihood::Constant))
    }

    fn profile(&self, sensor: &Sensor, _: &Snapped) -> [f32; 4] {
        [(1.0 / sensor.r_max) as f32, 0.0, 0.0, 0.0]
    }

    fn layers(&self) -> &'static [LayerSpec] {
        LAYERS
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        let logit = |p: f64| (p / (1.0 - p)).ln();
        let odds = match self.model {
            Likelihood::Murphy => f64::from(f32::from_bits(words[2])),
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
