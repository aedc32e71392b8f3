//! ARIA's laser logs (`.2d`, for MobileRobots' Mapper): tags with a colon, millimetres and degrees. `sick1pose:` and `sick1conf:` describe
//! a laser, `robot:` or `robotGlobal:` give the robot's pose, `sick1:` lists ranges (old logs) or `scan1:` hit points (newer ones).

use super::format::{Format, LogPath, Probe, RecordQueue, Source};
use super::mounting::MountedSensor;
use super::opening::laser_file;
use super::scan::ScanHeader;
use super::sick::no_return_code;
use super::text::{LineParser, TextLog, for_each_line};
use super::values::{check_pose, parse_number, quote};
use crate::log::reading::Pose;
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::sync::Arc;

/// No robot has more lasers; a damaged log might.
const MOST_LASERS: u32 = 16;

/// The format.
pub(crate) struct Aria;

impl Format for Aria {
    fn name(&self) -> &'static str {
        "aria"
    }

    fn describe(&self) -> &'static str {
        "an ARIA laser log (.2d, LaserOdometryLog)"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        matches!(probe, Probe::Text(text) if text.trim_start().starts_with("LaserOdometry"))
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = laser_file(place, kind, "ARIA", self.name())?;
        let (lasers, global) = read_lasers(input)?;
        let used: Vec<(u32, AriaLaser)> =
            lasers.into_iter().filter(|(_, laser)| laser.points || laser.ranges > 0).collect();
        if used.is_empty() {
            return Err(Error::input(input.path(), "an ARIA log without a sick1: or scan1: line: nothing to map"));
        }
        if let Some((n, _)) = used.iter().find(|(_, laser)| !laser.points && laser.conf.is_none()) {
            let what = format!("has sick{n}: lines, but no sick{n}conf: line that says where their beams look");
            return Err(Error::input(input.path(), what));
        }
        let mut notes = Vec::new();
        if global {
            notes.push("poses are those of robotGlobal (corrected), not those of robot (odometry)".into());
        }
        Ok(Box::new(TextLog {
            input: input.clone(),
            sensors: used.iter().map(|(n, laser)| laser.describe(*n)).collect(),
            beams: used.iter().any(|(_, laser)| !laser.points),
            posed: true,
            notes,
            parser: AriaParser { lasers: used.into(), global, t: 0.0, robot: None, scan: 0 },
        }))
    }
}

/// A laser, as far as the log describes it.
#[derive(Clone, Default)]
struct AriaLaser {
    /// Its place on the robot.
    mount: Pose,
    /// Bearings of the first and the last beam, radians, and how many there are.
    conf: Option<(f64, f64, u32)>,
    /// It gives hit points; its ranges, if there are some too, are the same again.
    points: bool,
    /// Lines of ranges.
    ranges: u64,
    /// The largest range, mm.
    largest: f64,
}

impl AriaLaser {
    fn step(&self) -> Option<f64> {
        let (first, last, count) = self.conf.filter(|(_, _, count)| *count > 1)?;
        Some((last - first) / f64::from(count - 1)).filter(|step| *step != 0.0)
    }

    fn describe(&self, n: u32) -> Description {
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

/// `sick1: …`: what the tag is, which laser it is of, and what follows.
fn split_tag(line: &str) -> Option<(&str, u32, &str)> {
    let (tag, rest) = line.trim().split_once(':')?;
    let digits = tag.find(|c: char| c.is_ascii_digit());
    let (name, what) = match digits {
        Some(at) => tag.split_at(at),
        None => return Some((tag, 0, rest)),
    };
    let end = what.find(|c: char| !c.is_ascii_digit()).unwrap_or(what.len());
    let n = what.get(..end)?.parse().ok().filter(|n| *n <= MOST_LASERS)?;
    Some(match (name, what.get(end..)?) {
        ("sick", "") => ("ranges", n, rest),
        ("scan", "") => ("points", n, rest),
        ("sick" | "scan", "pose") => ("pose", n, rest),
        ("sick" | "scan", "conf") => ("conf", n, rest),
        _ => ("other", n, rest),
    })
}

fn numbers(text: &str) -> std::result::Result<Vec<f64>, String> {
    text.split_ascii_whitespace().enumerate().map(|(i, field)| parse_number(i + 2, field)).collect()
}

/// What lasers there are, and whether the log has corrected poses.
fn read_lasers(input: &super::input::Input) -> Result<(BTreeMap<u32, AriaLaser>, bool)> {
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

#[derive(Clone)]
struct AriaParser {
    lasers: Arc<[(u32, AriaLaser)]>,
    global: bool,
    t: f64,
    robot: Option<Pose>,
    scan: u64,
}

impl LineParser for AriaParser {
    fn parse_line(
        &mut self,
        line: &str,
        at: u64,
        sensors: &[MountedSensor],
        items: &mut RecordQueue,
    ) -> std::result::Result<bool, String> {
        let text = line.trim();
        if text.is_empty() || text.starts_with('#') || text.starts_with("LaserOdometry") {
            return Ok(true);
        }
        let Some((tag, n, rest)) = split_tag(text) else {
            return Err(format!("{} is no tag of an ARIA log", quote(text)));
        };
        match tag {
            "time" | "logTime" => {
                let clock = rest.trim().split(':').map(str::parse::<f64>);
                let seconds = clock.collect::<std::result::Result<Vec<f64>, _>>().map_err(|e| format!("{tag}: {e}"))?;
                self.t = seconds.iter().fold(0.0, |t, part| 60.0 * t + part);
                return Ok(true);
            }
            "scan" | "scanId" => self.robot = None,
            _ if tag == if self.global { "robotGlobal" } else { "robot" } => {
                self.robot = None;
                let values = numbers(rest)?;
                let [x, y, turn, ..] = values[..] else { return Err(format!("{tag}: without x, y and an angle")) };
                let pose = Pose { x: x / 1000.0, y: y / 1000.0, heading: turn.to_radians() };
                check_pose("the robot's", &pose)?;
                self.robot = Some(pose);
                return Ok(true);
            }
            "ranges" | "points" => {
                let found =
                    self.lasers.iter().position(|(number, laser)| *number == n && laser.points == (tag == "points"));
                let Some(sensor) = found else { return Ok(false) };
                let robot = self.robot.ok_or("a scan without the robot's pose before it")?;
                let values = numbers(rest)?;
                let scan = ScanHeader { t: self.t, number: self.scan, sensor, robot, given: None, line: at };
                match tag {
                    "ranges" => ranges(&scan, &values, sensors, items)?,
                    _ => points(&scan, &values, &self.lasers[sensor].1.mount, sensors, items)?,
                }
                self.scan += 1;
                return Ok(true);
            }
            _ => {}
        }
        Ok(false)
    }
}

fn ranges(
    scan: &ScanHeader,
    mm: &[f64],
    sensors: &[MountedSensor],
    items: &mut RecordQueue,
) -> std::result::Result<(), String> {
    let beams = sensors.get(scan.sensor).and_then(|m| m.beams).ok_or("nothing says where its beams look")?;
    if mm.len() != beams.count as usize {
        return Err(format!("expected {} ranges, as sick1conf says, found {}", beams.count, mm.len()));
    }
    for (k, z) in mm.iter().enumerate() {
        scan.push(sensors, beams.first + k as f64 * beams.step, z / 1000.0, items);
    }
    Ok(())
}

/// Hit points in the robot's frame; (0, 0) is a beam without one.
fn points(
    scan: &ScanHeader,
    mm: &[f64],
    mount: &Pose,
    sensors: &[MountedSensor],
    items: &mut RecordQueue,
) -> std::result::Result<(), String> {
    if !mm.len().is_multiple_of(2) {
        return Err(format!("{} numbers are no pairs of x and y", mm.len()));
    }
    for point in mm.chunks_exact(2).filter(|point| *point != [0.0, 0.0]) {
        if !(point[0].is_finite() && point[1].is_finite()) {
            return Err(format!("({}, {}) is no point", point[0], point[1]));
        }
        let (dx, dy) = (point[0] / 1000.0 - mount.x, point[1] / 1000.0 - mount.y);
        scan.push(sensors, dy.atan2(dx) - mount.heading, dx.hypot(dy), items);
    }
    Ok(())
}
