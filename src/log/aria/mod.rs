//! ARIA's laser logs (`.2d`, for MobileRobots' Mapper): tags with a colon, millimetres and degrees. `sick1pose:` and `sick1conf:` describe
//! a laser, `robot:` or `robotGlobal:` give the robot's pose, `sick1:` lists ranges (old logs) or `scan1:` hit points (newer ones).

use super::format::{Format, LogPath, Probe, RecordQueue, Source};
use super::mounting::MountedSensor;
use super::opening::laser_file;
use super::scan::ScanHeader;
use super::text::{LineParser, TextLog};
use super::values::{check_pose, quote};
use crate::log::reading::Pose;
use crate::sensor::Kind;
use crate::{Error, Result};
use lasers::{AriaLaser, numbers, read_lasers, split_tag};
use std::sync::Arc;

mod lasers;

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

/// Appends readings from hit points in the robot's frame; (0, 0) is a beam without a hit.
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
