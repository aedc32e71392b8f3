//! Proves the backends equal on a user's own log: each against the f64 oracle, cell by cell.
//!
//! Membership must not differ in a single cell; every layer must keep within the bound that the oracle derives for each
//! cell; a class may differ only where the cell stands on a decision boundary, within those bounds.

use crate::Result;
use crate::binning::scan::Scan;
use crate::binning::snap::Edges;
use crate::feature::Update;
use crate::log::reading::Reading;
use crate::method::Unit;
use crate::method::settings::Settings;
use crate::oracle::{self, OracleMap, beams_of, cells_of};
use crate::pipeline::finished::Finished;
use crate::pipeline::session::Session;
use crate::support::wrapped::wrapped;
use serde::Serialize;
use std::fmt;

/// A cell that is worth a look.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// Column, from the left.
    pub column: usize,
    /// Row, from the bottom.
    pub row: usize,
    /// World x of its centre, metres.
    pub x: f64,
    /// World y of its centre, metres.
    pub y: f64,
    /// The oracle's value.
    pub oracle: f64,
    /// The backend's.
    pub value: f64,
    /// How far they are apart.
    pub difference: f64,
    /// How far they may be.
    pub bound: f64,
    /// The last readings that reached it, the last first.
    pub last_readings: Vec<LastReading>,
}

/// A reading that reached a cell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LastReading {
    /// Its line of the log; the beams of a laser scan share one.
    pub line: u64,
    /// Its sensor.
    pub sensor: String,
    /// Its range R, metres.
    pub range: f64,
}

/// One layer of one backend against the oracle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerCheck {
    /// The layer.
    pub layer: String,
    /// Its largest difference.
    pub largest: f64,
    /// The bound where it is.
    pub bound: f64,
    /// Cells beyond their bound: must be 0.
    pub beyond: u64,
    /// The cell of the largest difference; none where all are equal.
    pub largest_cell: Option<Cell>,
    /// The cell that comes nearest to its bound, or is farthest beyond it; none where all are equal.
    pub worst: Option<Cell>,
}

/// One backend against the oracle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BackendCheck {
    /// cpu or gpu.
    pub backend: String,
    /// What it ran on.
    pub adapter: String,
    /// Cells whose interior or arc updates differ in number: must be 0.
    pub membership: u64,
    /// The first of them.
    pub membership_cell: Option<Cell>,
    /// Readings counted otherwise (outside, empty_arc, wide): must be 0.
    pub counts: u64,
    /// Each layer.
    pub layers: Vec<LayerCheck>,
    /// Cells whose class differs.
    pub class: u64,
    /// Of those, cells that do not stand on a decision boundary: must be 0.
    pub class_wrong: u64,
    /// Cell updates.
    pub updates: u64,
    /// Seconds from the log to the map.
    pub seconds: f64,
    /// Whether all that must hold does.
    pub passed: bool,
}

/// What `verify` found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verification {
    /// The method.
    pub method: String,
    /// Readings mapped.
    pub readings: u64,
    /// Cells of the grid: columns, rows.
    pub size: [usize; 2],
    /// Cell updates by the oracle.
    pub updates: u64,
    /// The oracle's seconds.
    pub oracle_seconds: f64,
    /// Each backend.
    pub backends: Vec<BackendCheck>,
    /// Whether cpu and gpu gave the same bytes in every layer, where both ran.
    pub same_bytes: Option<bool>,
    /// Backends that were asked for and could not run, and why: what they would have given isn't known.
    pub skipped: Vec<String>,
    /// Backends that the method doesn't have, and why.
    pub absent: Vec<String>,
    /// Whether every backend that was asked for, and that the method has, ran and passed.
    pub passed: bool,
}

/// Checks a backend's map against the oracle's. `wrong_counts`: readings that the two counted otherwise.
pub fn check(
    session: &Session,
    oracle: &OracleMap,
    finished: &Finished,
    backend: (&str, String),
    wrong_counts: u64,
    seconds: f64,
) -> Result<BackendCheck> {
    let visits = &finished.visits;
    let seen = Seen::of(session)?;
    let cell = |k: usize, oracle: f64, value: f64, bound: f64| -> Result<Cell> {
        let (column, row) = (k % session.grid.width, k / session.grid.width);
        let (x, y) = session.grid.centre(column, row);
        let last_readings = last_readings(session, &seen, column, row)?;
        Ok(Cell { column, row, x, y, oracle, value, difference: apart(oracle, value), bound, last_readings })
    };
    let differs = |k: &usize| {
        let marks = visits.marks.get(*k) != oracle.marks.get(*k);
        visits.interior[*k] != oracle.interior[*k] || visits.arc[*k] != oracle.arc[*k] || marks
    };
    let members: Vec<usize> = (0..oracle.grid.cells()).filter(differs).collect();
    let total = |interior: u32, arc: u32| f64::from(interior) + f64::from(arc);
    let membership_cell = members
        .first()
        .map(|&k| cell(k, total(oracle.interior[k], oracle.arc[k]), total(visits.interior[k], visits.arc[k]), 0.0))
        .transpose()?;
    let mut layers = Vec::new();
    for reference in &oracle.layers {
        let data = finished.map.layer(reference.name).map(|l| &l.data);
        let ours = |k: usize| data.map_or(f64::NAN, |d| d.get(k));
        // The cell of the largest difference, and of the largest share of its bound: that, and which cell.
        let (mut largest, mut nearest) = ((0.0, None), (0.0, None));
        let mut beyond = 0;
        for (k, (&value, &bound)) in reference.values.iter().zip(&reference.bound).enumerate() {
            let difference = apart(value, ours(k));
            beyond += u64::from(difference > bound);
            if difference > largest.0 {
                largest = (difference, Some(k));
            }
            let share = if difference == 0.0 { 0.0 } else { difference / bound };
            if share > nearest.0 {
                nearest = (share, Some(k));
            }
        }
        let explain =
            |k: Option<usize>| k.map(|k| cell(k, reference.values[k], ours(k), reference.bound[k])).transpose();
        layers.push(LayerCheck {
            layer: reference.name.into(),
            largest: largest.0,
            bound: largest.1.map_or(0.0, |k| reference.bound[k]),
            beyond,
            largest_cell: explain(largest.1)?,
            worst: explain(nearest.1)?,
        });
    }
    let (mut class, mut class_wrong) = (0, 0);
    let classes = finished.map.layer("class").map(|l| &l.data);
    for (k, &reference) in oracle.class.iter().enumerate() {
        if classes.map_or(f64::NAN, |d| d.get(k)) != f64::from(reference) {
            class += 1;
            class_wrong += u64::from(!oracle.ambiguous[k]);
        }
    }
    let passed = members.is_empty() && wrong_counts == 0 && class_wrong == 0 && layers.iter().all(|l| l.beyond == 0);
    Ok(BackendCheck {
        backend: backend.0.into(),
        adapter: backend.1,
        membership: members.len() as u64,
        membership_cell,
        counts: wrong_counts,
        layers,
        class,
        class_wrong,
        updates: finished.map.updates,
        seconds,
        passed,
    })
}

/// How far two values are apart; what is not a number is beyond every bound.
fn apart(a: f64, b: f64) -> f64 {
    let difference = (a - b).abs();
    if difference.is_nan() { f64::INFINITY } else { difference }
}

/// Whether two maps hold the same bytes.
pub fn same_bytes(a: &Finished, b: &Finished) -> bool {
    let same = |k: usize| {
        let (a, b) = (&a.map.layers[k].data, &b.map.layers[k].data);
        a.len() == b.len() && (0..a.len()).all(|k| a.get(k).to_bits() == b.get(k).to_bits())
    };
    a.map.layers.len() == b.map.layers.len() && (0..a.map.layers.len()).all(same) && a.visits == b.visits
}

/// A session's readings, to say which of them reached a cell.
struct Seen {
    readings: Vec<Reading>,
    wedges: Option<Vec<Edges>>,
    /// For a method that takes scans.
    scans: Option<Vec<Scan>>,
    /// For a method that takes updates.
    updates: Vec<Update>,
}

impl Seen {
    fn of(session: &Session) -> Result<Seen> {
        let mut seen = Seen { readings: Vec::new(), wedges: None, scans: None, updates: Vec::new() };
        match session.method.unit() {
            Unit::Reading => (seen.readings, seen.wedges) = session.all()?,
            Unit::Scan => seen.scans = Some(session.scans()?.collect::<Result<_>>()?),
            Unit::Update => seen.updates = session.updates(usize::MAX)?.0,
        }
        Ok(seen)
    }
}

/// The last three readings that reached a cell, the last first.
fn last_readings(
    session: &Session,
    Seen { readings, wedges, scans, updates }: &Seen,
    column: usize,
    row: usize,
) -> Result<Vec<LastReading>> {
    const LAST: usize = 3;
    if let (Settings::Csm(csm), Some(scans)) = (session.method.settings(), scans) {
        let beams = beams_of(&session.grid, scans, &csm, (column, row));
        let reading = |(scan, beam): &(usize, usize)| {
            let ray = &scans[*scan].rays[*beam];
            let (sensor, line) = ray.source;
            let sensor = session.sensors()[sensor as usize].id.clone();
            LastReading { line, sensor, range: ray.range.unwrap_or(f64::INFINITY) }
        };
        return Ok(beams.iter().rev().take(LAST).map(reading).collect());
    }
    let (x, y) = session.grid.centre(column, row);
    let mut last = Vec::new();
    for update in updates.iter().rev() {
        let Reading { record, range, .. } = update.reading;
        if oracle::reaches(&session.grid, session.sensors(), update, (column, row))? {
            let sensor = session.sensors()[record.sensor as usize].id.clone();
            last.push(LastReading { line: record.line, sensor, range });
            if last.len() == LAST {
                break;
            }
        }
    }
    for (k, reading) in readings.iter().enumerate().rev() {
        let sensor = &session.sensors()[reading.record.sensor as usize];
        let pose = reading.record.pose;
        let reach = reading.range + sensor.epsilon(session.grid.resolution) + 3.0 * session.grid.resolution;
        if (x - pose.x).hypot(y - pose.y) > reach {
            continue;
        }
        let wedge = wedges.as_ref().map(|w| w[k]);
        let cells = cells_of(&session.grid, sensor, reading, &session.method.settings(), wedge)?;
        if cells.iter().any(|c| (c.column, c.row) == (column, row)) {
            last.push(LastReading { line: reading.record.line, sensor: sensor.id.clone(), range: reading.range });
            if last.len() == LAST {
                break;
            }
        }
    }
    Ok(last)
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Cell { column, row, x, y, oracle, value, difference, bound, .. } = self;
        write!(f, "cell ({column}, {row}) at ({x:.3}, {y:.3}) m: oracle {oracle:.9}, here {value:.9}, ")?;
        write!(f, "difference {difference:.3e}, bound {bound:.3e}")?;
        let last: Vec<String> = self
            .last_readings
            .iter()
            .map(|r| format!("line {} sensor {} ({:.2} m)", r.line, r.sensor, r.range))
            .collect();
        if !last.is_empty() {
            write!(f, "; last readings: {}", last.join(", "))?;
        }
        Ok(())
    }
}

impl Verification {
    /// Whether a backend and the oracle differ.
    pub fn differs(&self) -> bool {
        self.backends.iter().any(|b| !b.passed)
    }

    /// The result in a line.
    fn verdict(&self) -> String {
        let ran: Vec<&str> = self.backends.iter().map(|b| b.backend.as_str()).collect();
        match (self.differs(), self.skipped.is_empty()) {
            (true, _) => "NOT EQUAL".into(),
            (false, true) => "equal".into(),
            (false, false) => {
                format!("NOT VERIFIED: only oracle and {} were compared, and are equal", ran.join(" and "))
            }
        }
    }
}

impl fmt::Display for Verification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        let (method, readings, updates) = (&self.method, self.readings, self.updates);
        writeln!(f, "{method}: {readings} readings, {width} × {height} cells, {updates} cell updates")?;
        writeln!(f, "oracle  f64, one reading at a time ({:.2} s)", self.oracle_seconds)?;
        for b in &self.backends {
            let ran = format!("{:<7} {} ({:.2} s)", b.backend, b.adapter, b.seconds);
            writeln!(f, "{}", wrapped(&ran, 8))?;
            writeln!(f, "  cells that other readings reach  {}", b.membership)?;
            if let Some(cell) = &b.membership_cell {
                writeln!(f, "{}", wrapped(&format!("    the first: {cell}"), 6))?;
            }
            if b.counts > 0 {
                writeln!(f, "  readings counted otherwise  {}", b.counts)?;
            }
            for l in &b.layers {
                let beyond =
                    if l.beyond > 0 { format!("  {} CELLS BEYOND THEIR BOUND", l.beyond) } else { String::new() };
                writeln!(
                    f,
                    "  {:<10} largest difference {:.3e}, bound there {:.3e}{beyond}",
                    l.layer, l.largest, l.bound
                )?;
                match (&l.largest_cell, &l.worst) {
                    (Some(a), Some(b)) if a == b => {
                        writeln!(f, "{}", wrapped(&format!("    largest, nearest to its bound: {a}"), 6))?;
                    }
                    (a, b) => {
                        for (what, cell) in [("largest", a), ("nearest to its bound", b)] {
                            if let Some(cell) = cell {
                                writeln!(f, "{}", wrapped(&format!("    {what}: {cell}"), 6))?;
                            }
                        }
                    }
                }
            }
            let boundary = if b.class > 0 {
                format!(", {} of them on a decision boundary", b.class - b.class_wrong)
            } else {
                String::new()
            };
            writeln!(f, "  cells whose class differs  {}{boundary}", b.class)?;
        }
        if let Some(same) = self.same_bytes {
            writeln!(f, "cpu and gpu: {}", if same { "the same bytes in every layer" } else { "not the same bytes" })?;
        }
        for why in &self.absent {
            writeln!(f, "{}", wrapped(why, 2))?;
        }
        for why in &self.skipped {
            writeln!(f, "{}", wrapped(&format!("SKIPPED {why}"), 2))?;
        }
        write!(f, "{}", self.verdict())
    }
}
