//! Made-up worlds, where the truth is known: walls, boxes and circles with a path through them, the sonar and the laser
//! that would be heard there, and the map that ought to come out. `docs/worlds.md` describes the files.

pub mod random;
pub mod shape;
pub mod rig;
pub mod truth;

mod campus;
mod cone;
mod corner;
mod echo;
mod file;
mod image;
mod index;
mod path;
mod shipped;
mod simulate;
mod text;

pub use echo::Physics;
pub use path::Stop;
pub use rig::{RIGS, Rig};
pub(crate) use shipped::meant;
pub use shipped::{SHIPPED, Shipped};
pub use simulate::{Simulated, scan, simulate};
pub use truth::true_map;

use crate::geometry::plane::Point;
use crate::log::reading::Pose;
use crate::{Error, Result};
use shape::{Arc, Corner, Wall};
use std::path::Path;

/// A world: shapes, a path and a rig.
#[derive(Debug, Clone)]
pub struct World {
    /// Its name.
    pub name: String,
    /// Names of the classes 1, 2, …
    pub classes: Vec<String>,
    /// Where the robot scans.
    pub stops: Vec<Stop>,
    /// What it carries, unless another rig is asked for.
    pub rig: Rig,
    index: index::Index,
    corners: Vec<Corner>,
    bounds: [f64; 4],
    /// SHA-256 of its file, in hexadecimal.
    pub sha256: String,
}

impl World {
    /// Reads a world's file.
    ///
    /// # Errors
    /// [`Error::Input`] with the line and a remedy.
    pub fn open(path: &Path) -> Result<World> {
        let example = "give a world's TOML file, or the name of a built-in world, such as room";
        let bytes = std::fs::read(path).map_err(|e| Error::input(path, format!("can't be read: {e}; {example}")))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let (good, _) = e.as_bytes().split_at(e.utf8_error().valid_up_to());
            let line = good.iter().filter(|b| **b == b'\n').count() as u64 + 1;
            Error::at(path, line, format!("is not UTF-8 text: {example}"))
        })?;
        World::parse(path, &text)
    }

    /// The same from its text; `path` is for messages, and names a world that has no name.
    ///
    /// # Errors
    /// As [`World::open`].
    pub fn parse(path: &Path, text: &str) -> Result<World> {
        file::parse(path, text)
    }

    /// The box around everything in it: left, bottom, right, top, metres.
    pub fn bounds(&self) -> [f64; 4] {
        self.bounds
    }

    /// Where the robot scans, metres.
    pub fn scans(&self) -> Vec<Point> {
        self.stops.iter().map(|(_, p)| (p.x, p.y)).collect()
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
    fn corners_between(&self, low: f64, high: f64) -> &[Corner] {
        let at = |x: f64| self.corners.partition_point(|c| c.at.0 < x);
        &self.corners[at(low)..at(high).max(at(low))]
    }

    /// The pose and the time of a scan; beyond the path's end it goes round again.
    fn stop(&self, scan: u64) -> Option<(Pose, f64)> {
        let n = self.stops.len() as u64;
        let (t, pose) = *self.stops.get(scan.checked_rem(n)? as usize)?;
        let round = self.stops.last()?.0 + 1.0;
        Some((pose, t + round * (scan / n) as f64))
    }
}
