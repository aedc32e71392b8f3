//! Snaps a reading to its cone: position, radii and directions in integers, rotated on the host in f64.
//!
//! One unit is 1/32 of a cell, and a direction is the unit vector times 8192. All are rounded half up. From here on,
//! membership is exact.

use crate::geometry::cone::{Wide, on_axis_wide};
use crate::geometry::layout::{BROAD, CELL, Cone, DIRECTION, HALF_OPEN, NARROW_BEAM, NO_ECHO, WIDE};
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Reading};
use crate::sensor::Sensor;

/// The shape of the cells that a reading may update.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Footprint {
    /// The interior and arc of the cone; a narrow cone is at least a cell wide.
    Cone,
    /// The half-open cone between given edges, with an arc 1½ cells deep, so that a cell belongs to one beam of a scan.
    Wedge,
    /// The cells on the axis up to the hit.
    Axis,
}

/// The range and the arc's half depth of a reading after snapping, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snapped {
    /// The range R, metres.
    pub range: f64,
    /// The arc's half depth ε, metres.
    pub epsilon: f64,
}

/// The left and right edges of a wedge, radians in the world frame.
pub type Edges = (f64, f64);

/// Reach beyond which membership is decided in 64 bits, units: 1024 cells.
const NARROW: i64 = 1024 * CELL as i64;
/// The largest β, radians, for which the off-axis angle is computed from its tangent: 22.5°.
const BROADEST: f64 = std::f64::consts::FRAC_PI_8;
/// The largest reach that [`snap`] accepts, units.
const FARTHEST: i64 = 1 << 28;
/// By how much a footprint may exceed its reach and its edges, units.
pub(crate) const SLACK: i64 = 2 * CELL as i64;

/// ⌊v + ½⌋, clamped to limits that no grid reaches. It avoids `f64::floor`, which is a library call on the oldest processors.
pub(crate) fn round(v: f64) -> i64 {
    let v = (v + 0.5).clamp(-1e15, 1e15);
    let near = v as i64;
    near - i64::from(near as f64 > v)
}

fn direction(angle: f64) -> [i32; 2] {
    [angle.cos(), angle.sin()].map(|v| round(f64::from(DIRECTION) * v) as i32)
}

fn length([x, y]: [i32; 2]) -> f64 {
    f64::from(x * x + y * y).sqrt()
}

/// Converts a point of the world frame, metres, to units from the grid's lower left corner.
pub(crate) fn place(grid: &GridSpec, (x, y): (f64, f64)) -> [i64; 2] {
    let units = |v: f64| 32.0 * v / grid.resolution;
    [
        round(units(x - grid.anchor.0)) - i64::from(CELL) * grid.i0,
        round(units(y - grid.anchor.1)) - i64::from(CELL) * grid.j0,
    ]
}

/// Snaps a reading to the grid. Returns `None` if its reach does not meet the grid or exceeds the limit.
pub fn snap(
    grid: &GridSpec,
    sensor: &Sensor,
    reading: &Reading,
    footprint: Footprint,
    edges: Option<Edges>,
) -> Option<(Cone, Snapped)> {
    let units = |v: f64| 32.0 * v / grid.resolution;
    let epsilon = match footprint {
        Footprint::Wedge => 0.75 * grid.resolution,
        _ => sensor.epsilon(grid.resolution),
    };
    let no_echo = reading.outcome == Outcome::NoEcho;
    let (range, depth) = match (footprint, no_echo) {
        (Footprint::Axis, true) => (round(units(reading.range - epsilon)), round(units(epsilon))),
        _ => (round(units(reading.range)), round(units(epsilon))),
    };
    let reach = match footprint {
        Footprint::Axis => [range, range.max(0) + SLACK],
        _ => [(range - depth).max(0), range + depth],
    };
    let pose = reading.record.pose;
    let [x, y] = place(grid, (pose.x, pose.y));
    let meets =
        |at: i64, cells: usize| at + reach[1] + SLACK >= 0 && at - reach[1] - SLACK <= i64::from(CELL) * cells as i64;
    if reach[1] > FARTHEST || !meets(x, grid.width) || !meets(y, grid.height) {
        return None;
    }
    let beta = sensor.half_width;
    let (left, right) = edges.unwrap_or((pose.heading + beta, pose.heading - beta));
    let narrow = sensor.narrow();
    let flag = |on: bool, bit: u32| if on { bit } else { 0 };
    let axis = direction(pose.heading);
    let turn = if narrow || beta == 0.0 { 0.0 } else { 1.0 / beta };
    let cone = Cone {
        sensor: [x as i32, y as i32],
        reach: reach.map(|r| r as i32),
        axis,
        left: direction(left),
        right: direction(right),
        flags: flag(no_echo, NO_ECHO)
            | flag(narrow && footprint == Footprint::Cone, NARROW_BEAM)
            | flag(footprint == Footprint::Wedge, HALF_OPEN)
            | flag(range + depth > NARROW, WIDE)
            | flag(turn > 0.0 && beta > BROADEST, BROAD),
        index: 0,
        shape: [length(axis) as f32, turn as f32, 0.0, 0.0],
        profile: [0.0; 4],
    };
    let metres = |u: i64| u as f64 * grid.resolution / 32.0;
    Some((cone, Snapped { range: metres(range), epsilon: metres(depth) }))
}

/// Whether one cell of the grid is in the interior, and whether it is on the arc, decided on the host. The arc of a reading
/// without an echo counts as arc, except for [`Footprint::Axis`], where the last cell is interior.
pub fn region(cone: &Cone, footprint: Footprint, column: i64, row: i64) -> (bool, bool) {
    let v = [
        (i64::from(CELL) * column + 16 - i64::from(cone.sensor[0])) as i32,
        (i64::from(CELL) * row + 16 - i64::from(cone.sensor[1])) as i32,
    ];
    match footprint {
        Footprint::Axis => match on_axis_wide(cone, v) {
            (before, hit) if cone.flags & NO_ECHO != 0 => (before || hit, false),
            regions => regions,
        },
        _ => Wide::of(cone, v).regions(),
    }
}
