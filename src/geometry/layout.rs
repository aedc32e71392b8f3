//! The bytes that both backends read; twin of `shaders/geometry/layout.wgsl`.
//!
//! One unit is 1/32 of a cell. Coordinates count from the lower left corner of the grid. Directions are the unit vector
//! times 8192. A test holds every name, offset and constant of this file against the WGSL.

use bytemuck::{Pod, Zeroable};

/// Units in a cell.
pub const CELL: i32 = 32;
/// Length of a direction vector.
pub const DIRECTION: i32 = 8192;
/// Cells along a tile's edge: a tile is one workgroup's work.
pub const TILE: usize = 16;
/// Cells of a tile.
pub const TILE_CELLS: usize = TILE * TILE;
/// Tiles along a chunk's edge: a chunk of 1024 × 1024 cells is the unit of residence.
pub const CHUNK: usize = 64;
/// Tiles along a block's edge: where a GPU bins cones into tiles itself, they are sorted into blocks first.
pub const BLOCK: usize = 4;
/// Blocks along a chunk's edge.
pub const BLOCKS: usize = CHUNK / BLOCK;
/// Cones that are sorted into blocks together.
pub const SEGMENT: usize = 4096;

/// Cone flag: no echo came; the arc does not count.
pub const NO_ECHO: u32 = 1;
/// Cone flag: a narrow beam, widened to half a cell on each side of its axis.
pub const NARROW_BEAM: u32 = 2;
/// Cone flag: β is more than 22.5°.
pub const BROAD: u32 = 16;
/// Cone flag: the left edge belongs to the neighbour.
pub const HALF_OPEN: u32 = 4;
/// Cone flag: reaches farther than 1024 cells; decided in 64-bit integers.
pub const WIDE: u32 = 8;

/// Entry flag: the arc may meet this tile.
pub const ARC: u32 = 1;
/// Entry flag: every cell of the tile is interior.
pub const INSIDE: u32 = 2;
/// Bits of an entry below the cone's index.
pub const ENTRY_SHIFT: u32 = 2;

/// Length of a beam's direction.
pub const UNIT: i32 = 1 << 25;
/// Beam flag: nothing came back, or from too far: it may be the nearest, and then does nothing.
pub const IDLE: u32 = 256;
/// Beam flag: a cell on its bound belongs to the next beam.
pub const YIELD: u32 = 512;
/// Bits of a beam's id below its place in the scan.
pub const BEAM_SHIFT: u32 = 16;

/// Slot bit of an update's entry: the first of its fans may meet the tile; the other three's follow.
pub const FAN: u32 = 1;
/// The same: all of the tile lies in the first fan; the other three's follow.
pub const FULL: u32 = 16;
/// The same: the first part's lines may meet the tile; the second's follow.
pub const LINES: u32 = 256;
/// The same: the routine part may meet the tile.
pub const ROUTINE: u32 = 1024;

/// Update flag: what the routine part frees is limited by the third fan.
pub const FREE_LIMIT: u32 = 1;
/// Update flag: what the routine part occupies is limited by the fourth fan.
pub const ARC_LIMIT: u32 = 2;

/// Binning flag: cones reach the cells on their axis only.
pub const AXIS: u32 = 1;
/// Binning flag: the arc of a reading without an echo is included.
pub const ARCS: u32 = 2;

/// Frame mode: the pass frees (updates emptiness).
pub const FREE: u32 = 1;
/// Frame mode: the pass occupies.
pub const OCCUPY: u32 = 2;
/// Frame mode: the pass counts its cell updates.
pub const COUNT: u32 = 4;

/// One pass over one grid.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Frame {
    /// Columns and rows of the grid, cells.
    pub size: [u32; 2],
    /// [`FREE`], [`OCCUPY`], [`COUNT`].
    pub mode: u32,
    /// Metres a unit.
    pub scale: f32,
    /// The method's own numbers.
    pub constants: [[f32; 4]; 2],
    /// The method's own lengths, µm.
    pub limits: [i32; 4],
}

/// A reading's snapped cone and the numbers of its profile.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Cone {
    /// The sensor, units.
    pub sensor: [i32; 2],
    /// Where the arc begins, max(0, R − ε), and ends, R + ε, units (himm: R itself, and a bound of its reach).
    pub reach: [i32; 2],
    /// Direction of the axis.
    pub axis: [i32; 2],
    /// Direction of the left edge, heading + β.
    pub left: [i32; 2],
    /// Direction of the right edge, heading − β.
    pub right: [i32; 2],
    /// [`NO_ECHO`], [`NARROW_BEAM`], [`HALF_OPEN`], [`WIDE`], [`BROAD`].
    pub flags: u32,
    /// Where the reading stands in its batch.
    pub index: u32,
    /// Length of the axis' direction · 1/β (0: the off-axis angle counts as 0) · two spare.
    pub shape: [f32; 4],
    /// Four numbers of the method's profile.
    pub profile: [f32; 4],
}

/// A tile that a batch reaches.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Tile {
    /// Its lower left cell: column, row.
    pub corner: [u32; 2],
    /// Its entries, from, to (exclusive).
    pub entries: [u32; 2],
    /// Its place in its chunk's state.
    pub slot: u32,
    /// Spare.
    pub spare: [u32; 3],
}

/// The box of tiles of a chunk that a cone may reach, for a GPU that bins cones into tiles itself.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct ConeTileBounds {
    /// Its index in the batch.
    pub cone: u32,
    /// Where the part of the first tile of its box is; the others' follow, row by row.
    pub part: u32,
    /// The column and row of its box's first tile, counted from the chunk's.
    pub low: [u32; 2],
    /// Those after its box's last.
    pub high: [u32; 2],
}

/// What the kernels that bin a chunk's cones into its tiles need to know.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct BinningParams {
    /// The column and row of the chunk's first tile.
    pub chunk: [u32; 2],
    /// Columns and rows of the grid, cells.
    pub size: [u32; 2],
    /// How many cones may reach the chunk.
    pub cones: u32,
    /// How many [`SEGMENT`]s of them there are.
    pub segments: u32,
    /// [`AXIS`], [`ARCS`].
    pub flags: u32,
    /// Spare.
    pub pad: u32,
}

/// A scan, for the methods that take scans: where it was taken, and its beams.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Scan {
    /// Its pose, µm from the centre of the chunk's first cell.
    pub pose: [i32; 2],
    /// Its first beam in the batch.
    pub first: u32,
    /// How many beams it has.
    pub count: u32,
    /// Its number in the log.
    pub number: u32,
    /// Spare.
    pub pad: [u32; 3],
}

/// A beam of a scan, whose beams lie in the order of their bounds' bearings from +x.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Beam {
    /// Direction of the bound to the next beam: what lies on its other side is nearer to that one.
    pub bound: [i32; 2],
    /// Discrete: the gate's right and left edge; continuous: the direction, of length [`UNIT`], and the hit from the pose, µm.
    pub ray: [[i32; 2]; 2],
    /// The hit's range, µm.
    pub range: i32,
    /// The class label in the low 8 bits, 0 for none; [`IDLE`], [`YIELD`]; from [`BEAM_SHIFT`] on its place in the scan.
    pub id: u32,
}

/// What an update does beside its cone; its points lie in the batch's, units from the sensor.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Shapes {
    /// The vertices' first place and that after the last: of what either part frees, of the routine part's two limits.
    pub fans: [[u32; 2]; 4],
    /// The same of what either part occupies: the two ends of each line.
    pub lines: [[u32; 2]; 2],
    /// By how much either part moves P(occupied) from ½ · the weight of the routine part · spare.
    pub weights: [f32; 4],
    /// The reading's number in the log.
    pub number: u32,
    /// [`FREE_LIMIT`], [`ARC_LIMIT`].
    pub flags: u32,
    /// Spare.
    pub room: [u32; 2],
}

/// A cone, or a scan, in a tile's list.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Entry {
    /// The cone's, or the scan's, index, shifted by [`ENTRY_SHIFT`], and [`ARC`], [`INSIDE`].
    pub cone: u32,
    /// Where this tile's share of the cone's arc is summed; of a scan the first and, in the upper half, the last bound whose
    /// place among its bounds a cell of the tile may have; of an update [`FAN`], [`FULL`], [`LINES`], [`ROUTINE`].
    pub slot: u32,
}

impl Entry {
    /// The cone's index.
    #[inline(always)]
    pub fn index(self) -> usize {
        (self.cone >> ENTRY_SHIFT) as usize
    }
}
