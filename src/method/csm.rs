//! Counting sensor models (Doherty, Shan, Wang & Englot 2019; Gan et al. 2020): a Dirichlet over classes in each cell, from
//! the beams of its nearest poses; twin of `shaders/method/csm.wgsl`.
//!
//! A cell's words count free and occupied increments, sum marks of the beams they came from, and hold the increments
//! of α: counts, or sums of the sparse kernel (Melkumyan & Ramos 2009).

mod layers;

use super::settings::{Csm, FreeRule, Settings};
use super::{Cost, Entry, LayerSpec, Method, Pass, Step, Unit};
use crate::grid::Class;
use crate::kernels::cpu::{Job, Plane, walk_scans};
use crate::layout::{Beam, COUNT, Frame, IDLE, UNIT, YIELD};
use crate::scan::cross;
use layers::{Dirichlet, MOST};

const WGSL: &str = include_str!("../../shaders/method/csm.wgsl");
const DOHERTY: &str = "Doherty, Shan, Wang & Englot 2019; Gan et al. 2020";

const fn entry(name: &'static str, about: &'static str, make: fn(Settings) -> Option<Box<dyn Method>>) -> Entry {
    Entry { name, source: DOHERTY, about, wgsl: WGSL, cost: Cost { flop: 30, int: 60 }, groups: 1, make }
}

/// The registry's line of the plain counting model.
pub const DISCRETE: Entry =
    entry("csm-discrete", "counts of hits and of passes of the nearest beams of the 16 nearest poses", |settings| {
        model(settings, false, false)
    });
/// The registry's line of the plain kernel model.
pub const CONTINUOUS: Entry =
    entry("csm-continuous", "the same, spread by a sparse kernel of 0.2 m: no hole between beams", |settings| {
        model(settings, true, false)
    });
/// The registry's line of the counting model with class labels.
pub const SEMANTIC_DISCRETE: Entry =
    entry("csm-semantic-discrete", "counts of hits of each class and of passes: labelled logs", |settings| {
        model(settings, false, true)
    });
/// The registry's line of the kernel model with class labels.
pub const SEMANTIC_CONTINUOUS: Entry = entry(
    "csm-semantic-continuous",
    "hits of each class and passes, spread by the kernel: labelled logs",
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

/// Plane of the marks, after the two counts.
const MARKS: usize = 0;
/// Increments of no more than this together don't touch a cell.
const LEAST: f64 = 1e-6;

/// k(d)/σ0 = s⁵ Σ K[n] s²ⁿ with s = 1 − d/l, of Melkumyan & Ramos 2009: in s the kernel is odd and starts with s⁵, so that no
/// digits cancel where it ends. To 32 units of rounding.
const K: [f32; 9] = [
    8.658_586,
    -16.277_489,
    13.387_694,
    -6.406_328_7,
    2.026_378,
    -0.456_719_5,
    0.076_694_27,
    -0.009_528_071,
    0.000_712_918_5,
];

/// The kernel at a distance, µm.
#[inline(always)]
pub fn kernel(frame: &Frame, d: f32) -> f32 {
    let [per_l, sigma0, ..] = frame.constants[0];
    let s = (1.0 - d * per_l).max(0.0);
    let y = s * s;
    let mut sum = K[8];
    for n in (0..8).rev() {
        sum = sum * y + K[n];
    }
    sigma0 * ((y * y * s) * sum)
}

/// The dot product, exact while its result has 53 bits.
#[inline(always)]
fn dot(a: [i32; 2], v: [i32; 2]) -> f64 {
    f64::from(a[0]) * f64::from(v[0]) + f64::from(a[1]) * f64::from(v[1])
}

/// A cell's words while a beam updates it.
pub struct Cell<'a> {
    planes: &'a mut [Plane],
    at: [usize; 2],
}

impl Cell<'_> {
    /// The cell in this row and column of a tile.
    #[inline(always)]
    pub fn of(planes: &mut [Plane], row: usize, column: usize) -> Cell<'_> {
        Cell { planes, at: [row, column] }
    }

    #[inline(always)]
    fn add(&mut self, plane: usize, n: u32) {
        let word = &mut self.planes[plane][self.at[0]][self.at[1]];
        *word = word.wrapping_add(n);
    }

    #[inline(always)]
    fn add_float(&mut self, plane: usize, value: f32) {
        let word = &mut self.planes[plane][self.at[0]][self.at[1]];
        *word = (f32::from_bits(*word) + value).to_bits();
    }

    /// Notes which beam of which scan it was.
    #[inline(always)]
    fn mark(&mut self, scan: u32, beam: &Beam) {
        self.add(2 + MARKS, mark(scan, beam.id));
    }
}

/// A number that tells a beam of a scan from others, label and all.
#[inline(always)]
pub fn mark(scan: u32, id: u32) -> u32 {
    let mixed = (scan.wrapping_mul(0x9e37_79b1) ^ (id & !(IDLE | YIELD))).wrapping_mul(0x85eb_ca6b);
    (mixed ^ mixed >> 15).wrapping_mul(0xc2b2_ae35)
}

/// What the nearest beam of a scan says of a cell at `v` from its pose, `square` = v·v.
#[inline(always)]
pub fn update(csm: &Csm, frame: &Frame, scan: u32, beam: &Beam, v: [i32; 2], square: f64, mut cell: Cell) {
    if beam.id & IDLE != 0 {
        return;
    }
    if csm.continuous {
        continuous(csm, frame, scan, beam, v, &mut cell);
    } else {
        discrete(csm, frame, scan, beam, v, square, &mut cell);
    }
}

#[inline(always)]
fn discrete(csm: &Csm, frame: &Frame, scan: u32, beam: &Beam, v: [i32; 2], square: f64, cell: &mut Cell) {
    let [right, left] = beam.ray;
    if cross(right, v) < 0.0 || cross(left, v) > 0.0 {
        return;
    }
    let half = frame.limits[1];
    let (inner, outer) = (f64::from((beam.range - half).max(0)), f64::from(beam.range + half));
    let label = beam.id & 255;
    let before = square <= inner * inner;
    if !before && square < outer * outer {
        if label > 0 {
            cell.add(1, 1);
            cell.mark(scan, beam);
            if csm.semantic {
                cell.add(2 + label as usize, 1);
            }
        }
    } else if before {
        cell.add(0, 1);
        cell.mark(scan, beam);
    }
}

/// Units of a distance across a beam in a µm.
const FINE: f64 = 1024.0;

#[inline(always)]
fn continuous(csm: &Csm, frame: &Frame, scan: u32, beam: &Beam, v: [i32; 2], cell: &mut Cell) {
    let [unit, hit] = beam.ray;
    let [_, reach, step, l] = frame.limits;
    let along = dot(unit, v);
    if csm.free == FreeRule::Projection && along < 0.0 {
        return;
    }
    let mut marked = false;
    let label = beam.id & 255;
    let e = [v[0].wrapping_sub(hit[0]), v[1].wrapping_sub(hit[1])];
    if label > 0 && e[0].unsigned_abs().max(e[1].unsigned_abs()) < l as u32 {
        let [x, y] = e.map(|e| e as f32);
        let near =
            i64::from(e[0]) * i64::from(e[0]) + i64::from(e[1]) * i64::from(e[1]) < i64::from(reach) * i64::from(reach);
        cell.add_float(3 + label as usize, kernel(frame, (x * x + y * y).sqrt()));
        cell.add(1, u32::from(near));
        marked |= near;
    }
    // Across the beam in 1/1024 µm, along it in µm.
    let across = (cross(unit, v).abs() * (FINE / f64::from(UNIT))).floor();
    if across < f64::from(l) * FINE {
        let across = across as u32;
        let along_whole = (along / f64::from(UNIT)).floor() as i32;
        let mut free = |offset: i32| {
            let (p, o) = (across as f32 * (1.0 / FINE as f32), offset as f32);
            let p_whole = i64::from(across / FINE as u32);
            let near = p_whole * p_whole + i64::from(offset) * i64::from(offset) < i64::from(reach) * i64::from(reach);
            cell.add_float(3, kernel(frame, (p * p + o * o).sqrt()));
            cell.add(0, u32::from(near));
            marked |= near;
        };
        match csm.free {
            FreeRule::Projection if along <= f64::from(beam.range) * f64::from(UNIT) => free(0),
            FreeRule::Projection => {}
            FreeRule::Clamp => {
                let offset = along_whole - along_whole.clamp(0, (beam.range - l).max(0));
                if offset.abs() < l {
                    free(offset);
                }
            }
            FreeRule::Sample => {
                let first = (along_whole - l).max(0) / step;
                let last = (along_whole + l).min(beam.range);
                let mut k = first;
                while k * step <= last {
                    if (along_whole - k * step).abs() < l {
                        free(along_whole - k * step);
                    }
                    k += 1;
                }
            }
        }
    }
    if marked {
        cell.mark(scan, beam);
    }
}

impl Model {
    /// Planes of α after the marks.
    fn alphas(&self) -> usize {
        match (self.0.continuous, self.0.semantic) {
            (true, _) => 1 + self.0.labels(),
            (false, true) => self.0.labels(),
            (false, false) => 0,
        }
    }

    /// The increments of α of labels 1, 2, …, "free" last, and how many they are.
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

    fn unit(&self) -> Unit {
        Unit::Scan
    }

    fn marks(&self) -> Option<usize> {
        Some(MARKS)
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

    fn touched(&self, words: &[u32]) -> bool {
        self.increments(words).0.iter().sum::<f64>() > LEAST
    }

    fn gains(&self, words: &[u32], sums: &mut Vec<f64>) {
        let (increments, classes) = self.increments(words);
        crate::layers::add(&increments[..classes], sums);
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

    fn run(&self, _: Pass, job: &Job, state: &mut [u32]) {
        walk_scans(&self.0, job, state);
    }
}

/// The distance from which on the kernel is no more than [`LEAST`], µm: what is nearer touches a cell.
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
