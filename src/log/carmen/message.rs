//! One line of a CARMEN log: which laser, how its beams lie, the ranges and the poses.

use crate::log::format::{Beams, check_pose, number, quote};
use crate::reading::Pose;
use std::f64::consts::PI;

/// The laser messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tag {
    /// `FLASER`: the front laser.
    Front,
    /// `RLASER`: the rear laser, looking backwards.
    Rear,
    /// `ROBOTLASER1`: a laser with its layout in every message.
    Robot,
}

impl Tag {
    fn name(self) -> &'static str {
        match self {
            Tag::Front => "FLASER",
            Tag::Rear => "RLASER",
            Tag::Robot => "ROBOTLASER1",
        }
    }

    /// The cap that the log's parameters declare for this laser: `[front, rear]`.
    pub fn declared(self, caps: [Option<f64>; 2]) -> Option<f64> {
        match self {
            Tag::Front => caps[0],
            Tag::Rear => caps[1],
            Tag::Robot => None,
        }
    }
}

/// How a laser's beams lie. Each layout is a sensor of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layout {
    /// The message.
    pub tag: Tag,
    /// Beams a scan.
    pub count: u32,
    /// Bearing of the first beam from the laser's heading, radians.
    pub first: f64,
    /// From one beam to the next, radians.
    pub step: f64,
    /// The maximum range that the message declares, metres.
    pub cap: Option<f64>,
}

impl Layout {
    /// The sensor's name.
    pub fn id(&self) -> String {
        format!("{}/{}", self.tag.name(), self.count)
    }

    /// Its beams.
    pub fn beams(&self) -> Beams {
        Beams { count: self.count, first: self.first, step: self.step }
    }

    /// 180° from the right: n beams are 180°/n apart if n is even (the last one is missing), else 180°/(n − 1).
    fn half_circle(tag: Tag, count: u32) -> Layout {
        let gaps = if count.is_multiple_of(2) { count } else { count - 1 };
        Layout { tag, count, first: -PI / 2.0, step: PI / f64::from(gaps), cap: None }
    }
}

/// A laser message, but for its ranges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Message {
    pub layout: Layout,
    /// The laser's pose.
    pub laser: Pose,
    /// The robot's pose; FLASER and RLASER have none in the corrected frame, so it is the laser's place there.
    pub robot: Pose,
    /// Seconds.
    pub t: f64,
}

impl Message {
    /// The laser's place in the robot's frame.
    pub fn mount(&self) -> Pose {
        let (dx, dy) = (self.laser.x - self.robot.x, self.laser.y - self.robot.y);
        let (s, c) = self.robot.heading.sin_cos();
        let turn = self.laser.heading - self.robot.heading;
        Pose { x: c * dx + s * dy, y: c * dy - s * dx, heading: turn.sin().atan2(turn.cos()) }
    }
}

/// The cap that a parameter line declares, metres: (0, cap) for the front laser, (1, cap) for the rear one.
pub(super) fn cap(line: &str) -> Option<(usize, f64)> {
    let mut fields = line.strip_prefix("PARAM ")?.split_ascii_whitespace();
    let which = match fields.next()? {
        "robot_front_laser_max" => 0,
        "robot_rear_laser_max" => 1,
        _ => return None,
    };
    Some((which, fields.next()?.parse().ok().filter(|cap: &f64| *cap > 0.0)?))
}

/// Parses a line; `None`: it is no laser message. The ranges go to `ranges`.
pub(super) fn parse(line: &str, ranges: &mut Vec<f64>) -> Result<Option<Message>, String> {
    let tag = match line.split_ascii_whitespace().next() {
        Some("FLASER") => Tag::Front,
        Some("RLASER") => Tag::Rear,
        Some("ROBOTLASER1") => Tag::Robot,
        None => return Ok(None),
        Some(word) if word.starts_with('#') => return Ok(None),
        Some(word) if word.bytes().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit() || b == b'_') => {
            return Ok(None);
        }
        Some(word) => return Err(format!("{} is no CARMEN message", quote(word))),
    };
    let fields: Vec<&str> = line.split_ascii_whitespace().collect();
    let at = |i: usize| number(i + 1, fields.get(i).copied().unwrap_or_default());
    let pose = |i: usize| Ok::<_, String>(Pose { x: at(i)?, y: at(i + 1)?, heading: at(i + 2)? });
    let count_at = |i: usize| match fields.get(i) {
        Some(field) => field.parse::<u32>().map_err(|_| format!("field {} is {}, not a count", i + 1, quote(field))),
        None => Err(format!("{} with only {} fields", tag.name(), fields.len())),
    };
    let first = if tag == Tag::Robot { 9 } else { 2 };
    let count = count_at(first - 1)?;
    let n = count as usize;
    if n < 2 {
        return Err(format!("{} with {n} beams: their bearings are not defined", tag.name()));
    }
    let total = |more: usize| match fields.len() {
        found if found == n.saturating_add(more) => Ok(()),
        found => Err(format!("expected {} fields for {n} beams, found {found}", n.saturating_add(more))),
    };
    let message = if tag == Tag::Robot {
        let remissions = match fields.get(n.saturating_add(first)) {
            Some(_) => count_at(n + first)? as usize,
            None => 0,
        };
        total(remissions.saturating_add(24))?;
        let after = first + n + 1 + remissions;
        let layout = Layout { tag, count, first: at(2)?, step: at(4)?, cap: Some(at(5)?).filter(|cap| *cap > 0.0) };
        if !(layout.first.is_finite() && layout.step.is_finite() && layout.step != 0.0) {
            return Err(format!("start angle {} or resolution {} is no angle", layout.first, layout.step));
        }
        Message { layout, laser: pose(after)?, robot: pose(after + 3)?, t: at(after + 11)? }
    } else {
        total(11)?;
        let robot = pose(first + n)?;
        let turn = if tag == Tag::Rear { PI } else { 0.0 };
        let laser = Pose { heading: robot.heading + turn, ..robot };
        Message { layout: Layout::half_circle(tag, count), laser, robot, t: at(first + n + 6)? }
    };
    if !message.t.is_finite() {
        return Err(format!("the time stamp is {}", message.t));
    }
    check_pose("the laser's", &message.laser)?;
    check_pose("the robot's", &message.robot)?;
    ranges.clear();
    for (i, field) in fields.iter().enumerate().skip(first).take(n) {
        ranges.push(number(i + 1, field)?);
    }
    Ok(Some(message))
}
