//! The feature-based grid, an update at a time: which parts of an update apply to each cell, in 128-bit integers (`canvas`); values
//! in f64, with the bound of a kernel in f32.

mod canvas;

use super::bayes::{LogOdds, likelihood};
use super::bound::{BoundedValue, U};
use super::cone::{Cone, Rule, Vector};
use super::{OracleMap, Region, UpdateCounts};
use crate::feature::Update;
use crate::grid::GridSpec;
use crate::log::reading::Outcome;
use crate::method::settings::{Bayes, Features, Settings};
use crate::sensor::Sensor;
use crate::{Error, Result};
use canvas::{Canvas, snap};

/// P(occupied) on a feature's lines; in its free region it is 1 − this.
const P_LINE: f64 = 0.8;
/// No P(occupied) of an update is below this or above 1 − this.
const CLAMP: f64 = 0.02;
/// Roundings of the weighted sum: two of each term (its weight, its product), and a half in each of three sums below 1.
const TERM: f64 = 2.0 * U;
const SUMS: f64 = 2.0 * U;

/// A cell's code, the parts of an update that apply to it: bits of the first part's lines and free region, of the second's, of the
/// cone's arc and interior, and of the limits of the routine part.
const LINES: [u8; 2] = [1, 4];
const FREE_REGIONS: [u8; 2] = [2, 8];
const ARC: u8 = 16;
const INTERIOR: u8 = 32;
const FREE_LIMIT: u8 = 64;
const ARC_LIMIT: u8 = 128;

/// A cell that an update changes.
struct CodedCell {
    /// Row-major index into the grid.
    index: usize,
    code: u8,
    /// Centre − sensor, for the profiles of the routine part.
    v: Vector,
}

/// An update with its cells.
struct RasterizedUpdate {
    /// The cone of the routine part.
    cone: Option<Cone>,
    cells: Vec<CodedCell>,
    /// Whether it has lines or an arc, in the grid or not.
    may_occupy: bool,
}

/// Finds the cells of an update, exactly.
fn rasterize(grid: &GridSpec, sensors: &[Sensor], update: &Update) -> Result<RasterizedUpdate> {
    let (reading, index) = (&update.reading, update.reading.record.sensor);
    let sensor = sensors.get(index as usize).ok_or_else(|| {
        let (line, known) = (reading.record.line, sensors.len());
        Error::Usage(format!("the update of line {line} names sensor {index}, of {known}"))
    })?;
    let pose = reading.record.pose;
    let at = snap(grid, (pose.x, pose.y));
    let mut all = vec![at];
    let limits = update.routine.iter().flat_map(|r| [&r.free, &r.arc]);
    let fans = update.parts.iter().map(|p| &p.free).chain(limits).flatten();
    all.extend(fans.flat_map(|f| &f.vertices).map(|v| snap(grid, (v.x, v.y))));
    all.extend(update.parts.iter().flat_map(|p| &p.occupied).flatten().map(|v| snap(grid, (v.x, v.y))));
    let mut cone = None;
    if update.routine.is_some() {
        let rule = if sensor.narrow() { Rule::Narrow } else { Rule::Cone };
        let made = Cone::new(grid, sensor, reading, rule, None)?;
        let outer = i128::from(made.outer()) + 1;
        all.extend([[at[0] - outer, at[1] - outer], [at[0] + outer, at[1] + outer]]);
        cone = Some(made);
    }
    let extreme = |k: usize, pick: fn(i128, i128) -> i128| all.iter().map(|p| p[k]).fold(at[k], pick);
    let low = [0, 1].map(|k| extreme(k, i128::min) - 32);
    let high = [0, 1].map(|k| extreme(k, i128::max) + 32);
    let mut canvas = Canvas::new(grid, low, high);
    for (k, part) in update.parts.iter().enumerate() {
        part.free.iter().for_each(|fan| canvas.fan(FREE_REGIONS[k], at, fan));
        part.occupied.iter().for_each(|ends| canvas.line(LINES[k], ends.map(|p| (p.x, p.y))));
    }
    let mut may_occupy = update.parts.iter().any(|p| !p.occupied.is_empty());
    if let (Some(routine), Some(cone)) = (&update.routine, &cone) {
        routine.free.iter().for_each(|fan| canvas.fan(FREE_LIMIT, at, fan));
        routine.arc.iter().for_each(|fan| canvas.fan(ARC_LIMIT, at, fan));
        may_occupy |= routine.occupies && reading.outcome == Outcome::Hit;
        let mut cells = Vec::new();
        cone.cells(grid, &mut cells);
        for cell in cells {
            let (column, row) = (cell.index % grid.width, cell.index / grid.width);
            let here = (row - canvas.rows.start) * canvas.columns.len() + column - canvas.columns.start;
            let code = &mut canvas.codes[here];
            *code |= match cell.region {
                Region::Interior if routine.free.is_none() || *code & FREE_LIMIT != 0 => INTERIOR,
                Region::Arc if routine.occupies && (routine.arc.is_none() || *code & ARC_LIMIT != 0) => ARC,
                _ => 0,
            };
        }
    }
    let (mut found, width) = (Vec::new(), canvas.columns.len());
    for (k, bits) in canvas.codes.iter().enumerate() {
        let mut code = bits & !(FREE_LIMIT | ARC_LIMIT);
        for part in 0..2 {
            if code & LINES[part] != 0 {
                code &= !FREE_REGIONS[part];
            }
        }
        if code != 0 {
            let (column, row) = (canvas.columns.start + k % width, canvas.rows.start + k / width);
            let v = [(grid.i0, column, at[0]), (grid.j0, row, at[1])]
                .map(|(first, n, at)| (32 * (i128::from(first) + n as i128) + 16 - at) as i64);
            found.push(CodedCell { index: row * grid.width + column, code, v: (v[0], v[1]) });
        }
    }
    Ok(RasterizedUpdate { cone, cells: found, may_occupy })
}

/// P(occupied) of a cell given an update, with a kernel's bound.
fn weigh(update: &Update, settings: &Bayes, rasterized: &RasterizedUpdate, cell: &CodedCell) -> BoundedValue {
    let mut sum = BoundedValue { value: 0.5, bound: SUMS };
    for (k, part) in update.parts.iter().enumerate() {
        let p = if cell.code & LINES[k] != 0 {
            P_LINE
        } else if cell.code & FREE_REGIONS[k] != 0 {
            1.0 - P_LINE
        } else {
            continue;
        };
        sum.value += part.weight * (p - 0.5);
        sum.bound += TERM * part.weight;
    }
    if let (Some(routine), Some(cone), true) = (&update.routine, &rasterized.cone, cell.code & (ARC | INTERIOR) != 0) {
        let region = if cell.code & ARC != 0 { Region::Arc } else { Region::Interior };
        let p = likelihood(settings, cone, region, cone.polar(cell.v));
        sum.value += routine.weight * (p.value - 0.5);
        sum.bound += routine.weight * (p.bound + TERM);
    }
    BoundedValue { value: sum.value.clamp(CLAMP, 1.0 - CLAMP), bound: sum.bound }
}

/// The mark of an update with a cell's code, the same as the kernels'.
fn mark(number: u64, code: u8) -> u32 {
    let mixed = ((number as u32).wrapping_mul(0x9e37_79b1) ^ u32::from(code)).wrapping_mul(0x85eb_ca6b);
    (mixed ^ (mixed >> 15)).wrapping_mul(0xc2b2_ae35)
}

/// The map of a log's updates, in their order, by the feature-based grid.
///
/// # Errors
/// The updates' own; [`Error::Usage`] for an update without its sensor or a finite pose, or other settings.
pub fn map_updates(
    grid: &GridSpec,
    sensors: &[Sensor],
    updates: impl Iterator<Item = Result<Update>>,
    settings: &Settings,
) -> Result<OracleMap> {
    let Settings::Features(features) = settings else {
        return Err(Error::Usage("only the feature-based grid takes updates: see map".into()));
    };
    let Features { max_occ, p_occupied, p_empty, .. } = *features;
    let bayes = Bayes { max_occ, p_occupied, p_empty, ..Bayes::default() };
    let (mut odds, mut counts, mut marks) =
        (LogOdds::new(grid.cells()), UpdateCounts::new(grid.cells()), vec![0u32; grid.cells()]);
    for update in updates {
        let update = update?;
        let rasterized = rasterize(grid, sensors, &update)?;
        let mut occupied = 0;
        for cell in &rasterized.cells {
            let on_arc = cell.code & (LINES[0] | LINES[1] | ARC) != 0;
            let region = if on_arc { &mut counts.arc } else { &mut counts.interior };
            region[cell.index] += 1;
            occupied += usize::from(on_arc);
            marks[cell.index] = marks[cell.index].wrapping_add(mark(update.number, cell.code));
            odds.add(&bayes, cell.index, weigh(&update, &bayes, &rasterized, cell));
        }
        counts.updates += rasterized.cells.len() as u64;
        counts.outside += u64::from(rasterized.cells.is_empty());
        counts.empty_arc += u64::from(!rasterized.cells.is_empty() && occupied == 0 && rasterized.may_occupy);
    }
    Ok(super::assemble(grid, odds.finish(&bayes, &counts), counts, marks))
}

/// Whether an update changes a cell (column, row).
///
/// # Errors
/// As [`map_updates`].
pub fn update_touches(
    grid: &GridSpec,
    sensors: &[Sensor],
    update: &Update,
    (column, row): (usize, usize),
) -> Result<bool> {
    let wanted = row * grid.width + column;
    Ok(rasterize(grid, sensors, update)?.cells.iter().any(|cell| cell.index == wanted))
}
