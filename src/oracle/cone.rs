//! The snapped cone: which cells a reading reaches, decided in 64-bit integers (1 unit = 1/32 cell).
//!
//! The rules are those of every backend; the code is the oracle's own. A beam is scanned row by row over spans that
//! are supersets by a cell and more; every cell of a span is then decided exactly.

use super::{CellUpdate, Region};
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Reading};
use crate::sensor::Sensor;
use crate::{Error, Result};

/// Units in a cell.
const UNITS: i64 = 32;
/// Length of a snapped direction.
const LENGTH: f64 = 8192.0;
/// Units beyond which a reading counts as wide: 1024 cells.
const WIDE: i64 = 1024 * UNITS;
/// Largest reach in units: beyond it squares would leave 64 bits.
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

/// A reading's cell: where it lies from the sensor, in units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// Row-major index into the grid.
    pub index: usize,
    /// Interior or arc.
    pub region: Region,
    /// Centre − sensor.
    pub v: Vector,
}

/// A reading's beam, snapped, with what the profiles need in metres and radians.
#[derive(Debug, Clone)]
pub(super) struct Cone {
    rule: Rule,
    origin: Vector,
    axis: Vector,
    left: Vector,
    right: Vector,
    /// R in units (for HIMM's missing echo: what is free).
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
                "the reading of line {line} reaches {} m, more than {} cells: lower r_max or coarsen --resolution",
                reading.range,
                REACH_LIMIT / 32.0
            )));
        }
        let place = |v: f64, anchor: f64| {
            let far = (1u64 << 40) as f64;
            (32.0 * (v - anchor) / grid.resolution + 0.5).floor().clamp(-far, far) as i64
        };
        let (left, right) = wedge.unwrap_or((pose.heading + beta, pose.heading - beta));
        let hit = reading.outcome == Outcome::Hit;
        let (range, depth) = (radius(reading.range) as i64, radius(epsilon) as i64);
        let band = if rule == Rule::Wedge { TRUTH_BAND } else { depth };
        let free = if rule == Rule::Axis && !hit { radius(reading.range - epsilon) as i64 } else { range };
        let unit = grid.resolution / 32.0;
        Ok(Cone {
            rule,
            origin: (place(pose.x, grid.anchor.0), place(pose.y, grid.anchor.1)),
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

    /// Where the cell with centre − sensor = `v` lies, whatever the outcome; `None`: not in the beam.
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

    /// HIMM's rule: on the axis, before the hit or at it.
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

    /// Puts this reading's cells of the grid into `cells`; returns n, its arc cells (for a missing echo the arc that
    /// it would have, which is not put into `cells`).
    pub fn cells(&self, grid: &GridSpec, cells: &mut Vec<Cell>) -> usize {
        cells.clear();
        let mut arc = 0;
        let axis = self.rule == Rule::Axis;
        let reach = if axis { self.reach + 2 * UNITS } else { self.outer };
        let (left, right) = if axis { (self.axis, self.axis) } else { (self.left, self.right) };
        // A narrow beam's strip: its cross products with the edges exceed 0 by half a cell and the directions' snapping.
        let slack = match self.rule {
            Rule::Cone | Rule::Wedge => 0.0,
            Rule::Narrow => 16.0 * LENGTH + 4.0 * reach as f64,
            Rule::Axis => 16.0 * LENGTH,
        };
        let first = (UNITS * grid.i0 + UNITS / 2 - self.origin.0, UNITS * grid.j0 + UNITS / 2 - self.origin.1);
        for row in span(-reach as f64, reach as f64, first.1, grid.height) {
            let vy = first.1 + UNITS * row as i64;
            let (y, r) = (vy as f64, reach as f64);
            let half = (r * r - y * y).max(0.0).sqrt();
            let (mut low, mut high) = (-half, half);
            // cross(left, v) ≤ slack and cross(right, v) ≥ −slack, solved for v.0
            for (edge, sign) in [(left, 1.0), (right, -1.0)] {
                let (ex, ey) = (edge.0 as f64, edge.1 as f64);
                if ey * sign > 0.0 {
                    low = low.max((ex * y - sign * slack) / ey);
                } else if ey * sign < 0.0 {
                    high = high.min((ex * y - sign * slack) / ey);
                }
            }
            for column in span(low - 1.0, high + 1.0, first.0, grid.width) {
                let v = (first.0 + UNITS * column as i64, vy);
                let Some(region) = self.region(v) else { continue };
                arc += usize::from(region == Region::Arc);
                if self.hit || region == Region::Interior {
                    cells.push(Cell { index: row * grid.width + column, region, v });
                }
            }
        }
        arc
    }

    /// How far it reaches, units.
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

    /// The cell as it is reported.
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

/// The cells of a row or column whose centres lie between `low` and `high` units, and one more on either side.
fn span(low: f64, high: f64, first: i64, count: usize) -> std::ops::Range<usize> {
    let at = |v: f64| (v - first as f64) / UNITS as f64;
    let from = (at(low).floor() - 1.0).clamp(0.0, count as f64) as usize;
    let to = (at(high).ceil() + 2.0).clamp(0.0, count as f64) as usize;
    from..to.max(from)
}

/// Refuses a sensor that the rules don't cover.
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
