//! The outline of a snapped cone, as lines over the grid. It is made of the integers that decide membership.
//!
//! Coordinates are cells, from the grid's lower left corner, y up: cell (column c, row r) has its centre at (c + ½, r + ½).

use crate::binning::snap::{Footprint, snap};
use crate::geometry::layout::{CELL, NARROW_BEAM, NO_ECHO};
use crate::grid::GridSpec;
use crate::log::reading::Reading;
use crate::sensor::Sensor;
use crate::{Error, Result};
use serde::Serialize;
use std::f64::consts::TAU;

/// A point, in cells.
pub(crate) type Point = (f64, f64);

/// The distance from the anchor beyond which nothing is drawn, cells.
const FARTHEST: u64 = 1 << 40;

/// The outline of a reading's cone.
pub(crate) struct ConeOutline {
    /// The position of the sensor.
    pub sensor: Point,
    /// The axis, from the sensor to the far end.
    pub axis: [Point; 2],
    /// Edges and arcs.
    pub lines: Vec<Vec<Point>>,
}

/// The reading's numbers after snapping, as the JSON shows them.
#[derive(Serialize)]
pub(crate) struct SnappedCone {
    /// Length of a unit, 1/32 cell, metres.
    unit: f64,
    /// The sensor, units from the grid's lower left corner.
    sensor: [i64; 2],
    /// The ranges where the arc begins and ends, units (himm: R, twice).
    reach: [i32; 2],
    /// Directions, in 1/8192.
    axis: [i32; 2],
    left: [i32; 2],
    right: [i32; 2],
    /// R, metres.
    range: f64,
    /// ε, metres.
    epsilon: f64,
}

impl ConeOutline {
    /// The outline of a reading, and the snapped cone. `wedge`: the bearings of its edges, radians, for [`Footprint::Wedge`].
    ///
    /// # Errors
    /// [`Error::Usage`] for a reading that is too far from the grid's anchor.
    pub fn of(
        grid: &GridSpec,
        sensor: &Sensor,
        reading: &Reading,
        footprint: Footprint,
        wedge: Option<(f64, f64)>,
    ) -> Result<(ConeOutline, SnappedCone)> {
        // Snapped on the one cell where the sensor is: a reading that misses the grid has an outline too.
        let pose = reading.record.pose;
        let cell = |v: f64, anchor: f64| ((v - anchor) / grid.resolution).floor() as i64;
        let (i0, j0) = (cell(pose.x, grid.anchor.0), cell(pose.y, grid.anchor.1));
        let near = i0.unsigned_abs().max(j0.unsigned_abs()) < FARTHEST;
        let here = GridSpec { i0, j0, width: 1, height: 1, ..*grid };
        let edges = wedge.filter(|_| footprint == Footprint::Wedge);
        let snapped = if near { snap(&here, sensor, reading, footprint, edges) } else { None };
        let Some((cone, metres)) = snapped else {
            let (line, range) = (reading.record.line, reading.range);
            let (x, y) = (pose.x, pose.y);
            return Err(Error::Usage(format!(
                "the reading of line {line}, {range} m from ({x}, {y}), is too far to draw"
            )));
        };
        let unit = i64::from(CELL);
        let at = [unit * (i0 - grid.i0) + i64::from(cone.sensor[0]), unit * (j0 - grid.j0) + i64::from(cone.sensor[1])];
        let axis_only = footprint == Footprint::Axis;
        let reach = if axis_only { [cone.reach[0]; 2] } else { cone.reach };
        let snapped = SnappedCone {
            unit: grid.resolution / f64::from(CELL),
            sensor: at,
            reach,
            axis: cone.axis,
            left: cone.left,
            right: cone.right,
            range: metres.range,
            epsilon: metres.epsilon,
        };
        let cells = |units: f64| units / f64::from(CELL);
        let start = (cells(at[0] as f64), cells(at[1] as f64));
        let bearing = |v: [i32; 2]| f64::from(v[1]).atan2(f64::from(v[0]));
        let along = |angle: f64, r: f64| (start.0 + r * angle.cos(), start.1 + r * angle.sin());
        let (axis, left, right) = (bearing(cone.axis), bearing(cone.left), bearing(cone.right));
        let [inner, outer] = reach.map(|r| cells(f64::from(r.max(0))));
        // A missing echo has no arc: its cone ends where its interior does.
        let far = if cone.flags & NO_ECHO != 0 { inner } else { outer };
        let strip = if cone.flags & NARROW_BEAM != 0 { 0.5 } else { 0.0 };
        let mut lines: Vec<Vec<Point>> = [left, right].map(|edge| vec![start, along(edge, far)]).into();
        for side in [strip, -strip].into_iter().filter(|s| *s != 0.0) {
            let aside = |p: Point| (p.0 - side * axis.sin(), p.1 + side * axis.cos());
            lines.push(vec![aside(start), aside(along(axis, far))]);
        }
        let opening = (left - right).rem_euclid(TAU);
        for r in if inner < far { vec![inner, far] } else { vec![far] } {
            // A laser's arc is as wide as its strip, at least.
            let half = (opening / 2.0).max((strip / r.max(strip).max(1e-9)).asin());
            let middle = right + opening / 2.0;
            let arc = |k: i32| along(middle + half * f64::from(k) / 64.0, r);
            lines.push((-64..=64).map(arc).collect());
        }
        Ok((ConeOutline { sensor: start, axis: [start, along(axis, far)], lines }, snapped))
    }

    /// All points of the outline.
    pub fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.lines.iter().flatten().chain(&self.axis).copied()
    }
}
