//! Options' values: their types, parsers and checks.

use crate::grid::GridSpec;
use crate::kernels::Choice;
use crate::sensor::length;
use crate::{Error, Result};
use clap::ValueEnum;

/// Kind of sensor to take from the log.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum KindArgument {
    /// Sonar cones
    Sonar,
    /// Laser beams
    Laser,
}

/// The backend to compute on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BackendArgument {
    /// The best hardware GPU adapter, else the CPU
    Auto,
    /// A GPU adapter; a software one counts
    Gpu,
    /// The CPU: all cores, SIMD
    Cpu,
    /// The f64 reference, one reading at a time
    Oracle,
}

impl BackendArgument {
    /// The kernels' choice; `None` for the oracle.
    pub fn choice(self) -> Option<Choice> {
        match self {
            BackendArgument::Auto => Some(Choice::Auto),
            BackendArgument::Gpu => Some(Choice::Gpu),
            BackendArgument::Cpu => Some(Choice::Cpu),
            BackendArgument::Oracle => None,
        }
    }
}

/// Parses a length: a number of metres, or one with mm, cm or m.
pub fn parse_length(text: &str) -> std::result::Result<f64, String> {
    // NaN passes here and is refused with the other impossible cell sizes.
    text.parse().or_else(|_| length(text).map_err(|what| format!("it {what}")))
}

/// Parses a number.
pub fn parse_number(text: &str) -> std::result::Result<f64, String> {
    text.parse().map_err(|_| "it is not a number".into())
}

/// Checks the numbers of `--bounds` and the resolution, before anything is read.
///
/// # Errors
/// [`Error::Usage`] where there are not four numbers, or they make no grid.
pub fn check_bounds(given: Option<&[f64]>, resolution: f64) -> Result<Option<[f64; 4]>> {
    let bounds = match given {
        None => None,
        Some(&[x0, y0, x1, y1]) => Some([x0, y0, x1, y1]),
        Some(other) => {
            let what = format!("--bounds takes x0,y0,x1,y1, four numbers; here are {}", other.len());
            return Err(Error::Usage(what));
        }
    };
    GridSpec::from_bounds(bounds.unwrap_or([0.0, 0.0, 1.0, 1.0]), resolution)?;
    Ok(bounds)
}

/// Parses a count from 1.
pub fn parse_positive(text: &str) -> std::result::Result<u64, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "give a whole number from 1".into())
}

/// Parses a number of threads: 0 (one a core) to 1024.
pub fn parse_threads(text: &str) -> std::result::Result<usize, String> {
    text.parse().ok().filter(|n| *n <= 1024).ok_or_else(|| "give 0 (one a core) to 1024".into())
}

/// Limits the host's work, such as binning, to so many threads; 0: one a core. It can be called once a process.
pub fn use_threads(count: usize) -> Result<()> {
    if count == 0 {
        return Ok(());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
    pool.build_global().map_err(|e| Error::Resources(format!("{count} threads can't be started: {e}")))
}
