//! Counting sensor models, a cell at a time: its nearest poses of the whole log, and of each the beam nearest in bearing.
//!
//! Integers of 128 bits decide, µm and directions of length 2²⁵; values are f64, with the bound of a kernel in f32.

mod beam;
mod cell;

pub(super) use cell::has_subthreshold_evidence;

use super::bound::U;
use super::{OracleLayer, OracleMap};
use crate::binning::scan::Scan;
use crate::grid::GridSpec;
use crate::method::csm::ALPHA;
use crate::method::settings::Csm;
use beam::{SnappedScan, Vector, dot, nearest_beam, round, snap_scan};
use cell::{BeamAtCell, DirichletCell, MIN_INCREMENT};
use rayon::prelude::*;

/// The largest difference of two α that counts as a tie.
const TIE: f64 = 1e-6;

/// The beams that update a cell (column, row), one of each of its nearest poses, in log order: the scan's index, and the beam's in it.
pub fn contributing_beams(
    grid: &GridSpec,
    scans: &[Scan],
    csm: &Csm,
    (column, row): (usize, usize),
) -> Vec<(usize, usize)> {
    let snapped: Vec<SnappedScan> = scans.iter().map(|s| snap_scan(s, csm)).collect();
    nearest_beams(grid, &snapped, csm, (column, row)).into_iter().map(|(scan, beam, _)| (scan, beam)).collect()
}

/// What one beam contributes to a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamContribution {
    /// The scan's index, and the beam's in it.
    pub beam: (usize, usize),
    /// The increment of each α: labels, then "free".
    pub gained: Vec<f64>,
    /// Whether it counts as an update: as free, as occupied.
    pub counted: [bool; 2],
}

/// The contribution of each beam to a cell (column, row), in log order.
pub fn beam_contributions(grid: &GridSpec, scans: &[Scan], csm: &Csm, at: (usize, usize)) -> Vec<BeamContribution> {
    let snapped: Vec<SnappedScan> = scans.iter().map(|s| snap_scan(s, csm)).collect();
    let mut cell = DirichletCell::new(csm.labels() + 1);
    let contribution = |(scan, beam, v): (usize, usize, Vector)| {
        let (alpha, before) = (cell.alpha.clone(), [cell.interior, cell.arc]);
        cell.apply(csm, grid.resolution, &BeamAtCell { index: (scan, beam), beam: &snapped[scan].beams[beam], v });
        BeamContribution {
            beam: (scan, beam),
            gained: cell.alpha.iter().zip(alpha).map(|(after, before)| after - before).collect(),
            counted: [before[0] != cell.interior, before[1] != cell.arc],
        }
    };
    nearest_beams(grid, &snapped, csm, at).into_iter().map(contribution).collect()
}

/// The beams that update a cell (column, row), in log order: scan, beam, and the cell's centre from the scan's pose, µm.
fn nearest_beams(
    grid: &GridSpec,
    snapped: &[SnappedScan],
    csm: &Csm,
    at: (usize, usize),
) -> Vec<(usize, usize, Vector)> {
    let farthest = round(csm.z_max * 1e6).pow(2);
    let (x, y) = grid.centre(at.0, at.1);
    let centre = [round(x * 1e6), round(y * 1e6)];
    let from = |p: &SnappedScan| [centre[0] - p.pose[0], centre[1] - p.pose[1]];
    let mut near: Vec<(i128, usize)> = snapped.iter().enumerate().map(|(k, p)| (dot(from(p), from(p)), k)).collect();
    if let Some(n) = csm.neighbours.map(usize::from).filter(|n| *n < near.len()) {
        near.select_nth_unstable(n);
        near.truncate(n);
    }
    near.retain(|(d, _)| *d > 0 && *d < farthest);
    near.sort_by_key(|(_, scan)| *scan);
    let beam = |(_, scan): (i128, usize)| {
        let v = from(&snapped[scan]);
        (scan, nearest_beam(&snapped[scan].beams, v), v)
    };
    near.into_iter().map(beam).collect()
}

/// The map of a log's scans, in their order, by a counting sensor model.
pub fn map_scans(grid: &GridSpec, scans: &[Scan], csm: &Csm) -> OracleMap {
    let snapped: Vec<SnappedScan> = scans.iter().map(|s| snap_scan(s, csm)).collect();
    let start = DirichletCell::new(csm.labels() + 1);
    let cell = |k: usize| {
        let mut cell = start.clone();
        for (scan, beam, v) in nearest_beams(grid, &snapped, csm, (k % grid.width, k / grid.width)) {
            cell.apply(csm, grid.resolution, &BeamAtCell { index: (scan, beam), beam: &snapped[scan].beams[beam], v });
        }
        cell
    };
    let cells: Vec<DirichletCell> = (0..grid.cells()).into_par_iter().map(cell).collect();
    finish(grid, csm, cells)
}

fn finish(grid: &GridSpec, csm: &Csm, cells: Vec<DirichletCell>) -> OracleMap {
    let classes = csm.labels() + 1;
    let names = ["mean", "variance", "label"].into_iter().chain(ALPHA).take(3 + classes);
    let mut layers: Vec<OracleLayer> =
        names.map(|name| OracleLayer { name, values: Vec::new(), bound: Vec::new() }).collect();
    let (mut class, mut ambiguous) = (Vec::new(), Vec::new());
    for cell in &cells {
        let mut cell = cell.clone();
        let gained = cell.alpha.iter().sum::<f64>();
        let seen = cell.is_touched();
        // A kernel may decide otherwise whether the cell is touched.
        let unsure_touch =
            cell.interior + cell.arc == 0 && (gained - MIN_INCREMENT).abs() <= cell.bound.iter().sum::<f64>();
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
        let mean_bound = 2.0 * off / sum + 2.0 * U;
        let label_bound = if off > 0.0 && (edge || (decided == 1 && rival)) { classes as f64 } else { 0.0 };
        let values = [
            (labels.iter().sum::<f64>() / sum, mean_bound),
            (p * (1.0 - p) / (sum + 1.0), (mean_bound + off) / (sum + 1.0) + 2.0 * U),
            (label, label_bound),
        ];
        let alphas = alpha.iter().zip(&cell.bound).map(|(a, b)| (*a, b + U * (a + b)));
        // Added where a kernel may decide otherwise: α change by what they gained, the others to any value.
        let flip =
            |k: usize| if unsure_touch { [1.0, 1.0, classes as f64, 2.0 * MIN_INCREMENT][k.min(3)] } else { 0.0 };
        for (k, (layer, (value, bound))) in layers.iter_mut().zip(values.into_iter().chain(alphas)).enumerate() {
            layer.values.push(value);
            layer.bound.push(bound + flip(k));
        }
        class.push(if seen { decided } else { 0 });
        ambiguous.push(unsure_touch || (off > 0.0 && edge));
    }
    let of = |f: fn(&DirichletCell) -> u32| cells.iter().map(f).collect::<Vec<u32>>();
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
