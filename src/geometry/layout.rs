//! The records and constants that both backends read; twin of `shaders/geometry/layout.wgsl`.
//!
//! One unit is 1/32 of a cell. Coordinates count from the lower left corner of the grid. Directions are the unit vector
//! times 8192. A test holds every name, offset and constant of this file against the WGSL.

use bytemuck::{Pod, Zeroable};

/// Units along a cell's edge.
pub const CELL: i32 = 32;
/// Length of a cone's direction vectors.
pub const DIRECTION: i32 = 8192;
/// Cells along a tile's edge: a tile is one workgroup's work.
pub const TILE: usize = 16;
/// Cells of a tile.
pub const TILE_CELLS: usize = TILE * TILE;
/// Tiles along a chunk's edge: a chunk of 1024 × 1024 cells is the unit of residence.
pub const CHUNK: usize = 64;
/// Tiles along a block's edge: where a GPU bins cones into tiles itself, they are sorted into blocks first.
pub const BLOCK: usize = 4;
/// Number of blocks along a chunk's edge.
pub const BLOCKS: usize = CHUNK / BLOCK;
/// Number of cones that are sorted into blocks together.
pub const SEGMENT: usize = 4096;

/// Cone flag: the reading has no echo, so its arc does not count.
pub const NO_ECHO: u32 = 1;
/// Cone flag: the beam is narrow and is widened to half a cell on each side of its axis.
pub const NARROW_BEAM: u32 = 2;
/// Cone flag: β is more than 22.5°.
pub const BROAD: u32 = 16;
/// Cone flag: the left edge belongs to the neighbouring beam.
pub const HALF_OPEN: u32 = 4;
/// Cone flag: the cone reaches farther than 1024 cells, so membership is decided in 64-bit integers.
pub const WIDE: u32 = 8;

/// Entry flag: the arc may meet this tile.
pub const ARC: u32 = 1;
/// Entry flag: every cell of the tile is interior.
pub const INSIDE: u32 = 2;
/// Number of bits of an entry's first word below the cone's index.
pub const ENTRY_SHIFT: u32 = 2;

/// Length of a scan beam's direction vector.
pub const UNIT: i32 = 1 << 25;
/// Beam flag: there is no echo, or it is too far away. The beam may be a cell's nearest, and then updates nothing.
pub const IDLE: u32 = 256;
/// Beam flag: a cell on the beam's bound belongs to the next beam.
pub const YIELD: u32 = 512;
/// Number of bits of a beam's id below its index in the scan.
pub const BEAM_SHIFT: u32 = 16;

/// Slot bit of an update's entry: the update's first fan may meet the tile. The next three bits are for the other fans.
pub const FAN: u32 = 1;
/// Slot bit of an update's entry: the first fan holds the whole tile. The next three bits are for the other fans.
pub const FULL: u32 = 16;
/// Slot bit of an update's entry: the first part's lines may meet the tile. The next bit is for the second part.
pub const LINES: u32 = 256;
/// Slot bit of an update's entry: the routine part may meet the tile.
pub const ROUTINE: u32 = 1024;

/// Update flag: the routine part frees only cells of the third fan.
pub const FREE_LIMIT: u32 = 1;
/// Update flag: the routine part occupies only cells of the fourth fan.
pub const ARC_LIMIT: u32 = 2;

/// Binning flag: cones reach only the cells on their axis.
pub const AXIS: u32 = 1;
/// Binning flag: the arc of a reading without an echo is included.
pub const ARCS: u32 = 2;

/// Frame mode: the pass frees (updates emptiness).
pub const FREE: u32 = 1;
/// Frame mode: the pass occupies.
pub const OCCUPY: u32 = 2;
/// Frame mode: the pass counts its cell updates.
pub const COUNT: u32 = 4;

/// The parameters of one pass over one grid.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Frame {
    /// Columns and rows of the grid, cells.
    pub size: [u32; 2],
    /// The mode bits [`FREE`], [`OCCUPY`] and [`COUNT`].
    pub mode: u32,
    /// Length of a unit, metres.
    pub scale: f32,
    /// Constants of the method.
    pub constants: [[f32; 4]; 2],
    /// Lengths of the method, µm.
    pub limits: [i32; 4],
}

/// A reading's snapped cone and the parameters of its profile.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Cone {
    /// The sensor's position, units.
    pub sensor: [i32; 2],
    /// Distances at which the arc begins, max(0, R − ε), and ends, R + ε, units. For himm: R itself, and a bound of its reach.
    pub reach: [i32; 2],
    /// Direction of the axis.
    pub axis: [i32; 2],
    /// Direction of the left edge, heading + β.
    pub left: [i32; 2],
    /// Direction of the right edge, heading − β.
    pub right: [i32; 2],
    /// The flags [`NO_ECHO`], [`NARROW_BEAM`], [`HALF_OPEN`], [`WIDE`] and [`BROAD`].
    pub flags: u32,
    /// Index of the reading in its batch.
    pub index: u32,
    /// Four numbers: the length of the axis' direction; 1/β, or 0 where the off-axis angle counts as 0; two spare.
    pub shape: [f32; 4],
    /// The four parameters of the method's profile.
    pub profile: [f32; 4],
}

/// A tile that a batch reaches.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Tile {
    /// Column and row of the tile's lower left cell.
    pub corner: [u32; 2],
    /// Range of the tile's entries: first, end (exclusive).
    pub entries: [u32; 2],
    /// Index of the tile in its chunk's state.
    pub slot: u32,
    /// Spare.
    pub spare: [u32; 3],
}

/// The box of tiles of a chunk that a cone may reach, for a GPU that bins cones into tiles itself.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct ConeTileBounds {
    /// Index of the cone in the batch.
    pub cone: u32,
    /// Index of the part of the box's first tile. The parts of the other tiles follow, row by row.
    pub part: u32,
    /// Column and row of the box's first tile, counted from the chunk's first tile.
    pub low: [u32; 2],
    /// Column and row after the box's last tile, counted likewise.
    pub high: [u32; 2],
}

/// The parameters of the kernels that bin a chunk's cones into its tiles.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct BinningParams {
    /// Column and row of the chunk's first tile.
    pub chunk: [u32; 2],
    /// Columns and rows of the grid, cells.
    pub size: [u32; 2],
    /// Number of cones that may reach the chunk.
    pub cones: u32,
    /// Number of segments of at most [`SEGMENT`] cones.
    pub segments: u32,
    /// The flags [`AXIS`] and [`ARCS`].
    pub flags: u32,
    /// Spare.
    pub pad: u32,
}

/// A scan: its pose and the range of its beams. Only methods that take scans use it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Scan {
    /// The pose's position, µm from the centre of the chunk's first cell.
    pub pose: [i32; 2],
    /// Index of the scan's first beam in the batch.
    pub first: u32,
    /// Number of beams.
    pub count: u32,
    /// Number of the scan in the log.
    pub number: u32,
    /// Spare.
    pub pad: [u32; 3],
}

/// A beam of a scan. A scan's beams are sorted by the bearings of their bounds from +x.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Beam {
    /// Direction of the bound to the next beam. Points on the bound's other side are nearer to the next beam.
    pub bound: [i32; 2],
    /// Discrete models: the gate's right and left edge. Continuous models: the direction, of length [`UNIT`], and the hit
    /// relative to the pose, µm.
    pub ray: [[i32; 2]; 2],
    /// Range of the hit, µm.
    pub range: i32,
    /// The class label in the low 8 bits, 0 for none; the flags [`IDLE`] and [`YIELD`]; from bit [`BEAM_SHIFT`] on the
    /// beam's index in the scan.
    pub id: u32,
}

/// The fans, lines and weights of an update. They index the batch's points, which are in units from the sensor.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Shapes {
    /// Range of each fan's vertices among the points: first, end (exclusive). Fans 0 and 1 are freed by the two parts; fans 2
    /// and 3 limit what the routine part frees and occupies.
    pub fans: [[u32; 2]; 4],
    /// Range of the line ends among the points for the lines that each of the two parts occupies. A line has two ends.
    pub lines: [[u32; 2]; 2],
    /// Four numbers: by how much each of the two parts moves P(occupied) from ½; the weight of the routine part; one spare.
    pub weights: [f32; 4],
    /// Number of the reading in the log.
    pub number: u32,
    /// The flags [`FREE_LIMIT`] and [`ARC_LIMIT`].
    pub flags: u32,
    /// Spare.
    pub room: [u32; 2],
}

/// An entry of a tile's list: a cone, a scan or an update that may touch the tile.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Entry {
    /// Index of the cone, scan or update, shifted by [`ENTRY_SHIFT`], and the flags [`ARC`] and [`INSIDE`].
    pub cone: u32,
    /// For a cone: the index of the part that sums the tile's share of the arc. For a scan: the least and, in the upper half,
    /// the largest place that a cell of the tile may have among the scan's bounds. For an update: the bits [`FAN`], [`FULL`],
    /// [`LINES`] and [`ROUTINE`].
    pub slot: u32,
}

impl Entry {
    /// Index of the cone, scan or update.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.cone >> ENTRY_SHIFT) as usize
    }
}
