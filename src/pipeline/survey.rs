//! A first look through a log: what its records are worth, the box they reach, its bad lines.

mod covered;
mod doubts;
mod way;

use crate::log::reading::{Counts, Outcome, Pose, classify};
use crate::log::{BadLines, Log, Problem};
use crate::sensor::Sensor;
use crate::{Error, Result};
pub use covered::Spread;

use covered::Covered;
use doubts::Doubts;
use std::path::Path;
use way::Way;

/// What a first pass over a log found.
#[derive(Debug, Clone)]
pub struct Survey {
    /// What its records are worth (those of the first `until` used readings).
    pub counts: Counts,
    /// Used hits that carry a class label.
    pub labelled: u64,
    /// Used hits.
    pub hits: u64,
    /// Scans with a used reading.
    pub scans: u64,
    /// x0, y0, x1, y1: the box of every used reading's cone up to R + ε, metres.
    pub covered: [f64; 4],
    /// Lines that are no readings though they should be.
    pub bad_lines: BadLines,
    /// Lines of other kinds.
    pub ignored: u64,
    /// What of the ranges should make a user doubt the sensors' limits, in whole sentences.
    pub notes: Vec<String>,
    /// The robot's largest step between two readings, if it is so long that a pose may be wrong: metres, the second's line and pose.
    pub jump: Option<(f64, u64, Pose)>,
}

/// What a survey needs to know of the run.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// Only the first so many used readings.
    pub until: u64,
    /// The user has said where the sensors' scale ends.
    pub r_max_set: bool,
    /// What the method adds to a reading's cone.
    pub spread: Spread,
}

/// Reads the log through.
///
/// # Errors
/// The log's.
pub fn survey(log: &Log, sensors: &[Sensor], look: &Look) -> Result<Survey> {
    let mut survey = Survey {
        counts: Counts::default(),
        labelled: 0,
        hits: 0,
        scans: 0,
        covered: Covered::nothing().corners(),
        bad_lines: BadLines::default(),
        ignored: 0,
        notes: Vec::new(),
        jump: None,
    };
    let mut records = log.records()?;
    let (mut covered, mut doubts) = (Covered::nothing(), Doubts::of(sensors.len()));
    let (mut scan, mut way) = (None, Way::new());
    while survey.counts.used < look.until {
        let record = match records.next() {
            None => break,
            Some(Ok(record)) => record,
            Some(Err(Problem::Fatal(e))) => return Err(e),
            Some(Err(Problem::Line(bad))) => {
                survey.bad_lines.add(&bad);
                continue;
            }
        };
        let sensor = &sensors[record.sensor as usize];
        let judged = classify(record, sensor);
        survey.counts.add(&judged);
        doubts.look(&record, sensor, &judged);
        let Ok(reading) = judged else { continue };
        let hit = reading.outcome == Outcome::Hit;
        survey.hits += u64::from(hit);
        survey.labelled += u64::from(hit && record.label.is_some());
        if scan != Some(record.scan) {
            scan = Some(record.scan);
            survey.scans += 1;
        }
        way.go(record.robot, record.line);
        covered.add(&reading, sensor, look.resolution, look.spread);
    }
    survey.ignored = records.ignored();
    survey.covered = covered.corners();
    survey.jump = way.jump();
    survey.notes = doubts.tell(sensors, look.r_max_set);
    survey.notes.extend(way.degrees());
    Ok(survey)
}

impl Survey {
    /// Adds to an error about the grid's size where it comes from, if a pose jumps.
    pub fn explain(&self, error: Error, path: &Path) -> Error {
        match self.jump() {
            Some((line, what)) => Error::at(path, line, format!("{what}; if that is wrong, give `bounds`. {error}")),
            None => error,
        }
    }

    /// The line of the robot's largest step and what happens there, if it is so long that a pose may be wrong.
    pub fn jump(&self) -> Option<(u64, String)> {
        let (step, line, Pose { x, y, .. }) = self.jump?;
        Some((line, format!("the robot's pose jumps {step:.0} m, to ({x}, {y})")))
    }
}
