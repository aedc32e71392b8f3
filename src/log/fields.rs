//! A line of echogrid's own log, in either syntax: its fields, and the record that they make.

use super::mounting::MountedSensor;
use super::values::{check_pose, quote};
use crate::log::reading::{Pose, Record};
use crate::sensor::Kind;
use crate::support::suggest::similar;
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

/// The names of the fields, in their usual order.
pub(super) const FIELD_NAMES: [&str; 11] = ["t", "scan", "sensor", "px", "py", "ph", "x", "y", "h", "z", "label"];

/// How a line names its sensor.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum SensorName<'a> {
    /// By its index in the header, from 0.
    Index(u64),
    /// By its id.
    Id(Cow<'a, str>),
}

/// The fields of one line; `None`: not given.
#[derive(Debug, Default)]
pub(super) struct ReadingFields<'a> {
    /// Seconds.
    pub t: Option<f64>,
    /// Scan, from 0.
    pub scan: Option<u64>,
    /// Its sensor.
    pub sensor: Option<SensorName<'a>>,
    /// The robot's x, y, heading.
    pub robot: [Option<f64>; 3],
    /// The sensor's x, y, heading.
    pub pose: [Option<f64>; 3],
    /// The range; +∞: no echo.
    pub z: Option<f64>,
    /// Class label, from 1.
    pub label: Option<u64>,
}

/// Makes records from fields.
pub(super) struct RecordBuilder {
    sensors: Arc<[MountedSensor]>,
    ids: HashMap<String, u32>,
    classes: usize,
    only: Option<Kind>,
}

impl RecordBuilder {
    /// For a log of these sensors and this number of classes; `only`: leave out sensors of other kinds.
    pub fn new(sensors: Arc<[MountedSensor]>, classes: usize, only: Option<Kind>) -> Self {
        let ids = (0..).zip(sensors.iter()).map(|(i, m)| (m.sensor.id.clone(), i)).collect();
        RecordBuilder { sensors, ids, classes, only }
    }

    /// The record of a line; `None`: its sensor is of another kind.
    ///
    /// # Errors
    /// A text that names the field at fault.
    pub fn record(&self, fields: &ReadingFields<'_>, line: u64) -> Result<Option<Record>, String> {
        let need = |name: &str| format!("{name} is missing");
        let index = self.sensor(fields.sensor.as_ref())?;
        let Some(mounted) = self.sensors.get(index as usize) else {
            return Err(format!("sensor {index}: the log has {} sensors, counted from 0", self.sensors.len()));
        };
        if self.only.is_some_and(|kind| kind != mounted.sensor.kind) {
            return Ok(None);
        }
        let [px, py, ph] = fields.robot;
        let robot = Pose {
            x: px.ok_or_else(|| need("px"))?,
            y: py.ok_or_else(|| need("py"))?,
            heading: ph.ok_or_else(|| need("ph"))?,
        };
        check_pose("the robot's", &robot)?;
        let given = match fields.pose {
            [None, None, None] => None,
            [Some(x), Some(y), Some(heading)] => Some(Pose { x, y, heading }),
            _ => return Err("x, y and h go together: give all three or none".into()),
        };
        if let Some(pose) = &given {
            check_pose("the sensor's", pose)?;
        }
        let t = fields.t.unwrap_or(0.0);
        if !t.is_finite() {
            return Err(format!("t is {t}"));
        }
        let label = match fields.label {
            None => None,
            Some(label) => match u16::try_from(label) {
                Ok(label) if label > 0 && (self.classes == 0 || usize::from(label) <= self.classes) => Some(label),
                _ if self.classes > 0 => {
                    return Err(format!("label {label}: the log has classes 1 to {}", self.classes));
                }
                _ => return Err(format!("label {label}: labels are 1 to 65535")),
            },
        };
        Ok(Some(Record {
            t,
            scan: fields.scan.ok_or_else(|| need("scan"))?,
            sensor: index,
            robot,
            pose: mounted.pose(&robot, given, 0.0),
            range: fields.z.ok_or_else(|| need("z"))?,
            label,
            line,
        }))
    }

    fn sensor(&self, name: Option<&SensorName<'_>>) -> Result<u32, String> {
        match name {
            None if self.sensors.len() == 1 => Ok(0),
            None => Err("sensor is missing".into()),
            Some(SensorName::Index(index)) => Ok(u32::try_from(*index).unwrap_or(u32::MAX)),
            Some(SensorName::Id(id)) => match (self.ids.get(id.as_ref()), id.parse()) {
                (Some(index), _) => Ok(*index),
                (None, Ok(index)) => Ok(index),
                (None, Err(_)) => {
                    let known: Vec<&str> = self.sensors.iter().take(16).map(|m| m.sensor.id.as_str()).collect();
                    Err(format!("no sensor is called {}{}", quote(id), similar(id, &known)))
                }
            },
        }
    }
}
