//! What can be wrong in the middle of a log.

use crate::Error;

/// A line that should be a reading but can't be read as one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}")]
pub struct BadLine {
    /// The line, from 1.
    pub line: u64,
    /// The reason.
    pub what: String,
}

/// What can be wrong in the middle of a log.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// One line is bad: it is counted, and the run goes on.
    #[error("{0}")]
    Line(BadLine),
    /// The rest of the log can't be read.
    #[error("{0}")]
    Fatal(Error),
}
