//! A complete sensor on the robot: its beams, and the pose of a reading.

use crate::log::reading::Pose;
use crate::sensor::Sensor;

/// The beam layout of a laser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Beams {
    /// How many.
    pub count: u32,
    /// Bearing of the first from the sensor's axis, radians.
    pub first: f64,
    /// From one to the next, radians.
    pub step: f64,
}

impl Beams {
    /// `count` beams, evenly over a field of view about the axis, radians. Over a full circle the last beam is one step from the
    /// first.
    pub fn over(fov: f64, count: u32) -> Beams {
        let gaps = if fov > std::f64::consts::TAU - 1e-6 { count } else { count.saturating_sub(1) };
        Beams { count, first: -fov / 2.0, step: fov / f64::from(gaps.max(1)) }
    }
}

/// A complete sensor with its beam layout and the origin of its pose.
#[derive(Debug, Clone)]
pub(crate) struct MountedSensor {
    /// The sensor.
    pub sensor: Sensor,
    /// Its beams, if it is a laser whose scans have a fixed layout.
    pub beams: Option<Beams>,
    /// The user gave its pose, which overrides a sensor pose in the log.
    pub placed: bool,
    /// It is at the robot's centre, whatever the log says (`mounts=none`).
    pub centred: bool,
}

impl MountedSensor {
    /// The world pose of a reading, `off` radians from the sensor's axis; `given` is the sensor's pose in the log.
    pub fn pose(&self, robot: &Pose, given: Option<Pose>, off: f64) -> Pose {
        match given {
            Some(pose) if !self.placed => {
                let (x, y) = if self.centred { (robot.x, robot.y) } else { (pose.x, pose.y) };
                Pose { x, y, heading: pose.heading + off }
            }
            _ => robot.compose(self.sensor.x, self.sensor.y, self.sensor.axis + off),
        }
    }
}
