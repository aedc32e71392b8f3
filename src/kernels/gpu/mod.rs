//! The GPU backend, through wgpu: `plan` lists the passes of a batch, `engine` executes them; the chunks' cells stay resident.

pub(super) mod adapter;
mod buffers;
mod device;
mod engine;
mod options;
mod peak;
mod pipeline;
mod pipelines;
mod plan;
mod pool;
pub mod program;
mod recording;
mod resident;
mod testing;
pub mod tile_binner;
mod timer;
mod work;

pub use options::{Options, Patch};

use super::adapter::AdapterInfo;
use super::peak::Peaks;
use super::shader::part_bytes;
use super::{Backend, ChunkStates, Limits, Shares, accumulate_counts, check_input};
use crate::binning::batch::BATCH;
use crate::binning::batch::Batch;
use crate::geometry::layout::{BLOCKS, CHUNK, Cone, Entry, Frame, SEGMENT, TILE_CELLS};
use crate::grid::ChunkId;
use crate::method::{self, Method, Step};
use crate::{Error, Result};
use device::Device;
use engine::{Engine, Executed};
use pipeline::Pipeline;
use pipelines::Pipelines;
use plan::plan;
use pool::Pool;
use program::Program;
use recording::{Download, Recording};
use resident::Resident;
use timer::Timer;
use work::{Capacity, Work};

/// The GPU backend.
pub struct Gpu {
    device: Device,
    pipelines: Pipelines,
    resident: Resident,
    pool: Pool,
    /// The submission of the batch before: the host bins the next batch meanwhile, and at most two wait.
    pending: Option<wgpu::SubmissionIndex>,
    timer: Option<Timer>,
    /// Bytes of a tile's part of a reading's sum.
    part_bytes: usize,
    /// Whether it bins cones into tiles itself.
    bins_tiles: bool,
}

/// Bytes that the cells of a chunk take at most, of a method that takes readings.
const LARGEST_CHUNK: u64 = 32 * (CHUNK * CHUNK * TILE_CELLS) as u64;

/// Bytes that a cone takes in the lists of blocks at most.
const IN_BLOCKS: usize = BLOCKS * BLOCKS * size_of::<u32>();

/// Iterations over a tile's entries that a software adapter's thread may have. The loops of each stage of sixteen entries add ten at most:
/// 65,000 in all, fewer than the 65,535 after which Mesa ends a loop.
const SOFTWARE_MAX_LOOP_ITERATIONS: usize = 40_000;

impl Gpu {
    /// Opens the best adapter.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where there is none that will do.
    pub fn new(options: &Options) -> Result<Gpu> {
        Ok(Gpu::on(Device::open(options.hardware)?, options))
    }

    /// On a device that is open.
    pub fn with_device(info: AdapterInfo, device: wgpu::Device, queue: wgpu::Queue, options: &Options) -> Gpu {
        Gpu::on(Device::new(info, device, queue), options)
    }

    fn on(device: Device, options: &Options) -> Gpu {
        let part_bytes = part_bytes(options.stages(&device.info));
        // Any method's chunk, and a usual batch's cones by block, must fit into one binding.
        let largest = LARGEST_CHUNK.max((BATCH * IN_BLOCKS) as u64);
        let able = device.info.binding >= largest && device.info.workgroups as usize >= CHUNK * CHUNK;
        let bins_tiles = able && options.bins_tiles.unwrap_or(!device.info.software);
        Gpu {
            device,
            pipelines: Pipelines::new(options),
            resident: Resident::default(),
            pool: Pool::default(),
            pending: None,
            timer: None,
            part_bytes,
            bins_tiles,
        }
    }

    /// The adapter.
    pub fn adapter_info(&self) -> &AdapterInfo {
        &self.device.info
    }

    fn healthy(&self) -> Result<()> {
        self.device.healthy(self.resident.bytes())
    }

    /// Fails where the adapter can't run a method.
    fn check(&self, method: &dyn Method) -> Result<()> {
        if let Some(why) = method.cpu_only() {
            return Err(Error::NoAdapter(format!("{why}: use --backend cpu")));
        }
        let (info, tiles) = (self.adapter_info(), CHUNK * CHUNK);
        let chunk = (method::tile_words(method) * 4 * tiles) as u64;
        if chunk > info.buffer || (info.workgroups as usize) < tiles {
            return Err(Error::NoAdapter(format!(
                "{info} gives at most {} bytes and {} workgroups; a chunk of {} needs {chunk} and {tiles}: use \
                 --backend cpu",
                info.buffer,
                info.workgroups,
                method::name(method)
            )));
        }
        Ok(())
    }

    fn capacity(&self, method: &dyn Method) -> Capacity {
        let bytes = |tiles: usize| (method::tile_words(method) * size_of::<u32>() * tiles) as u64;
        let fits = |tiles: &usize| *tiles == 1 || bytes(*tiles) <= self.device.info.binding;
        // All tiles of a chunk, or where they are more than the adapter binds a half, a quarter, …
        let halves = std::iter::successors(Some(CHUNK * CHUNK), |tiles| Some(tiles / 2));
        Capacity { part_bytes: self.part_bytes, tiles_per_binding: { halves }.find(fits).unwrap_or(1) }
    }

    fn execute(&mut self, recording: Recording, programs: &[(Program, Pipeline)]) -> Result<Executed> {
        let Gpu { device, pool, resident, timer, .. } = self;
        Engine { device, pool, resident, timer: timer.as_mut() }.execute(recording, programs)
    }
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn adapter(&self) -> String {
        self.adapter_info().to_string()
    }

    fn peaks(&mut self) -> Result<Option<Peaks>> {
        peak::peaks(&self.device).map(Some)
    }

    fn limits(&self) -> Limits {
        let (bindable, info) = (self.device.bindable(), self.adapter_info());
        let one = if self.bins_tiles { IN_BLOCKS } else { size_of::<Cone>() };
        Limits {
            // Sum takes a thread a reading, 64 in a workgroup; blocks take whole segments.
            readings: (bindable / one / SEGMENT * SEGMENT).min(64 * info.workgroups as usize),
            entries: bindable / size_of::<Entry>(),
            parts: bindable / self.part_bytes,
            max_loop_iterations: if info.software { SOFTWARE_MAX_LOOP_ITERATIONS } else { usize::MAX },
            bins_tiles: self.bins_tiles,
        }
    }

    fn apply(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        batch: &Batch,
        steps: &[Step],
        shares: &mut Shares,
    ) -> Result<()> {
        check_input(method, batch)?;
        self.check(method)?;
        shares.resize(batch.cones().len(), [0; 4]);
        let work = Work { method, frame, batch, steps, shares };
        let recording = plan(&work, self.capacity(method))?;
        let programs = self.pipelines.prepare(&self.device, &work, &recording)?;
        let Executed { submitted, downloads } = self.execute(recording, &programs)?;
        for (download, words) in downloads {
            match download {
                Download::Counts => accumulate_counts(shares, words.into_iter(), batch.cones().len()),
                Download::Shares => {
                    let read = words.chunks_exact(4).map(|w| [w[0], w[1], w[2], w[3]]);
                    shares.iter_mut().zip(read).for_each(|(share, read)| *share = read);
                }
                // No plan of a batch asks for these.
                Download::Tiles | Download::Entries => {}
            }
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

    fn take(&mut self, chunk: ChunkId) -> Result<Option<Vec<u32>>> {
        self.healthy()?;
        self.resident.take(&self.device, chunk)
    }

    fn finish(&mut self, _: &dyn Method) -> Result<ChunkStates> {
        self.healthy()?;
        self.resident.take_all(&self.device)
    }
}
