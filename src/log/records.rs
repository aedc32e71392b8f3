//! One pass over a log: its records in order, and the lines that are none.

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

    /// Lines so far that hold no readings of this kind (odometry, parameters, other sensors): not an error.
    pub fn ignored(&self) -> u64 {
        self.ignored.load(Ordering::Relaxed)
    }

    /// The same count, to be read after the pass was moved elsewhere.
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
