//! One pass over a log: its records in order, and its bad lines.

use super::format::{RecordQueue, ScanReader};
use super::problem::Problem;
use crate::log::reading::Record;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The records of a log, from its start, in constant memory. After a [`Problem::Fatal`] there is no more.
pub struct Records {
    scans: Box<dyn ScanReader>,
    items: RecordQueue,
    ignored: Arc<AtomicU64>,
    ended: bool,
}

impl Records {
    pub(super) fn new(scans: Box<dyn ScanReader>, ignored: Arc<AtomicU64>) -> Self {
        Records { scans, items: RecordQueue::new(), ignored, ended: false }
    }

    /// The number of lines so far without readings of this kind (odometry, parameters, other sensors); these are no errors.
    pub fn ignored(&self) -> u64 {
        self.ignored.load(Ordering::Relaxed)
    }

    /// The same count, for reading after the pass was moved.
    pub fn ignored_counter(&self) -> Arc<AtomicU64> {
        self.ignored.clone()
    }
}

impl Iterator for Records {
    type Item = Result<Record, Problem>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.items.is_empty() && !self.ended {
            self.ended = !self.scans.fill(&mut self.items);
        }
        let item = self.items.pop_front();
        if let Some(Err(Problem::Fatal(_))) = item {
            self.ended = true;
            self.items.clear();
        }
        item
    }
}

impl std::fmt::Debug for Records {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Records").field("ignored", &self.ignored()).finish_non_exhaustive()
    }
}
