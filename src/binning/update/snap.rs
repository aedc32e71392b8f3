//! Snaps an update to integers: its cone, and the points of its shapes in units from the snapped sensor.

use crate::binning::snap::{self, Footprint, SLACK, place, snap};
use crate::feature::{Fan, Update};
use crate::geometry::layout::{ARC_LIMIT, CELL, Cone, FREE_LIMIT, NO_ECHO, Shapes};
use crate::geometry::plane::Point;
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Reading};
use crate::sensor::{Kind, Sensor};
use crate::{Error, Result};
use bytemuck::Zeroable;

/// The largest distance of an update's point from its sensor, units: 512 cells. Products of such coordinates fit 32 bits.
pub const FARTHEST: i64 = 512 * CELL as i64;

/// By how much a feature's line raises P(occupied) from ½, to 0.8, and its free region lowers it, to 0.2.
const SAYS: f64 = 0.3;

/// A snapped update.
#[derive(Debug, Clone)]
pub struct Snapped {
    /// The cone of the routine part; without one, only its sensor is set.
    pub cone: Cone,
    /// Fans, lines and weights of the parts. They index `points`.
    pub shapes: Shapes,
    /// The vertices of fans and the ends of lines, units from the sensor.
    pub points: Vec<[i32; 2]>,
    /// Whether there is a routine part whose cone meets the grid.
    pub routine: bool,
    /// Whether any part may occupy cells.
    pub may_occupy: bool,
}

/// Checks that no sonar may see farther than updates can reach in cells of `resolution`, metres.
///
/// # Errors
/// [`Error::Usage`], which tells the user what to do.
pub fn check(sensors: &[Sensor], resolution: f64) -> Result<()> {
    for sensor in sensors.iter().filter(|s| s.kind == Kind::Sonar) {
        let reach = sensor.r_max + sensor.epsilon(resolution) + 2.0 * resolution;
        if 32.0 * reach / resolution > FARTHEST as f64 {
            return Err(Error::Usage(format!(
                "sensor {}: r_max is {} m, more than the 512 cells of {resolution} m that method features takes: give a \
                 coarser `resolution` or a smaller `r_max`",
                sensor.id, sensor.r_max
            )));
        }
    }
    Ok(())
}

/// A function that gives the four parameters of a method's profile for one reading of a sensor.
pub type Profile<'a> = dyn Fn(&Sensor, &snap::Snapped) -> [f32; 4] + 'a;

/// Snaps an update. Returns `None` if no part of it reaches the grid.
///
/// # Errors
/// [`Error::Usage`] if the update names an unknown sensor, has more than two parts, or reaches farther than 512 cells.
pub fn snapped(grid: &GridSpec, sensors: &[Sensor], profile: &Profile, update: &Update) -> Result<Option<Snapped>> {
    let reading = &update.reading;
    let line = reading.record.line;
    let Some(sensor) = sensors.get(reading.record.sensor as usize) else {
        let (index, known) = (reading.record.sensor, sensors.len());
        return Err(Error::Usage(format!("the update of line {line} names sensor {index}, of {known}")));
    };
    if update.parts.len() > 2 {
        let parts = update.parts.len();
        return Err(Error::Usage(format!("the update of line {line} has {parts} parts, more than two features")));
    }
    let pose = reading.record.pose;
    let mut points = Points { grid, reading, sensor: place(grid, (pose.x, pose.y)), all: Vec::new() };
    let mut shapes = Shapes { number: update.number as u32, ..Shapes::zeroed() };
    for (k, part) in update.parts.iter().enumerate() {
        shapes.fans[k] = points.fan(part.free.as_ref())?;
        shapes.lines[k] = points.add(part.occupied.iter().flatten())?;
        shapes.weights[k] = (SAYS * part.weight) as f32;
    }
    let mut cone = None;
    if let Some(routine) = &update.routine {
        shapes.weights[2] = routine.weight as f32;
        shapes.fans[2] = points.fan(routine.free.as_ref())?;
        shapes.fans[3] = points.fan(routine.arc.as_ref())?;
        let flag = |limit: &Option<Fan>, bit: u32| if limit.is_some() { bit } else { 0 };
        shapes.flags = flag(&routine.free, FREE_LIMIT) | flag(&routine.arc, ARC_LIMIT);
        let reach = reading.range + sensor.epsilon(grid.resolution);
        if reach.is_nan() || 32.0 * reach / grid.resolution > FARTHEST as f64 {
            return Err(points.far(reach));
        }
        cone = snap(grid, sensor, reading, Footprint::Cone, None).map(|(cone, snapped)| Cone {
            profile: profile(sensor, &snapped),
            flags: cone.flags | if routine.occupies { 0 } else { NO_ECHO },
            ..cone
        });
    }
    // The points of a sensor farther than this from the grid do not reach it.
    let reaches = |k: usize| {
        let cells = [grid.width, grid.height][k] as i64;
        (-FARTHEST - SLACK..=i64::from(CELL) * cells + FARTHEST + SLACK).contains(&points.sensor[k])
    };
    if !reaches(0) || !reaches(1) {
        return Ok(None);
    }
    let routine = cone.is_some();
    let alone = Cone { sensor: points.sensor.map(|v| v as i32), ..Cone::zeroed() };
    let hit = reading.outcome == Outcome::Hit;
    let may_occupy = update.parts.iter().any(|p| !p.occupied.is_empty())
        || update.routine.as_ref().is_some_and(|r| r.occupies && hit);
    Ok(Some(Snapped { cone: cone.unwrap_or(alone), shapes, points: points.all, routine, may_occupy }))
}

/// Collects an update's points.
struct Points<'a> {
    grid: &'a GridSpec,
    reading: &'a Reading,
    /// The snapped sensor, to which the points are relative.
    sensor: [i64; 2],
    all: Vec<[i32; 2]>,
}

impl Points<'_> {
    fn fan(&mut self, fan: Option<&Fan>) -> Result<[u32; 2]> {
        fan.map_or(Ok([0; 2]), |fan| self.add(fan.vertices.iter()))
    }

    /// Adds points and returns their range: first, end (exclusive).
    fn add<'p>(&mut self, points: impl Iterator<Item = &'p Point>) -> Result<[u32; 2]> {
        let from = self.all.len() as u32;
        for point in points {
            let at = place(self.grid, (point.x, point.y));
            let v = [at[0] - self.sensor[0], at[1] - self.sensor[1]];
            let pose = self.reading.record.pose;
            let away = (point.x - pose.x).hypot(point.y - pose.y);
            if !away.is_finite()
                || v.iter().any(|c| c.abs() > FARTHEST)
                || v[0] * v[0] + v[1] * v[1] > FARTHEST * FARTHEST
            {
                return Err(self.far(away));
            }
            self.all.push(v.map(|c| c as i32));
        }
        Ok([from, self.all.len() as u32])
    }

    fn far(&self, metres: f64) -> Error {
        Error::Usage(format!(
            "the update of line {} reaches {metres:.2} m, more than 512 cells of {} m: give a coarser `resolution` or a \
             smaller `r_max`",
            self.reading.record.line, self.grid.resolution
        ))
    }
}
