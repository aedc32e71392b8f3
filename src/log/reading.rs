//! Readings in the world frame: one range from one sensor pose, classified by the sensor's limits.
//!
//! World frame: metres, x right, y up, angles in radians counter-clockwise from +x.

use crate::sensor::{AtMax, Sensor};
use nalgebra::{Isometry2, Point2, Vector2};
use serde::Serialize;

/// A position and a heading in the world frame: metres, radians.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Metres to the right.
    pub x: f64,
    /// Metres up.
    pub y: f64,
    /// Radians counter-clockwise from +x.
    pub heading: f64,
}

impl Pose {
    /// The position, metres.
    pub fn position(&self) -> Point2<f64> {
        Point2::new(self.x, self.y)
    }

    /// The unit vector of the heading.
    pub fn direction(&self) -> Vector2<f64> {
        let (sin, cos) = self.heading.sin_cos();
        Vector2::new(cos, sin)
    }

    /// The transformation from this pose's own frame (x forward, y left) to the world frame.
    pub fn isometry(&self) -> Isometry2<f64> {
        Isometry2::new(self.position().coords, self.heading)
    }

    /// The world pose of something at (`x`, `y`, `heading`) in this pose's own frame (x forward, y left).
    ///
    /// [`Pose::isometry`] adds the rotated vector to the position as a whole, which rounds otherwise in the last bit: logs are
    /// held to these sums.
    pub fn compose(&self, x: f64, y: f64, heading: f64) -> Pose {
        let (s, c) = self.heading.sin_cos();
        Pose { x: self.x + c * x - s * y, y: self.y + s * x + c * y, heading: self.heading + heading }
    }
}

/// One record of a log as it was read, before the sensor's limits are applied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Time stamp, seconds.
    pub t: f64,
    /// The scan it belongs to, counted from 0.
    pub scan: u64,
    /// Index into the log's sensors.
    pub sensor: u32,
    /// The robot's pose of its scan.
    pub robot: Pose,
    /// The sensor's own pose.
    pub pose: Pose,
    /// Range in metres; +∞ is no echo; NaN and negative values are passed on, to be counted.
    pub range: f64,
    /// Class label, from 1, where the log has one.
    pub label: Option<u16>,
    /// Line of the log, counted from 1.
    pub line: u64,
}

/// Whether an echo came back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// An echo from `range`.
    Hit,
    /// No echo: the interior of a cone of `range` (the sensor's `no_echo_range`) is free, and there is no arc.
    NoEcho,
}

/// A reading to be mapped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The record it comes from.
    pub record: Record,
    /// Hit or no echo.
    pub outcome: Outcome,
    /// R in metres: the echo's range, or the sensor's `no_echo_range`.
    pub range: f64,
}

/// The reason for which a record is not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unused {
    /// No echo, and the sensor's `no_echo_range` is 0.
    NoEcho,
    /// Nearer than `r_min`.
    BelowRMin,
    /// Not a number.
    NotANumber,
    /// Negative.
    Negative,
    /// An echo from beyond `hit_range`.
    BeyondHitRange,
}

/// Classifies a record by its sensor's limits.
///
/// # Errors
/// The reason for which the record is not used.
pub fn classify(record: Record, sensor: &Sensor) -> Result<Reading, Unused> {
    let z = record.range;
    if z.is_nan() {
        Err(Unused::NotANumber)
    } else if z < 0.0 {
        Err(Unused::Negative)
    } else if z < sensor.r_min {
        Err(Unused::BelowRMin)
    } else if z > sensor.r_max || (z == sensor.r_max && sensor.at_r_max == AtMax::NoEcho) {
        if sensor.no_echo_range > 0.0 {
            Ok(Reading { record, outcome: Outcome::NoEcho, range: sensor.no_echo_range })
        } else {
            Err(Unused::NoEcho)
        }
    } else if z > sensor.hit_range {
        Err(Unused::BeyondHitRange)
    } else {
        Ok(Reading { record, outcome: Outcome::Hit, range: z })
    }
}

/// Records rejected, by reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Rejected {
    /// Nearer than `r_min`.
    pub below_r_min: u64,
    /// Not a number.
    pub not_a_number: u64,
    /// Negative.
    pub negative: u64,
    /// An echo from beyond `hit_range`.
    pub beyond_hit_range: u64,
}

/// Counts of a log's records by how they were used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// All records.
    pub read: u64,
    /// Mapped: hits, and missing echoes that free something.
    pub used: u64,
    /// Missing echoes, used or not.
    pub no_echo: u64,
    /// Used, but no cell of the grid lies inside the cone.
    pub outside: u64,
    /// Used hits with interior cells but no arc cell.
    pub empty_arc: u64,
    /// Used, with a cell inside the grid, reaching farther than 1024 cells: decided in 64-bit integers.
    pub wide: u64,
    /// Not used, by reason.
    pub rejected: Rejected,
}

impl Counts {
    /// Counts one classified record.
    pub fn add(&mut self, classified: &Result<Reading, Unused>) {
        self.read += 1;
        match classified {
            Ok(reading) => {
                self.used += 1;
                self.no_echo += u64::from(reading.outcome == Outcome::NoEcho);
            }
            Err(Unused::NoEcho) => self.no_echo += 1,
            Err(Unused::BelowRMin) => self.rejected.below_r_min += 1,
            Err(Unused::NotANumber) => self.rejected.not_a_number += 1,
            Err(Unused::Negative) => self.rejected.negative += 1,
            Err(Unused::BeyondHitRange) => self.rejected.beyond_hit_range += 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_isometry_is_a_composition_but_for_the_last_bits() {
        let robot = Pose { x: 3.25, y: -7.5, heading: 2.3 };
        let (one, two) = (robot.compose(0.4, -0.7, 0.1).position(), robot.isometry() * Point2::new(0.4, -0.7));
        assert!((one - two).norm() < 1e-14, "{one} and {two}");
        assert_eq!(robot.isometry() * Point2::origin(), robot.position());
        assert!((robot.isometry() * Vector2::x() - robot.direction()).norm() < 1e-15);
    }
}
