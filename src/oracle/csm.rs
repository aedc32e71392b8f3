//! Counting sensor models, a cell at a time: its nearest poses out of all, of each the nearest beam out of all.
//!
//! Integers of 128 bits decide, µm and directions of length 2²⁵; values are f64, with the bound of a kernel in f32.

use super::bound::U;
use super::{OracleLayer, OracleMap};
use crate::grid::GridSpec;
use crate::method::settings::{Csm, FreeRule};
use crate::scan::Scan;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Length of a direction.
const LENGTH: f64 = 33_554_432.0;
/// Increments of no more than this don't touch a cell.
const LEAST: f64 = 1e-6;
/// α no farther apart are a tie.
const TIE: f64 = 1e-6;
/// Relative error of a kernel in f32, given its argument: its polynomial's, and the five products about it.
const KERNEL: f64 = 40.0 * U;
/// Absolute error of d/l: the root of a sum of squares, the product with 1/l; and what is cut off below 1/1024 µm.
const ARGUMENT: f64 = 16.0 * U;

type Vector = [i128; 2];

fn cross(a: Vector, b: Vector) -> i128 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Vector, b: Vector) -> i128 {
    a[0] * b[0] + a[1] * b[1]
}

fn round(v: f64) -> i128 {
    (v + 0.5).floor() as i128
}

/// A beam: its direction, and its hit if it has one.
struct Beam {
    unit: Vector,
    right: Vector,
    left: Vector,
    hit: Option<(Vector, i128)>,
    label: usize,
}

/// A pose and its beams, in the log's order.
struct Place {
    pose: Vector,
    beams: Vec<Beam>,
}

fn place(scan: &Scan, csm: &Csm) -> Place {
    let first = scan.rays.first().map(|r| (r.sensor.x, r.sensor.y));
    let one = scan.rays.iter().all(|r| Some((r.sensor.x, r.sensor.y)) == first);
    let (x, y) = first.filter(|_| one).unwrap_or((scan.robot.x, scan.robot.y));
    let pose = [round(x * 1e6), round(y * 1e6)];
    let beams = scan.rays.iter().map(|ray| {
        let (s, c) = ray.sensor.heading.sin_cos();
        let ends = ray.range.filter(|z| *z < csm.z_max).and_then(|z| {
            let hit = [round((ray.sensor.x + z * c) * 1e6) - pose[0], round((ray.sensor.y + z * s) * 1e6) - pose[1]];
            let range = if one { round(z * 1e6) } else { (dot(hit, hit) as f64).sqrt().round() as i128 };
            let far = hit.iter().any(|v| v.abs() >= 1 << 27) || hit == [0, 0];
            (!far).then_some((hit, range))
        });
        let along = ends.map_or([c, s], |(hit, _)| hit.map(|v| v as f64));
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        let unit = along.map(|v| round(v / length * LENGTH));
        let edge = |angle: f64| {
            let (s, c) = angle.sin_cos();
            let [x, y] = unit.map(|v| v as f64);
            [round(c * x - s * y), round(s * x + c * y)]
        };
        let hit = ends.filter(|(_, range)| *range < round(csm.z_max * 1e6));
        Beam { unit, right: edge(-csm.w_beam / 2.0), left: edge(csm.w_beam / 2.0), hit, label: usize::from(ray.label) }
    });
    Place { pose, beams: beams.collect() }
}

/// Whether `a` turns less far than `b` to reach `v`, counter-clockwise.
fn sooner(a: Vector, b: Vector, v: Vector) -> bool {
    // Less than half a turn, or more; then by the side on which one lies of the other.
    let half = |u: Vector| cross(u, v) < 0 || (cross(u, v) == 0 && dot(u, v) < 0);
    (half(a), cross(a, b)) < (half(b), 0)
}

/// The beam whose direction is nearest to `v`'s, the lower one of two that are as near.
fn nearest(beams: &[Beam], v: Vector) -> usize {
    // The beam to the right of v, and the one to its left: those with the least turns to v and from it.
    let turn = |better: &dyn Fn(Vector, Vector) -> bool| {
        (1..beams.len()).fold(0, |best, k| if better(beams[k].unit, beams[best].unit) { k } else { best })
    };
    let right = turn(&|a, b| sooner(a, b, v));
    let mirror = |u: Vector| [u[0], -u[1]];
    let left = turn(&|a, b| sooner(mirror(a), mirror(b), mirror(v)));
    let (from, to) = (beams[right].unit, beams[left].unit);
    if from == to || cross(from, v) == 0 && dot(from, v) > 0 {
        return right.min(if from == to { left } else { right });
    }
    let sum = [from[0] + to[0], from[1] + to[1]];
    let middle = if sum.iter().all(|s| s.abs() < 1 << 15) {
        [-from[1], from[0]]
    } else if cross(from, to) > 0 {
        sum
    } else {
        [-sum[0], -sum[1]]
    };
    match cross(middle, v).signum() {
        -1 => right,
        1 => left,
        _ if dot(middle, v) > 0 => right.min(left),
        _ => right,
    }
}

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
struct Cell {
    alpha: Vec<f64>,
    bound: Vec<f64>,
    interior: u32,
    arc: u32,
    marks: u32,
}

impl Cell {
    fn add(&mut self, class: usize, value: f64, bound: f64) {
        self.alpha[class] += value;
        // The sum rounds anew with each increment.
        self.bound[class] += bound + U * (self.alpha[class] + self.bound[class]);
    }

    /// What a beam says.
    fn see(&mut self, csm: &Csm, resolution: f64, scan: usize, (index, beam): (usize, &Beam), v: Vector) {
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
pub(super) fn is_faint(gains: &[f64]) -> bool {
    gains.iter().sum::<f64>() > LEAST
}

/// As the kernels mark a beam, label and all.
fn mark(scan: u32, id: u32) -> u32 {
    let mixed = (scan.wrapping_mul(0x9e37_79b1) ^ id).wrapping_mul(0x85eb_ca6b);
    (mixed ^ (mixed >> 15)).wrapping_mul(0xc2b2_ae35)
}

/// The beams that speak of a cell, one of each of its nearest poses, in log order: scan and beam.
pub fn beams_of(grid: &GridSpec, scans: &[Scan], csm: &Csm, (column, row): (usize, usize)) -> Vec<(usize, usize)> {
    let places: Vec<Place> = scans.iter().map(|s| place(s, csm)).collect();
    chosen(grid, &places, csm, (column, row)).into_iter().map(|(scan, beam, _)| (scan, beam)).collect()
}

/// The same with the cell's place from the pose, µm.
fn chosen(grid: &GridSpec, places: &[Place], csm: &Csm, at: (usize, usize)) -> Vec<(usize, usize, Vector)> {
    let farthest = round(csm.z_max * 1e6).pow(2);
    let (x, y) = grid.centre(at.0, at.1);
    let centre = [round(x * 1e6), round(y * 1e6)];
    let from = |p: &Place| [centre[0] - p.pose[0], centre[1] - p.pose[1]];
    let mut near: Vec<(i128, usize)> = places.iter().enumerate().map(|(k, p)| (dot(from(p), from(p)), k)).collect();
    if let Some(n) = csm.neighbours.map(usize::from).filter(|n| *n < near.len()) {
        near.select_nth_unstable(n);
        near.truncate(n);
    }
    near.retain(|(d, _)| *d > 0 && *d < farthest);
    near.sort_by_key(|(_, scan)| *scan);
    let beam = |(_, scan): (i128, usize)| {
        let v = from(&places[scan]);
        (scan, nearest(&places[scan].beams, v), v)
    };
    near.into_iter().map(beam).collect()
}

/// The map of a log's scans, in their order, by a counting sensor model.
pub fn map_scans(grid: &GridSpec, scans: &[Scan], csm: &Csm) -> OracleMap {
    let places: Vec<Place> = scans.iter().map(|s| place(s, csm)).collect();
    let start =
        Cell { alpha: vec![0.0; csm.labels() + 1], bound: vec![0.0; csm.labels() + 1], interior: 0, arc: 0, marks: 0 };
    let cell = |k: usize| {
        let mut cell = start.clone();
        for (scan, beam, v) in chosen(grid, &places, csm, (k % grid.width, k / grid.width)) {
            cell.see(csm, grid.resolution, scan, (beam, &places[scan].beams[beam]), v);
        }
        cell
    };
    let cells: Vec<Cell> = (0..grid.cells()).into_par_iter().map(cell).collect();
    finish(grid, csm, cells)
}

/// Names of the layers of α.
const ALPHA: [&str; 33] = [
    "alpha_1", "alpha_2", "alpha_3", "alpha_4", "alpha_5", "alpha_6", "alpha_7", "alpha_8", "alpha_9", "alpha_10",
    "alpha_11", "alpha_12", "alpha_13", "alpha_14", "alpha_15", "alpha_16", "alpha_17", "alpha_18", "alpha_19",
    "alpha_20", "alpha_21", "alpha_22", "alpha_23", "alpha_24", "alpha_25", "alpha_26", "alpha_27", "alpha_28",
    "alpha_29", "alpha_30", "alpha_31", "alpha_32", "alpha_33",
];

fn finish(grid: &GridSpec, csm: &Csm, cells: Vec<Cell>) -> OracleMap {
    let classes = csm.labels() + 1;
    let names = ["mean", "variance", "label"].into_iter().chain(ALPHA).take(3 + classes);
    let mut layers: Vec<OracleLayer> =
        names.map(|name| OracleLayer { name, values: Vec::new(), bound: Vec::new() }).collect();
    let (mut class, mut ambiguous) = (Vec::new(), Vec::new());
    for cell in &cells {
        let mut cell = cell.clone();
        let gained = cell.alpha.iter().sum::<f64>();
        let seen = cell.interior + cell.arc > 0 || is_faint(&cell.alpha);
        // A kernel may find it touched, or not, otherwise than here.
        let wavers = cell.interior + cell.arc == 0 && (gained - LEAST).abs() <= cell.bound.iter().sum::<f64>();
        if !seen {
            cell.alpha.fill(0.0);
            cell.bound.fill(0.0);
        }
        let alpha: Vec<f64> = cell.alpha.iter().map(|a| a + csm.prior).collect();
        let (sum, off) = (alpha.iter().sum::<f64>(), cell.bound.iter().sum::<f64>());
        let (labels, free) = (&alpha[..classes - 1], alpha[classes - 1]);
        let top = labels.iter().copied().fold(f64::MIN, f64::max);
        let best = labels.iter().position(|a| *a == top).unwrap_or(0);
        let decided = if top - free > TIE { 1 } else { -i8::from(free - top > TIE) };
        // Near a tie, with free or between labels, a kernel may decide otherwise.
        let edge = ((top - free).abs() - TIE).abs() <= cell.bound[best] + cell.bound[classes - 1];
        let rival = labels
            .iter()
            .enumerate()
            .any(|(k, a)| k != best && top - a <= cell.bound[best] + cell.bound[k] && off > 0.0);
        let p = top.max(free) / sum;
        let label = match decided {
            1 => best as f64 + 1.0,
            -1 => classes as f64,
            _ => 0.0,
        };
        // A quotient of sums: each off by no more than `off`; then to f32.
        let share = 2.0 * off / sum + 2.0 * U;
        let unsure = if off > 0.0 && (edge || (decided == 1 && rival)) { classes as f64 } else { 0.0 };
        let values = [
            (labels.iter().sum::<f64>() / sum, share),
            (p * (1.0 - p) / (sum + 1.0), (share + off) / (sum + 1.0) + 2.0 * U),
            (label, unsure),
        ];
        let alphas = alpha.iter().zip(&cell.bound).map(|(a, b)| (*a, b + U * (a + b)));
        // What a flip changes: every α by what it gained, the rest to any value.
        let flip = |k: usize| if wavers { [1.0, 1.0, classes as f64, 2.0 * LEAST][k.min(3)] } else { 0.0 };
        for (k, (layer, (value, bound))) in layers.iter_mut().zip(values.into_iter().chain(alphas)).enumerate() {
            layer.values.push(value);
            layer.bound.push(bound + flip(k));
        }
        class.push(if seen { decided } else { 0 });
        ambiguous.push(wavers || (off > 0.0 && edge));
    }
    let of = |f: fn(&Cell) -> u32| cells.iter().map(f).collect::<Vec<u32>>();
    let (interior, arc) = (of(|c| c.interior), of(|c| c.arc));
    OracleMap {
        grid: *grid,
        layers,
        class,
        ambiguous,
        touched: cells.iter().filter(|c| c.interior + c.arc > 0 || is_faint(&c.alpha)).count() as u64,
        gains: cells.iter().map(|c| c.alpha.clone()).collect(),
        updates: interior.iter().chain(&arc).map(|n| u64::from(*n)).sum(),
        marks: cells.iter().map(|c| c.marks).collect(),
        interior,
        arc,
        outside: 0,
        empty_arc: 0,
        wide: 0,
    }
}
