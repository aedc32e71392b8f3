//! The input of a method: which sensors and which kind of items it takes from a log, and how its parameters depend on the log.

use super::settings::Settings;
use crate::binning::scan::Selection;
use crate::feature::Rules;
use crate::grid::GridSpec;
use crate::log::classes::Classes;
use crate::sensor::{Kind, Sensor};
use std::path::Path;

/// The kind of items that a method takes; the kinds of [`crate::binning::batch::Input`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A reading: each updates the cells of its cone.
    Reading,
    /// A scan: each cell takes one beam of it.
    Scan,
    /// An update that features made of a reading.
    Update,
}

impl Unit {
    /// Name of the items in messages.
    pub fn name(self) -> &'static str {
        match self {
            Unit::Reading => "readings",
            Unit::Scan => "scans",
            Unit::Update => "updates",
        }
    }
}

/// The input of a method, with the parameters that make it from the records of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Input {
    /// Readings, one by one.
    Readings,
    /// Whole scans.
    Scans {
        /// Which poses and beams may touch a cell.
        selection: Selection,
        /// How many class labels the method tells apart; 0 if it ignores them.
        labels: usize,
    },
    /// Updates that the feature stage makes of readings by these rules.
    Updates(Rules),
}

impl Input {
    /// The kind of input.
    pub fn unit(&self) -> Unit {
        match self {
            Input::Readings => Unit::Reading,
            Input::Scans { .. } => Unit::Scan,
            Input::Updates(_) => Unit::Update,
        }
    }
}

/// How far around a beam a method updates cells, beyond its cone.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spread {
    /// Distance in every direction, metres.
    pub beside: f64,
    /// Angle off the axis, up to the beam's range, radians.
    pub half_width: f64,
}

/// The one kind of sensor whose readings a method maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RequiredSensor {
    /// The kind.
    pub kind: Kind,
    /// Why, as a predicate of the method, for the error about a request for the other kind.
    pub reason: &'static str,
    /// What the method does and what to do instead, for the error about a log that has only the other kind; `None`: the error of
    /// the log's reader says enough.
    pub instead: Option<&'static str>,
}

/// The facts of a log and a grid that parameters may depend on.
#[derive(Debug, Clone, Copy)]
pub struct LogFacts<'a> {
    /// The log's path, for errors.
    pub path: &'a Path,
    /// The log's sensors.
    pub sensors: &'a [Sensor],
    /// Names of the class labels that the log itself gives, label 1 first.
    pub class_names: &'a [String],
    /// The file of class labels that the user gave.
    pub class_file: Option<&'a Path>,
    /// Number of used hits.
    pub hits: u64,
    /// Number of used hits that carry a class label.
    pub labelled: u64,
    /// The grid.
    pub grid: &'a GridSpec,
}

/// Parameters that are complete for a log.
#[derive(Debug, Clone)]
pub struct Completed {
    /// The parameters.
    pub settings: Settings,
    /// The class labels, where the method tells them apart.
    pub classes: Option<Classes>,
}

/// The kind of number that a method takes as a reading's own evidence of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Evidence {
    /// The meaning of the number.
    pub about: &'static str,
    /// Whether it is a probability, for which ½ means no evidence; otherwise 0 does.
    pub probability: bool,
    /// Whether it is reduced by the known emptiness, and normalised over the arc, before a cell takes it.
    pub normalised: bool,
}

impl Evidence {
    /// Evidence whose magnitude counts.
    pub const fn magnitude(about: &'static str) -> Evidence {
        Evidence { about, probability: false, normalised: false }
    }

    /// Evidence that is a probability.
    pub const fn probability(about: &'static str) -> Evidence {
        Evidence { about, probability: true, normalised: false }
    }
}
