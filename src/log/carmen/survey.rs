//! The first pass over a CARMEN log: its lasers, their no-return codes, the heading of the rear laser, and the messages that are left out.
//! Nothing in such a log lists its lasers.

use super::beams::{LaserParameters, resolve_beams};
use super::laser::{CarmenLaser, MAX_RANGE};
use super::message::{self, CarmenLine, LaserLayout, LaserMessage, ScanPose};
use super::odometry;
use super::rear::RearHeading;
use super::tag::Family;
use crate::Result;
use crate::log::input::Input;
use crate::log::mounting::Beams;
use crate::log::no_return::RangeHistogram;
use crate::log::problem::{BadLine, Problem};
use crate::log::reading::Pose;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The largest number of beam layouts; a damaged log might have more.
const MAX_LAYOUTS: usize = 256;
/// The largest number of message names that are counted.
const MAX_NAMES: usize = 64;
/// The result of the first pass.
pub(super) struct LaserSurvey {
    /// The lasers to read.
    pub lasers: Vec<CarmenLaser>,
    /// Which heading `RLASER` carries.
    pub rear: RearHeading,
    /// Messages with ranges that are not read, by their name, and why.
    skipped: BTreeMap<String, (u64, &'static str)>,
    /// The first bad line, and the number of bad lines.
    pub bad: Option<(BadLine, u64)>,
    parameters: [LaserParameters; 2],
    /// Odometry messages.
    odometry: u64,
}

impl LaserSurvey {
    /// Reads the log through.
    pub fn read(input: &Input) -> Result<LaserSurvey> {
        let mut survey = LaserSurvey {
            lasers: Vec::new(),
            rear: RearHeading::default(),
            skipped: BTreeMap::new(),
            bad: None,
            parameters: Default::default(),
            odometry: 0,
        };
        let mut lines = input.lines()?;
        let mut ranges = Vec::new();
        while let Some(line) = lines.next() {
            let parsed = match line {
                Ok(line) => {
                    LaserParameters::read(&mut survey.parameters, line);
                    survey.odometry += u64::from(odometry::parse(line).is_some_and(|read| read.is_ok()));
                    message::parse(line, &mut ranges)
                }
                Err(Problem::Line(bad)) => Err(bad.what),
                Err(Problem::Fatal(error)) => return Err(error),
            };
            match parsed {
                Ok(CarmenLine::Laser(message)) => {
                    // The last number of an unterminated line may lack digits; the later pass reports the line.
                    if !(lines.is_unterminated() && message.t.is_none() && survey.timed(&message)) {
                        survey.add(&message, &ranges);
                    }
                }
                Ok(CarmenLine::Unread(name)) => survey.skip(name.into(), 1, "echogrid does not read them"),
                Ok(CarmenLine::Other) => {}
                Err(what) => {
                    let line = lines.number();
                    survey.bad.get_or_insert((BadLine { line, what }, 0)).1 += 1;
                }
            }
        }
        survey.complete();
        Ok(survey)
    }

    fn skip(&mut self, name: String, count: u64, why: &'static str) {
        if self.skipped.len() < MAX_NAMES || self.skipped.contains_key(&name) {
            self.skipped.entry(name).or_insert((0, why)).0 += count;
        }
    }

    /// Whether all messages so far of this laser have a time stamp.
    pub fn timed(&self, message: &LaserMessage) -> bool {
        self.lasers.iter().any(|l| l.layout == message.layout && l.timeless == 0)
    }

    fn add(&mut self, message: &LaserMessage, ranges: &[f64]) {
        self.rear.observe(message);
        let at = self.lasers.iter().position(|l| l.layout == message.layout);
        let at = match at {
            Some(at) => at,
            None if self.lasers.len() == MAX_LAYOUTS => return,
            None => {
                let layout = message.layout;
                let same = |l: &&CarmenLaser| l.layout.tag == layout.tag && l.layout.count == layout.count;
                let again = self.lasers.iter().filter(same).count();
                let more = if again > 0 { format!("#{}", again + 1) } else { String::new() };
                self.lasers.push(CarmenLaser {
                    layout,
                    id: format!("{}/{}{more}", layout.tag, layout.count),
                    beams: Beams { count: layout.count, first: 0.0, step: 1.0 },
                    origin: String::new(),
                    mount: Pose::default(),
                    first: message.place,
                    ranges: RangeHistogram::of(layout.count),
                    messages: 0,
                    timeless: 0,
                    codes: Vec::new(),
                    r_max: MAX_RANGE,
                });
                self.lasers.len() - 1
            }
        };
        if let Some(laser) = self.lasers.get_mut(at) {
            laser.timeless += u64::from(message.t.is_none());
            let heading = match message.place {
                ScanPose::LaserAndRobot(pose, _) | ScanPose::LaserOnly(pose, _) => Some(pose.heading),
                ScanPose::FromOdometry => None,
            };
            ranges.iter().enumerate().for_each(|(k, z)| laser.ranges.add(k, *z, heading));
            laser.messages += 1;
        }
    }

    /// Completes the lasers after the whole log was read.
    fn complete(&mut self) {
        let posed = self.lasers.iter().any(|l| l.layout.posed);
        let why = |layout: &LaserLayout| match layout {
            LaserLayout { posed: true, .. } => None,
            _ if posed => Some("they carry no pose, and messages that do are in the log"),
            LaserLayout { tag, .. } if !tag.mounted() => Some(
                "where that laser sits on the robot is not in the log; to map them, write them as ROBOTLASER messages with \
                 the laser's pose",
            ),
            _ if self.odometry == 0 => Some("they carry no pose, and no ODOM message does"),
            _ => None,
        };
        let (out, lasers): (Vec<CarmenLaser>, Vec<CarmenLaser>) =
            std::mem::take(&mut self.lasers).into_iter().partition(|l| why(&l.layout).is_some());
        let out: Vec<_> = out.iter().map(|l| (l.layout.tag.to_string(), l.messages, why(&l.layout))).collect();
        for (name, count, why) in out {
            self.skip(name, count, why.unwrap_or_default());
        }
        self.lasers = lasers;
        for laser in &mut self.lasers {
            let parameters = &self.parameters[usize::from(laser.layout.tag.rear())];
            (laser.beams, laser.origin) = resolve_beams(&laser.layout, parameters);
            laser.mount = match laser.first {
                ScanPose::FromOdometry => {
                    let heading = if laser.layout.tag.rear() { PI } else { 0.0 };
                    Pose { x: parameters.offset.0, y: parameters.offset.1, heading }
                }
                place => {
                    let (laser, robot) = self.rear.poses(laser.layout.tag, place);
                    relative_pose(&robot, &laser)
                }
            };
            laser.codes = laser.ranges.codes(laser.beams.step);
            let declared = laser.layout.cap.or(parameters.cap).filter(|cap| *cap > 0.05);
            let code = laser.codes.last().map(|code| code.range);
            laser.r_max = declared.into_iter().chain(code).fold(MAX_RANGE, f64::min);
        }
    }

    /// Notes for the user.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for laser in &self.lasers {
            notes.extend(laser.zeros_note());
            if laser.timeless > 0 {
                let (id, n) = (&laser.id, laser.timeless);
                notes.push(format!("{id}: {n} messages have no time stamp; 0 is taken."));
            }
            if laser.first == ScanPose::FromOdometry {
                let (x, y) = (laser.mount.x, laser.mount.y);
                notes.push(format!(
                    "{}: its messages carry no pose; the robot's is that of the ODOM messages before and after, the laser sits {x} m \
                     forward and {y} m to the left of its centre{} (PARAM robot_…laser_offset; a sensor file may say otherwise).",
                    laser.id,
                    if laser.layout.tag.rear() { ", looking backwards" } else { "" },
                ));
            }
            if laser.layout.tag.family == Family::Reading {
                let what = "its poses are the odometry's as the LASER_READING messages have them; SM_UPDATE messages, which \
                            correct them, are not used.";
                notes.push(format!("{}: {what}", laser.id));
            }
        }
        notes.extend(self.rear.note());
        notes.extend(self.left_out().map(|what| format!("Left out: {what}.")));
        notes
    }

    /// A note on the ranges of a laser that are read as no return, if there are any.
    pub fn no_return_note(&self, laser: usize) -> Option<String> {
        let laser = self.lasers.get(laser)?;
        laser.no_return_note(laser.layout.cap.or(self.parameters[usize::from(laser.layout.tag.rear())].cap))
    }

    /// The messages with ranges that are not read: their numbers, and the reasons.
    pub fn left_out(&self) -> Option<String> {
        let each = |(name, (count, why)): (&String, &(u64, &str))| format!("{count} {name} ({why})");
        let all: Vec<String> = self.skipped.iter().map(each).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }
}

/// The laser's pose in the robot's frame.
fn relative_pose(robot: &Pose, laser: &Pose) -> Pose {
    let (dx, dy) = (laser.x - robot.x, laser.y - robot.y);
    let (s, c) = robot.heading.sin_cos();
    let turn = laser.heading - robot.heading;
    Pose { x: c * dx + s * dy, y: c * dy - s * dx, heading: turn.sin().atan2(turn.cos()) }
}
