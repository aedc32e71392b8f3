//! The GPU's kernels through wgpu: a method's passes over each chunk that a batch reaches, the chunks resident.

pub mod adapter;
mod ceiling;
mod device;
pub mod lists;
mod pass;
mod pool;
pub mod shader;
mod timer;
mod upload;
pub mod vulkan;

use super::{Backend, Chunks, Limits, Shares, shares, tally};
use crate::binning::batch::BATCH;
use crate::binning::batch::Batch;
use crate::geometry::layout::{BLOCKS, CHUNK, Cone, Entry, Frame, SEGMENT, TILE_CELLS};
use crate::method::{self, Method, Step};
use crate::{Error, Result};
use adapter::Found;
use device::Device;
use lists::Lister;
use pass::{Needs, Passes, key};
use pool::{Piece, Pool};
use shader::Kernel;
use std::collections::BTreeMap;
use timer::Timer;
use upload::{ChunkBuffers, Upload};

/// A change to a kernel's source: every `from` becomes `to`. For tests that seed faults.
pub type Patch = (String, String);

/// How to open the GPU.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Refuse a software adapter.
    pub hardware: bool,
    /// Changes to the kernels' sources, for tests that seed faults.
    pub patches: Vec<Patch>,
    /// How many times four cells a thread owns, 1 to 16, rounded up to a power of two; `None`: what suits the adapter's class.
    /// Results don't depend on it.
    pub groups: Option<u32>,
    /// Whether kernels stage readings in workgroup memory and tell tiles apart; `None`: what suits the adapter's class. Results don't
    /// depend on it.
    pub staged: Option<bool>,
    /// Whether the GPU lists tiles itself; `None`: what suits the adapter's class. Results don't depend on it, but that a software
    /// adapter's lists are not held to as many entries as it can go through ([`Limits::turns`]): on one it is for tests.
    pub lists: Option<bool>,
}

impl Options {
    /// Whether kernels stage readings on this adapter.
    fn stages(&self, found: &Found) -> bool {
        self.staged.unwrap_or(!found.software)
    }
}

/// The GPU backend.
pub struct Gpu {
    device: Device,
    passes: Passes,
    chunks: BTreeMap<[u32; 2], wgpu::Buffer>,
    /// Memory of chunks that were handed over.
    spare: Vec<wgpu::Buffer>,
    pool: Pool,
    /// The batch before, still under way: the host bins the next one meanwhile, and only two wait.
    pending: Option<wgpu::SubmissionIndex>,
    timer: Option<Timer>,
    patches: Vec<Patch>,
    /// Bytes of a part of a sum.
    part: usize,
    lister: Option<Lister>,
    lists: bool,
}

/// A tile's part of a reading's sum: one number where kernels stage readings, else one for each group of four cells.
pub(crate) const fn part_bytes(staged: bool) -> usize {
    if staged { size_of::<f32>() } else { 64 * size_of::<f32>() }
}

/// Bytes that the cells of a chunk take at most, of a method that takes readings.
const LARGEST_CHUNK: u64 = 32 * (CHUNK * CHUNK * TILE_CELLS) as u64;

/// Bytes that a near cone takes in the lists of blocks at most.
const IN_BLOCKS: usize = BLOCKS * BLOCKS * size_of::<u32>();

/// How often a software adapter's thread may go round the loop over a tile's entries: with what it goes round for each stage of
/// sixteen, ten times at most, less than Mesa's 65535.
const SOFTWARE_TURNS: usize = 40_000;

impl Gpu {
    /// Opens the best adapter.
    pub fn new(options: &Options) -> Result<Gpu> {
        Ok(Gpu::on(Device::open(options.hardware)?, options))
    }

    /// On a device that is open.
    pub fn with_device(found: Found, device: wgpu::Device, queue: wgpu::Queue, options: &Options) -> Gpu {
        Gpu::on(Device::new(found, device, queue), options)
    }

    fn on(device: Device, options: &Options) -> Gpu {
        let (passes, part) = (Passes::new(&device, options), part_bytes(options.stages(&device.found)));
        // Any method's chunk, and a usual batch's cones by block, must fit into one binding.
        let largest = LARGEST_CHUNK.max((BATCH * IN_BLOCKS) as u64);
        let able = device.found.binding >= largest && device.found.workgroups as usize >= CHUNK * CHUNK;
        let lists = able && options.lists.unwrap_or(!device.found.software);
        Gpu {
            device,
            passes,
            chunks: BTreeMap::new(),
            spare: Vec::new(),
            pool: Pool::default(),
            pending: None,
            timer: None,
            patches: options.patches.clone(),
            part,
            lister: None,
            lists,
        }
    }

    /// The adapter.
    pub fn found(&self) -> &Found {
        &self.device.found
    }

    /// A chunk's words; its memory is for another.
    fn hand_over(&mut self, buffer: wgpu::Buffer) -> Result<Vec<u32>> {
        let words = self.device.read(&buffer, buffer.size())?;
        if self.spare.len() < SPARE {
            self.spare.push(buffer);
        }
        Ok(words)
    }

    fn healthy(&self) -> Result<()> {
        self.device.healthy(self.chunks.values().map(wgpu::Buffer::size).sum())
    }

    /// Fails where an adapter can't do what a batch asks.
    fn check(&self, method: &dyn Method) -> Result<()> {
        if let Some(why) = method.cpu_only() {
            return Err(Error::NoAdapter(format!("{why}: use --backend cpu")));
        }
        let (found, tiles) = (self.found(), CHUNK * CHUNK);
        let chunk = (method::tile_words(method) * 4 * tiles) as u64;
        if chunk > found.buffer || (found.workgroups as usize) < tiles {
            return Err(Error::NoAdapter(format!(
                "{found} gives at most {} bytes and {} workgroups; a chunk of {} needs {chunk} and {tiles}: use \
                 --backend cpu",
                found.buffer,
                found.workgroups,
                method::name(method)
            )));
        }
        Ok(())
    }
}

/// Tiles of a chunk whose cells are bound at once: all, or where they are more than the adapter binds a half, a quarter, …
fn slots(device: &Device, method: &dyn Method) -> usize {
    let bytes = |slots: usize| (method::tile_words(method) * size_of::<u32>() * slots) as u64;
    let fits = |slots: &usize| *slots == 1 || bytes(*slots) <= device.found.binding;
    std::iter::successors(Some(CHUNK * CHUNK), |slots| Some(slots / 2)).find(fits).unwrap_or(1)
}

/// Chunks' memory that is kept for others at most.
const SPARE: usize = 2;

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn adapter(&self) -> String {
        self.found().to_string()
    }

    fn ceilings(&mut self) -> Result<Option<crate::kernels::ceiling::Ceilings>> {
        ceiling::ceilings(&self.device).map(Some)
    }

    fn limits(&self) -> Limits {
        let bindable = self.device.bindable();
        let one = if self.lists { IN_BLOCKS } else { size_of::<Cone>() };
        Limits {
            // Sum takes a thread a reading, 64 in a group; blocks take whole segments.
            readings: (bindable / one / SEGMENT * SEGMENT).min(64 * self.found().workgroups as usize),
            entries: bindable / size_of::<Entry>(),
            parts: bindable / self.part,
            turns: if self.found().software { SOFTWARE_TURNS } else { usize::MAX },
            lists: self.lists,
        }
    }

    fn apply(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        batch: &Batch,
        steps: &[Step],
        shares_so_far: &mut Shares,
    ) -> Result<()> {
        self.check(method)?;
        let needs = Needs::of(&batch.cones);
        for step in steps {
            match step {
                Step::Pass(pass, _) => self.passes.prepare(&self.device, method, (*pass).into(), needs)?,
                Step::Sum => self.passes.prepare(&self.device, method, Kernel::Sum, needs)?,
                Step::Share | Step::Hand | Step::Tally => {}
            }
        }
        let mut encoder = self.device.encoder();
        let bytes = (method::tile_words(method) * CHUNK * CHUNK * size_of::<u32>()) as u64;
        for list in &batch.chunks {
            let spare = &mut self.spare;
            self.chunks.entry([list.place[1], list.place[0]]).or_insert_with(|| {
                match spare.iter().position(|b| b.size() == bytes) {
                    Some(k) => {
                        let buffer = spare.swap_remove(k);
                        encoder.clear_buffer(&buffer, 0, None);
                        buffer
                    }
                    None => self.device.zeros("chunk", bytes),
                }
            });
        }
        shares_so_far.resize(batch.cones.len(), [0; 4]);
        if self.lister.is_none() && batch.chunks.iter().any(|c| !c.near.is_empty()) {
            self.lister = Some(Lister::new(&self.device, &self.patches)?);
        }
        let upload = Upload {
            device: &self.device,
            pool: &mut self.pool,
            encoder: &mut encoder,
            timer: self.timer.as_mut(),
            lister: self.lister.as_ref(),
            part: self.part,
        };
        let buffers = upload.batch((method, frame, steps), batch, shares_so_far);
        let mut record = |encoder: &mut _, kernel: Kernel, frame: Frame, chunk: &ChunkBuffers, groups| {
            let Some(state) = self.chunks.get(&chunk.place) else { return };
            let frame = self.pool.filled(&self.device, &[frame]);
            let b = &buffers;
            let (offset, size) = chunk.cells;
            let cells = wgpu::BufferBinding { buffer: state, offset, size: std::num::NonZero::new(size) };
            let [frame, cones, tiles, entries, parts, shares, first_part] =
                [&frame, &b.cones, &chunk.tiles, &chunk.entries, &b.parts, &b.shares, &b.first_part]
                    .map(Piece::binding);
            let bound = [frame, cones, tiles, entries, cells, parts, shares, first_part];
            let stamps = self.timer.as_mut().and_then(|t| t.writes(kernel.name()));
            self.passes.record(&self.device, encoder, key(method, kernel, needs), bound, groups, stamps);
        };
        for step in steps {
            match *step {
                Step::Pass(pass, mode) => {
                    for chunk in &buffers.chunks {
                        record(&mut encoder, pass.into(), Frame { mode, ..frame }, chunk, chunk.groups);
                    }
                }
                Step::Sum => {
                    // Any chunk will do: a thread a reading.
                    if let Some(chunk) = buffers.chunks.first() {
                        record(&mut encoder, Kernel::Sum, frame, chunk, (batch.cones.len() as u32).div_ceil(64));
                    }
                }
                Step::Share => {
                    self.device.submit(&mut encoder);
                    let counts = self.device.read(&buffers.parts.buffer, buffers.parts.bytes)?;
                    let shares = shares(method, counts.into_iter(), &batch.cones);
                    self.device.queue.write_buffer(&buffers.shares.buffer, 0, bytemuck::cast_slice(&shares));
                }
                Step::Tally => {
                    self.device.submit(&mut encoder);
                    tally(
                        shares_so_far,
                        self.device.read(&buffers.parts.buffer, buffers.parts.bytes)?.into_iter(),
                        batch.cones.len(),
                    );
                }
                Step::Hand => {
                    self.device.submit(&mut encoder);
                    let words = self.device.read(&buffers.shares.buffer, buffers.shares.bytes)?;
                    let handed = words.chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]);
                    shares_so_far.iter_mut().zip(handed).for_each(|(share, new)| *share = new);
                }
            }
        }
        let submitted = self.device.submit(&mut encoder);
        if let Some(timer) = &mut self.timer {
            timer.read(&self.device)?;
        }
        self.pool.recycle();
        if let Some(before) = self.pending.replace(submitted) {
            self.device.wait(Some(before))?;
        }
        self.healthy()
    }

    fn time_passes(&mut self) {
        self.timer = Timer::new(&self.device);
    }

    fn pass_times(&mut self) -> Vec<(&'static str, f64)> {
        self.timer.take().map_or_else(Vec::new, Timer::seconds)
    }

    fn wait(&mut self) -> Result<()> {
        self.device.wait(None)?;
        self.healthy()
    }

    fn take(&mut self, place: [u32; 2]) -> Result<Option<Vec<u32>>> {
        self.healthy()?;
        let Some(buffer) = self.chunks.remove(&place) else { return Ok(None) };
        self.hand_over(buffer).map(Some)
    }

    fn finish(&mut self, _: &dyn Method) -> Result<Chunks> {
        self.healthy()?;
        let chunks = std::mem::take(&mut self.chunks);
        chunks.into_iter().map(|(place, buffer)| Ok((place, self.hand_over(buffer)?))).collect()
    }
}
