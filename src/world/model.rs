//! A world: its shapes, the trajectory of the robot, and its rig of sensors.

use super::index::ShapeIndex;
use super::path::TimedPose;
use super::rig::Rig;
use super::shape::{Arc, Corner, Wall};
use crate::geometry::plane::Point;
use crate::log::reading::Pose;

/// A world with a trajectory through it and a rig of sensors.
#[derive(Debug, Clone)]
pub struct World {
    /// Its name.
    pub name: String,
    /// Names of the classes 1, 2, …
    pub classes: Vec<String>,
    /// The poses at which the robot scans, in order of time.
    pub trajectory: Vec<TimedPose>,
    /// The sensors, unless another rig is asked for.
    pub rig: Rig,
    /// SHA-256 of its file, in hexadecimal.
    pub sha256: String,
    pub(super) index: ShapeIndex,
    pub(super) corners: Vec<Corner>,
    pub(super) bounds: [f64; 4],
}

impl World {
    /// The bounding box of its shapes: left, bottom, right, top, metres.
    pub fn bounds(&self) -> [f64; 4] {
        self.bounds
    }

    /// The positions at which the robot scans.
    pub fn scans(&self) -> Vec<Point> {
        self.trajectory.iter().map(|stop| stop.pose.position()).collect()
    }

    /// Its straight walls.
    pub fn walls(&self) -> &[Wall] {
        &self.index.walls
    }

    /// Its arcs.
    pub fn arcs(&self) -> &[Arc] {
        &self.index.arcs
    }

    /// Its corners, from left to right.
    pub fn corners(&self) -> &[Corner] {
        &self.corners
    }

    /// The corners between two x, metres.
    pub(super) fn corners_between(&self, low: f64, high: f64) -> &[Corner] {
        let first_from = |x: f64| self.corners.partition_point(|c| c.at.x < x);
        &self.corners[first_from(low)..first_from(high).max(first_from(low))]
    }

    /// The pose and the time of a scan; after its end the trajectory is repeated.
    pub(super) fn scan_pose(&self, scan: u64) -> Option<(Pose, f64)> {
        let n = self.trajectory.len() as u64;
        let TimedPose { t, pose } = *self.trajectory.get(scan.checked_rem(n)? as usize)?;
        let round = self.trajectory.last()?.t + 1.0;
        Some((pose, t + round * (scan / n) as f64))
    }
}
