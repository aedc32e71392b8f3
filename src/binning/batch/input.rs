//! A batch: what is mapped together, and which tiles of which chunks it reaches.

use crate::geometry::layout::{Beam, Cone, ConeTileBounds, Entry, FAN, LINES, Scan, Shapes, Tile};
use crate::grid::ChunkId;
use rayon::prelude::*;

/// The part of a batch that reaches one chunk.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ChunkList {
    /// The chunk's column and row.
    pub place: ChunkId,
    /// The tiles that the batch reaches, ascending by slot.
    pub tiles: Vec<Tile>,
    /// Their entries, tile by tile, each tile's in log order.
    pub entries: Vec<Entry>,
    /// For a backend that bins tiles itself, instead of `tiles` and `entries`: the cones whose boxes meet the chunk, in log order.
    pub cone_bounds: Vec<ConeTileBounds>,
}

impl ChunkList {
    /// (Cone, tile) pairs: the entries, or the tiles of all boxes where the backend bins tiles itself.
    pub fn pairs(&self) -> usize {
        let tiles = |b: &ConeTileBounds| ((b.high[0] - b.low[0]) * (b.high[1] - b.low[1])) as usize;
        self.entries.len() + self.cone_bounds.iter().map(tiles).sum::<usize>()
    }
}

/// Items of one kind, binned.
#[derive(Debug, Clone)]
pub struct Batch {
    /// The chunks that the items reach, row by row.
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
    /// Updates that features made of readings.
    Updates(UpdateInput),
}

/// Readings.
#[derive(Debug, Clone, Default)]
pub struct ConeInput {
    /// The snapped readings, in log order.
    pub cones: Vec<Cone>,
    /// Where the parts of each reading's sum begin; one more than there are readings.
    pub first_part: Vec<u32>,
}

/// Scans.
#[derive(Debug, Clone, Default)]
pub struct ScanInput {
    /// The scans, in log order.
    pub scans: Vec<Scan>,
    /// The beams of all scans.
    pub beams: Vec<Beam>,
    /// The centres of the chunk's columns, then of its rows, µm from the centre of its first cell.
    pub centres: Vec<i32>,
}

/// Updates.
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
    /// What the items are called in messages.
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

    /// Where the parts of each reading's sum begin; only readings have sums.
    pub fn first_part(&self) -> &[u32] {
        match &self.input {
            Input::Cones(input) => &input.first_part,
            Input::Scans(_) | Input::Updates(_) => &[],
        }
    }

    /// The parts of all sums.
    pub fn parts(&self) -> usize {
        self.first_part().last().map_or(0, |p| *p as usize)
    }

    /// The most iterations that a GPU's thread spends in its loops over one tile's list: one for each entry, one for each side of a fan
    /// or line that may meet the tile, and one to leave or skip each of these inner loops, for each of the thread's vectors of four cells.
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
