//! The snapped cone: which cells a reading reaches, decided in 64-bit integers (1 unit = 1/32 cell).
//!
//! The rules are those of every backend; the code is the oracle's own. `raster` lists the cells of a cone.

mod raster;

use super::{CellUpdate, Region};
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Reading};
use crate::sensor::Sensor;
use crate::{Error, Result};

/// Units in a cell.
const UNITS: i64 = 32;
/// Length of a snapped direction.
const LENGTH: f64 = 8192.0;
/// Reach above which a reading counts as wide, units: 1024 cells.
const WIDE: i64 = 1024 * UNITS;
/// Largest reach, units: its square fits 64 bits.
const REACH_LIMIT: f64 = (1u64 << 30) as f64;
/// Half the depth of the laser truth's hit band, units: ¾ cell.
const TRUTH_BAND: i64 = 24;

/// A vector in units or in 1/8192.
pub(super) type Vector = (i64, i64);

/// z of the cross product.
fn cross(a: Vector, b: Vector) -> i64 {
    a.0 * b.1 - a.1 * b.0
}

/// The dot product.
fn dot(a: Vector, b: Vector) -> i64 {
    a.0 * b.0 + a.1 * b.1
}

/// The membership rule of a beam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Rule {
    /// Centre inside the cone.
    Cone,
    /// Centre inside the cone, or within half a cell of the axis.
    Narrow,
    /// The cells on the axis, one a step (HIMM).
    Axis,
    /// The half-open wedge between two bearings, right and left (laser truth).
    Wedge,
}

/// A cell of a reading's cone, with its position relative to the sensor, in units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Row-major index into the grid.
    pub index: usize,
    /// Interior or arc.
    pub region: Region,
    /// Centre − sensor.
    pub v: Vector,
}

/// A reading's beam, snapped to integers, with the lengths and angles of the profiles in metres and radians.
#[derive(Debug, Clone)]
pub(super) struct Cone {
    rule: Rule,
    origin: Vector,
    axis: Vector,
    left: Vector,
    right: Vector,
    /// R in units; of HIMM's missing echo R − ε, up to which it is free.
    reach: i64,
    inner: i64,
    outer: i64,
    /// A missing echo has no arc.
    pub hit: bool,
    /// Reaches beyond 1024 cells.
    pub wide: bool,
    /// A narrow beam's θ is 0.
    pub narrow: bool,
    /// Metres in a unit.
    pub unit: f64,
    /// R in metres, snapped.
    pub range: f64,
    /// ε in metres, snapped.
    pub epsilon: f64,
    /// R − ε − `r_min` in metres; not positive: the radial term of Emp is 1.
    pub span: f64,
    /// The sensor's smallest range, metres.
    pub r_min: f64,
    /// The sensor's largest range, metres.
    pub r_max: f64,
    /// β in radians.
    pub beta: f64,
}

impl Cone {
    /// Snaps a reading. `wedge`: (left, right) bearings in radians, for [`Rule::Wedge`] only.
    pub fn new(
        grid: &GridSpec,
        sensor: &Sensor,
        reading: &Reading,
        rule: Rule,
        wedge: Option<(f64, f64)>,
    ) -> Result<Self> {
        let (pose, line) = (reading.record.pose, reading.record.line);
        let beta = sensor.half_width;
        let epsilon = sensor.epsilon(grid.resolution);
        check(sensor, epsilon)?;
        let radius = |r: f64| (32.0 * r / grid.resolution + 0.5).floor();
        if !(pose.x.is_finite() && pose.y.is_finite() && pose.heading.is_finite()) {
            return Err(Error::Usage(format!("the reading of line {line} has no finite pose: remove the line")));
        }
        let reaches = |r: f64| (-1.0..REACH_LIMIT).contains(&r);
        if !reaches(radius(reading.range) + radius(epsilon)) {
            return Err(Error::Usage(format!(
                "the reading of line {line} reaches {} m, more than {} cells: lower r_max or coarsen `resolution`",
                reading.range,
                REACH_LIMIT / 32.0
            )));
        }
        let snap = |v: f64, anchor: f64| {
            let limit = (1u64 << 40) as f64;
            (32.0 * (v - anchor) / grid.resolution + 0.5).floor().clamp(-limit, limit) as i64
        };
        let (left, right) = wedge.unwrap_or((pose.heading + beta, pose.heading - beta));
        let hit = reading.outcome == Outcome::Hit;
        let (range, depth) = (radius(reading.range) as i64, radius(epsilon) as i64);
        let band = if rule == Rule::Wedge { TRUTH_BAND } else { depth };
        let free = if rule == Rule::Axis && !hit { radius(reading.range - epsilon) as i64 } else { range };
        let unit = grid.resolution / 32.0;
        Ok(Cone {
            rule,
            origin: (snap(pose.x, grid.anchor.0), snap(pose.y, grid.anchor.1)),
            axis: direction(pose.heading),
            left: direction(left),
            right: direction(right),
            reach: free,
            inner: (range - band).max(0),
            outer: range + band,
            hit,
            wide: range + band > WIDE,
            narrow: sensor.narrow(),
            unit,
            range: range as f64 * unit,
            epsilon: depth as f64 * unit,
            span: (range - depth) as f64 * unit - sensor.r_min,
            r_min: sensor.r_min,
            r_max: sensor.r_max,
            beta,
        })
    }

    /// The region of the cell with centre − sensor = `v`, whatever the reading's outcome; `None`: the cell is not in the beam.
    fn region(&self, v: Vector) -> Option<Region> {
        if self.rule == Rule::Axis {
            return self.axis_region(v);
        }
        let along = dot(self.axis, v);
        if along < 0 {
            return None;
        }
        let (left, right) = (cross(self.left, v), cross(self.right, v));
        let inside = match self.rule {
            Rule::Wedge => right >= 0 && left < 0,
            _ => left <= 0 && 0 <= right,
        };
        let near_axis = self.rule == Rule::Narrow
            && cross(self.axis, v).abs() <= 16 * LENGTH as i64
            && along <= self.outer * LENGTH as i64;
        let d2 = dot(v, v);
        if !(inside || near_axis) || d2 > self.outer * self.outer {
            None
        } else if d2 < self.inner * self.inner {
            Some(Region::Interior)
        } else {
            Some(Region::Arc)
        }
    }

    /// HIMM's rule: the cells on the axis, those before the hit and the hit's own.
    fn axis_region(&self, v: Vector) -> Option<Region> {
        let (c, s, a, b) = if self.axis.0.abs() >= self.axis.1.abs() {
            (self.axis.0, self.axis.1, v.0, v.1)
        } else {
            (self.axis.1, self.axis.0, v.1, v.0)
        };
        let sign = c.signum();
        let off = (b * c - a * s) * sign;
        if a * sign < 0 || off < -16 * c.abs() || off >= 16 * c.abs() {
            return None;
        }
        let length = LENGTH as i64;
        let beyond = length * a * sign - self.reach * c.abs();
        if beyond < -16 * length {
            Some(Region::Interior)
        } else if beyond < 16 * length {
            // a missing echo has no hit: its last cell is free
            Some(if self.hit { Region::Arc } else { Region::Interior })
        } else {
            None
        }
    }

    /// The largest distance of a cell's centre from the sensor, units.
    pub fn outer(&self) -> i64 {
        self.outer
    }

    /// Distance in metres and off-axis angle in radians of a cell, for the profiles.
    pub fn polar(&self, v: Vector) -> (f64, f64) {
        let d = (dot(v, v) as f64).sqrt() * self.unit;
        if self.narrow {
            return (d, 0.0);
        }
        (d, (cross(self.axis, v).abs() as f64).atan2(dot(self.axis, v) as f64))
    }

    /// The cell with its column and row, for callers outside of the oracle.
    pub fn update(&self, grid: &GridSpec, cell: &Cell) -> CellUpdate {
        let (d, theta) = self.polar(cell.v);
        let (column, row) = (cell.index % grid.width, cell.index / grid.width);
        CellUpdate { column, row, region: cell.region, d, theta }
    }
}

/// A unit direction in 1/8192.
fn direction(angle: f64) -> Vector {
    let (s, c) = angle.sin_cos();
    ((LENGTH * c + 0.5).floor() as i64, (LENGTH * s + 0.5).floor() as i64)
}

/// Refuses a sensor outside of the limits of the membership rules.
fn check(sensor: &Sensor, epsilon: f64) -> Result<()> {
    let widest = 60f64.to_radians() + 1e-12;
    if !(0.0..=widest).contains(&sensor.half_width) {
        let degrees = sensor.half_width.to_degrees();
        return Err(Error::Usage(format!("sensor {}: beta is {degrees} deg; give 0 to 60 deg", sensor.id)));
    }
    if !(sensor.r_max.is_finite() && sensor.r_max > 0.0 && sensor.r_min.is_finite()) {
        let (low, high) = (sensor.r_min, sensor.r_max);
        return Err(Error::Usage(format!(
            "sensor {}: r_min {low} and r_max {high} must be finite, r_max above 0",
            sensor.id
        )));
    }
    if !(epsilon.is_finite() && epsilon >= 0.0) {
        return Err(Error::Usage(format!("sensor {}: epsilon is {epsilon} m; give 0 or more", sensor.id)));
    }
    Ok(())
}
