//! Determines whose heading `RLASER` messages carry: CARMEN's own logger writes the laser's, other programs the robot's. Each message is compared with
//! the `FLASER` message before it, if that is of the same time, else with its own odometry's heading: about 180° apart it is the laser's, about
//! equal it is the robot's. The majority decides.

use super::message::{LaserMessage, ScanPose};
use super::tag::{Family, Tag};
use crate::log::reading::Pose;
use std::f64::consts::PI;

/// A front scan gives the robot's heading for this time, seconds.
const MAX_AGE: f64 = 0.5;

/// The votes of a log's messages.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RearHeading {
    /// The last `FLASER` message's time and heading.
    front: Option<(f64, f64)>,
    /// The number of messages with the laser's heading, with the robot's, or with neither.
    laser: u64,
    robot: u64,
    unclear: u64,
}

impl RearHeading {
    /// Counts the vote of a message.
    pub fn observe(&mut self, message: &LaserMessage) {
        let ScanPose::LaserOnly(pose, odometry) = message.place else { return };
        if message.layout.tag.family != Family::Flat {
            return;
        }
        if !message.layout.tag.rear() {
            self.front = message.t.map(|t| (t, pose.heading));
            return;
        }
        let front = self.front.filter(|f| message.t.is_some_and(|t| (t - f.0).abs() <= MAX_AGE)).map(|f| f.1);
        let Some(robot) = front.or(odometry) else { return };
        match (pose.heading - robot).cos() {
            // Within 60° of one or the other.
            c if c < -0.5 => self.laser += 1,
            c if c > 0.5 => self.robot += 1,
            _ => self.unclear += 1,
        }
    }

    /// Whether `RLASER` carries the laser's own heading.
    fn is_laser(&self) -> bool {
        self.laser > self.robot
    }

    /// The laser's pose and the robot's, of a message with a pose. In the old messages both have the same position.
    pub fn poses(&self, tag: Tag, place: ScanPose) -> (Pose, Pose) {
        match place {
            ScanPose::LaserAndRobot(laser, robot) => (laser, robot),
            ScanPose::LaserOnly(pose, _) if tag.family == Family::Flat && tag.rear() => {
                let turned = |by: f64| Pose { heading: pose.heading + by, ..pose };
                if self.is_laser() { (pose, turned(-PI)) } else { (turned(PI), pose) }
            }
            ScanPose::LaserOnly(pose, _) => (pose, pose),
            ScanPose::FromOdometry => Default::default(),
        }
    }

    /// A note on the decision, if there were such messages.
    pub fn note(&self) -> Option<String> {
        let all = self.laser + self.robot + self.unclear;
        if all == 0 {
            return None;
        }
        let (votes, text) = match self.is_laser() {
            true => (self.laser, "the rear laser's own: 180° off the robot's"),
            false => (self.robot, "the robot's: the laser looks the other way"),
        };
        let doubt = match votes * 10 < all * 9 {
            true => {
                ". The others say otherwise or nothing clear: look at the map, and give a sensor file with the rear laser's axis \
                 (0 or 180deg) if what lies behind the robot is drawn before it"
            }
            false => "",
        };
        Some(format!("RLASER: its heading is taken for {text}, in {votes} of {all} messages{doubt}."))
    }
}
