//! Scans are readings taken at one pose. They are for the methods in which a cell takes one beam of each of its nearest poses.
//!
//! Poses, hits, ranges and cell centres are rounded to 1 µm, directions to 2⁻²⁵. Every choice is made in integers of at most 53
//! bits: the nearest poses by squared distance, the nearest beam by cross products.

mod area;
mod batch;
mod index;
mod order;
mod selection;
pub(crate) mod snap;
mod store;

pub use batch::{Most, Tiles};
pub use index::Index;
pub use order::{before, cross, place};
pub use selection::Selection;
pub use snap::{Snapped, micrometres, snap};
pub use store::Store;

use crate::log::reading::{Pose, Record, Unused, classify};
use crate::sensor::Sensor;
use crate::{Error, Result};

/// A beam of a scan before snapping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// The sensor's pose, metres and radians in the world frame.
    pub sensor: Pose,
    /// The range of the hit, metres; `None` without an echo.
    pub range: Option<f64>,
    /// The class label of the hit, from 1; 0 if it has none.
    pub label: u8,
    /// Index of the sensor in the log, and line number of the record.
    pub source: (u32, u64),
}

/// The readings of one scan, without the rejected ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scan {
    /// The robot's pose.
    pub robot: Pose,
    /// The beams in log order, with and without an echo.
    pub rays: Vec<Ray>,
    /// Number of used readings among them.
    pub used: u64,
}

/// The largest number of beams in a scan.
pub const MOST_BEAMS: usize = 65_535;

/// Groups a log's records into scans.
pub struct Scans<'a, I> {
    records: I,
    sensors: &'a [Sensor],
    /// The largest class label that is accepted; 0 if labels are ignored.
    labels: usize,
    /// Number of used readings still to be taken.
    left: u64,
    next: Option<Record>,
    path: &'a std::path::Path,
}

impl<'a, I: Iterator<Item = Result<Record>>> Scans<'a, I> {
    /// Groups records up to the `until`-th used one. `labels` is the number of class labels, or 0 if they are ignored.
    pub fn new(records: I, sensors: &'a [Sensor], labels: usize, until: u64, path: &'a std::path::Path) -> Self {
        Scans { records, sensors, labels, left: until, next: None, path }
    }

    /// Adds a record to a scan, unless its reading is rejected.
    fn add(&mut self, scan: &mut Scan, record: Record) -> Result<()> {
        let range = match classify(record, &self.sensors[record.sensor as usize]) {
            Ok(reading) => {
                self.left -= 1;
                scan.used += 1;
                (reading.outcome == crate::log::reading::Outcome::Hit).then_some(reading.range)
            }
            Err(Unused::NoEcho) => None,
            Err(_) => return Ok(()),
        };
        let label = match record.label {
            Some(label) if self.labels > 0 && range.is_some() => {
                if usize::from(label) > self.labels {
                    let (line, labels) = (record.line, self.labels);
                    let what = format!(
                        "label {label}: there are classes 1 to {labels}; name more with `classes`, or mend the log"
                    );
                    return Err(Error::at(self.path, line, what));
                }
                label as u8
            }
            _ => u8::from(self.labels == 0),
        };
        if scan.rays.is_empty() {
            scan.robot = record.robot;
        }
        scan.rays.push(Ray { sensor: record.pose, range, label, source: (record.sensor, record.line) });
        if scan.rays.len() > MOST_BEAMS {
            let what = format!(
                "scan {} has more than {MOST_BEAMS} readings: give each pose's readings a scan of their own",
                record.scan
            );
            return Err(Error::at(self.path, record.line, what));
        }
        Ok(())
    }

    fn scan(&mut self) -> Result<Option<Scan>> {
        let (mut scan, mut number) = (Scan::default(), None);
        while self.left > 0 {
            let record = match self.next.take() {
                Some(record) => record,
                None => match self.records.next() {
                    Some(record) => record?,
                    None => break,
                },
            };
            if *number.get_or_insert(record.scan) != record.scan {
                self.next = Some(record);
                if !scan.rays.is_empty() {
                    break;
                }
                number = None;
                continue;
            }
            self.add(&mut scan, record)?;
        }
        Ok(Some(scan).filter(|s| !s.rays.is_empty()))
    }
}

impl<I: Iterator<Item = Result<Record>>> Iterator for Scans<'_, I> {
    type Item = Result<Scan>;

    fn next(&mut self) -> Option<Result<Scan>> {
        self.scan().transpose()
    }
}
