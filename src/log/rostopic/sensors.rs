//! The sensors of a ROS topic, from the first rows of each frame.

use super::row::{Body, TopicLayout, cell};
use crate::log::cells::split_cells;
use crate::sensor::{Description, Kind};
use std::borrow::Cow;

/// The largest number of sensors of a log; a damaged log might name more.
const MAX_SENSORS: usize = 256;

/// The name of a row's frame, or `sensor`.
pub(super) fn frame<'a>(layout: &TopicLayout, cells: &'a [Cow<'_, str>]) -> &'a str {
    match layout.frame.and_then(|i| cells.get(i)) {
        Some(name) if !name.is_empty() => name,
        _ => "sensor",
    }
}

/// The sensors of a topic by their frames, as their first rows describe them.
#[derive(Default)]
pub(super) struct TopicSensors {
    pub sensors: Vec<(String, Description)>,
}

impl TopicSensors {
    /// Adds the sensor of a row, if it is a new one.
    pub fn add(&mut self, layout: &TopicLayout, line: &str) {
        let cells = split_cells(line, b',');
        let name = frame(layout, &cells);
        if self.sensors.iter().any(|(known, _)| known == name) || self.sensors.len() >= MAX_SENSORS {
            return;
        }
        if let Ok(description) = describe(layout, &cells, name) {
            self.sensors.push((name.into(), description));
        }
    }
}

/// The description of a row's sensor.
///
/// # Errors
/// A text that names the bad cell.
pub(super) fn describe(layout: &TopicLayout, cells: &[Cow<'_, str>], name: &str) -> Result<Description, String> {
    let limits = |low: f64, high: f64| {
        let fine = low >= 0.0 && high > low && high < 1e6;
        (Some(low).filter(|low| fine && *low > 0.0), Some(high).filter(|_| fine))
    };
    let id = Some(name.to_string());
    match &layout.body {
        Body::Scan(head, _) | Body::OpenScan(head, _) => {
            let [first, step, low, high] = angles(cells, head)?;
            let (r_min, r_max) = limits(low, high);
            let count = ranges(layout, cells)?.len() as u32;
            let (beams, first, step) = (Some(count.max(2)), Some(first), Some(step));
            Ok(Description { id, kind: Some(Kind::Laser), r_min, r_max, beams, first, step, ..Description::default() })
        }
        Body::Range([fov, low, high, z], radiation) => {
            cell(cells, *z, "the range")?;
            let infrared = radiation.is_some_and(|i| cell(cells, i, "radiation_type") == Ok(1.0));
            let (r_min, r_max) = limits(cell(cells, *low, "min_range")?, cell(cells, *high, "max_range")?);
            let half_width = Some(cell(cells, *fov, "field_of_view")? / 2.0).filter(|w| (0.001..=1.04).contains(w));
            let kind = Some(if infrared { Kind::Laser } else { Kind::Sonar });
            Ok(Description { id, kind, r_min, r_max, half_width, ..Description::default() })
        }
        Body::Pose(_) => Err("a pose".into()),
    }
}

/// The first bearing, step, smallest and largest range of a scan.
///
/// # Errors
/// A text that names the bad cell.
pub(super) fn angles(cells: &[Cow<'_, str>], head: &[usize; 4]) -> Result<[f64; 4], String> {
    let names = ["angle_min", "angle_increment", "range_min", "range_max"];
    let mut values = [0.0; 4];
    for ((value, i), name) in values.iter_mut().zip(head).zip(names) {
        *value = cell(cells, *i, name)?;
    }
    if !(values[0].is_finite() && values[1].is_finite() && values[1] != 0.0) {
        return Err(format!("angle_min {} or angle_increment {} is no angle", values[0], values[1]));
    }
    Ok(values)
}

/// The cells of a row that are its ranges.
///
/// # Errors
/// A text that says how many cells were expected.
pub(super) fn ranges<'a, 'b>(layout: &TopicLayout, cells: &'b [Cow<'a, str>]) -> Result<&'b [Cow<'a, str>], String> {
    match &layout.body {
        Body::Scan(_, range) => cells.get(range.clone()).ok_or_else(|| "ends before its last range".to_string()),
        Body::OpenScan([first, step, ..], from) => {
            // angle_max is between them.
            let [a, b, s] = [*first, first + 1, *step].map(|i| cell(cells, i, "the angles"));
            let count = ((b? - a?) / s?).round() + 1.0;
            let rest = cells.get(*from..).unwrap_or_default();
            let fits = |found: usize| (found as f64 - count).abs() <= 1.0;
            match rest.len() {
                found if fits(found) => Ok(rest),
                found if found.is_multiple_of(2) && fits(found / 2) => Ok(&rest[..found / 2]),
                found => Err(format!(
                    "expected about {count} ranges as its angles say, and as many intensities or none, found {found} cells"
                )),
            }
        }
        _ => Ok(&[]),
    }
}
