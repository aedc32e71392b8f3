//! A sonar reading as the feature stage takes it: the sensor's pose and the echo.

use crate::geometry::plane::{Point, Vector};
use crate::log::reading::{Outcome, Reading, Record};
use crate::sensor::Sensor;

/// One sonar reading. A missing echo is one as well: it frees the area in front of a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ping {
    /// Its record.
    pub record: Record,
    /// Its number among the log's pings, from 0.
    pub number: u64,
    /// The position of the sensor, world frame, metres.
    pub at: Point,
    /// Unit vector of the beam's axis.
    pub axis: Vector,
    /// The range of the echo, metres; `None`: it is missing.
    pub range: Option<f64>,
    /// Half a beam's width β, radians.
    pub half_width: f64,
    /// The range up to which echoes count, metres: a missing echo has no meaning beyond.
    pub reach: f64,
    /// The range up to which a missing echo frees its cone where no wall is known, metres; 0: it frees nothing.
    pub frees: f64,
}

impl Ping {
    /// The ping of a record; `None` if the sensor's limits reject it.
    pub fn of(record: Record, number: u64, sensor: &Sensor) -> Option<Ping> {
        let z = record.range;
        if z.is_nan() || z < sensor.r_min || (z > sensor.hit_range && z <= sensor.r_max) {
            return None;
        }
        Some(Ping {
            record,
            number,
            at: record.pose.position(),
            axis: record.pose.direction(),
            range: (z <= sensor.r_max).then_some(z),
            half_width: sensor.half_width,
            reach: sensor.hit_range.min(sensor.r_max),
            frees: sensor.no_echo_range,
        })
    }

    /// The position of the robot, world frame, metres.
    pub fn centre(&self) -> Point {
        self.record.robot.position()
    }

    /// The reading for the kernels, of range `z`, metres: the range of an echo, or the range up to which a missing echo frees.
    pub fn reading(&self, z: f64) -> Reading {
        let outcome = if self.range.is_some() { Outcome::Hit } else { Outcome::NoEcho };
        Reading { record: self.record, outcome, range: z }
    }
}
