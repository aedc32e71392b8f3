//! Counting sensor models, a cell at a time: its nearest poses out of all, of each the nearest beam out of all.
//!
//! Integers of 128 bits decide, µm and directions of length 2²⁵; values are f64, with the bound of a kernel in f32.

mod beam;
mod cell;

pub(super) use cell::is_faint;

use super::bound::U;
use super::{OracleLayer, OracleMap};
use crate::binning::scan::Scan;
use crate::grid::GridSpec;
use crate::method::csm::ALPHA;
use crate::method::settings::Csm;
use beam::{Place, Vector, dot, nearest, place, round};
use cell::{Cell, LEAST};
use rayon::prelude::*;

/// α no farther apart are a tie.
const TIE: f64 = 1e-6;

/// The beams that speak of a cell, one of each of its nearest poses, in log order: scan and beam.
pub fn beams_of(grid: &GridSpec, scans: &[Scan], csm: &Csm, (column, row): (usize, usize)) -> Vec<(usize, usize)> {
    let places: Vec<Place> = scans.iter().map(|s| place(s, csm)).collect();
    chosen(grid, &places, csm, (column, row)).into_iter().map(|(scan, beam, _)| (scan, beam)).collect()
}

/// What a chosen beam gave to a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// The scan, and the beam in it.
    pub beam: (usize, usize),
    /// What each α gained: labels, then "free".
    pub gained: Vec<f64>,
    /// Whether it counts as an update of free space, and of an obstacle.
    pub counted: [bool; 2],
}

/// What each of the beams that speak of a cell gave to it, in log order.
pub fn given(grid: &GridSpec, scans: &[Scan], csm: &Csm, at: (usize, usize)) -> Vec<Given> {
    let places: Vec<Place> = scans.iter().map(|s| place(s, csm)).collect();
    let mut cell = Cell::new(csm.labels() + 1);
    let give = |(scan, beam, v): (usize, usize, Vector)| {
        let (alpha, before) = (cell.alpha.clone(), [cell.interior, cell.arc]);
        cell.see(csm, grid.resolution, scan, (beam, &places[scan].beams[beam]), v);
        Given {
            beam: (scan, beam),
            gained: cell.alpha.iter().zip(alpha).map(|(after, before)| after - before).collect(),
            counted: [before[0] != cell.interior, before[1] != cell.arc],
        }
    };
    chosen(grid, &places, csm, at).into_iter().map(give).collect()
}

/// The beams that speak of a cell, with its place from each pose, µm.
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
    let start = Cell::new(csm.labels() + 1);
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

fn finish(grid: &GridSpec, csm: &Csm, cells: Vec<Cell>) -> OracleMap {
    let classes = csm.labels() + 1;
    let names = ["mean", "variance", "label"].into_iter().chain(ALPHA).take(3 + classes);
    let mut layers: Vec<OracleLayer> =
        names.map(|name| OracleLayer { name, values: Vec::new(), bound: Vec::new() }).collect();
    let (mut class, mut ambiguous) = (Vec::new(), Vec::new());
    for cell in &cells {
        let mut cell = cell.clone();
        let gained = cell.alpha.iter().sum::<f64>();
        let seen = cell.is_touched();
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
        touched: cells.iter().filter(|c| c.is_touched()).count() as u64,
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
