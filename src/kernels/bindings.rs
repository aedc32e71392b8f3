//! What each kernel binds, by the names of the WGSL; twin of `shaders/method/driver/readings.wgsl`, of `shaders/method/driver/scans.wgsl` and of
//! `shaders/method/driver/updates.wgsl`. The driver `sum` declares its own. A test compares every layout with what naga reflects of the
//! composed WGSL.

use super::KernelError;
use super::shader::Kernel;
use crate::geometry::layout::{Beam, BinningParams, Cone, ConeTileBounds, Entry, Frame, Scan, Shapes, Tile};
use crate::method::Unit;

/// How a kernel uses a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer that is only read.
    Read,
    /// A storage buffer that is read and written.
    ReadWrite,
}

/// A binding of group 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binding {
    /// `@binding(number)`.
    pub number: u32,
    /// The variable's name in the WGSL.
    pub name: &'static str,
    /// How it is used.
    pub access: Access,
    /// Bytes of one element.
    pub stride: u64,
}

const fn binding<T>(number: u32, name: &'static str, access: Access) -> Binding {
    Binding { number, name, access, stride: size_of::<T>() as u64 }
}

/// Four words of the cells' state.
type Vec4 = [u32; 4];

const FRAME: Binding = binding::<Frame>(0, "frame", Access::Uniform);
const CONES: Binding = binding::<Cone>(1, "cones", Access::Read);
const TILES: Binding = binding::<Tile>(2, "tiles", Access::Read);
const ENTRIES: Binding = binding::<Entry>(3, "entries", Access::Read);
const STATE: Binding = binding::<Vec4>(4, "state", Access::ReadWrite);
const PARTS: Binding = binding::<u32>(5, "parts", Access::ReadWrite);
const SHARES: Binding = binding::<Vec4>(6, "shares", Access::ReadWrite);

/// *fuse* over readings.
const FUSE_READINGS: &[Binding] = &[FRAME, CONES, TILES, ENTRIES, STATE, SHARES];
/// *weigh* and *count* over readings.
const MEASURE_READINGS: &[Binding] = &[FRAME, CONES, TILES, ENTRIES, STATE, PARTS, SHARES];
/// *sum* over readings.
const SUM_READINGS: &[Binding] = &[CONES, PARTS, SHARES, binding::<u32>(7, "first_part", Access::Read)];
/// *fuse* over scans.
const FUSE_SCANS: &[Binding] = &[
    FRAME,
    binding::<Scan>(1, "scans", Access::Read),
    TILES,
    ENTRIES,
    binding::<u32>(4, "state", Access::ReadWrite),
    binding::<i32>(6, "centres", Access::Read),
    binding::<Beam>(7, "beams", Access::Read),
];
/// *fuse* over updates.
const FUSE_UPDATES: &[Binding] = &[
    FRAME,
    CONES,
    TILES,
    ENTRIES,
    STATE,
    binding::<Shapes>(6, "shapes", Access::ReadWrite),
    binding::<[i32; 2]>(7, "points", Access::Read),
];

/// What a kernel of a method that takes this kind of input binds.
///
/// # Errors
/// [`KernelError::NoKernel`] where there is no such kernel.
pub fn bindings(input: Unit, kernel: Kernel) -> Result<&'static [Binding], KernelError> {
    match (input, kernel) {
        (Unit::Reading, Kernel::Fuse) => Ok(FUSE_READINGS),
        (Unit::Reading, Kernel::Weigh | Kernel::Count) => Ok(MEASURE_READINGS),
        (Unit::Reading, Kernel::Sum) => Ok(SUM_READINGS),
        (Unit::Scan, Kernel::Fuse) => Ok(FUSE_SCANS),
        (Unit::Update, Kernel::Fuse) => Ok(FUSE_UPDATES),
        (Unit::Scan | Unit::Update, Kernel::Weigh | Kernel::Count | Kernel::Sum) => {
            Err(KernelError::NoKernel { kernel: kernel.name(), input: input.name() })
        }
    }
}

/// What the kernel that sorts a chunk's cones into blocks of tiles binds (`shaders/binning/list/cone_tile_bounds.wgsl`).
pub const SORT_INTO_BLOCKS: &[Binding] = &[
    binding::<BinningParams>(0, "params", Access::Uniform),
    binding::<ConeTileBounds>(1, "bounds", Access::Read),
    binding::<u32>(2, "blocks", Access::ReadWrite),
    binding::<u32>(3, "counts", Access::ReadWrite),
];

/// What the kernels that make each tile's list from its block's bind (`shaders/binning/list/tiles.wgsl`).
pub const LIST_TILES: &[Binding] = &[
    binding::<BinningParams>(0, "params", Access::Uniform),
    binding::<ConeTileBounds>(1, "bounds", Access::Read),
    binding::<u32>(2, "blocks", Access::Read),
    binding::<u32>(3, "counts", Access::Read),
    binding::<Cone>(4, "cones", Access::Read),
    binding::<Tile>(5, "tiles", Access::ReadWrite),
    binding::<Entry>(6, "entries", Access::ReadWrite),
];
