//! A reading as the stage sees it: where it was taken, which way, and what came back.

use crate::geometry::plane::Point;
use crate::log::reading::{Outcome, Reading, Record};
use crate::sensor::Sensor;

/// One sonar reading; a missing echo is kept, it frees what lies before a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ping {
    /// Its record.
    pub record: Record,
    /// Its number among the log's pings, from 0.
    pub number: u64,
    /// The sensor, metres.
    pub at: Point,
    /// Unit vector of the axis.
    pub axis: Point,
    /// The echo's range, metres; `None`: none came.
    pub range: Option<f64>,
    /// Half a beam's width β, radians.
    pub half_width: f64,
    /// Range up to which its echoes count, metres: a missing echo tells nothing of what is farther.
    pub reach: f64,
    /// Up to where a missing echo frees its cone although nothing is known to stand behind, metres; 0: nowhere.
    pub frees: f64,
}

impl Ping {
    /// The ping of a record; `None`: its sensor's limits reject it.
    pub fn of(record: Record, number: u64, sensor: &Sensor) -> Option<Ping> {
        let z = record.range;
        if z.is_nan() || z < sensor.r_min || (z > sensor.hit_range && z <= sensor.r_max) {
            return None;
        }
        let (sin, cos) = record.pose.heading.sin_cos();
        Some(Ping {
            record,
            number,
            at: (record.pose.x, record.pose.y),
            axis: (cos, sin),
            range: (z <= sensor.r_max).then_some(z),
            half_width: sensor.half_width,
            reach: sensor.hit_range.min(sensor.r_max),
            frees: sensor.no_echo_range,
        })
    }

    /// The robot's centre, metres.
    pub fn centre(&self) -> Point {
        (self.record.robot.x, self.record.robot.y)
    }

    /// The reading that the kernels take, of range z; a missing echo's is how far it frees, metres.
    pub fn reading(&self, z: f64) -> Reading {
        let outcome = if self.range.is_some() { Outcome::Hit } else { Outcome::NoEcho };
        Reading { record: self.record, outcome, range: z }
    }
}
