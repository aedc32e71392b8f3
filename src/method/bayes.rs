//! Bayesian occupancy grid (Elfes 1989; likelihoods of Murphy 2000, expressions 11.1 to 11.6); twin of
//! `shaders/method/bayes.wgsl`.
//!
//! A cell keeps a pair of products (`odds`). The constant model, for lasers, needs only the two counts that every method keeps,
//! which are exact in any order.

use super::settings::{Bayes, Likelihood, Settings};
use super::{Completed, Cost, Entry, Evidence, LayerSpec, LogFacts, Method, Pass, Step, odds};
use crate::Result;
use crate::binning::snap::Snapped;
use crate::geometry::layout::{COUNT, Cone, Frame};
use crate::geometry::profile::murphy;
use crate::grid::Class;
use crate::method::driver::{Job, Kernel, Plane, Reached, WrongInput, walk};
use crate::sensor::{Kind, Sensor};
use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use odds::CellStates;

/// The registry entry.
pub const ENTRY: Entry = Entry {
    name: "bayes",
    source: "Elfes 1989; Murphy 2000",
    about: "log odds of occupied from each reading's likelihoods",
    wgsl: concat!(
        include_str!("../../shaders/method/odds.wgsl"),
        "\n",
        include_str!("../../shaders/method/bayes.wgsl")
    ),
    cost: Cost { flop: 23, int: 22 },
    vec4s_per_thread: 8,
    make: |settings| match settings {
        Settings::Bayes(b) => Some(Box::new(b)),
        _ => None,
    },
};

/// P(s|·) is at least this, and at most [`odds::MOST`].
const LEAST: f64 = 0.02;

impl Kernel for Bayes {
    type CellStates<S: Simd> = CellStates<S>;

    #[inline(always)]
    fn polar(&self) -> bool {
        self.likelihood() == Likelihood::Murphy
    }

    #[inline(always)]
    fn load<S: Simd>(simd: S, planes: &[Plane], row: usize) -> CellStates<S> {
        odds::load(simd, planes, row)
    }

    #[inline(always)]
    fn store<S: Simd>(cells: CellStates<S>, planes: &mut [Plane], row: usize) {
        odds::store(cells, planes, row);
    }

    #[inline(always)]
    fn fuse_cells<S: Simd>(
        &self,
        frame: &Frame,
        cone: &Cone,
        row: &Reached<S>,
        _: &[u32; 4],
        cells: &mut CellStates<S>,
    ) {
        if self.likelihood() == Likelihood::Constant {
            return;
        }
        let (d, turn) = (row.distance, row.turn);
        let p = odds::likelihood(frame, murphy(cone.profile[0], d, turn), row.arc);
        let other = f32x16::splat(p.token(), 1.0) - p;
        let member = row.interior | row.arc;
        let occupied = cells.occupied * row.arc.select(p, other);
        let empty = cells.empty * row.arc.select(other, p);
        cells.occupied = member.select(occupied, cells.occupied);
        cells.empty = member.select(empty, cells.empty);
    }

    #[inline(always)]
    fn renormalize<S: Simd>(&self, cells: &mut CellStates<S>) {
        odds::renormalize(cells);
    }
}

impl Method for Bayes {
    fn settings(&self) -> Settings {
        Settings::Bayes(*self)
    }

    /// Chooses the likelihoods that fit the sensors, unless the user did. A sonar's profile decreases towards its range and its edge;
    /// with it a laser would lose a part of its walls.
    fn complete(&self, log: &LogFacts) -> Result<Completed> {
        let lasers = log.sensors.iter().all(|s| s.kind == Kind::Laser);
        let fitting = if lasers { Likelihood::Constant } else { Likelihood::Murphy };
        let settings = Settings::Bayes(Bayes { model: Some(self.model.unwrap_or(fitting)), ..*self });
        Ok(Completed { settings, classes: None })
    }

    fn evidence(&self) -> Evidence {
        Evidence::probability("P(s|occupied)")
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
        Some(("CONSTANT", self.likelihood() == Likelihood::Constant))
    }

    fn profile(&self, sensor: &Sensor, _: &Snapped) -> [f32; 4] {
        [(1.0 / sensor.r_max) as f32, 0.0, 0.0, 0.0]
    }

    fn layers(&self) -> Vec<LayerSpec> {
        odds::LAYERS.to_vec()
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        let logit = |p: f64| (p / (1.0 - p)).ln();
        let odds = match self.likelihood() {
            Likelihood::Murphy => odds::log_odds(&words[2..]),
            Likelihood::Constant => f64::from(words[1]) * logit(self.p_hit) + f64::from(words[0]) * logit(self.p_miss),
        };
        match odds::values(odds, [self.p_occupied, self.p_empty], layers) {
            _ if words[0] + words[1] == 0 => Class::Unknown,
            class => class,
        }
    }

    fn combined(&self, layers: &[f32], _: Class) -> f32 {
        odds::combined(layers)
    }

    fn run(&self, pass: Pass, job: &Job, state: &mut [u32]) -> std::result::Result<(), WrongInput> {
        walk(self, pass, job, state)
    }
}
