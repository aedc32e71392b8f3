//! The GPU's kernels through wgpu: a method's passes over each chunk that a batch reaches, the chunks resident.

pub mod adapter;
mod ceiling;
mod device;
pub mod lists;
mod pass;
mod timer;
pub mod shader;

use super::{Backend, Chunks, Limits, Shares, shares, tally};
use crate::batch::{Batch, ChunkList};
use crate::layout::{CHUNK, Cone, Entry, Frame, TILE_CELLS, Tile};
use crate::method::{self, Method, Step, Unit};
use crate::{Error, Result};
use adapter::Found;
use device::Device;
use lists::{Listed, Lister};
use pass::{Needs, Passes, key};
use shader::Kernel;
use std::collections::BTreeMap;
use timer::Timer;
use wgpu::BufferUsages as Usage;

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
    /// Whether the GPU lists tiles itself; `None`: what suits the adapter's class. Results don't depend on it.
    pub lists: Option<bool>,
}

/// The GPU backend.
pub struct Gpu {
    device: Device,
    passes: Passes,
    chunks: BTreeMap<[u32; 2], wgpu::Buffer>,
    /// The batch before, still under way: the host bins the next one meanwhile, and only two are held.
    pending: Option<wgpu::SubmissionIndex>,
    timer: Option<Timer>,
    lister: Option<Lister>,
    lists: bool,
}

/// A tile's part of a reading's sum.
pub(crate) const PART_BYTES: usize = size_of::<f32>();

/// Bytes that the cells of a chunk take at most, of a method that takes readings.
const LARGEST_CHUNK: u64 = 32 * (CHUNK * CHUNK * TILE_CELLS) as u64;

/// How often a software adapter's thread may go round the loop over a tile's entries: with what it goes round for each stage of
/// sixteen, six times at most, a little less than Mesa's 65535.
const SOFTWARE_TURNS: usize = 45_000;

/// A chunk's buffers for one batch, or, where an adapter doesn't bind all of its cells at once, those of some of its tiles.
struct ChunkBuffers {
    tiles: wgpu::Buffer,
    entries: wgpu::Buffer,
    groups: u32,
    place: [u32; 2],
    /// Which of the cells' bytes they are: from where, how many.
    cells: (u64, u64),
}

/// A batch's buffers. Of scans, where a method takes them: the scans themselves, for shares the centres of the cells, for first parts
/// the beams; of updates for shares their shapes, for first parts their points.
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
        Ok(Gpu::on(Device::open(options.hardware)?, options))
    }

    /// On a device that is open.
    pub fn with_device(found: Found, device: wgpu::Device, queue: wgpu::Queue, options: &Options) -> Gpu {
        Gpu::on(Device::new(found, device, queue), options)
    }

    fn on(device: Device, options: &Options) -> Gpu {
        let passes = Passes::new(&device, options);
        // The lists of any method's chunk must fit into one binding.
        let able = device.found.binding >= LARGEST_CHUNK && device.found.workgroups as usize >= CHUNK * CHUNK;
        let lists = able && options.lists.unwrap_or(!device.found.software);
        Gpu { device, passes, chunks: BTreeMap::new(), pending: None, timer: None, lister: None, lists }
    }

    /// The adapter.
    pub fn found(&self) -> &Found {
        &self.device.found
    }

    /// Uploads a batch, and records what lists its tiles where that is left to the GPU.
    fn upload(
        &self,
        (encoder, timer): (&mut wgpu::CommandEncoder, &mut Option<Timer>),
        (method, frame, steps): (&dyn Method, Frame, &[Step]),
        batch: &Batch,
        shares_so_far: &Shares,
    ) -> BatchBuffers {
        let input = Usage::STORAGE | Usage::COPY_DST;
        let device = &self.device;
        let sums = steps.contains(&Step::Sum);
        let slots = batch.first_part.last().copied().unwrap_or(0) as usize;
        let parts = if sums { slots * PART_BYTES } else { batch.cones.len() * size_of::<u32>() };
        let (tile, slots) = ((method::tile_words(method) * size_of::<u32>()) as u64, self.slots(method) as u32);
        let part = |list: &ChunkList, first: u32| {
            let within = |t: &&Tile| (first..first + slots).contains(&t.slot);
            let tiles: Vec<Tile> =
                list.tiles.iter().filter(within).map(|t| Tile { slot: t.slot - first, ..*t }).collect();
            ChunkBuffers {
                tiles: device.buffer("tiles", &tiles, input),
                entries: device.buffer("entries", &list.entries, input),
                groups: tiles.len() as u32,
                place: [list.place[1], list.place[0]],
                cells: (u64::from(first) * tile, u64::from(slots) * tile),
            }
        };
        let cones = match method.unit() {
            Unit::Scan => device.buffer("scans", &batch.scans, input),
            Unit::Reading | Unit::Update => device.buffer("cones", &batch.cones, input),
        };
        let all = (CHUNK * CHUNK) as u32;
        let arcs = steps.iter().any(|s| matches!(s, Step::Share | Step::Tally));
        let mut chunk = |list: &ChunkList| match &self.lister {
            Some(lister) if !list.near.is_empty() => {
                let how = Lister::how(&frame, list, method.footprint(), arcs);
                let stamps = timer.as_mut().and_then(|t| t.writes("list"));
                let Listed { tiles, entries } = lister.record(device, encoder, (&cones, list, how), stamps);
                let cells = (0, u64::from(all) * tile);
                vec![ChunkBuffers { tiles, entries, groups: all, place: [list.place[1], list.place[0]], cells }]
            }
            _ => (0..all).step_by(slots as usize).map(|first| part(list, first)).filter(|c| c.groups > 0).collect(),
        };
        BatchBuffers {
            chunks: batch.chunks.iter().flat_map(&mut chunk).collect(),
            parts: device.zeros("parts", parts as u64),
            shares: match method.unit() {
                Unit::Reading => device.buffer("shares", shares_so_far, input | Usage::COPY_SRC),
                Unit::Scan => device.buffer("centres", &batch.centres, input),
                Unit::Update => device.buffer("shapes", &batch.shapes, input),
            },
            first_part: match method.unit() {
                Unit::Reading => device.buffer("first_part", &batch.first_part, input),
                Unit::Scan => device.buffer("beams", &batch.beams, input),
                Unit::Update => device.buffer("points", &batch.points, input),
            },
            cones,
        }
    }

    /// Tiles of a chunk whose cells are bound at once: all, or where they are more than the adapter binds a half, a quarter, …
    fn slots(&self, method: &dyn Method) -> usize {
        let bytes = |slots: usize| (method::tile_words(method) * size_of::<u32>() * slots) as u64;
        let fits = |slots: &usize| *slots == 1 || bytes(*slots) <= self.found().binding;
        std::iter::successors(Some(CHUNK * CHUNK), |slots| Some(slots / 2)).find(fits).unwrap_or(1)
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
        Limits {
            // Sum takes a thread a reading, 64 in a group.
            readings: (bindable / size_of::<Cone>()).min(64 * self.found().workgroups as usize),
            entries: bindable / size_of::<Entry>(),
            parts: bindable / PART_BYTES,
            turns: if self.found().software && !self.lists { SOFTWARE_TURNS } else { usize::MAX },
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
        for list in &batch.chunks {
            let place = [list.place[1], list.place[0]];
            if !self.chunks.contains_key(&place) {
                let bytes = method::tile_words(method) * CHUNK * CHUNK * size_of::<u32>();
                self.chunks.insert(place, self.device.zeros("chunk", bytes as u64));
            }
        }
        shares_so_far.resize(batch.cones.len(), [0; 4]);
        if self.lister.is_none() && batch.chunks.iter().any(|c| !c.near.is_empty()) {
            self.lister = Some(Lister::new(&self.device)?);
        }
        let (mut encoder, mut timer) = (self.device.encoder(), self.timer.take());
        let buffers = self.upload((&mut encoder, &mut timer), (method, frame, steps), batch, shares_so_far);
        self.timer = timer;
        let mut record = |encoder: &mut _, kernel: Kernel, frame: Frame, chunk: &ChunkBuffers, groups| {
            let Some(state) = self.chunks.get(&chunk.place) else { return };
            let frame = self.device.buffer("frame", &[frame], Usage::UNIFORM);
            let b = &buffers;
            let (offset, size) = chunk.cells;
            let cells = wgpu::BufferBinding { buffer: state, offset, size: std::num::NonZero::new(size) };
            let [frame, cones, tiles, entries, parts, shares, first_part] =
                [&frame, &b.cones, &chunk.tiles, &chunk.entries, &b.parts, &b.shares, &b.first_part]
                    .map(wgpu::Buffer::as_entire_buffer_binding);
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
                    let counts = self.device.read(&buffers.parts)?;
                    let shares = shares(method, counts.into_iter(), &batch.cones);
                    self.device.queue.write_buffer(&buffers.shares, 0, bytemuck::cast_slice(&shares));
                }
                Step::Tally => {
                    self.device.submit(&mut encoder);
                    tally(shares_so_far, self.device.read(&buffers.parts)?.into_iter(), batch.cones.len());
                }
                Step::Hand => {
                    self.device.submit(&mut encoder);
                    let words = self.device.read(&buffers.shares)?;
                    let handed = words.chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]);
                    shares_so_far.iter_mut().zip(handed).for_each(|(share, new)| *share = new);
                }
            }
        }
        let submitted = self.device.submit(&mut encoder);
        if let Some(timer) = &mut self.timer {
            timer.read(&self.device)?;
        }
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
        self.chunks.remove(&place).map(|buffer| self.device.read(&buffer)).transpose()
    }

    fn finish(&mut self, _: &dyn Method) -> Result<Chunks> {
        self.healthy()?;
        let chunks = std::mem::take(&mut self.chunks);
        chunks.iter().map(|(place, buffer)| Ok((*place, self.device.read(buffer)?))).collect()
    }
}
