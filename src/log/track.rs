//! A robot's poses by time, and its pose at times between them.

use crate::log::reading::Pose;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The first and the last pose hold for this long beyond their times, seconds.
const MAX_EXTRAPOLATION: f64 = 0.1;
/// Poses farther apart in time than this, seconds, are not interpolated if the robot moved.
const MAX_GAP: f64 = 5.0;
/// A robot that moved and turned no more than this stood still: metres, radians.
const STILL: (f64, f64) = (0.05, 0.02);

/// A robot's poses in the order of time, and the number of readings without one.
#[derive(Debug, Clone)]
pub(super) struct PoseTrack {
    poses: Arc<[(f64, Pose)]>,
    missed: Arc<AtomicU64>,
}

impl PoseTrack {
    /// From poses with their times, seconds, in any order.
    pub fn of(mut poses: Vec<(f64, Pose)>) -> PoseTrack {
        poses.sort_by(|a, b| a.0.total_cmp(&b.0));
        PoseTrack { poses: poses.into(), missed: Arc::default() }
    }

    /// The number of poses.
    pub fn len(&self) -> usize {
        self.poses.len()
    }

    /// The first and the last time.
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((self.poses.first()?.0, self.poses.last()?.0))
    }

    /// The pose at a time, by linear interpolation; the heading turns the shorter way.
    pub fn at(&self, t: f64) -> Option<Pose> {
        let next = self.poses.partition_point(|(time, _)| *time < t);
        let after = self.poses.get(next);
        let before = next.checked_sub(1).and_then(|i| self.poses.get(i));
        match (before, after) {
            (_, Some((time, pose))) if *time == t => Some(*pose),
            (None, Some((time, pose))) | (Some((time, pose)), None) => {
                ((time - t).abs() <= MAX_EXTRAPOLATION).then_some(*pose)
            }
            (Some((t0, a)), Some((t1, b))) => {
                let turn = b.heading - a.heading;
                let turn = turn.sin().atan2(turn.cos());
                let still = (b.x - a.x).hypot(b.y - a.y) <= STILL.0 && turn.abs() <= STILL.1;
                if t1 - t0 > MAX_GAP && !still {
                    return None;
                }
                let part = (t - t0) / (t1 - t0);
                let between = |a: f64, b: f64| a + part * (b - a);
                Some(Pose { x: between(a.x, b.x), y: between(a.y, b.y), heading: a.heading + part * turn })
            }
            (None, None) => None,
        }
    }

    /// Records the number of readings of a pass without a pose.
    pub fn count_missed(&self, missed: u64) {
        self.missed.fetch_max(missed, Ordering::Relaxed);
    }

    /// A note about readings without a pose; `what` names the readings.
    pub fn note(&self, what: &str) -> Option<String> {
        let missed = self.missed.load(Ordering::Relaxed);
        let (first, last) = self.span()?;
        (missed > 0).then(|| {
            format!(
                "{missed} {what} were left out: at their times there is no pose (the {} poses run from {first:.3} to \
                 {last:.3} s, and are not filled in over more than {MAX_GAP} s)",
                self.len()
            )
        })
    }
}

/// The heading of a quaternion: its rotation about the vertical axis, radians.
pub(super) fn yaw(x: f64, y: f64, z: f64, w: f64) -> f64 {
    (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_poses_and_beside_them() {
        let pose = |x: f64, heading: f64| Pose { x, y: 2.0 * x, heading };
        let track = PoseTrack::of(vec![(3.0, pose(1.0, -3.0)), (1.0, pose(0.0, 3.0)), (20.0, pose(9.0, -3.0))]);
        let half = track.at(2.0).unwrap();
        assert_eq!((half.x, half.y), (0.5, 1.0));
        // The shorter way round, over π.
        assert!((half.heading - std::f64::consts::PI).abs() < 1e-12, "{half:?}");
        assert_eq!(track.at(0.95), Some(pose(0.0, 3.0)));
        assert_eq!((track.at(0.5), track.at(30.0), track.at(10.0), track.at(f64::NAN)), (None, None, None, None));
        assert_eq!(track.at(20.0), Some(pose(9.0, -3.0)));
        assert!((yaw(0.0, 0.0, 0.5f64.sin(), 0.5f64.cos()) - 1.0).abs() < 1e-12);
    }
}
