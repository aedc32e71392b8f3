//! What a method takes one at a time: readings, scans or updates, all of a log's.

use super::scans::Scanned;
use crate::Result;
use crate::binning::scan::Scan;
use crate::feature::{StageResult, Update};
use crate::method::Unit;
use crate::method::settings::{Certainty, Order, Settings};
use crate::pipeline::mapper::Item;
use crate::pipeline::session::Session;

/// A log's items, in order.
pub enum Items {
    /// Readings.
    Readings(Vec<Item>),
    /// Readings in the 1985 order: all free, then all occupy.
    Anew(Vec<Item>),
    /// Scans, for a counting sensor model.
    Scans(Box<Scanned>),
    /// Updates of the feature-based grid, and what its stage found in the whole log.
    Updates(Vec<Update>, Box<StageResult>),
}

impl Items {
    /// What a session's take in memory at most, bytes, with what is kept of each: an update has its fans.
    pub fn memory(session: &Session) -> u64 {
        let each = if session.method.unit() == Unit::Update { 1024 } else { 32 + size_of::<Item>() as u64 };
        session.survey.counts.read * each
    }

    /// All of a session's.
    ///
    /// # Errors
    /// The log's.
    pub fn read(session: &Session) -> Result<Items> {
        let settings = session.method.settings();
        Ok(match (session.method.unit(), settings) {
            (Unit::Scan, Settings::Csm(csm)) => Items::Scans(Box::new(Scanned::read(session, csm)?)),
            (Unit::Update, _) => {
                let (updates, found) = session.updates(usize::MAX)?;
                Items::Updates(updates, Box::new(found))
            }
            (_, Settings::Certainty(Certainty { order: Order::Batch })) => {
                Items::Anew(session.items()?.collect::<Result<_>>()?)
            }
            _ => Items::Readings(session.items()?.collect::<Result<_>>()?),
        })
    }

    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Items::Readings(items) | Items::Anew(items) => items.len(),
            Items::Scans(scans) => scans.all.len(),
            Items::Updates(updates, _) => updates.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The reading of an item, with its wedge's edges where it has them; a scan is none.
    pub fn reading(&self, k: usize) -> Option<Item> {
        match self {
            Items::Readings(items) | Items::Anew(items) => items.get(k).copied(),
            Items::Updates(updates, _) => updates.get(k).map(|u| (u.reading, None)),
            Items::Scans(_) => None,
        }
    }

    /// The update.
    pub fn update(&self, k: usize) -> Option<&Update> {
        match self {
            Items::Updates(updates, _) => updates.get(k),
            _ => None,
        }
    }

    /// The scan.
    pub fn scan(&self, k: usize) -> Option<&Scan> {
        match self {
            Items::Scans(scans) => scans.all.get(k),
            _ => None,
        }
    }

    /// Where an item stands in the log: the number of its scan, from 0 (of a counting sensor model's scans their own), and its line; of
    /// a scan its last.
    pub fn place(&self, k: usize) -> Option<(u64, u64)> {
        match self {
            Items::Scans(scans) => scans.all.get(k).and_then(|s| s.rays.last()).map(|ray| (k as u64, ray.source.1)),
            _ => self.reading(k).map(|(reading, _)| (reading.record.scan, reading.record.line)),
        }
    }

    /// Where the log's scans begin, those without an item left out: the first item of each run of items of one scan.
    pub(super) fn starts(&self) -> Vec<usize> {
        let scan = |k: usize| self.place(k).map(|p| p.0);
        (0..self.len()).filter(|k| *k == 0 || scan(*k) != scan(*k - 1)).collect()
    }
}
