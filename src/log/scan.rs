//! The values that all readings of a scan share.

use super::format::RecordQueue;
use super::mounting::MountedSensor;
use crate::log::reading::{Pose, Record};

/// The values that all readings of a scan share.
pub(super) struct ScanHeader {
    /// Time stamp, seconds.
    pub t: f64,
    /// The scan's number, from 0.
    pub number: u64,
    /// Index of its sensor.
    pub sensor: usize,
    /// The robot's pose.
    pub robot: Pose,
    /// The sensor's pose, if the log gives it.
    pub given: Option<Pose>,
    /// The scan's line in the log, from 1.
    pub line: u64,
}

impl ScanHeader {
    /// Appends a reading of `range` metres, `off` radians from the sensor's axis; a range of +∞ is no echo.
    pub fn push(&self, sensors: &[MountedSensor], off: f64, range: f64, items: &mut RecordQueue) {
        if let Some(mounted) = sensors.get(self.sensor) {
            items.push_back(Ok(Record {
                t: self.t,
                scan: self.number,
                sensor: self.sensor as u32,
                robot: self.robot,
                pose: mounted.pose(&self.robot, self.given, off),
                range,
                label: None,
                line: self.line,
            }));
        }
    }
}
