//! Rows of a table, parsed to records.

use super::columns::{Column, ColumnRole};
use super::separator::Separator;
use super::start::comment;
use crate::log::format::RecordQueue;
use crate::log::mounting::MountedSensor;
use crate::log::reading::Pose;
use crate::log::scan::ScanHeader;
use crate::log::sensor_ids::MAX_SENSORS;
use crate::log::text::LineParser;
use crate::log::values::{check_pose, quote};
use crate::{Error, Result};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The sensors that a row's ranges belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RangeLayout {
    /// One sensor: a single range, or several with an angle each.
    Own,
    /// One laser: a range for each beam.
    Beams,
    /// A ring of sonars: a range for each sonar.
    Ring,
}

/// Reads the rows of a table.
#[derive(Clone)]
pub(super) struct TableParser {
    pub path: PathBuf,
    pub columns: Arc<[Column]>,
    pub rows: Separator,
    pub from: u64,
    pub layout: RangeLayout,
    pub several: bool,
    pub ids: Arc<HashMap<String, usize>>,
    pub scan: u64,
    /// The time and the robot's pose of the row before.
    pub last: Option<(f64, Pose)>,
}

impl LineParser for TableParser {
    fn parse_line(
        &mut self,
        line: &str,
        at: u64,
        sensors: &[MountedSensor],
        items: &mut RecordQueue,
    ) -> std::result::Result<bool, String> {
        if at < self.from || line.trim().is_empty() || comment(line.trim()) {
            return Ok(true);
        }
        let cells = self.rows.split(line);
        if cells.len() != self.columns.len() {
            return Err(format!("expected {} cells, found {}", self.columns.len(), cells.len()));
        }
        let (mut t, mut scan, mut sensor, mut label) = (None, None, 0, None);
        let (mut robot, mut given) = ([0.0; 3], [0.0; 3]);
        let (mut ranges, mut angles) = (Vec::new(), Vec::new());
        for (cell, column) in cells.iter().zip(self.columns.iter()) {
            let value = |name: &str| self.rows.value(cell, column.scale, name);
            match column.role {
                ColumnRole::Skip => {}
                ColumnRole::T => t = Some(value("t")?),
                ColumnRole::Scan => scan = Some(whole(value("scan")?, cell, "scan")?),
                ColumnRole::Label if cell.is_empty() => {}
                ColumnRole::Label => label = Some(whole(value("label")?, cell, "label")?),
                ColumnRole::Sensor => {
                    let plain = || self.ids.get(&cell.parse::<usize>().ok()?.to_string());
                    let index = self.ids.get(cell.as_ref()).or_else(plain);
                    sensor =
                        *index.ok_or_else(|| format!("sensor {} is not among the first {MAX_SENSORS}", quote(cell)))?;
                }
                ColumnRole::Px => robot[0] = value("x")?,
                ColumnRole::Py => robot[1] = value("y")?,
                ColumnRole::Ph => robot[2] = value("heading")?,
                ColumnRole::X => given[0] = value("the sensor's x")?,
                ColumnRole::Y => given[1] = value("the sensor's y")?,
                ColumnRole::H => given[2] = value("the sensor's heading")?,
                ColumnRole::Range if cell.is_empty() || cell == "null" => ranges.push(f64::INFINITY),
                ColumnRole::Range => ranges.push(value("range")?),
                ColumnRole::Angle => angles.push(value("angle")?),
            }
        }
        let pose = |[x, y, heading]: [f64; 3]| Pose { x, y, heading };
        let robot = pose(robot);
        check_pose("the robot's", &robot)?;
        let given = self.columns.iter().any(|c| c.role == ColumnRole::X).then(|| pose(given));
        if let Some(given) = &given {
            check_pose("the sensor's", given)?;
        }
        let time = t.unwrap_or(0.0);
        if !time.is_finite() {
            return Err(format!("t is {time}"));
        }
        if let Some(angle) = angles.iter().find(|angle| !angle.is_finite()) {
            return Err(format!("angle is {angle}"));
        }
        let label = match label {
            None => None,
            Some(label) => Some(u16::try_from(label).ok().filter(|l| *l > 0).ok_or("labels are 1 to 65535")?),
        };
        // Rows of one time, or without times of one place, are a scan; a row of several ranges is one.
        let moved = match (&self.last, t) {
            (None, _) => false,
            (Some((last, _)), Some(t)) => *last != t,
            (Some((_, last)), None) => *last != robot,
        };
        self.scan += u64::from(moved || (self.last.is_some() && ranges.len() > 1 && !self.several));
        self.last = Some((time, robot));
        let mut scan = ScanHeader { t: time, number: scan.unwrap_or(self.scan), sensor, robot, given, line: at };
        let beams = sensors.get(sensor).and_then(|m| m.beams);
        let before = items.len();
        for (k, range) in ranges.iter().enumerate() {
            let off = match (self.layout, beams) {
                (RangeLayout::Beams, Some(beams)) => beams.first + k as f64 * beams.step,
                _ => angles.get(k).copied().unwrap_or(0.0),
            };
            if self.layout == RangeLayout::Ring {
                scan.sensor = k;
            }
            scan.push(sensors, off, *range, items);
        }
        if label.is_some() {
            for record in items.iter_mut().skip(before).flatten() {
                record.label = label;
            }
        }
        Ok(true)
    }

    fn check_sensors(&self, sensors: &[MountedSensor]) -> Result<()> {
        let count = self.columns.iter().filter(|column| column.role == ColumnRole::Range).count();
        match self.layout {
            RangeLayout::Beams if sensors.iter().any(|m| m.beams.is_none()) => Err(Error::input(
                &self.path,
                format!(
                    "nothing says where the {count} beams of a row look: give --set fov=180deg (their field of view, the first \
                     beam on the right), columns of angles, or a --sensor-file with first and step"
                ),
            )),
            RangeLayout::Ring if !sensors.iter().any(|m| m.placed) => Err(Error::input(
                &self.path,
                format!(
                    "nothing says where the {count} sonars of a row sit and look: describe them in a --sensor-file, one \
                     [[sensor]] each with x, y and axis (docs/formats.md)"
                ),
            )),
            _ => Ok(()),
        }
    }
}

fn whole(value: f64, cell: &str, name: &str) -> std::result::Result<u64, String> {
    match value.fract() == 0.0 && (0.0..9e15).contains(&value) {
        true => Ok(value as u64),
        false => Err(format!("{name} is {}, not a count", quote(cell))),
    }
}
