//! The feature-based grid, an update at a time: who says what of each cell, in 128-bit integers; values in f64, with the bound of
//! a kernel in f32.

use super::bayes::{Odds, likelihood};
use super::bound::{Approx, U};
use super::cone::{Cone, Rule, Vector};
use super::{OracleMap, Region, Tally};
use crate::feature::{Fan, Update};
use crate::grid::GridSpec;
use crate::log::reading::Outcome;
use crate::method::settings::{Bayes, Features, Settings};
use crate::sensor::Sensor;
use crate::{Error, Result};
use std::ops::Range;

/// What a feature says of its lines and, the other way round, of what it frees: 0.8 and 0.2.
const SAYS: f64 = 0.8;
/// No P(occupied) of an update is below this or above 1 − this.
const CLAMP: f64 = 0.02;
/// Roundings of the weighted sum: two of each term (its weight, its product), and a half in each of three sums below 1.
const TERM: f64 = 2.0 * U;
const SUMS: f64 = 2.0 * U;

/// What is said of a cell: bits of the first part's lines and fan, of the second's, of the cone's arc and interior, and of the
/// routine part's limits.
const LINES: [u8; 2] = [1, 4];
const FREES: [u8; 2] = [2, 8];
const ARC: u8 = 16;
const INTERIOR: u8 = 32;
const FREE_LIMIT: u8 = 64;
const ARC_LIMIT: u8 = 128;

/// A vertex or a cell in units from the anchor.
type Place = [i128; 2];

fn cross(a: Place, b: Place) -> i128 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Place, b: Place) -> i128 {
    a[0] * b[0] + a[1] * b[1]
}

fn from(a: Place, b: Place) -> Place {
    [b[0] - a[0], b[1] - a[1]]
}

fn snap(grid: &GridSpec, (x, y): (f64, f64)) -> Place {
    [(x, grid.anchor.0), (y, grid.anchor.1)]
        .map(|(v, anchor)| (32.0 * (v - anchor) / grid.resolution + 0.5).floor() as i128)
}

/// The cells of a box of the grid, each with what is said of it.
struct Canvas<'a> {
    grid: &'a GridSpec,
    columns: Range<usize>,
    rows: Range<usize>,
    said: Vec<u8>,
}

/// The cells along an axis whose centres lie from `low` to `high`.
fn span(first: i64, count: usize, [low, high]: [i128; 2]) -> Range<usize> {
    let at = |v: i128| (v - 16).div_euclid(32) - i128::from(first);
    let within = |v: i128| v.clamp(0, count as i128) as usize;
    let (from, to) = (within(at(low)), within(at(high) + 2));
    from..to.max(from)
}

impl Canvas<'_> {
    fn new(grid: &GridSpec, low: Place, high: Place) -> Canvas<'_> {
        let (columns, rows) =
            (span(grid.i0, grid.width, [low[0], high[0]]), span(grid.j0, grid.height, [low[1], high[1]]));
        let said = vec![0; columns.len() * rows.len()];
        Canvas { grid, columns, rows, said }
    }

    /// Sets bits where a test on the centre holds, of the cells about some points.
    fn paint(&mut self, bits: u8, about: &[Place], holds: impl Fn(Place) -> bool) {
        let reach = |k: usize| {
            let all = || about.iter().map(|p| p[k]);
            [all().min().unwrap_or(0) - 32, all().max().unwrap_or(0) + 32]
        };
        let grid = self.grid;
        let (columns, rows) = (span(grid.i0, grid.width, reach(0)), span(grid.j0, grid.height, reach(1)));
        for row in rows.start.max(self.rows.start)..rows.end.min(self.rows.end) {
            for column in columns.start.max(self.columns.start)..columns.end.min(self.columns.end) {
                let centre = |first: i64, k: usize| 32 * (i128::from(first) + k as i128) + 16;
                if holds([centre(grid.i0, column), centre(grid.j0, row)]) {
                    let at = (row - self.rows.start) * self.columns.len() + column - self.columns.start;
                    self.said[at] |= bits;
                }
            }
        }
    }

    fn fan(&mut self, bits: u8, sensor: Place, fan: &Fan) {
        let vertices: Vec<Place> = fan.vertices.iter().map(|v| snap(self.grid, (v.x, v.y))).collect();
        for k in 1..vertices.len() {
            let [a, b] = [vertices[k - 1], vertices[k]];
            let (rays, last) = ([from(sensor, a), from(sensor, b)], k + 1 == vertices.len());
            if cross(rays[0], rays[1]) <= 0 {
                continue;
            }
            self.paint(bits, &[sensor, a, b], |centre| {
                let p = from(sensor, centre);
                let right = cross(p, rays[1]);
                cross(rays[0], p) >= 0 && (right > 0 || last && right == 0) && cross(from(a, b), from(a, centre)) >= 0
            });
        }
    }

    fn line(&mut self, bits: u8, ends: [Place; 2]) {
        let [a, b] = ends;
        let d = from(a, b);
        self.paint(bits, &[a, b], |centre| {
            let p = from(a, centre);
            match d {
                [0, 0] => dot(p, p) <= 24 * 24,
                _ => cross(d, p).abs() <= 16 * (d[0].abs() + d[1].abs()) && (0..=dot(d, d)).contains(&dot(d, p)),
            }
        });
    }
}

/// A cell that an update says something of.
struct Said {
    index: usize,
    code: u8,
    /// From the sensor, where the routine part says something.
    v: Vector,
}

/// An update as the oracle sees it.
struct Seen {
    cone: Option<Cone>,
    cells: Vec<Said>,
    may_occupy: bool,
}

fn see(grid: &GridSpec, sensors: &[Sensor], update: &Update) -> Result<Seen> {
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
        part.free.iter().for_each(|fan| canvas.fan(FREES[k], at, fan));
        part.occupied.iter().for_each(|ends| canvas.line(LINES[k], ends.map(|p| snap(grid, (p.x, p.y)))));
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
            let said = &mut canvas.said[here];
            *said |= match cell.region {
                Region::Interior if routine.free.is_none() || *said & FREE_LIMIT != 0 => INTERIOR,
                Region::Arc if routine.occupies && (routine.arc.is_none() || *said & ARC_LIMIT != 0) => ARC,
                _ => 0,
            };
        }
    }
    let (mut found, width) = (Vec::new(), canvas.columns.len());
    for (k, said) in canvas.said.iter().enumerate() {
        let mut code = said & !(FREE_LIMIT | ARC_LIMIT);
        for part in 0..2 {
            if code & LINES[part] != 0 {
                code &= !FREES[part];
            }
        }
        if code != 0 {
            let (column, row) = (canvas.columns.start + k % width, canvas.rows.start + k / width);
            let v = [(grid.i0, column, at[0]), (grid.j0, row, at[1])]
                .map(|(first, n, at)| (32 * (i128::from(first) + n as i128) + 16 - at) as i64);
            found.push(Said { index: row * grid.width + column, code, v: (v[0], v[1]) });
        }
    }
    Ok(Seen { cone, cells: found, may_occupy })
}

/// P(occupied) of a cell given an update, with a kernel's bound.
fn weigh(update: &Update, settings: &Bayes, seen: &Seen, cell: &Said) -> Approx {
    let mut sum = Approx { value: 0.5, bound: SUMS };
    for (k, part) in update.parts.iter().enumerate() {
        let says = if cell.code & LINES[k] != 0 {
            SAYS
        } else if cell.code & FREES[k] != 0 {
            1.0 - SAYS
        } else {
            continue;
        };
        sum.value += part.weight * (says - 0.5);
        sum.bound += TERM * part.weight;
    }
    if let (Some(routine), Some(cone), true) = (&update.routine, &seen.cone, cell.code & (ARC | INTERIOR) != 0) {
        let region = if cell.code & ARC != 0 { Region::Arc } else { Region::Interior };
        let p = likelihood(settings, cone, region, cone.polar(cell.v));
        sum.value += routine.weight * (p.value - 0.5);
        sum.bound += routine.weight * (p.bound + TERM);
    }
    Approx { value: sum.value.clamp(CLAMP, 1.0 - CLAMP), bound: sum.bound }
}

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
    let (mut odds, mut tally, mut marks) =
        (Odds::new(grid.cells()), Tally::new(grid.cells()), vec![0u32; grid.cells()]);
    for update in updates {
        let update = update?;
        let seen = see(grid, sensors, &update)?;
        let mut occupied = 0;
        for cell in &seen.cells {
            let on_arc = cell.code & (LINES[0] | LINES[1] | ARC) != 0;
            let counts = if on_arc { &mut tally.arc } else { &mut tally.interior };
            counts[cell.index] += 1;
            occupied += usize::from(on_arc);
            marks[cell.index] = marks[cell.index].wrapping_add(mark(update.number, cell.code));
            odds.add(&bayes, cell.index, weigh(&update, &bayes, &seen, cell));
        }
        tally.updates += seen.cells.len() as u64;
        tally.outside += u64::from(seen.cells.is_empty());
        tally.empty_arc += u64::from(!seen.cells.is_empty() && occupied == 0 && seen.may_occupy);
    }
    Ok(super::assemble(grid, odds.finish(&bayes, &tally), tally, marks))
}

/// Whether an update says something of a cell.
///
/// # Errors
/// As [`map_updates`].
pub fn reaches(grid: &GridSpec, sensors: &[Sensor], update: &Update, (column, row): (usize, usize)) -> Result<bool> {
    let wanted = row * grid.width + column;
    Ok(see(grid, sensors, update)?.cells.iter().any(|cell| cell.index == wanted))
}
