//! The robot's trajectory through a log, and checks of it: steps that no robot takes, headings that look like degrees.

use crate::log::reading::Pose;
use std::f64::consts::PI;

/// A step of this many metres between two readings is always reported.
const FAR: f64 = 100.0;
/// A shorter step is reported if it has at least this many metres …
const LONG: f64 = 3.0;
/// … and so many times the robot's mean step …
const TIMES: f64 = 30.0;
/// … of more than this many steps.
const STEPS: u64 = 10;
/// Headings beyond this, radians, belong to a robot that turned more than once, or are in degrees.
const TURNED: f64 = 7.0;

/// Statistics of a sequence of poses.
#[derive(Debug, Clone)]
pub(super) struct Trajectory {
    last: Option<Pose>,
    /// Steps longer than 0: their number, and their sum in metres.
    steps: (u64, f64),
    /// The longest step: metres, and the line and the pose where it ends.
    longest: (f64, u64, Pose),
    /// The least and the largest heading, and the largest difference of consecutive headings, radians.
    headings: [f64; 2],
    turn: f64,
}

impl Trajectory {
    /// The empty trajectory.
    pub fn new() -> Trajectory {
        Trajectory {
            last: None,
            steps: (0, 0.0),
            longest: (0.0, 0, Pose::default()),
            headings: [f64::INFINITY, f64::NEG_INFINITY],
            turn: 0.0,
        }
    }

    /// Adds the pose of a line.
    pub fn add(&mut self, to: Pose, line: u64) {
        if self.last == Some(to) {
            return;
        }
        if let Some(from) = self.last {
            let step = (to.x - from.x).hypot(to.y - from.y);
            if step > 0.0 {
                self.steps = (self.steps.0 + 1, self.steps.1 + step);
            }
            if step > self.longest.0 {
                self.longest = (step, line, to);
            }
            self.turn = self.turn.max((to.heading - from.heading).abs());
        }
        self.headings = [self.headings[0].min(to.heading), self.headings[1].max(to.heading)];
        self.last = Some(to);
    }

    /// The longest step, if it is so long that a pose may be wrong: metres, and the line and the pose where it ends.
    pub fn jump(&self) -> Option<(f64, u64, Pose)> {
        let ((count, sum), (step, ..)) = (self.steps, self.longest);
        let others = (sum - step) / count.saturating_sub(1).max(1) as f64;
        let odd = count > STEPS && step >= LONG && step >= TIMES * others;
        (odd || step >= FAR).then_some(self.longest)
    }

    /// A warning about headings that look like degrees. The headings of a robot that turned more than once don't leap.
    pub fn degrees(&self) -> Option<String> {
        let [low, high] = self.headings;
        (low.abs().max(high.abs()) > TURNED && self.turn > PI && self.last.is_some()).then(|| {
            format!(
                "its headings run from {low:.1} to {high:.1}, and leap by up to {:.1} from one pose to the next: most likely they are \
                 degrees, where radians are taken; say so (heading:deg in --columns or --pose-columns), or convert them",
                self.turn
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trajectory(poses: impl Iterator<Item = (f64, f64)>) -> Trajectory {
        let mut trajectory = Trajectory::new();
        (1..).zip(poses).for_each(|(line, (x, heading))| trajectory.add(Pose { x, y: 0.0, heading }, line));
        trajectory
    }

    #[test]
    fn headings_in_degrees_are_told_from_many_turns() {
        let around = |step: f64, all: f64| (0..200).map(move |k| (0.1 * f64::from(k), (step * f64::from(k)) % all));
        assert!(trajectory(around(7.3, 360.0)).degrees().unwrap().contains("heading:deg"));
        assert!(trajectory(around(7.3, 360.0).map(|(x, h)| (x, h - 180.0))).degrees().is_some());
        // radians: wrapped, and those of a robot that turned many times
        assert_eq!(trajectory(around(0.2, 2.0 * PI)).degrees(), None);
        assert_eq!(trajectory(around(0.2, 1e9)).degrees(), None);
        assert_eq!(trajectory(std::iter::once((0.0, 90.0))).degrees(), None);
    }

    #[test]
    fn a_jump_is_one_beside_the_other_steps() {
        let steps = |jump: f64| (0..60).map(move |k| (0.1 * f64::from(k) + if k > 30 { jump } else { 0.0 }, 0.0));
        assert_eq!(trajectory(steps(0.0)).jump(), None);
        assert_eq!(trajectory(steps(2.0)).jump(), None);
        let (step, line, _) = trajectory(steps(5.0)).jump().unwrap();
        assert!((step - 5.1).abs() < 1e-9 && line == 32, "{step} {line}");
        // a robot that is driven from stop to stop
        assert_eq!(trajectory((0..60).map(|k| (4.0 * f64::from(k), 0.0))).jump(), None);
        assert!(trajectory([(0.0, 0.0), (150.0, 0.0)].into_iter()).jump().is_some());
    }
}
