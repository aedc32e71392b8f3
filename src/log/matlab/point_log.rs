//! A log of the variables `robotPose` and `laserScan`: hit points in the robot's frame.

use super::array::Array;
use super::scan_data::HALF_WIDTH;
use super::variables::Variables;
use crate::Result;
use crate::log::classes::Classes;
use crate::log::format::{RecordQueue, ScanReader, Source};
use crate::log::input::Input;
use crate::log::mounting::MountedSensor;
use crate::log::problem::{BadLine, Problem};
use crate::log::reading::{Pose, Record};
use crate::log::values::{check_pose, quote};
use crate::sensor::{Description, Kind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A scan: the robot's pose, and the points that it hit, with labels.
type Points = (Pose, Array);

/// A log of `robotPose` and `laserScan`.
pub(super) struct PointLog {
    input: Input,
    scans: Arc<Vec<Points>>,
    sensors: Vec<Description>,
    classes: Vec<String>,
}

impl PointLog {
    /// From the two variables; the error doesn't name the file.
    pub fn of(input: &Input, found: Variables) -> std::result::Result<PointLog, String> {
        let Variables { mut wanted, names } = found;
        let asked =
            [("robotPose", "a struct of x, y and h"), ("laserScan", "a cell of 2 × N or 3 × N points for each scan")];
        let missing: Vec<String> = asked
            .iter()
            .filter(|(name, _)| !wanted.contains_key(*name))
            .map(|(name, what)| format!("{name} ({what})"))
            .collect();
        let (Some(pose), Some(scans)) = (wanted.remove("robotPose"), wanted.remove("laserScan")) else {
            return Err(format!("has no variable {}; it holds {}", missing.join(" and no "), list(&names)));
        };
        let Array::Struct(fields) = pose else {
            return Err(format!("robotPose is {pose}, not a struct of x, y and h"));
        };
        let missing: Vec<&str> =
            ["x", "y", "h"].into_iter().filter(|name| fields.iter().all(|(n, _)| n != name)).collect();
        if !missing.is_empty() {
            let there: Vec<String> = fields.iter().map(|(n, _)| n.clone()).collect();
            return Err(format!("robotPose has no field {}; it has {}", missing.join(" and no "), list(&there)));
        }
        let column = |name: &str| match fields.iter().find(|(n, _)| n == name) {
            Some((_, Array::Numbers { values, .. })) => Ok(values),
            Some((_, other)) => Err(format!("robotPose.{name} is {other}, not numbers")),
            None => Err(format!("robotPose has no field {name}")),
        };
        let (x, y, h) = (column("x")?, column("y")?, column("h")?);
        let Array::Cells(cells) = scans else { return Err(format!("laserScan is {scans}, not a cell of scans")) };
        if [x.len(), y.len(), h.len()] != [cells.len(); 3] {
            let (x, y, h, n) = (x.len(), y.len(), h.len(), cells.len());
            return Err(format!("robotPose has {x} x, {y} y and {h} h for {n} scans in laserScan: as many are wanted"));
        }
        let labelled = cells.iter().any(|c| matches!(c, Array::Numbers { rows: 3, .. }));
        let rooms = Classes::rooms().map_err(|e| e.to_string())?;
        let classes = if labelled { rooms.names[..rooms.count()].to_vec() } else { Vec::new() };
        let poses = x.iter().zip(y).zip(h).map(|((x, y), h)| Pose { x: *x, y: *y, heading: *h });
        let laser = Description {
            id: Some("laser".into()),
            kind: Some(Kind::Laser),
            half_width: Some(HALF_WIDTH.to_radians()),
            ..Description::default()
        };
        Ok(PointLog {
            input: input.clone(),
            scans: Arc::new(poses.zip(cells).collect()),
            sensors: vec![laser],
            classes,
        })
    }
}

/// Names as a file has them, for a message.
fn list(names: &[String]) -> String {
    const SHOWN: usize = 16;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|n| quote(n)).collect();
    match names.len() {
        0 => "nothing".into(),
        n if n > SHOWN => format!("{} and {} more", shown.join(", "), n - SHOWN),
        _ => shown.join(", "),
    }
}

impl Source for PointLog {
    fn sensors(&self) -> &[Description] {
        &self.sensors
    }

    fn has_beams(&self) -> bool {
        false
    }

    fn classes(&self) -> &[String] {
        &self.classes
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[MountedSensor]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>> {
        Ok(Box::new(PointReader { scans: self.scans.clone(), next: 0, sensors, ignored }))
    }
}

struct PointReader {
    scans: Arc<Vec<Points>>,
    next: usize,
    sensors: Arc<[MountedSensor]>,
    ignored: Arc<AtomicU64>,
}

impl ScanReader for PointReader {
    fn fill(&mut self, items: &mut RecordQueue) -> bool {
        let Some((robot, points)) = self.scans.get(self.next) else { return false };
        let (scan, line) = (self.next as u64, self.next as u64 + 1);
        self.next += 1;
        let bad = |what: String| Err(Problem::Line(BadLine { line, what: format!("scan {line}: {what}") }));
        if let Err(what) = check_pose("the robot's", robot) {
            items.push_back(bad(what));
            return true;
        }
        match points {
            // A scan without a beam says nothing.
            Array::Numbers { values, .. } if values.is_empty() => {
                self.ignored.fetch_add(1, Ordering::Relaxed);
            }
            Array::Numbers { rows: rows @ (2 | 3), values } => {
                for (beam, point) in values.chunks_exact(*rows).enumerate() {
                    match record(&self.sensors, robot, point, scan) {
                        Ok(record) => items.push_back(Ok(record)),
                        Err(what) => items.push_back(bad(format!("beam {}: {what}", beam + 1))),
                    }
                }
            }
            other => items.push_back(bad(format!("{other}, not 2 × N or 3 × N points"))),
        }
        true
    }
}

fn record(sensors: &[MountedSensor], robot: &Pose, point: &[f64], scan: u64) -> std::result::Result<Record, String> {
    let label = match point.get(2) {
        None => None,
        Some(label) if label.fract() == 0.0 && (1.0..65536.0).contains(label) => Some(*label as u16),
        Some(label) => return Err(format!("label {label}: labels are whole numbers from 1")),
    };
    if !(point[0].is_finite() && point[1].is_finite()) {
        return Err(format!("({}, {}) is no point", point[0], point[1]));
    }
    let mounted = sensors.first().ok_or("no sensor")?;
    let off = point[1].atan2(point[0]);
    let given = Pose { heading: robot.heading + off, ..*robot };
    Ok(Record {
        t: scan as f64,
        scan,
        sensor: 0,
        robot: *robot,
        pose: mounted.pose(robot, Some(given), if mounted.placed { off } else { 0.0 }),
        range: point[0].hypot(point[1]),
        label,
        line: scan + 1,
    })
}
