//! The readings that reached a cell, to explain a difference.

use super::report::ReadingRef;
use crate::binning::scan::Scan;
use crate::binning::snap::Edges;
use crate::feature::Update;
use crate::log::reading::Reading;
use crate::method::Unit;
use crate::method::settings::{Csm, Settings};
use crate::oracle::{self, contributing_beams, updated_cells};
use crate::pipeline::session::Session;
use crate::{Error, Result};

/// How many of a cell's last readings are named.
const LAST: usize = 3;

/// All of a session's items, in the form that its method takes.
pub(super) enum CellReadings {
    /// Readings, with the edges of their wedges where they have them.
    Readings(Vec<Reading>, Option<Vec<Edges>>),
    /// Scans, and the parameters of the counting sensor model.
    Scans(Vec<Scan>, Csm),
    /// Updates of features.
    Updates(Vec<Update>),
}

impl CellReadings {
    /// Reads a session's log.
    pub fn of(session: &Session) -> Result<CellReadings> {
        Ok(match (session.method.unit(), session.method.settings()) {
            (Unit::Reading, _) => {
                let (readings, wedges) = session.all_readings()?;
                CellReadings::Readings(readings, wedges)
            }
            (Unit::Scan, Settings::Csm(csm)) => CellReadings::Scans(session.scans()?.collect::<Result<_>>()?, csm),
            (Unit::Scan, _) => {
                return Err(Error::Resources("a method that takes scans is no counting sensor model".into()));
            }
            (Unit::Update, _) => CellReadings::Updates(session.updates(usize::MAX)?.0),
        })
    }

    /// The last readings that reached a cell, the last first.
    pub fn last(&self, session: &Session, column: usize, row: usize) -> Result<Vec<ReadingRef>> {
        match self {
            CellReadings::Readings(readings, wedges) => {
                last_readings(session, readings, wedges.as_deref(), [column, row])
            }
            CellReadings::Scans(scans, csm) => Ok(last_beams(session, scans, csm, [column, row])),
            CellReadings::Updates(updates) => last_updates(session, updates, [column, row]),
        }
    }
}

fn last_readings(
    session: &Session,
    readings: &[Reading],
    wedges: Option<&[Edges]>,
    [column, row]: [usize; 2],
) -> Result<Vec<ReadingRef>> {
    let (grid, settings) = (&session.grid, session.method.settings());
    let (x, y) = grid.centre(column, row);
    let mut last = Vec::new();
    for (k, reading) in readings.iter().enumerate().rev() {
        let sensor = &session.sensors()[reading.record.sensor as usize];
        let pose = reading.record.pose;
        let reach = reading.range + sensor.epsilon(grid.resolution) + 3.0 * grid.resolution;
        if (x - pose.x).hypot(y - pose.y) > reach {
            continue;
        }
        let cells = updated_cells(grid, sensor, reading, &settings, wedges.map(|w| w[k]))?;
        if cells.iter().any(|c| (c.column, c.row) == (column, row)) {
            last.push(ReadingRef { line: reading.record.line, sensor: sensor.id.clone(), range: reading.range });
            if last.len() == LAST {
                break;
            }
        }
    }
    Ok(last)
}

fn last_beams(session: &Session, scans: &[Scan], csm: &Csm, [column, row]: [usize; 2]) -> Vec<ReadingRef> {
    let beams = contributing_beams(&session.grid, scans, csm, (column, row));
    let reading = |(scan, beam): &(usize, usize)| {
        let ray = &scans[*scan].rays[*beam];
        let (sensor, line) = ray.source;
        let sensor = session.sensors()[sensor as usize].id.clone();
        ReadingRef { line, sensor, range: ray.range.unwrap_or(f64::INFINITY) }
    };
    beams.iter().rev().take(LAST).map(reading).collect()
}

fn last_updates(session: &Session, updates: &[Update], [column, row]: [usize; 2]) -> Result<Vec<ReadingRef>> {
    let mut last = Vec::new();
    for update in updates.iter().rev() {
        let Reading { record, range, .. } = update.reading;
        if oracle::update_touches(&session.grid, session.sensors(), update, (column, row))? {
            let sensor = session.sensors()[record.sensor as usize].id.clone();
            last.push(ReadingRef { line: record.line, sensor, range });
            if last.len() == LAST {
                break;
            }
        }
    }
    Ok(last)
}
