//! The logs of CMU's course 16-833 (`robotdata1.log`): `L x y θ xl yl θl r1 … r180 t` is a scan with the robot's and the laser's
//! poses, `O x y θ t` odometry. Centimetres and radians; beam k at −90° + k · 1°; ranges from 8183 cm on are no return.

use super::format::{Format, LogPath, Probe, RecordQueue, Source};
use super::mounting::MountedSensor;
use super::opening::laser_file;
use super::scan::ScanHeader;
use super::sick::SICK_CODES;
use super::text::{LineParser, TextLog};
use super::values::{check_pose, parse_number, quote};
use crate::Result;
use crate::log::reading::Pose;
use crate::sensor::{Description, Kind};

/// Beams of a scan.
const BEAMS: u32 = 180;
/// Fields of a scan: the tag, two poses, the ranges and the time.
const SCAN_FIELDS: usize = 1 + 6 + BEAMS as usize + 1;
/// The laser's position, metres in front of the robot's centre.
const LASER_X: f64 = 0.25;

/// The format.
pub(crate) struct Cmu;

impl Format for Cmu {
    fn name(&self) -> &'static str {
        "cmu"
    }

    fn describe(&self) -> &'static str {
        "a robotdata log of CMU's course 16-833 (L and O lines, centimetres)"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        text.lines().filter(|line| !line.trim().is_empty()).take(16).any(|line| {
            let mut fields = line.split_ascii_whitespace();
            let wanted = match fields.next() {
                Some("L") => SCAN_FIELDS,
                Some("O") => 5,
                _ => return false,
            };
            let rest: Vec<&str> = fields.collect();
            // The first line of a file may be cut off, or lack a beam.
            rest.iter().all(|field| field.parse::<f64>().is_ok()) && rest.len().abs_diff(wanted - 1) <= wanted / 8
        })
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = laser_file(place, kind, "CMU", self.name())?;
        let laser = Description {
            id: Some("laser".into()),
            kind: Some(Kind::Laser),
            x: Some(LASER_X),
            r_max: Some(SICK_CODES[0].start() / 100.0),
            beams: Some(BEAMS),
            first: Some(-90f64.to_radians()),
            step: Some(1f64.to_radians()),
            ..Description::default()
        };
        Ok(Box::new(TextLog {
            input: input.clone(),
            sensors: vec![laser],
            beams: true,
            posed: true,
            notes: Vec::new(),
            parser: CmuParser { scan: 0 },
        }))
    }
}

#[derive(Clone)]
struct CmuParser {
    scan: u64,
}

impl LineParser for CmuParser {
    fn parse_line(
        &mut self,
        line: &str,
        at: u64,
        sensors: &[MountedSensor],
        items: &mut RecordQueue,
    ) -> std::result::Result<bool, String> {
        let fields: Vec<&str> = line.split_ascii_whitespace().collect();
        let value = |i: usize| parse_number(i + 1, fields.get(i).copied().unwrap_or_default());
        let pose =
            |i: usize| Ok::<_, String>(Pose { x: value(i)? / 100.0, y: value(i + 1)? / 100.0, heading: value(i + 2)? });
        match fields.first() {
            None => return Ok(true),
            Some(&"O") => return Ok(false),
            Some(&"L") if fields.len() == SCAN_FIELDS => {}
            Some(&"L") => return Err(format!("expected {SCAN_FIELDS} fields in an L line, found {}", fields.len())),
            Some(tag) => return Err(format!("{} is neither L nor O", quote(tag))),
        }
        let (robot, laser) = (pose(1)?, pose(4)?);
        check_pose("the robot's", &robot)?;
        check_pose("the laser's", &laser)?;
        let t = value(SCAN_FIELDS - 1)?;
        if !t.is_finite() {
            return Err(format!("the time stamp is {t}"));
        }
        let scan = ScanHeader { t, number: self.scan, sensor: 0, robot, given: Some(laser), line: at };
        let beams = sensors.first().and_then(|m| m.beams).ok_or("the beams are not laid out")?;
        for k in 0..BEAMS as usize {
            let cm = value(7 + k)?;
            let range = if cm >= *SICK_CODES[0].start() { f64::INFINITY } else { cm / 100.0 };
            scan.push(sensors, beams.first + k as f64 * beams.step, range, items);
        }
        self.scan += 1;
        Ok(true)
    }
}
