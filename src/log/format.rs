//! What a log format is to the rest: it claims a log by its content, describes its sensors, and streams its scans.
//! **Adding a format is one file and one line in [`FORMATS`].**

use super::input::Input;
use super::{Problem, aria, carmen, cmu, csv, jsonl, matlab, player, rostopic, sonar_ring_8};
use crate::log::reading::{Pose, Record};
use crate::sensor::{Description, Kind, Sensor};
use crate::{Error, Result};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// Every format, in the order in which they are asked.
pub(crate) const FORMATS: &[&dyn Format] = &[
    &sonar_ring_8::SonarRing8,
    &jsonl::JsonLines,
    &csv::Csv,
    &rostopic::RosTopic,
    &aria::Aria,
    &player::Player,
    &cmu::Cmu,
    &carmen::Carmen,
    &matlab::Matlab,
    &matlab::Octave,
];

/// What a format is shown to tell whether a log is its own.
pub(crate) enum Probe<'a> {
    /// A folder.
    Folder(&'a Path),
    /// The first bytes of a file, unpacked.
    Text(&'a str),
}

/// Where a log lies.
#[derive(Clone)]
pub(crate) enum Place {
    /// A folder of files.
    Folder(std::path::PathBuf),
    /// One file or stream.
    File(Input),
}

/// A log format.
pub(crate) trait Format: Sync {
    /// Its name, in reports.
    fn name(&self) -> &'static str;
    /// What it looks like, for the message about an unknown format.
    fn looks(&self) -> &'static str;
    /// Whether a log is of this format.
    fn claims(&self, probe: &Probe<'_>) -> bool;
    /// Opens a log, checking all that can be checked before a run. `kind`: which sensors are wanted.
    fn open(&self, place: &Place, kind: Option<Kind>) -> Result<Box<dyn Source>>;
}

/// An open log of some format.
pub(crate) trait Source: Send + Sync {
    /// Its sensors, as far as the format or the log describes them.
    fn sensors(&self) -> &[Description];
    /// The line of the log that describes them, if one does.
    fn sensor_line(&self) -> Option<u64> {
        None
    }
    /// Whether the beams of a laser scan are laid out by its sensor (else each record carries its own heading).
    fn has_beams(&self) -> bool;
    /// Whether it has the robot's poses; a log without them needs `--poses`.
    fn has_poses(&self) -> bool {
        true
    }
    /// Refuses sensors that, complete as they are, don't say what the log leaves open.
    fn ready(&self, _sensors: &[Mounted]) -> Result<()> {
        Ok(())
    }
    /// Whether a preset of the program, not the log, describes its sensors.
    fn has_preset(&self) -> bool {
        false
    }
    /// Where the layout of a sensor's beams comes from, and whether that is plain: nothing that a user should look at.
    fn beams_origin(&self, _sensor: usize) -> Option<(String, bool)> {
        None
    }
    /// What of a sensor's ranges is taken for no return, if any is, in a whole sentence.
    fn silence(&self, _sensor: usize) -> Option<String> {
        None
    }
    /// Names of the class labels 1, 2, …
    fn classes(&self) -> &[String] {
        &[]
    }
    /// What a user should know of how the log is read, in whole sentences: what was taken for a missing return, which messages are
    /// left out, which layout of beams was assumed.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
    /// The files it reads, in a fixed order: the checksum runs over them.
    fn inputs(&self) -> Vec<&Input>;
    /// A pass over the log from its start. Lines of other kinds are counted in `ignored`.
    fn scans(&self, sensors: Arc<[Mounted]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn Scans>>;
}

/// What a pass gives.
pub(crate) type Items = VecDeque<std::result::Result<Record, Problem>>;

/// A pass over a log.
pub(crate) trait Scans: Send {
    /// Reads on by a line or a scan and appends what it held, if anything; `false` at the end.
    fn fill(&mut self, items: &mut Items) -> bool;
}

/// The beams of a laser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Beams {
    /// How many.
    pub count: u32,
    /// Bearing of the first from the sensor's axis, radians.
    pub first: f64,
    /// From one to the next, radians.
    pub step: f64,
}

impl Beams {
    /// So many beams evenly over a field of view about the axis, radians; all around, the last stands beside the first.
    pub fn over(fov: f64, count: u32) -> Beams {
        let gaps = if fov > std::f64::consts::TAU - 1e-6 { count } else { count.saturating_sub(1) };
        Beams { count, first: -fov / 2.0, step: fov / f64::from(gaps.max(1)) }
    }
}

/// A sensor, and where its readings are taken to come from.
#[derive(Debug, Clone)]
pub(crate) struct Mounted {
    /// The sensor.
    pub sensor: Sensor,
    /// Its beams, if it is a laser whose scans are laid out.
    pub beams: Option<Beams>,
    /// The user has placed it: that beats a sensor pose given in the log.
    pub placed: bool,
    /// It sits at the robot's centre, whatever the log says (`mounts=none`).
    pub centred: bool,
}

impl Mounted {
    /// The pose of a reading, `off` from the sensor's axis; `given` is the sensor's pose as the log has it.
    pub fn pose(&self, robot: &Pose, given: Option<Pose>, off: f64) -> Pose {
        match given {
            Some(pose) if !self.placed => {
                let (x, y) = if self.centred { (robot.x, robot.y) } else { (pose.x, pose.y) };
                Pose { x, y, heading: pose.heading + off }
            }
            _ => robot.compose(self.sensor.x, self.sensor.y, self.sensor.axis + off),
        }
    }
}

/// Poses further out are taken for damage: float noise would drown a cell there.
const FARTHEST: f64 = 1e6;
/// Headings beyond this are no headings: a robot that turned 1600 times, or a number in another column.
const LARGEST_ANGLE: f64 = 1e4;

/// Refuses a pose that is not finite or absurdly far out; the text names the value.
pub(crate) fn check_pose(what: &str, pose: &Pose) -> std::result::Result<(), String> {
    for (name, value) in [("x", pose.x), ("y", pose.y), ("heading", pose.heading)] {
        if !value.is_finite() {
            return Err(format!("{what} {name} is {value}"));
        }
        if name == "heading" && value.abs() > LARGEST_ANGLE {
            return Err(format!("{what} heading is {value} rad, more than 1e4 rad either way"));
        }
        if name != "heading" && value.abs() > FARTHEST {
            return Err(format!("{what} {name} is {value} m, farther than 1e6 m from the origin"));
        }
    }
    Ok(())
}

/// A piece of a log for a message: short, and safe to print.
pub(crate) fn quote(text: &str) -> String {
    let short: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() { format!("'{short}…'") } else { format!("'{short}'") }
}

/// A number of a log; the text names the field.
pub(crate) fn number(field: usize, text: &str) -> std::result::Result<f64, String> {
    text.parse().map_err(|_| {
        let point = text.replace(',', ".");
        match point.parse::<f64>() {
            Ok(_) => format!("field {field} is {}: write {point} with a point", quote(text)),
            Err(_) => format!("field {field} is {}, not a number", quote(text)),
        }
    })
}

/// Only lasers here: refuses `--sensor sonar`.
pub(crate) fn lasers_only(input: &Input, kind: Option<Kind>, format: &str) -> Result<()> {
    match kind {
        Some(Kind::Sonar) => Err(Error::input(
            input.path(),
            format!("a {format} log holds laser readings only: leave out --sensor sonar"),
        )),
        _ => Ok(()),
    }
}
