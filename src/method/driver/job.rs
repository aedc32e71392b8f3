//! The work of one task: a pass over one tile. Each kind of input has its own job.

use crate::binning::batch::Input;
use crate::geometry::layout::{Beam, Cone, Entry, Frame, Scan, Shapes, Tile};
use std::sync::atomic::AtomicU32;

/// A method was given a batch of another kind than it takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a method that takes {takes} was given {given}: this is a defect of echogrid: please report it")]
pub struct WrongInput {
    /// What the method takes.
    pub takes: &'static str,
    /// What the batch holds.
    pub given: &'static str,
}

impl From<WrongInput> for crate::Error {
    fn from(error: WrongInput) -> Self {
        crate::Error::Kernel(Box::new(error))
    }
}

/// One kernel over a chunk's tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pass {
    /// Sums the evidence on each reading's arc, tile by tile, from emptiness alone.
    Weigh,
    /// Counts the arc cells of each reading.
    Count,
    /// Updates the cells.
    Fuse,
}

/// The fields that every job has.
#[derive(Clone, Copy)]
pub struct TileTask<'a> {
    /// The parameters of the pass.
    pub frame: &'a Frame,
    /// The tile.
    pub tile: &'a Tile,
    /// The tile's entries, in log order.
    pub entries: &'a [Entry],
}

/// A pass over one tile.
pub enum Job<'a> {
    /// With readings.
    Readings(ReadingJob<'a>),
    /// With scans.
    Scans(ScanJob<'a>),
    /// With updates.
    Updates(UpdateJob<'a>),
}

/// A pass over one tile with readings; its fields are the bindings of `shaders/method/driver/readings.wgsl`.
pub struct ReadingJob<'a> {
    /// The pass.
    pub frame: &'a Frame,
    /// The batch's cones.
    pub cones: &'a [Cone],
    /// The tile.
    pub tile: &'a Tile,
    /// The tile's entries, in log order.
    pub entries: &'a [Entry],
    /// Output: parts of sums, indexed by the entry's slot, or counts, indexed by the cone.
    pub parts: &'a [AtomicU32],
    /// The share of each cone, which the previous pass found.
    pub shares: &'a [[u32; 4]],
}

/// A pass over one tile with scans; its fields are the bindings of `shaders/method/driver/scans.wgsl`.
pub struct ScanJob<'a> {
    /// The pass.
    pub frame: &'a Frame,
    /// The batch's scans.
    pub scans: &'a [Scan],
    /// The tile.
    pub tile: &'a Tile,
    /// The tile's entries, in log order.
    pub entries: &'a [Entry],
    /// The centres of the chunk's columns, then of its rows, µm.
    pub centres: &'a [i32],
    /// The beams of all scans.
    pub beams: &'a [Beam],
}

/// A pass over one tile with updates; its fields are the bindings of `shaders/method/driver/updates.wgsl`.
pub struct UpdateJob<'a> {
    /// The pass.
    pub frame: &'a Frame,
    /// The cone of each update.
    pub cones: &'a [Cone],
    /// The tile.
    pub tile: &'a Tile,
    /// The tile's entries, in log order.
    pub entries: &'a [Entry],
    /// The fans and lines of each update.
    pub shapes: &'a [Shapes],
    /// The points of all fans and lines.
    pub points: &'a [[i32; 2]],
}

impl<'a> Job<'a> {
    /// A pass over a tile with a batch's input. Only readings use `parts` and `shares`.
    #[inline(always)]
    pub fn new(task: TileTask<'a>, input: &'a Input, parts: &'a [AtomicU32], shares: &'a [[u32; 4]]) -> Job<'a> {
        let TileTask { frame, tile, entries } = task;
        match input {
            Input::Cones(input) => {
                Job::Readings(ReadingJob { frame, cones: &input.cones, tile, entries, parts, shares })
            }
            Input::Scans(input) => Job::Scans(ScanJob {
                frame,
                scans: &input.scans,
                tile,
                entries,
                centres: &input.centres,
                beams: &input.beams,
            }),
            Input::Updates(input) => Job::Updates(UpdateJob {
                frame,
                cones: &input.cones,
                tile,
                entries,
                shapes: &input.shapes,
                points: &input.points,
            }),
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Job::Readings(_) => "readings",
            Job::Scans(_) => "scans",
            Job::Updates(_) => "updates",
        }
    }

    /// The job of a method that takes readings.
    pub(super) fn readings(&self) -> Result<&ReadingJob<'a>, WrongInput> {
        match self {
            Job::Readings(job) => Ok(job),
            other => Err(WrongInput { takes: "readings", given: other.name() }),
        }
    }

    /// The job of a method that takes scans.
    pub(super) fn scans(&self) -> Result<&ScanJob<'a>, WrongInput> {
        match self {
            Job::Scans(job) => Ok(job),
            other => Err(WrongInput { takes: "scans", given: other.name() }),
        }
    }

    /// The job of a method that takes updates.
    pub(super) fn updates(&self) -> Result<&UpdateJob<'a>, WrongInput> {
        match self {
            Job::Updates(job) => Ok(job),
            other => Err(WrongInput { takes: "updates", given: other.name() }),
        }
    }
}
