//! The count of a log's bad lines, and the first few of them.

use super::problem::BadLine;
use serde::Serialize;

/// Bad lines that are kept for the report.
const KEPT: usize = 3;

/// Lines of the log that couldn't be read.
#[derive(Debug, Clone, Default, Serialize)]
pub struct BadLines {
    /// How many.
    pub count: u64,
    /// The messages of the first three.
    pub first: Vec<String>,
}

impl BadLines {
    /// Counts a bad line, and keeps its message if it is among the first.
    pub fn add(&mut self, bad: &BadLine) {
        self.count += 1;
        if self.first.len() < KEPT {
            self.first.push(bad.to_string());
        }
    }
}
