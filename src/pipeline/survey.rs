//! The survey of a log in one pass: what becomes of its records, the box that they reach, its bad lines, and warnings about its ranges
//! and poses.

mod covered;
mod ranges;
mod trajectory;

use crate::log::BadLines;
use crate::log::reading::{Counts, Outcome, Pose, classify};
use crate::log::{Log, Problem};
use crate::method::Spread;
use crate::sensor::Sensor;
use crate::{Error, Result};
use covered::CoveredBox;
use ranges::RangeChecks;
use std::path::Path;
use trajectory::Trajectory;

/// The result of a survey.
#[derive(Debug, Clone)]
pub struct Survey {
    /// What becomes of its records, up to the last used reading to be mapped.
    pub counts: Counts,
    /// Used hits that carry a class label.
    pub labelled: u64,
    /// Used hits.
    pub hits: u64,
    /// Scans with a used reading.
    pub scans: u64,
    /// x0, y0, x1, y1: the box of every used reading's cone up to R + ε, metres.
    pub covered: [f64; 4],
    /// Lines that should be readings and can't be read.
    pub bad_lines: BadLines,
    /// Lines of other kinds.
    pub ignored: u64,
    /// Warnings that the sensors' limits or the unit of the headings may be wrong, in whole sentences.
    pub notes: Vec<String>,
    /// The robot's longest step between two readings, if it is so long that a pose may be wrong: metres, the line and the pose of the
    /// second reading.
    pub jump: Option<(f64, u64, Pose)>,
}

/// What a survey depends on beside the log.
#[derive(Debug, Clone, Copy)]
pub struct SurveyOptions {
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// Only the first so many used readings.
    pub until: u64,
    /// Whether the user set the sensors' `r_max`.
    pub r_max_set: bool,
    /// How far around a beam the method updates cells, beyond the beam's cone.
    pub spread: Spread,
}

/// Surveys a log.
///
/// # Errors
/// The log's.
pub fn survey(log: &Log, sensors: &[Sensor], options: &SurveyOptions) -> Result<Survey> {
    let mut survey = Survey {
        counts: Counts::default(),
        labelled: 0,
        hits: 0,
        scans: 0,
        covered: CoveredBox::empty().corners(),
        bad_lines: BadLines::default(),
        ignored: 0,
        notes: Vec::new(),
        jump: None,
    };
    let mut records = log.records()?;
    let (mut covered, mut ranges) = (CoveredBox::empty(), RangeChecks::of(sensors.len()));
    let (mut scan, mut trajectory) = (None, Trajectory::new());
    while survey.counts.used < options.until {
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
        ranges.add(&record, sensor, &judged);
        // Rejected records are counted, and reach no cell.
        let Ok(reading) = judged else { continue };
        let hit = reading.outcome == Outcome::Hit;
        survey.hits += u64::from(hit);
        survey.labelled += u64::from(hit && record.label.is_some());
        if scan != Some(record.scan) {
            scan = Some(record.scan);
            survey.scans += 1;
        }
        trajectory.add(record.robot, record.line);
        covered.add(&reading, sensor, options.resolution, options.spread);
    }
    survey.ignored = records.ignored();
    survey.covered = covered.corners();
    survey.jump = trajectory.jump();
    survey.notes = ranges.warnings(sensors, options.r_max_set);
    survey.notes.extend(trajectory.degrees());
    Ok(survey)
}

impl Survey {
    /// Adds the line and the pose of the jump to an error about the size of the grid, if a pose jumps.
    pub fn explain(&self, error: Error, path: &Path) -> Error {
        match self.jump() {
            Some((line, what)) => Error::at(path, line, format!("{what}; if that is wrong, give `bounds`. {error}")),
            None => error,
        }
    }

    /// The line of the robot's longest step and a description of the step, if it is so long that a pose may be wrong.
    pub fn jump(&self) -> Option<(u64, String)> {
        let (step, line, Pose { x, y, .. }) = self.jump?;
        Some((line, format!("the robot's pose jumps {step:.0} m, to ({x}, {y})")))
    }
}
