//! The data of a log of named variables: poses, and for each pose the ranges of its beams or their hit points.

use super::array::Array;
use super::element::ReadResult;
use super::fields::{Field, resolve};
use super::scan_values::ScanValues;
use crate::log::mounting::Beams;
use crate::log::reading::Pose;
use crate::sensor::angle;

/// Half the usual beam spacing of such lasers, degrees.
pub(super) const HALF_WIDTH: f64 = 0.5;

/// The bearings of the beams.
enum Bearings {
    /// The same in every scan.
    Same(Vec<f64>),
    /// A list for each scan.
    Each(ScanValues, f64),
    /// The first bearing and the step, radians: of each scan, or one for all.
    Even(Vec<f64>, Vec<f64>),
    /// Evenly over this field of view, radians.
    Over(f64),
}

/// Poses, readings and bearings of a log.
pub(super) struct ScanData {
    pub poses: Vec<Pose>,
    /// Times of the poses, seconds; empty if unknown.
    pub times: Vec<f64>,
    pub r_max: Option<f64>,
    /// The laser's pose on the robot.
    pub mount: Option<Pose>,
    readings: ScanValues,
    scale: f64,
    /// `None`: the readings are hit points.
    bearings: Option<Bearings>,
    labels: Option<ScanValues>,
}

/// One number for each scan: from a row, a column, or a cell array.
fn series(array: &Array, key: &str) -> ReadResult<Vec<f64>> {
    match array {
        Array::Numbers { rows, values } if *rows <= 1 || *rows == values.len() => Ok(values.clone()),
        Array::Cells(cells) => cells
            .iter()
            .map(|cell| match cell {
                Array::Numbers { values, .. } if values.len() == 1 => Ok(values[0]),
                other => Err(format!("{key} is a cell with {other}, not a number each")),
            })
            .collect(),
        other => Err(format!("{key} is {other}, not a number for each scan")),
    }
}

/// A 3 × N or N × 3 matrix, or a cell of three numbers each; `true`: scans are columns.
fn poses(array: &Array, scale: f64) -> ReadResult<(Vec<Pose>, bool)> {
    let pose = |x: f64, y: f64, h: f64| Pose { x, y, heading: h * scale };
    match array {
        Array::Numbers { rows, values } => {
            let columns = values.len() / (*rows).max(1);
            // 3 × 3 numbers are read as a pose in each row.
            if columns == 3 {
                let at = |i: usize, k: usize| values.get(k * rows + i).copied().unwrap_or(f64::NAN);
                return Ok(((0..*rows).map(|i| pose(at(i, 0), at(i, 1), at(i, 2))).collect(), false));
            }
            match rows {
                3 => Ok((values.chunks_exact(3).map(|p| pose(p[0], p[1], p[2])).collect(), true)),
                _ => Err(format!(
                    "pose is {array}, not 3 × N or N × 3: name x, y and heading by themselves, as x=P(:,1)"
                )),
            }
        }
        Array::Cells(cells) => {
            let each = cells.iter().map(|cell| match cell {
                Array::Numbers { values, .. } if values.len() == 3 => Ok(pose(values[0], values[1], values[2])),
                other => Err(format!("pose is a cell with {other}, not three numbers each")),
            });
            Ok((each.collect::<ReadResult<Vec<Pose>>>()?, false))
        }
        other => Err(format!("pose is {other}, not 3 × N or N × 3 numbers")),
    }
}

impl ScanData {
    /// Finds the fields in the variables.
    ///
    /// # Errors
    /// A text that names the key at fault.
    pub fn of(variables: &[(String, Array)], fields: &[Field]) -> ReadResult<ScanData> {
        let field = |key: &str| fields.iter().find(|field| field.key == key);
        let array = |field: &Field| resolve(variables, &field.path).map_err(|what| format!("{}: {what}", field.key));
        let list = |key: &str| -> ReadResult<Option<Vec<f64>>> {
            let Some(field) = field(key) else { return Ok(None) };
            // A plain number is a value, not a variable's name.
            if let Ok(number) = angle(&field.path) {
                return Ok(Some(vec![number * field.scale]));
            }
            Ok(Some(series(&array(field)?, key)?.into_iter().map(|v| v * field.scale).collect()))
        };
        let (poses, by_columns) = match field("pose") {
            Some(field) => poses(&array(field)?, field.scale)?,
            None => {
                let (x, y, h) = (list("x")?, list("y")?, list("heading")?);
                let (x, y, h) = (x.unwrap_or_default(), y.unwrap_or_default(), h.unwrap_or_default());
                if x.len() != y.len() || x.len() != h.len() {
                    let (x, y, h) = (x.len(), y.len(), h.len());
                    return Err(format!("{x} x, {y} y and {h} heading: as many are wanted"));
                }
                let all = x.iter().zip(&y).zip(&h).map(|((x, y), h)| Pose { x: *x, y: *y, heading: *h });
                (all.collect(), false)
            }
        };
        let n = poses.len();
        let key = if field("points").is_some() { "points" } else { "ranges" };
        let named = field(key).ok_or("name ranges or points")?;
        let readings = ScanValues::of(array(named)?, n, by_columns, key)?;
        if key == "points" && !matches!(readings, ScanValues::Cells(_)) {
            return Err("points must be a cell of 2 × N points for each pose".into());
        }
        let each = |values: Vec<f64>, key: &str| match values.len() {
            1 => Ok(values),
            found if found == n => Ok(values),
            found => Err(format!("{found} numbers in {key} for {n} poses: one, or as many")),
        };
        let bearings = if key == "points" {
            None
        } else if let Some(field) = field("angles") {
            Some(match array(field)? {
                Array::Numbers { rows, values } if rows <= 1 || rows == values.len() => {
                    Bearings::Same(values.into_iter().map(|v| v * field.scale).collect())
                }
                other => Bearings::Each(ScanValues::of(other, n, by_columns, "angles")?, field.scale),
            })
        } else if let (Some(first), Some(step)) = (list("first")?, list("step")?) {
            Some(Bearings::Even(each(first, "first")?, each(step, "step")?))
        } else {
            let fov = list("fov")?.and_then(|fov| fov.first().copied()).ok_or("name the beams' bearings")?;
            Some(Bearings::Over(fov))
        };
        let times = match list("t")? {
            Some(times) if times.len() == n => times,
            Some(times) => return Err(format!("{} times in t for {n} poses: as many are wanted", times.len())),
            None => Vec::new(),
        };
        let mount = match field("mount") {
            None => None,
            Some(field) => match array(field)? {
                Array::Cells(cells) => cells.into_iter().next(),
                other => Some(other),
            },
        };
        let mount = match mount {
            Some(Array::Numbers { values, .. }) if values.len() == 3 => {
                Some(Pose { x: values[0], y: values[1], heading: values[2] })
            }
            None => None,
            Some(other) => return Err(format!("mount is {other}, not x, y and heading")),
        };
        let r_max = list("r_max")?.and_then(|r| r.into_iter().reduce(f64::max)).filter(|r| *r > 0.05 && r.is_finite());
        let labels = match field("labels") {
            Some(field) => Some(ScanValues::of(array(field)?, n, by_columns, "labels")?),
            None => None,
        };
        Ok(ScanData { poses, times, r_max, mount, readings, scale: named.scale, bearings, labels })
    }

    /// Half the angle from beam to beam of the first scan, radians.
    pub fn half_width(&self) -> Option<f64> {
        let all = (0..self.poses.len().min(16)).filter_map(|i| self.scan(i).ok()).find(|scan| scan.len() > 1)?;
        self.bearings.as_ref()?;
        Some(((all[1].0 - all[0].0) / 2.0).abs()).filter(|half| *half > 1e-5 && *half < 0.5)
    }

    /// The readings of a scan: bearing, range, label.
    pub fn scan(&self, i: usize) -> ReadResult<Vec<(f64, f64, Option<f64>)>> {
        let values = self.readings.scan(i)?;
        let labels = self.labels.as_ref().map(|labels| labels.scan(i)).transpose()?;
        let Some(bearings) = &self.bearings else { return self.points(i) };
        let count = values.len();
        let off: Vec<f64> = match bearings {
            Bearings::Same(all) => all.clone(),
            Bearings::Each(all, scale) => all.scan(i)?.into_iter().map(|v| v * scale).collect(),
            Bearings::Even(first, step) => {
                let at = |all: &[f64]| all.get(i).or(all.first()).copied().unwrap_or(f64::NAN);
                (0..count).map(|k| at(first) + k as f64 * at(step)).collect()
            }
            Bearings::Over(fov) => {
                let beams = Beams::over(*fov, count as u32);
                (0..count).map(|k| beams.first + k as f64 * beams.step).collect()
            }
        };
        if off.len() != count {
            return Err(format!("{count} ranges, but {} angles", off.len()));
        }
        if let Some(odd) = off.iter().find(|angle| !angle.is_finite()) {
            return Err(format!("an angle is {odd}"));
        }
        let label = |k: usize| labels.as_ref().and_then(|l| l.get(k).copied());
        Ok(off.into_iter().zip(values).enumerate().map(|(k, (a, z))| (a, z * self.scale, label(k))).collect())
    }

    fn points(&self, i: usize) -> ReadResult<Vec<(f64, f64, Option<f64>)>> {
        let ScanValues::Cells(cells) = &self.readings else { return Err("no cell of points".into()) };
        match cells.get(i) {
            Some(Array::Numbers { values, .. }) if values.is_empty() => Ok(Vec::new()),
            Some(Array::Numbers { rows: rows @ (2 | 3), values }) => {
                Ok(values.chunks_exact(*rows).map(|p| hit(p[0], p[1], self.scale, p.get(2).copied())).collect())
            }
            // A point a row.
            Some(Array::Numbers { rows, values }) if matches!(values.len() / rows.max(&1), 2 | 3) => {
                let at = |k: usize, axis: usize| values.get(axis * rows + k).copied();
                let point = |k| hit(at(k, 0).unwrap_or(f64::NAN), at(k, 1).unwrap_or(f64::NAN), self.scale, at(k, 2));
                Ok((0..*rows).map(point).collect())
            }
            Some(other) => Err(format!("{other}, not 2 × N or 3 × N points")),
            None => Ok(Vec::new()),
        }
    }
}

fn hit(x: f64, y: f64, scale: f64, label: Option<f64>) -> (f64, f64, Option<f64>) {
    (y.atan2(x), x.hypot(y) * scale, label)
}
