//! The robot's pose for messages without one: from the odometry message before it in the log and the one after.

use crate::Result;
use crate::log::input::Input;
use crate::log::lines::LineReader;
use crate::log::reading::Pose;
use crate::log::values::{check_pose, parse_number};

/// Odometry messages farther apart than this, seconds, are not interpolated.
const MAX_GAP: f64 = 2.0;

/// One odometry message.
#[derive(Debug, Clone, Copy)]
struct OdometrySample {
    line: u64,
    t: f64,
    pose: Pose,
}

/// A second pass over the log, from odometry message to odometry message.
pub(super) struct OdometryReader {
    lines: LineReader,
    before: Option<OdometrySample>,
    after: Option<OdometrySample>,
}

/// The pose and the time of `ODOM x y θ tv rv a t host t`, `ODOM x y θ t` or `POSITION x y θ t`; `None`: another line.
pub(super) fn parse(line: &str) -> Option<std::result::Result<(Pose, f64), String>> {
    let mut fields = line.split_ascii_whitespace();
    if !matches!(fields.next(), Some("ODOM" | "POSITION")) {
        return None;
    }
    let all: Vec<&str> = fields.collect();
    let at = |i: usize| parse_number(i + 2, all.get(i).copied().unwrap_or_default());
    let read = || {
        let pose = Pose { x: at(0)?, y: at(1)?, heading: at(2)? };
        check_pose("the robot's", &pose)?;
        let t = match all.len() {
            3 => f64::NAN,
            4..=6 => at(3)?,
            _ => at(6)?,
        };
        Ok((pose, t))
    };
    Some(read())
}

impl OdometryReader {
    /// From the log's start.
    pub fn open(input: &Input) -> Result<OdometryReader> {
        let mut odometry = OdometryReader { lines: input.lines()?, before: None, after: None };
        odometry.step();
        Ok(odometry)
    }

    fn step(&mut self) {
        self.before = self.after.or(self.before);
        self.after = None;
        while let Some(line) = self.lines.next() {
            if let Some(Ok((pose, t))) = line.ok().and_then(parse) {
                self.after = Some(OdometrySample { line: self.lines.number(), t, pose });
                return;
            }
        }
    }

    /// The robot's pose at a message's line and time: interpolated between two odometry messages, or the nearer one's.
    pub fn at(&mut self, line: u64, t: f64) -> Option<Pose> {
        while self.after.is_some_and(|after| after.line < line) {
            self.step();
        }
        let (before, after) = match (self.before, self.after) {
            (Some(before), Some(after)) => (before, after),
            (one, other) => return one.or(other).map(|stamp| stamp.pose),
        };
        let (since, until, gap) = (t - before.t, after.t - t, after.t - before.t);
        if since >= 0.0 && until >= 0.0 && gap > 0.0 && gap <= MAX_GAP {
            let part = since / gap;
            let (a, b) = (before.pose, after.pose);
            let turn = (b.heading - a.heading).sin().atan2((b.heading - a.heading).cos());
            let heading = a.heading + part * turn;
            return Some(Pose { x: a.x + part * (b.x - a.x), y: a.y + part * (b.y - a.y), heading });
        }
        Some(if until.abs() < since.abs() { after.pose } else { before.pose })
    }
}
