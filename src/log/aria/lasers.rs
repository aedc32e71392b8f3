//! The first pass over an ARIA log: its lasers, and whether it has corrected poses.

use crate::Result;
use crate::log::input::Input;
use crate::log::reading::Pose;
use crate::log::sick::no_return_code;
use crate::log::text::for_each_line;
use crate::log::values::parse_number;
use crate::sensor::{Description, Kind};
use std::collections::BTreeMap;

/// The largest number of a laser; a damaged log might have larger ones.
const MAX_LASERS: u32 = 16;

/// A laser, as far as the log describes it.
#[derive(Clone, Default)]
pub(super) struct AriaLaser {
    /// Its pose on the robot.
    pub mount: Pose,
    /// The bearings of the first and the last beam, radians, and the number of beams.
    pub conf: Option<(f64, f64, u32)>,
    /// The log has its hit points. Ranges beside them are the same readings.
    pub points: bool,
    /// The number of lines of ranges.
    pub ranges: u64,
    /// The largest range, mm.
    pub largest: f64,
}

impl AriaLaser {
    fn step(&self) -> Option<f64> {
        let (first, last, count) = self.conf.filter(|(_, _, count)| *count > 1)?;
        Some((last - first) / f64::from(count - 1)).filter(|step| *step != 0.0)
    }

    /// Its description; `n` is its number.
    pub fn describe(&self, n: u32) -> Description {
        let beams = |value| if self.points { None } else { value };
        Description {
            id: Some(format!("laser{n}")),
            kind: Some(Kind::Laser),
            x: Some(self.mount.x),
            y: Some(self.mount.y),
            axis: Some(self.mount.heading),
            half_width: self.step().map(|step| (step.abs() / 2.0).min(0.5)),
            r_max: no_return_code(self.largest).map(|code| code / 1000.0),
            beams: self.conf.map(|(_, _, count)| count).filter(|_| !self.points),
            first: beams(self.conf.map(|(first, _, _)| first)),
            step: beams(self.step()),
            ..Description::default()
        }
    }
}

/// Splits `sick1: …` into the kind of the tag, the laser's number and the rest of the line.
pub(super) fn split_tag(line: &str) -> Option<(&str, u32, &str)> {
    let (tag, rest) = line.trim().split_once(':')?;
    let digits = tag.find(|c: char| c.is_ascii_digit());
    let (name, what) = match digits {
        Some(at) => tag.split_at(at),
        None => return Some((tag, 0, rest)),
    };
    let end = what.find(|c: char| !c.is_ascii_digit()).unwrap_or(what.len());
    let n = what.get(..end)?.parse().ok().filter(|n| *n <= MAX_LASERS)?;
    Some(match (name, what.get(end..)?) {
        ("sick", "") => ("ranges", n, rest),
        ("scan", "") => ("points", n, rest),
        ("sick" | "scan", "pose") => ("pose", n, rest),
        ("sick" | "scan", "conf") => ("conf", n, rest),
        _ => ("other", n, rest),
    })
}

/// The numbers after a tag.
///
/// # Errors
/// A text that names the field.
pub(super) fn numbers(text: &str) -> std::result::Result<Vec<f64>, String> {
    text.split_ascii_whitespace().enumerate().map(|(i, field)| parse_number(i + 2, field)).collect()
}

/// Reads the lasers of the log, and whether it has corrected poses.
pub(super) fn read_lasers(input: &Input) -> Result<(BTreeMap<u32, AriaLaser>, bool)> {
    let mut lasers: BTreeMap<u32, AriaLaser> = BTreeMap::new();
    let mut global = false;
    for_each_line(input, |line, _| {
        let Some((tag, n, rest)) = split_tag(line) else { return true };
        match tag {
            "robotGlobal" => global |= numbers(rest).is_ok_and(|v| v.len() >= 3),
            "pose" | "conf" | "ranges" | "points" => {
                let Ok(values) = numbers(rest) else { return true };
                let laser = lasers.entry(n).or_default();
                match (tag, values[..].len(), &values[..]) {
                    // scan1pose has a height before its angle.
                    ("pose", 3 | 4, [x, y, .., turn]) => {
                        laser.mount = Pose { x: x / 1000.0, y: y / 1000.0, heading: turn.to_radians() };
                    }
                    ("conf", 3, [first, last, count]) if (1.0..1e6).contains(count) => {
                        laser.conf = Some((first.to_radians(), last.to_radians(), *count as u32));
                    }
                    ("ranges", ..) => {
                        laser.ranges += 1;
                        laser.largest = values.iter().copied().fold(laser.largest, f64::max);
                    }
                    ("points", ..) => laser.points = true,
                    _ => {}
                }
            }
            _ => {}
        }
        true
    })?;
    Ok((lasers, global))
}
