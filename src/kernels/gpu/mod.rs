//! The GPU's kernels through wgpu: a method's passes over each chunk that a batch reaches, the chunks resident.

pub mod adapter;
pub mod shader;

use super::{Backend, Chunks, Outcomes, fresh_chunk, shares};
use crate::batch::{Batch, ChunkList};
use crate::layout::{Cone, Entry, Frame, Tile, WIDE};
use crate::method::{self, Method, Step};
use crate::{Error, Result};
use adapter::Found;
use bytemuck::Pod;
use shader::Kernel;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::BufferUsages as Usage;
use wgpu::util::DeviceExt;

/// A change to a kernel's source: every `from` becomes `to`. For tests that seed faults.
pub type Patch = (String, String);

/// How to open the GPU.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Refuse a software adapter.
    pub hardware: bool,
    /// Changes to the kernels' sources, for tests that seed faults.
    pub patches: Vec<Patch>,
}

/// The GPU backend.
pub struct Gpu {
    found: Found,
    device: wgpu::Device,
    queue: wgpu::Queue,
    layout: wgpu::BindGroupLayout,
    kernels: BTreeMap<Key, wgpu::ComputePipeline>,
    patches: Vec<Patch>,
    chunks: BTreeMap<[u32; 2], wgpu::Buffer>,
    /// The batch before, still under way: the host bins the next one meanwhile, and only two are held.
    pending: Option<wgpu::SubmissionIndex>,
    /// The first error that the device reported by itself: out of memory, lost.
    failure: Arc<Mutex<Option<String>>>,
}

/// Bindings, in the order of `shaders/layout.wgsl`: uniform, then storage, read-only or not.
const BINDINGS: [Option<bool>; 8] =
    [None, Some(true), Some(true), Some(true), Some(false), Some(false), Some(false), Some(true)];

/// A pipeline: the method, its kernel, whether for wide readings.
type Key = (&'static str, Kernel, bool);

/// A chunk's buffers for one batch.
struct ChunkBuffers {
    tiles: wgpu::Buffer,
    entries: wgpu::Buffer,
    groups: u32,
    place: [u32; 2],
}

/// A batch's buffers.
struct BatchBuffers {
    cones: wgpu::Buffer,
    parts: wgpu::Buffer,
    shares: wgpu::Buffer,
    first_part: wgpu::Buffer,
    chunks: Vec<ChunkBuffers>,
}

impl Gpu {
    /// Opens the best adapter.
    pub fn new(options: &Options) -> Result<Gpu> {
        let (found, device, queue) = adapter::open(options.hardware)?;
        Ok(Self::with_device(found, device, queue, options))
    }

    /// On a device that is open.
    pub fn with_device(found: Found, device: wgpu::Device, queue: wgpu::Queue, options: &Options) -> Gpu {
        let entries: Vec<_> = BINDINGS
            .iter()
            .enumerate()
            .map(|(binding, storage)| wgpu::BindGroupLayoutEntry {
                binding: binding as u32,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: match storage {
                        None => wgpu::BufferBindingType::Uniform,
                        Some(read_only) => wgpu::BufferBindingType::Storage { read_only: *read_only },
                    },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("every pass"),
            entries: &entries,
        });
        let failure = Arc::new(Mutex::new(None));
        let report = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            report.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error.to_string());
        }));
        let patches = options.patches.clone();
        Gpu {
            failure,
            pending: None,
            found,
            device,
            queue,
            layout,
            kernels: BTreeMap::new(),
            patches,
            chunks: BTreeMap::new(),
        }
    }

    /// The largest buffer that is bound whole, bytes.
    fn bindable(&self) -> usize {
        self.found.binding.min(self.found.buffer).min(1 << 30) as usize
    }

    /// The adapter.
    pub fn found(&self) -> &Found {
        &self.found
    }

    fn prepare(&mut self, method: &dyn Method, kernel: Kernel, wide: bool) -> Result<()> {
        let key = (method::name(method), kernel, wide);
        if self.kernels.contains_key(&key) {
            return Ok(());
        }
        let label = format!("{} {}", key.0, kernel.name());
        let mut source = shader::source(method, kernel, wide);
        for (from, to) in &self.patches {
            source = source.replace(from, to);
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&label),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&label),
            bind_group_layouts: &[Some(&self.layout)],
            immediate_size: 0,
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&label),
            layout: Some(&layout),
            module: &module,
            entry_point: Some(kernel.name()),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        if let Some(e) = pollster::block_on(scope.pop()) {
            return Err(Error::NoAdapter(format!("{} refuses the kernel {label}: {e}", self.found)));
        }
        self.kernels.insert(key, pipeline);
        Ok(())
    }

    fn buffer<T: Pod>(&self, label: &str, contents: &[T], usage: Usage) -> wgpu::Buffer {
        let empty = vec![0u8; size_of::<T>().max(16)];
        let contents = if contents.is_empty() { &empty } else { bytemuck::cast_slice(contents) };
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
    }

    fn upload(&self, batch: &Batch) -> BatchBuffers {
        let input = Usage::STORAGE | Usage::COPY_DST;
        let parts = (batch.first_part.last().copied().unwrap_or(0) as usize).max(batch.cones.len());
        let chunk = |list: &ChunkList| ChunkBuffers {
            tiles: self.buffer::<Tile>("tiles", &list.tiles, input),
            entries: self.buffer::<Entry>("entries", &list.entries, input),
            groups: list.tiles.len() as u32,
            place: [list.place[1], list.place[0]],
        };
        BatchBuffers {
            cones: self.buffer::<Cone>("cones", &batch.cones, input),
            parts: self.buffer("parts", &vec![0u32; parts], input | Usage::COPY_SRC),
            shares: self.buffer("shares", &vec![[0u32; 4]; batch.cones.len()], input),
            first_part: self.buffer("first_part", &batch.first_part, input),
            chunks: batch.chunks.iter().map(chunk).collect(),
        }
    }

    /// Records one kernel over one chunk (a thread a reading for [`Kernel::Sum`]).
    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        key: Key,
        frame: &wgpu::Buffer,
        buffers: &BatchBuffers,
        chunk: &ChunkBuffers,
        groups: u32,
    ) {
        let (Some(pipeline), Some(state)) = (self.kernels.get(&key), self.chunks.get(&chunk.place)) else { return };
        let bound = [
            frame,
            &buffers.cones,
            &chunk.tiles,
            &chunk.entries,
            state,
            &buffers.parts,
            &buffers.shares,
            &buffers.first_part,
        ];
        let entries: Vec<_> = bound
            .iter()
            .enumerate()
            .map(|(k, b)| wgpu::BindGroupEntry { binding: k as u32, resource: b.as_entire_binding() })
            .collect();
        let label = Some(key.1.name());
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &self.layout,
            entries: &entries,
        });
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes: None });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        // More groups than one axis takes are cut by the caller: a chunk has 4096 tiles at most.
        pass.dispatch_workgroups(groups, 1, 1);
    }

    fn submit(&self, encoder: &mut wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        let full = std::mem::replace(encoder, self.encoder());
        self.queue.submit([full.finish()])
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("batch") })
    }

    fn poll(&self, until: wgpu::PollType) -> Result<()> {
        let lost = |e| Error::NoAdapter(format!("{} stopped answering: {e}", self.found));
        self.device.poll(until).map(|_| ()).map_err(lost)
    }

    /// Reads a buffer's words back.
    fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u32>> {
        let lost = |e: &dyn std::fmt::Display| Error::NoAdapter(format!("{}: reading back failed: {e}", self.found));
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("staging"),
            size: buffer.size(),
            usage: Usage::MAP_READ | Usage::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.encoder();
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        let (send, receive) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver waits below; it is gone only if this call is.
            let _ = send.send(result);
        });
        self.poll(wgpu::PollType::wait_indefinitely())?;
        receive.recv().map_err(|e| lost(&e))?.map_err(|e| lost(&e))?;
        let view = staging.get_mapped_range(..).map_err(|e| lost(&e))?;
        Ok(bytemuck::pod_collect_to_vec(&view))
    }

    /// Fails if the device has reported an error by itself.
    fn healthy(&self) -> Result<()> {
        match self.failure.lock().unwrap_or_else(PoisonError::into_inner).as_deref() {
            None => Ok(()),
            Some(what) => {
                let resident = crate::memory::show(self.chunks.values().map(wgpu::Buffer::size).sum());
                Err(Error::Resources(format!(
                    "{} failed with {resident} of cells resident: {what}; give smaller --bounds, a coarser --resolution, a \
                     smaller --batch, or --backend cpu",
                    self.found
                )))
            }
        }
    }

    /// Fails where an adapter can't do what a batch asks.
    fn check(&self, method: &dyn Method) -> Result<()> {
        if let Some(why) = method.cpu_only() {
            return Err(Error::NoAdapter(format!("{why}: use --backend cpu")));
        }
        let chunk = (method::tile_words(method) * 4 * crate::layout::CHUNK * crate::layout::CHUNK) as u64;
        if chunk > self.found.binding || self.found.workgroups < 4096 {
            return Err(Error::NoAdapter(format!(
                "{} binds at most {} bytes and {} workgroups; a chunk of {} needs {chunk} and 4096: use --backend cpu",
                self.found,
                self.found.binding,
                self.found.workgroups,
                method::name(method)
            )));
        }
        Ok(())
    }
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn adapter(&self) -> String {
        self.found.to_string()
    }

    fn entry_limit(&self) -> usize {
        self.bindable() / size_of::<Entry>()
    }

    fn reading_limit(&self) -> usize {
        // Sum takes a thread a reading, 64 in a group.
        (self.bindable() / size_of::<Cone>()).min(64 * self.found.workgroups as usize)
    }

    fn apply(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        batch: &Batch,
        outcomes: Outcomes,
        sweep: usize,
    ) -> Result<()> {
        self.check(method)?;
        let name = method::name(method);
        let steps = method.sweeps()[sweep];
        let wide = batch.cones.iter().any(|c| c.flags & WIDE != 0);
        for step in steps {
            match step {
                Step::Pass(pass, _) => self.prepare(method, (*pass).into(), wide)?,
                Step::Sum => self.prepare(method, Kernel::Sum, wide)?,
                Step::Share => {}
            }
        }
        for list in &batch.chunks {
            let place = [list.place[1], list.place[0]];
            if !self.chunks.contains_key(&place) {
                let usage = Usage::STORAGE | Usage::COPY_SRC;
                self.chunks.insert(place, self.buffer("chunk", &fresh_chunk(method), usage));
            }
        }
        let buffers = self.upload(batch);
        let mut encoder = self.encoder();
        for step in steps {
            match *step {
                Step::Pass(pass, mode) => {
                    let frame = self.buffer("frame", &[Frame { mode, ..frame }], Usage::UNIFORM);
                    for chunk in &buffers.chunks {
                        self.record(&mut encoder, (name, pass.into(), wide), &frame, &buffers, chunk, chunk.groups);
                    }
                }
                Step::Sum => {
                    let frame = self.buffer("frame", &[frame], Usage::UNIFORM);
                    if let Some(chunk) = buffers.chunks.first() {
                        let groups = (batch.cones.len() as u32).div_ceil(64);
                        self.record(&mut encoder, (name, Kernel::Sum, wide), &frame, &buffers, chunk, groups);
                    }
                }
                Step::Share => {
                    self.submit(&mut encoder);
                    let counts = self.read(&buffers.parts)?;
                    let shares = shares(method, counts.into_iter(), outcomes);
                    self.queue.write_buffer(&buffers.shares, 0, bytemuck::cast_slice(&shares));
                }
            }
        }
        let submitted = self.submit(&mut encoder);
        if let Some(before) = self.pending.replace(submitted) {
            self.poll(wgpu::PollType::Wait { submission_index: Some(before), timeout: None })?;
        }
        self.healthy()
    }

    fn wait(&mut self) -> Result<()> {
        self.poll(wgpu::PollType::wait_indefinitely())?;
        self.healthy()
    }

    fn finish(&mut self, _: &dyn Method) -> Result<Chunks> {
        self.healthy()?;
        let chunks = std::mem::take(&mut self.chunks);
        chunks.iter().map(|(place, buffer)| Ok((*place, self.read(buffer)?))).collect()
    }
}
