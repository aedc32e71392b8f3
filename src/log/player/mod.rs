//! Logs of Player's writelog driver: a message a line, `time host robot interface index type subtype …` (Player 2 and 3) or with the
//! data's time in place of type and subtype (Player 1). Lasers, sonars and rangers are read; poses come from position2d, taken at each
//! scan's time.

use super::format::{Format, LogPath, Probe, RecordQueue, Source};
use super::mounting::MountedSensor;
use super::opening::require_file;
use super::scan::ScanHeader;
use super::text::{LineParser, TextLog};
use super::track::PoseTrack;
use super::values::check_pose;
use crate::log::reading::Pose;
use crate::sensor::Kind;
use crate::{Error, Result};
use message::{Payload, PlayerMessage, parse_line};
use std::sync::Arc;
use survey::{Device, PlayerSurvey, with_id};

mod message;
mod survey;

/// The format.
pub(crate) struct Player;

impl Format for Player {
    fn name(&self) -> &'static str {
        "player"
    }

    fn describe(&self) -> &'static str {
        "a Player log (writelog: time host robot interface index …)"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        let first = text.lines().map(|l| l.trim_start_matches('#').trim()).find(|l| !l.is_empty()).unwrap_or_default();
        first.starts_with("Player version")
            || first.starts_with("Player log")
            || text.lines().filter(|line| !line.starts_with('#')).take(16).any(message::is_player_line)
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = require_file(place, "Player")?;
        let survey = PlayerSurvey::of(input, kind)?;
        let (position, poses) = match survey.positions.into_iter().next() {
            Some((index, poses)) => (Some(index), poses),
            None => (None, Vec::new()),
        };
        if survey.sensors.is_empty() {
            let what = match kind {
                Some(Kind::Laser) => "a Player log without a laser's scans: leave out --sensor laser",
                Some(Kind::Sonar) => "a Player log without sonars that say where they sit: leave out --sensor sonar",
                None => {
                    "a Player log without laser, sonar or ranger messages that say where their beams look: nothing to map"
                }
            };
            return Err(Error::input(input.path(), what));
        }
        let mut notes = survey.notes;
        if let (Some(index), true) = (position, survey.several) {
            notes.push(format!("it has several position2d devices: poses are those of the first, position2d:{index}"));
        }
        Ok(Box::new(TextLog {
            input: input.clone(),
            sensors: survey.sensors.iter().map(|(device, count, d)| with_id(device, *count, d)).collect(),
            beams: survey.sensors.iter().any(|(_, _, d)| d.beams.is_some()),
            posed: position.is_some() || survey.scan_poses,
            notes,
            parser: PlayerParser {
                devices: survey.sensors.iter().map(|(device, _, _)| device.clone()).collect(),
                robot: survey.robot,
                track: position.map(|_| PoseTrack::of(poses)),
                posed: survey.scan_poses,
                missed: 0,
                scan: 0,
            },
        }))
    }
}

#[derive(Clone)]
struct PlayerParser {
    devices: Arc<[Device]>,
    robot: Option<(String, String)>,
    track: Option<PoseTrack>,
    /// Whether scans carry the robot's pose.
    posed: bool,
    missed: u64,
    scan: u64,
}

impl LineParser for PlayerParser {
    fn parse_line(
        &mut self,
        line: &str,
        at: u64,
        sensors: &[MountedSensor],
        items: &mut RecordQueue,
    ) -> std::result::Result<bool, String> {
        let Some(PlayerMessage { t, robot: from, index, what }) = parse_line(line)? else { return Ok(true) };
        if self.robot.as_ref() != Some(&from) {
            return Ok(false);
        }
        let find = |wanted: &Device| self.devices.iter().position(|device| device == wanted);
        let (sensor, own, ranges) = match what {
            Payload::Laser(layout, pose, ranges) => (find(&Device::Laser(index, layout)), pose, ranges),
            Payload::Sonar(ranges) => (find(&Device::Sonar(index, 0, ranges.len())), None, ranges),
            Payload::Ranger(ranges) => {
                let laser = find(&Device::RangerLaser(index, ranges.len()));
                (laser.or_else(|| find(&Device::Ranger(index, 0, ranges.len()))), None, ranges)
            }
            Payload::Position(pose) => {
                check_pose("the robot's", &pose)?;
                return Ok(false);
            }
            _ => return Ok(false),
        };
        let Some(sensor) = sensor else { return Ok(false) };
        let robot = match (own, &self.track) {
            (Some(pose), _) => Some(pose),
            (None, Some(track)) => track.at(t),
            (None, None) if self.posed => return Err("a scan without a pose, in a log whose scans carry theirs".into()),
            (None, None) => Some(Pose::default()),
        };
        let Some(robot) = robot else {
            self.missed += 1;
            if let Some(track) = &self.track {
                track.count_missed(self.missed);
            }
            return Ok(false);
        };
        check_pose("the robot's", &robot)?;
        let scan = |sensor| ScanHeader { t, number: self.scan, sensor, robot, given: None, line: at };
        match sensors.get(sensor).and_then(|m| m.beams) {
            Some(beams) => {
                let scan = scan(sensor);
                for (k, z) in ranges.iter().enumerate() {
                    scan.push(sensors, beams.first + k as f64 * beams.step, *z, items);
                }
            }
            None => {
                for (k, z) in ranges.iter().enumerate() {
                    scan(sensor + k).push(sensors, 0.0, *z, items);
                }
            }
        }
        self.scan += 1;
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        self.track.iter().filter_map(|track| track.note("scans")).collect()
    }
}
