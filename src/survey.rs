//! A first look through a log: what its records are worth, the box they reach, its bad lines.

use crate::log::{Log, Problem};
use crate::output::BadLines;
use crate::reading::{Counts, Outcome, Pose, judge};
use crate::sensor::Sensor;
use crate::{Error, Result};
use std::path::Path;

/// Bad lines that are quoted.
const QUOTED: usize = 3;

/// A step between two readings, metres, that no robot takes.
const SUSPICIOUS: f64 = 100.0;

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
    /// x0, y0, x1, y1: every used reading's sensor ± (R + ε), metres.
    pub covered: [f64; 4],
    /// Lines that are no readings though they should be.
    pub bad_lines: BadLines,
    /// Lines of other kinds.
    pub ignored: u64,
    /// What of the ranges should make a user doubt the sensors' limits, in whole sentences.
    pub notes: Vec<String>,
    /// The robot's largest step between two readings: metres, the second's line and pose.
    pub jump: (f64, u64, Pose),
}

/// Reads the log through, up to the `until`-th used reading.
///
/// # Errors
/// The log's.
pub fn survey(log: &Log, sensors: &[Sensor], resolution: f64, until: u64) -> Result<Survey> {
    let mut survey = Survey {
        counts: Counts::default(),
        labelled: 0,
        hits: 0,
        scans: 0,
        covered: [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY],
        bad_lines: BadLines::default(),
        ignored: 0,
        notes: Vec::new(),
        jump: (0.0, 0, Pose::default()),
    };
    let mut records = log.records()?;
    let (mut scan, mut last): (Option<u64>, Option<Pose>) = (None, None);
    while survey.counts.used < until {
        let record = match records.next() {
            None => break,
            Some(Ok(record)) => record,
            Some(Err(Problem::Fatal(e))) => return Err(e),
            Some(Err(Problem::Line(bad))) => {
                survey.bad_lines.count += 1;
                if survey.bad_lines.first.len() < QUOTED {
                    survey.bad_lines.first.push(bad.to_string());
                }
                continue;
            }
        };
        let sensor = &sensors[record.sensor as usize];
        let judged = judge(record, sensor);
        survey.counts.add(&judged);
        let Ok(reading) = judged else { continue };
        let hit = reading.outcome == Outcome::Hit;
        survey.hits += u64::from(hit);
        survey.labelled += u64::from(hit && record.label.is_some());
        if scan != Some(record.scan) {
            scan = Some(record.scan);
            survey.scans += 1;
        }
        let at = record.robot;
        let step = last.map_or(0.0, |l: Pose| (at.x - l.x).hypot(at.y - l.y));
        if step > survey.jump.0 {
            survey.jump = (step, record.line, at);
        }
        last = Some(at);
        let (pose, reach) = (record.pose, reading.range + sensor.epsilon(resolution));
        let [x0, y0, x1, y1] = survey.covered;
        survey.covered =
            [x0.min(pose.x - reach), y0.min(pose.y - reach), x1.max(pose.x + reach), y1.max(pose.y + reach)];
    }
    survey.ignored = records.ignored();
    Ok(survey)
}

impl Survey {
    /// Adds to an error about the grid's size where it comes from, if a pose jumps.
    pub fn explain(&self, error: Error, path: &Path) -> Error {
        match self.jump() {
            Some((line, what)) => Error::at(path, line, format!("{what}; if that is wrong, give --bounds. {error}")),
            None => error,
        }
    }

    /// The line of the robot's largest step and what happens there, if it is so long that a pose may be wrong.
    pub fn jump(&self) -> Option<(u64, String)> {
        let (step, line, Pose { x, y, .. }) = self.jump;
        (step >= SUSPICIOUS).then(|| (line, format!("the robot's pose jumps {step:.0} m, to ({x}, {y})")))
    }
}
