//! A log, a method and a grid, checked before the long run ([`open`](Session::open)); the inputs that the method takes of the log; and its
//! map, by a backend or by the oracle.

mod inputs;
mod map;
mod open;
mod oracle;
mod parameters;

pub use map::MappedLog;

use crate::feature;
use crate::grid::GridSpec;
use crate::log::classes::Classes;
use crate::log::{self, Log};
use crate::method::settings::Settings;
use crate::method::{Input, Method};
use crate::pipeline::memory;
use crate::pipeline::survey::Survey;
use crate::sensor::Sensor;
use crate::{Error, Result};

/// What to map, and how.
#[derive(Debug, Clone)]
pub struct Request {
    /// How to read the log.
    pub log: log::Options,
    /// The method and its parameters.
    pub settings: Settings,
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// Bounds of the grid, x0, y0, x1, y1 in metres; `None`: the box of all that the readings reach.
    pub bounds: Option<[f64; 4]>,
    /// Only the first so many used readings; `None`: all.
    pub until: Option<u64>,
    /// A bad line is an error.
    pub strict: bool,
}

/// An open log, surveyed, with its grid.
pub struct Session {
    /// The log.
    pub log: Log,
    sensors: Vec<Sensor>,
    /// The method.
    pub method: Box<dyn Method>,
    /// The grid.
    pub grid: GridSpec,
    /// The result of a first pass over the log.
    pub survey: Survey,
    /// The class labels, where the method tells them apart.
    pub classes: Option<Classes>,
    /// The number of used readings to map.
    until: u64,
    bounded: bool,
}

impl Session {
    /// Whether the request gave the grid's bounds.
    pub fn bounded(&self) -> bool {
        self.bounded
    }

    /// The log's sensors, with the method's limits.
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// Notes for the user on how the log was read, in whole sentences.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.log.notes();
        notes.extend(self.survey.notes.iter().cloned());
        notes
    }

    /// The input of the method on this grid.
    pub(super) fn input(&self) -> Input {
        self.method.input(self.grid.resolution)
    }

    /// The most memory that mapping takes, bytes, with `batch` readings at a time.
    pub fn memory(&self, batch: usize) -> u64 {
        let batch = batch.min(usize::try_from(self.survey.counts.used).unwrap_or(usize::MAX));
        let stage = match self.input() {
            // The feature stage holds missing echoes, too.
            Input::Updates(_) => feature::memory(self.survey.counts.read),
            Input::Readings | Input::Scans { .. } => 0,
        };
        memory::resident(&self.grid, self.method.as_ref(), batch) + stage
    }

    /// Checks that a run which takes `needed` bytes keeps to the cap, and to the memory that is free.
    ///
    /// # Errors
    /// [`Error::Resources`], with the pose that made the grid so large.
    pub fn check_memory(&self, needed: u64, cap: Option<u64>) -> Result<()> {
        let checked = self.grid.check_memory(needed, cap, "give smaller `bounds` or a coarser `resolution`");
        checked.map_err(|e| self.explain(e))
    }

    /// Adds to an error about the size of the grid the pose that caused it, where the grid follows the poses.
    pub fn explain(&self, error: Error) -> Error {
        if self.bounded { error } else { self.survey.explain(error, self.log.path()) }
    }
}
