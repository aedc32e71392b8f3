//! Bins cones into tiles on the GPU. The lists are those of `batch`, byte for byte but for the numbers of the parts; the kernels are
//! twins of `shaders/binning/list/*.wgsl`.

use super::device::Device;
use super::options::Patch;
use super::pipeline::{Description, Pipeline, patched};
use super::program::{BinnerKernel, Program};
use super::recording::{BufferId, Command, Contents, Dispatch, Recording};
use crate::binning::batch::ChunkList;
use crate::binning::snap::Footprint;
use crate::geometry::layout::{ARCS, AXIS, BLOCKS, BinningParams, CHUNK, Entry, SEGMENT, TILE, Tile};
use crate::kernels::KernelError;
use crate::kernels::bindings::Binding;
use crate::{Error, Result};

const LAYOUT: &str = include_str!("../../../shaders/geometry/layout.wgsl");
const COMPACT: &str = include_str!("../../../shaders/binning/list/compact.wgsl");
const CONE_TILE_BOUNDS: &str = include_str!("../../../shaders/binning/list/cone_tile_bounds.wgsl");
const MEETS: &str = include_str!("../../../shaders/binning/list/meets.wgsl");
const TILES: &str = include_str!("../../../shaders/binning/list/tiles.wgsl");

/// The label of its passes.
pub const LABEL: &str = "list";

/// The WGSL of both modules: the first sorts into blocks, the second makes the tiles' lists.
pub fn sources() -> [String; 2] {
    // Threads of a workgroup: a block has many cones to go through, a tile few.
    let [block, tile] = [256, 64].map(|workers| format!("const WORKERS: u32 = {workers}u;"));
    [[&block, LAYOUT, COMPACT, CONE_TILE_BOUNDS].join("\n"), [&tile, LAYOUT, COMPACT, MEETS, TILES].join("\n")]
}

/// The pipelines of the binner's kernels.
pub struct TileBinner([Pipeline; 4]);

impl TileBinner {
    /// Makes the pipelines, their sources changed as given.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where the adapter refuses a kernel.
    pub fn new(device: &Device, patches: &[Patch]) -> Result<TileBinner> {
        let scope = device.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let [blocks, tiles] = sources().map(|source| device.module("tile binner", patched(source, patches)));
        let pipelines = BinnerKernel::ALL.map(|kernel| {
            let module = if kernel == BinnerKernel::SortIntoBlocks { &blocks } else { &tiles };
            let (label, bindings) = (kernel.name(), kernel.bindings());
            Pipeline::new(device, &Description { label, module, entry_point: label, bindings, constants: &[] })
        });
        match pollster::block_on(scope.pop()) {
            Some(e) => Err(Error::NoAdapter(format!("{} refuses the kernels that bin tiles: {e}", device.info))),
            None => Ok(TileBinner(pipelines)),
        }
    }

    /// The pipeline of a kernel.
    pub fn pipeline(&self, kernel: BinnerKernel) -> &Pipeline {
        &self.0[kernel as usize]
    }
}

/// The parameters of a chunk's binning.
pub fn params(size: [u32; 2], list: &ChunkList, footprint: Footprint, no_echo_arcs: bool) -> BinningParams {
    let flag = |on: bool, bit: u32| if on { bit } else { 0 };
    BinningParams {
        chunk: list.place.first_cell().map(|first| (first / TILE) as u32),
        size,
        cones: list.cone_bounds.len() as u32,
        segments: list.cone_bounds.len().div_ceil(SEGMENT) as u32,
        flags: flag(footprint == Footprint::Axis, AXIS) | flag(no_echo_arcs, ARCS),
        pad: 0,
    }
}

/// A chunk's lists on the device.
pub struct BinnedTiles {
    /// A tile for each slot.
    pub tiles: BufferId,
    /// The entries of all tiles.
    pub entries: BufferId,
}

/// Records the pass that bins a chunk's cones into its tiles.
///
/// # Errors
/// [`KernelError::MissingBuffer`] where a kernel binds what is not here.
pub fn record<'a>(
    recording: &mut Recording<'a>,
    cones: BufferId,
    list: &'a ChunkList,
    params: BinningParams,
) -> std::result::Result<BinnedTiles, KernelError> {
    let (blocks_of_chunk, segments) = (BLOCKS * BLOCKS, params.segments.max(1));
    let lists_of_blocks = u64::from(segments) * blocks_of_chunk as u64;
    let words = |count: u64| count * size_of::<u32>() as u64;
    let undefined = |recording: &mut Recording, bytes| recording.buffer(bytes, Contents::Undefined);
    let params = recording.upload_owned(&[params]);
    let bounds = recording.upload(&list.cone_bounds);
    let blocks = undefined(recording, words(lists_of_blocks * SEGMENT as u64));
    let counts = undefined(recording, words(lists_of_blocks));
    let tiles = undefined(recording, (CHUNK * CHUNK * size_of::<Tile>()) as u64);
    let entries = undefined(recording, (list.pairs() * size_of::<Entry>()) as u64);
    let buffer = |name: &str| match name {
        "params" => Some(params),
        "bounds" => Some(bounds),
        "blocks" => Some(blocks),
        "counts" => Some(counts),
        "cones" => Some(cones),
        "tiles" => Some(tiles),
        "entries" => Some(entries),
        _ => None,
    };
    let dispatch = |kernel: BinnerKernel| {
        let all = (CHUNK * CHUNK) as u32;
        let workgroups = match kernel {
            BinnerKernel::SortIntoBlocks => [blocks_of_chunk as u32, segments],
            BinnerKernel::Measure | BinnerKernel::List => [all, 1],
            BinnerKernel::Place => [1, 1],
        };
        let missing = |binding| KernelError::MissingBuffer { pass: kernel.name(), binding };
        let bound = |b: &Binding| Ok((b.number, buffer(b.name).ok_or(missing(b.name))?));
        let bindings = kernel.bindings().iter().map(bound).collect::<std::result::Result<_, KernelError>>()?;
        Ok(Dispatch { program: Program::Binner(kernel), bindings, workgroups })
    };
    let dispatches = BinnerKernel::ALL.into_iter().map(dispatch).collect::<std::result::Result<_, KernelError>>()?;
    recording.passes(LABEL, dispatches);
    // The next chunk may use them again.
    recording.command(Command::Release(blocks));
    recording.command(Command::Release(counts));
    Ok(BinnedTiles { tiles, entries })
}
