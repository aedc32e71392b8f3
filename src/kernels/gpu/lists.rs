//! Lists made on the GPU, byte for byte those of `batch` but for where parts are; what the passes bind is twin of
//! `shaders/binning/list/*.wgsl`.

use super::device::Device;
use super::pool::{Piece, Pool};
use super::{Gpu, Patch};
use crate::binning::batch::{Batch, Binning, ChunkList};
use crate::binning::snap::Footprint;
use crate::geometry::layout::{ARCS, AXIS, BLOCKS, CHUNK, Entry, Frame, Lists, SEGMENT, Tile};
use crate::{Error, Result};
use bytemuck::Zeroable;

const LAYOUT: &str = include_str!("../../../shaders/geometry/layout.wgsl");
const COMPACT: &str = include_str!("../../../shaders/binning/list/compact.wgsl");
const NEAR: &str = include_str!("../../../shaders/binning/list/near.wgsl");
const MEETS: &str = include_str!("../../../shaders/binning/list/meets.wgsl");
const TILES: &str = include_str!("../../../shaders/binning/list/tiles.wgsl");

/// A chunk's lists on the device.
pub struct Listed {
    /// A tile for each slot, …
    pub tiles: Piece,
    /// … and their entries.
    pub entries: Piece,
}

/// The pipelines: into blocks; how long each tile's list is, where it begins, its entries.
pub struct Lister {
    near: wgpu::ComputePipeline,
    measure: wgpu::ComputePipeline,
    place: wgpu::ComputePipeline,
    list: wgpu::ComputePipeline,
}

/// The WGSL of both modules.
pub fn sources() -> [String; 2] {
    // Threads of a workgroup: a block's have many cones to go through, a tile's few.
    let [block, tile] = [256, 64].map(|workers| format!("const WORKERS: u32 = {workers}u;"));
    [[&block, LAYOUT, COMPACT, NEAR].join("\n"), [&tile, LAYOUT, COMPACT, MEETS, TILES].join("\n")]
}

impl Gpu {
    /// The lists that the GPU makes of a batch's chunks: for tests, which hold them against those of `batch`.
    pub fn list(&mut self, size: [usize; 2], binning: &Binning, batch: &Batch) -> Result<Vec<ChunkList>> {
        let (device, pool, lister) = (&self.device, &mut self.pool, Lister::new(&self.device, &self.patches)?);
        let frame = Frame { size: size.map(|s| s as u32), ..Frame::zeroed() };
        let cones = pool.filled(device, &batch.cones);
        let lists = batch.chunks.iter().map(|list| {
            let how = Lister::how(&frame, list, binning.footprint, binning.no_echo_arcs);
            let mut encoder = device.encoder();
            let listed = lister.record((device, &mut *pool), &mut encoder, (&cones, list, how), None);
            device.submit(&mut encoder);
            let read = |piece: &Piece| device.read(&piece.buffer, piece.bytes);
            let mut tiles: Vec<Tile> = bytemuck::pod_collect_to_vec(&read(&listed.tiles)?);
            let mut entries: Vec<Entry> = bytemuck::pod_collect_to_vec(&read(&listed.entries)?);
            entries.truncate(tiles.last().map_or(0, |t| t.entries[1] as usize));
            tiles.retain(|t| t.entries[0] < t.entries[1]);
            Ok(ChunkList { tiles, entries, ..list.clone() })
        });
        lists.collect()
    }
}

impl Lister {
    /// Makes the pipelines, their sources changed as given.
    pub fn new(device: &Device, patches: &[Patch]) -> Result<Lister> {
        let scope = device.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let [near, tiles] = sources().map(|source| {
            let patched = |source: String, (from, to): &Patch| source.replace(from, to);
            device.module("lists", patches.iter().fold(source, patched))
        });
        let pipeline = |module, entry_point| {
            device.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..Default::default()
                },
                cache: None,
            })
        };
        let lister = Lister {
            near: pipeline(&near, "near_blocks"),
            measure: pipeline(&tiles, "measure"),
            place: pipeline(&tiles, "place"),
            list: pipeline(&tiles, "list"),
        };
        match pollster::block_on(scope.pop()) {
            Some(e) => Err(Error::NoAdapter(format!("{} refuses the kernels that list tiles: {e}", device.found))),
            None => Ok(lister),
        }
    }

    /// How a chunk of a batch is listed.
    pub fn how(frame: &Frame, list: &ChunkList, footprint: Footprint, no_echo_arcs: bool) -> Lists {
        let flag = |on: bool, bit: u32| if on { bit } else { 0 };
        Lists {
            chunk: list.place.map(|p| p * CHUNK as u32),
            size: frame.size,
            near: list.near.len() as u32,
            segments: list.near.len().div_ceil(SEGMENT) as u32,
            how: flag(footprint == Footprint::Axis, AXIS) | flag(no_echo_arcs, ARCS),
            pad: 0,
        }
    }

    /// Records the passes that list a chunk's tiles.
    pub fn record(
        &self,
        (device, pool): (&Device, &mut Pool),
        encoder: &mut wgpu::CommandEncoder,
        (cones, list, how): (&Piece, &ChunkList, Lists),
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites>,
    ) -> Listed {
        let (blocks, segments) = (BLOCKS * BLOCKS, how.segments.max(1));
        let in_blocks = u64::from(segments) * blocks as u64;
        let words = |count: u64| count * size_of::<u32>() as u64;
        let lists = pool.filled(device, &[how]);
        let near = pool.filled(device, &list.near);
        let by_block = pool.any(device, words(in_blocks * SEGMENT as u64));
        let counts = pool.any(device, words(in_blocks));
        let listed = Listed {
            tiles: pool.any(device, (CHUNK * CHUNK * size_of::<Tile>()) as u64),
            entries: pool.any(device, (list.pairs() * size_of::<Entry>()) as u64),
        };
        let all = [&lists, &near, &by_block, &counts, cones, &listed.tiles, &listed.entries];
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("list"), timestamp_writes });
        // A pipeline's layout has what its entry point uses.
        let mut run = |pipeline: &wgpu::ComputePipeline, bound: &[u32], x: u32, y: u32| {
            let resource = |binding: u32| wgpu::BindingResource::Buffer(all[binding as usize].binding());
            let entry = |binding: &u32| wgpu::BindGroupEntry { binding: *binding, resource: resource(*binding) };
            let entries: Vec<_> = bound.iter().map(entry).collect();
            let layout = pipeline.get_bind_group_layout(0);
            let descriptor = wgpu::BindGroupDescriptor { label: Some("list"), layout: &layout, entries: &entries };
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &device.device.create_bind_group(&descriptor), &[]);
            pass.dispatch_workgroups(x, y, 1);
        };
        let tiles = (CHUNK * CHUNK) as u32;
        run(&self.near, &[0, 1, 2, 3], blocks as u32, segments);
        run(&self.measure, &[0, 1, 2, 3, 4, 5], tiles, 1);
        run(&self.place, &[5], 1, 1);
        run(&self.list, &[0, 1, 2, 3, 4, 5, 6], tiles, 1);
        drop(pass);
        pool.done(by_block);
        pool.done(counts);
        listed
    }
}
