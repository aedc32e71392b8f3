//! The inputs of a whole log, in memory: readings, scans or updates, as the method takes them.

use super::stepped_scans::SteppedScans;
use crate::binning::scan::Scan;
use crate::feature::{StageResult, Update};
use crate::method::settings::Settings;
use crate::method::{self, Input, Unit};
use crate::pipeline::readings::ReadingInput;
use crate::pipeline::session::Session;
use crate::{Error, Result};

/// All inputs of a log, in order.
pub enum LogInputs {
    /// Readings.
    Readings(Vec<ReadingInput>),
    /// Readings for a method of several sweeps over the log, such as the certainty grid in the order of 1985: all free, then all occupy.
    SweptReadings(Vec<ReadingInput>),
    /// Scans, for a counting sensor model.
    Scans(Box<SteppedScans>),
    /// Updates of the feature stage, and the features of the whole log.
    Updates(Vec<Update>, Box<StageResult>),
}

impl LogInputs {
    /// The most memory that the inputs of a session take, bytes, with the share that is kept of each.
    pub fn memory(session: &Session) -> u64 {
        let each = if session.method.unit() == Unit::Update { 1024 } else { 32 + size_of::<ReadingInput>() as u64 };
        session.survey.counts.read * each
    }

    /// Reads all inputs of a session.
    ///
    /// # Errors
    /// The log's.
    pub fn read(session: &Session) -> Result<LogInputs> {
        match session.input() {
            // The oracle, which explains a cell, knows scans of the counting sensor models alone.
            Input::Scans { selection, .. } => match session.method.settings() {
                Settings::Csm(csm) => Ok(LogInputs::Scans(Box::new(SteppedScans::read(session, csm, selection)?))),
                _ => Err(Error::Usage(format!("{} can't be stepped", method::name(session.method.as_ref())))),
            },
            Input::Updates(_) => {
                let (updates, features) = session.updates(usize::MAX)?;
                Ok(LogInputs::Updates(updates, Box::new(features)))
            }
            Input::Readings => {
                let readings = session.readings()?.collect::<Result<_>>()?;
                let one_sweep = session.method.sweeps().len() == 1;
                Ok(if one_sweep { LogInputs::Readings(readings) } else { LogInputs::SweptReadings(readings) })
            }
        }
    }

    /// The number of inputs.
    pub fn len(&self) -> usize {
        match self {
            LogInputs::Readings(items) | LogInputs::SweptReadings(items) => items.len(),
            LogInputs::Scans(scans) => scans.all.len(),
            LogInputs::Updates(updates, _) => updates.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The reading of an input, with the edges of its wedge where it has them; `None` for a scan.
    pub fn reading(&self, k: usize) -> Option<ReadingInput> {
        match self {
            LogInputs::Readings(items) | LogInputs::SweptReadings(items) => items.get(k).copied(),
            LogInputs::Updates(updates, _) => updates.get(k).map(|u| (u.reading, None)),
            LogInputs::Scans(_) => None,
        }
    }

    /// The `k`-th update; `None` for other inputs.
    pub fn update(&self, k: usize) -> Option<&Update> {
        match self {
            LogInputs::Updates(updates, _) => updates.get(k),
            _ => None,
        }
    }

    /// The `k`-th scan; `None` for other inputs.
    pub fn scan(&self, k: usize) -> Option<&Scan> {
        match self {
            LogInputs::Scans(scans) => scans.all.get(k),
            _ => None,
        }
    }

    /// The position of an input in the log: the number of its scan, from 0, and its line. For a scan these are its own number among
    /// the scans, and the line of its last ray.
    pub fn place(&self, k: usize) -> Option<(u64, u64)> {
        match self {
            LogInputs::Scans(scans) => scans.all.get(k).and_then(|s| s.rays.last()).map(|ray| (k as u64, ray.source.1)),
            _ => self.reading(k).map(|(reading, _)| (reading.record.scan, reading.record.line)),
        }
    }

    /// The first input of each scan of the log; scans without an input are left out.
    pub(super) fn starts(&self) -> Vec<usize> {
        let scan = |k: usize| self.place(k).map(|p| p.0);
        (0..self.len()).filter(|k| *k == 0 || scan(*k) != scan(*k - 1)).collect()
    }
}
