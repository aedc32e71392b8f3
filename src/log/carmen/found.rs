//! The first way through a CARMEN log: which lasers it has, what they write where nothing came back, which way the rear one looks, and what
//! is left out. Nothing in such a log lists its lasers.

use super::beams::{Parameters, lay};
use super::message::{self, Layout, Line, Message, Place};
use super::odometry;
use super::rear::Rear;
use super::tag::Family;
use crate::Result;
use crate::log::codes::{Code, Ranges};
use crate::log::format::Beams;
use crate::log::input::Input;
use crate::log::reading::Pose;
use crate::log::{BadLine, Problem};
use crate::sensor::{Description, Kind};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Ranges from here on are no return, metres: SICK's lasers, which nearly all of these logs come from, give up here.
const FARTHEST: f64 = 80.0;
/// No log has more layouts; a damaged one might.
const MOST_LAYOUTS: usize = 256;
/// So many names of messages are told apart.
const MOST_NAMES: usize = 64;
/// A share of readings of 0 from which it is told.
const MANY: f64 = 0.01;

/// One laser of the log: a layout of beams.
pub(super) struct Laser {
    pub layout: Layout,
    /// Its name.
    pub id: String,
    pub beams: Beams,
    /// Where their layout comes from.
    pub origin: String,
    /// Its place in the robot's frame, as its first message or the parameters have it.
    pub mount: Pose,
    first: Place,
    ranges: Ranges,
    /// Its messages, and those without a time stamp.
    messages: u64,
    timeless: u64,
    codes: Vec<Code>,
    r_max: f64,
}

/// What the first way through found.
pub(super) struct Found {
    /// The lasers that are read.
    pub lasers: Vec<Laser>,
    /// Which heading `RLASER` carries.
    pub rear: Rear,
    /// Messages with ranges that are not read, by their name, and why.
    skipped: BTreeMap<String, (u64, &'static str)>,
    /// The first bad line, and how many there are.
    pub bad: Option<(BadLine, u64)>,
    parameters: [Parameters; 2],
    /// Odometry messages.
    odometry: u64,
}

impl Found {
    /// Reads the log through.
    pub fn read(input: &Input) -> Result<Found> {
        let mut found = Found {
            lasers: Vec::new(),
            rear: Rear::default(),
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
                    Parameters::read(&mut found.parameters, line);
                    found.odometry += u64::from(odometry::parse(line).is_some_and(|read| read.is_ok()));
                    message::parse(line, &mut ranges)
                }
                Err(Problem::Line(bad)) => Err(bad.what),
                Err(Problem::Fatal(error)) => return Err(error),
            };
            match parsed {
                Ok(Line::Laser(message)) => {
                    // What the file ends within may lack its last digits: the pass says so.
                    if !(lines.cut() && message.t.is_none() && found.timed(&message)) {
                        found.add(&message, &ranges);
                    }
                }
                Ok(Line::Unread(name)) => found.skip(name.into(), 1, "echogrid does not read them"),
                Ok(Line::Other) => {}
                Err(what) => {
                    let line = lines.number();
                    found.bad.get_or_insert((BadLine { line, what }, 0)).1 += 1;
                }
            }
        }
        found.complete();
        Ok(found)
    }

    fn skip(&mut self, name: String, count: u64, why: &'static str) {
        if self.skipped.len() < MOST_NAMES || self.skipped.contains_key(&name) {
            self.skipped.entry(name).or_insert((0, why)).0 += count;
        }
    }

    /// Whether all messages so far of this laser have a time stamp.
    pub fn timed(&self, message: &Message) -> bool {
        self.lasers.iter().any(|l| l.layout == message.layout && l.timeless == 0)
    }

    fn add(&mut self, message: &Message, ranges: &[f64]) {
        self.rear.look(message);
        let at = self.lasers.iter().position(|l| l.layout == message.layout);
        let at = match at {
            Some(at) => at,
            None if self.lasers.len() == MOST_LAYOUTS => return,
            None => {
                let layout = message.layout;
                let same = |l: &&Laser| l.layout.tag == layout.tag && l.layout.count == layout.count;
                let again = self.lasers.iter().filter(same).count();
                let more = if again > 0 { format!("#{}", again + 1) } else { String::new() };
                self.lasers.push(Laser {
                    layout,
                    id: format!("{}/{}{more}", layout.tag, layout.count),
                    beams: Beams { count: layout.count, first: 0.0, step: 1.0 },
                    origin: String::new(),
                    mount: Pose::default(),
                    first: message.place,
                    ranges: Ranges::of(layout.count),
                    messages: 0,
                    timeless: 0,
                    codes: Vec::new(),
                    r_max: FARTHEST,
                });
                self.lasers.len() - 1
            }
        };
        if let Some(laser) = self.lasers.get_mut(at) {
            laser.timeless += u64::from(message.t.is_none());
            let heading = match message.place {
                Place::Both(pose, _) | Place::One(pose, _) => Some(pose.heading),
                Place::Odometry => None,
            };
            ranges.iter().enumerate().for_each(|(k, z)| laser.ranges.add(k, *z, heading));
            laser.messages += 1;
        }
    }

    /// Decides what the whole log was needed for.
    fn complete(&mut self) {
        let posed = self.lasers.iter().any(|l| l.layout.posed);
        let why = |layout: &Layout| match layout {
            Layout { posed: true, .. } => None,
            _ if posed => Some("they carry no pose, and messages that do are in the log"),
            Layout { tag, .. } if !tag.mounted() => Some(
                "where that laser sits on the robot is not in the log; to map them, write them as ROBOTLASER messages with \
                 the laser's pose",
            ),
            _ if self.odometry == 0 => Some("they carry no pose, and no ODOM message does"),
            _ => None,
        };
        let (out, lasers): (Vec<Laser>, Vec<Laser>) =
            std::mem::take(&mut self.lasers).into_iter().partition(|l| why(&l.layout).is_some());
        let out: Vec<_> = out.iter().map(|l| (l.layout.tag.to_string(), l.messages, why(&l.layout))).collect();
        for (name, count, why) in out {
            self.skip(name, count, why.unwrap_or_default());
        }
        self.lasers = lasers;
        for laser in &mut self.lasers {
            let parameters = &self.parameters[usize::from(laser.layout.tag.rear())];
            (laser.beams, laser.origin) = lay(&laser.layout, parameters);
            laser.mount = match laser.first {
                Place::Odometry => {
                    let heading = if laser.layout.tag.rear() { PI } else { 0.0 };
                    Pose { x: parameters.offset.0, y: parameters.offset.1, heading }
                }
                place => {
                    let (laser, robot) = self.rear.poses(laser.layout.tag, place);
                    within(&robot, &laser)
                }
            };
            laser.codes = laser.ranges.codes(laser.beams.step);
            let declared = laser.layout.cap.or(parameters.cap).filter(|cap| *cap > 0.05);
            let code = laser.codes.last().map(|code| code.range);
            laser.r_max = declared.into_iter().chain(code).fold(FARTHEST, f64::min);
        }
    }

    /// What a user should know of it.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for laser in &self.lasers {
            notes.extend(laser.zeros());
            if laser.timeless > 0 {
                let (id, n) = (&laser.id, laser.timeless);
                notes.push(format!("{id}: {n} messages have no time stamp; 0 is taken."));
            }
            if laser.first == Place::Odometry {
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

    /// What of a laser's ranges is taken for no return, if any is.
    pub fn silence(&self, laser: usize) -> Option<String> {
        let laser = self.lasers.get(laser)?;
        laser.silence(laser.layout.cap.or(self.parameters[usize::from(laser.layout.tag.rear())].cap))
    }

    /// The messages with ranges that are not read: how many, and why.
    pub fn left_out(&self) -> Option<String> {
        let each = |(name, (count, why)): (&String, &(u64, &str))| format!("{count} {name} ({why})");
        let all: Vec<String> = self.skipped.iter().map(each).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }
}

impl Laser {
    /// Its description.
    pub fn describe(&self) -> Description {
        Description {
            id: Some(self.id.clone()),
            kind: Some(Kind::Laser),
            x: Some(self.mount.x),
            y: Some(self.mount.y),
            axis: Some(self.mount.heading),
            r_max: Some(self.r_max),
            beams: Some(self.beams.count),
            first: Some(self.beams.first),
            step: Some(self.beams.step),
            ..Description::default()
        }
    }

    /// What is taken for no return.
    fn silence(&self, declared: Option<f64>) -> Option<String> {
        let (count, most) = self.ranges.beyond(self.r_max);
        if count == 0 {
            return None;
        }
        let mut what = Vec::new();
        if !self.codes.is_empty() {
            let codes: Vec<String> = self.codes.iter().map(|c| format!("{} m ({})", c.range, c.count)).collect();
            what.push(format!("peaks at the end of its ranges are taken for no return: {}", codes.join(", ")));
        }
        if let Some(declared) = declared.filter(|d| *d <= self.r_max) {
            what.push(format!("the log declares a maximum of {declared} m"));
        }
        match declared {
            Some(declared) if declared > FARTHEST && self.r_max == FARTHEST => what.push(format!(
                "ranges from 80 m on are no return, though the log declares {declared} m: lasers of this kind write their codes there"
            )),
            _ if what.is_empty() => {
                what.push(format!("ranges from 80 m on are no return, most often {most} m"));
            }
            _ => {}
        }
        (!what.is_empty()).then(|| {
            let (id, what, r_max) = (&self.id, what.join("; "), self.r_max);
            format!("{id}: {what}. So its r_max is {r_max} m, which {count} readings reach; --set r_max=… decides otherwise.")
        })
    }

    fn zeros(&self) -> Option<String> {
        let (all, none) = (self.ranges.all, self.ranges.none);
        (none as f64 > MANY * all as f64).then(|| {
            let id = &self.id;
            format!(
                "{id}: {none} of {all} readings are 0 or less, which may be a missing return or a fault: they are rejected and free \
                 nothing."
            )
        })
    }
}

/// A pose as another one sees it.
fn within(robot: &Pose, laser: &Pose) -> Pose {
    let (dx, dy) = (laser.x - robot.x, laser.y - robot.y);
    let (s, c) = robot.heading.sin_cos();
    let turn = laser.heading - robot.heading;
    Pose { x: c * dx + s * dy, y: c * dy - s * dx, heading: turn.sin().atan2(turn.cos()) }
}
