//! A batch: items that are mapped together, with the lists of the tiles that they may reach, chunk by chunk.

use crate::geometry::layout::{Beam, Cone, ConeTileBounds, Entry, FAN, LINES, Scan, Shapes, Tile};
use crate::grid::ChunkId;
use rayon::prelude::*;

/// The part of a batch that reaches one chunk.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChunkList {
    /// The chunk.
    pub place: ChunkId,
    /// The tiles that the batch may reach, in ascending order of slot.
    pub tiles: Vec<Tile>,
    /// The entries of all tiles, tile by tile, in log order within a tile.
    pub entries: Vec<Entry>,
    /// The cones whose boxes meet the chunk, in log order. A backend that bins tiles itself uses these instead of `tiles` and
    /// `entries`.
    pub cone_bounds: Vec<ConeTileBounds>,
}

impl ChunkList {
    /// Number of (cone, tile) pairs: the entries, or the tiles of all boxes where the backend bins tiles itself.
    pub fn pairs(&self) -> usize {
        let tiles = |b: &ConeTileBounds| ((b.high[0] - b.low[0]) * (b.high[1] - b.low[1])) as usize;
        self.entries.len() + self.cone_bounds.iter().map(tiles).sum::<usize>()
    }
}

/// A batch of items of one kind, binned.
#[derive(Debug, Clone)]
pub struct Batch {
    /// The lists of the chunks that the items reach, row by row.
    pub chunks: Vec<ChunkList>,
    /// The items.
    pub input: Input,
}

/// The items of a batch; a method takes one kind of them ([`crate::method::Method::unit`]).
#[derive(Debug, Clone)]
pub enum Input {
    /// Readings, as snapped cones.
    Cones(ConeInput),
    /// Scans of one chunk.
    Scans(ScanInput),
    /// Updates that the feature stage made of readings.
    Updates(UpdateInput),
}

/// The readings of a batch.
#[derive(Debug, Clone, Default)]
pub struct ConeInput {
    /// The snapped readings, in log order.
    pub cones: Vec<Cone>,
    /// Index of the first part of each reading's sum, with one more element than there are readings.
    pub first_part: Vec<u32>,
}

/// The scans of a batch.
#[derive(Debug, Clone, Default)]
pub struct ScanInput {
    /// The scans, in log order.
    pub scans: Vec<Scan>,
    /// The beams of all scans.
    pub beams: Vec<Beam>,
    /// The centres of the chunk's columns, then of its rows, µm from the centre of its first cell.
    pub centres: Vec<i32>,
}

/// The updates of a batch.
#[derive(Debug, Clone, Default)]
pub struct UpdateInput {
    /// The cone of each update.
    pub cones: Vec<Cone>,
    /// The fans and lines of each update.
    pub shapes: Vec<Shapes>,
    /// The points of all fans and lines, units from their sensors.
    pub points: Vec<[i32; 2]>,
}

impl Input {
    /// Name of the items in messages.
    pub fn name(&self) -> &'static str {
        match self {
            Input::Cones(_) => "readings",
            Input::Scans(_) => "scans",
            Input::Updates(_) => "updates",
        }
    }
}

impl Batch {
    /// The cones of the readings or of the updates; scans have none.
    pub fn cones(&self) -> &[Cone] {
        match &self.input {
            Input::Cones(input) => &input.cones,
            Input::Scans(_) => &[],
            Input::Updates(input) => &input.cones,
        }
    }

    /// Index of the first part of each reading's sum; empty for other items, which have no sums.
    pub fn first_part(&self) -> &[u32] {
        match &self.input {
            Input::Cones(input) => &input.first_part,
            Input::Scans(_) | Input::Updates(_) => &[],
        }
    }

    /// Total number of parts of all sums.
    pub fn parts(&self) -> usize {
        self.first_part().last().map_or(0, |p| *p as usize)
    }

    /// The largest number of iterations that a GPU thread spends in its loops over one tile's list. There is one for each entry. For
    /// each of the thread's vectors of four cells there is one for each side of a fan or line that may meet the tile, and one to leave
    /// or skip each of these inner loops.
    pub fn max_loop_iterations(&self, vec4s_per_thread: usize) -> usize {
        let shapes: &[Shapes] = match &self.input {
            Input::Updates(input) => &input.shapes,
            Input::Cones(_) | Input::Scans(_) => &[],
        };
        let sides = |entry: &Entry| match shapes.get(entry.index()) {
            Some(shapes) => {
                let count =
                    |[from, to]: [u32; 2], bit: u32| 1 + if entry.slot & bit != 0 { (to - from) as usize } else { 0 };
                let fans = (0..4).map(|k| count(shapes.fans[k], FAN << k)).sum::<usize>();
                fans + (0..2).map(|k| count(shapes.lines[k], LINES << k)).sum::<usize>()
            }
            None => 0,
        };
        let tile = |list: &ChunkList, tile: &Tile| {
            let entries = &list.entries[tile.entries[0] as usize..tile.entries[1] as usize];
            entries.len() + vec4s_per_thread * entries.iter().map(sides).sum::<usize>()
        };
        let tiles = |list: &ChunkList| list.tiles.par_iter().map(|t| tile(list, t)).max().unwrap_or(0);
        self.chunks.iter().map(tiles).max().unwrap_or(0)
    }
}
