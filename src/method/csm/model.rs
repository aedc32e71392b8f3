//! The four counting sensor models as methods: their registry entries, the parameters of the kernels, and the layers from a
//! cell's words.

use super::layers::{self, Dirichlet, MOST};
use super::{MARKS, complete};
use crate::Result;
use crate::geometry::layout::COUNT;
use crate::grid::Class;
use crate::method::driver::{Job, WrongInput, walk_scans};
use crate::method::settings::{Csm, Settings};
use crate::method::{Completed, Cost, Entry, Evidence, Input, LayerSpec, LogFacts, Method, Pass, Spread, Step};

const WGSL: &str = include_str!("../../../shaders/method/csm.wgsl");
const DOHERTY: &str = "Doherty, Shan, Wang & Englot 2019; Gan et al. 2020";

/// Operations with which a beam updates a cell, as in `csm.rs`. The choice of poses and beams is not included: it is most of the
/// work, but belongs to no update.
const COUNTED: Cost = Cost { flop: 10, int: 12 };
/// Operations of an update with two kernels.
const SPREAD: Cost = Cost { flop: 87, int: 10 };

const fn entry(
    name: &'static str,
    about: &'static str,
    cost: Cost,
    make: fn(Settings) -> Option<Box<dyn Method>>,
) -> Entry {
    Entry { name, source: DOHERTY, about, wgsl: WGSL, cost, vec4s_per_thread: 1, make }
}

/// The registry entry of the plain counting model.
pub const DISCRETE: Entry = entry(
    "csm-discrete",
    "counts of hits and of passes of the nearest beams of the 16 nearest poses",
    COUNTED,
    |settings| model(settings, false, false),
);
/// The registry entry of the plain kernel model.
pub const CONTINUOUS: Entry = entry(
    "csm-continuous",
    "the same, spread by a sparse kernel of 0.2 m: no hole between beams",
    SPREAD,
    |settings| model(settings, true, false),
);
/// The registry entry of the counting model with class labels.
pub const SEMANTIC_DISCRETE: Entry =
    entry("csm-semantic-discrete", "counts of hits of each class and of passes: labelled logs", COUNTED, |settings| {
        model(settings, false, true)
    });
/// The registry entry of the kernel model with class labels.
pub const SEMANTIC_CONTINUOUS: Entry = entry(
    "csm-semantic-continuous",
    "hits of each class and passes, spread by the kernel: labelled logs",
    SPREAD,
    |settings| model(settings, true, true),
);

fn model(settings: Settings, continuous: bool, semantic: bool) -> Option<Box<dyn Method>> {
    match settings {
        Settings::Csm(csm) if (csm.continuous, csm.semantic) == (continuous, semantic) => Some(Box::new(Model(csm))),
        _ => None,
    }
}

/// One of the four models.
#[derive(Debug, Clone, Copy)]
struct Model(Csm);

/// The largest increment that does not count as an update. Such increments touch a cell only where their sum is larger than this.
const LEAST: f64 = 1e-6;

impl Model {
    /// Number of planes of α, which follow the marks.
    fn alphas(&self) -> usize {
        match (self.0.continuous, self.0.semantic) {
            (true, _) => 1 + self.0.labels(),
            (false, true) => self.0.labels(),
            (false, false) => 0,
        }
    }

    /// The increments of α for labels 1, 2, … and, last, for "free", and the number of increments.
    fn increments(&self, words: &[u32]) -> ([f64; MOST], usize) {
        let labels = self.0.labels();
        let (mut all, float) = ([0.0; MOST], |w: u32| f64::from(f32::from_bits(w)));
        for k in 0..labels {
            all[k] = match (self.0.continuous, self.0.semantic) {
                (true, _) => float(words[4 + k]),
                (false, true) => f64::from(words[3 + k]),
                (false, false) => f64::from(words[1]),
            };
        }
        all[labels] = if self.0.continuous { float(words[3]) } else { f64::from(words[0]) };
        (all, labels + 1)
    }
}

impl Method for Model {
    fn settings(&self) -> Settings {
        Settings::Csm(self.0)
    }

    fn input(&self, resolution: f64) -> Input {
        let labels = if self.0.semantic { self.0.labels() } else { 0 };
        Input::Scans { selection: self.0.selection(resolution), labels }
    }

    fn spread(&self) -> Spread {
        match self.0.continuous {
            true => Spread { beside: self.0.l, half_width: 0.0 },
            false => Spread { beside: self.0.w_obstacle.unwrap_or(0.0) / 2.0, half_width: self.0.w_beam / 2.0 },
        }
    }

    fn complete(&self, log: &LogFacts) -> Result<Completed> {
        complete::complete(self.0, log)
    }

    fn marks(&self) -> Option<usize> {
        Some(MARKS)
    }

    fn evidence(&self) -> Evidence {
        Evidence::magnitude("what the beam that the cell takes gives to its α")
    }

    fn planes(&self) -> usize {
        1 + self.alphas()
    }

    fn sweeps(&self) -> &'static [&'static [Step]] {
        &[&[Step::Pass(Pass::Fuse, COUNT)]]
    }

    fn constants(&self) -> [[f32; 4]; 2] {
        [[(1e-6 / self.0.l) as f32, self.0.sigma0 as f32, 0.0, 0.0], [0.0; 4]]
    }

    fn limits(&self, resolution: f64) -> [i32; 4] {
        let micrometres = |metres: f64| (metres * 1e6).round() as i32;
        let csm = &self.0;
        let second = if csm.continuous { reach(csm) } else { csm.half_obstacle(resolution) };
        [micrometres(csm.z_max), second, micrometres(csm.step), micrometres(csm.l)]
    }

    fn declarations(&self) -> String {
        let Csm { continuous, semantic, free, neighbours, .. } = self.0;
        let n = neighbours.unwrap_or(0);
        format!(
            "const CONTINUOUS: bool = {continuous};\nconst SEMANTIC: bool = {semantic};\n\
             const FREE_RULE: u32 = {}u;\nconst NEIGHBOURS: u32 = {n}u;\nconst HELD: u32 = {}u;\nconst PLANES: u32 = {}u;\n\
             const ALPHAS: u32 = {}u;",
            free as u32,
            n.max(1),
            3 + self.alphas(),
            self.alphas().max(1),
        )
    }

    fn layers(&self) -> Vec<LayerSpec> {
        layers::specs(&self.0)
    }

    fn has_subthreshold_evidence(&self, words: &[u32]) -> bool {
        self.0.continuous && words[3..].iter().map(|w| f64::from(f32::from_bits(*w))).sum::<f64>() > LEAST
    }

    fn gains(&self, words: &[u32], sums: &mut Vec<f64>) {
        let (increments, classes) = self.increments(words);
        crate::method::add(&increments[..classes], sums);
    }

    fn values(&self, words: &[u32], layers: &mut [f32]) -> Class {
        let (increments, classes) = self.increments(words);
        Dirichlet::of(&self.0, &increments[..classes]).values(layers)
    }

    fn combined(&self, layers: &[f32], class: Class) -> f32 {
        match class {
            Class::Unknown => 0.0,
            _ => 2.0 * layers[0] - 1.0,
        }
    }

    fn run(&self, _: Pass, job: &Job, state: &mut [u32]) -> std::result::Result<(), WrongInput> {
        walk_scans(&self.0, job, state)
    }
}

/// The distance from which on the kernel is at most 10⁻⁶, µm. Increments at smaller distances count as updates.
pub fn reach(csm: &Csm) -> i32 {
    let k = |micrometres: i32| {
        let s = (1.0 - f64::from(micrometres) * 1e-6 / csm.l).max(0.0);
        let turn = std::f64::consts::TAU * s;
        csm.sigma0 * ((2.0 + turn.cos()) / 3.0 * s - turn.sin() / std::f64::consts::TAU)
    };
    let (mut near, mut far) = (0, (csm.l * 1e6).round() as i32);
    while near < far {
        let middle = near + (far - near) / 2;
        if k(middle) > LEAST { near = middle + 1 } else { far = middle }
    }
    near
}
