//! Executes a recording: takes buffers from the pool, uploads, encodes the passes, submits them, and copies to the host.

use super::device::Device;
use super::pipeline::Pipeline;
use super::pool::{BufferSlice, Pool};
use super::program::Program;
use super::recording::{Buffer, BufferId, Command, Contents, Download, Pass, Recording};
use super::resident::Resident;
use super::timer::Timer;
use crate::Result;
use crate::grid::ChunkId;
use crate::kernels::KernelError;

/// What a recording came to.
pub struct Executed {
    /// The last submission.
    pub submitted: wgpu::SubmissionIndex,
    /// What was copied to the host, in order.
    pub downloads: Vec<(Download, Vec<u32>)>,
}

/// The device and what a recording is executed with.
pub struct Engine<'a> {
    /// The device.
    pub device: &'a Device,
    /// Buffers to use again.
    pub pool: &'a mut Pool,
    /// The chunks' cells.
    pub resident: &'a mut Resident,
    /// Where passes are timed.
    pub timer: Option<&'a mut Timer>,
}

/// A recording under way: its buffers, as far as they are made, and the commands since the last submission.
struct Execution<'a, 'r> {
    engine: Engine<'a>,
    buffers: Vec<Buffer<'r>>,
    made: Vec<Option<BufferSlice>>,
    programs: &'a [(Program, Pipeline)],
    encoder: wgpu::CommandEncoder,
}

impl Engine<'_> {
    /// Executes a recording with the pipelines of its kernels.
    ///
    /// # Errors
    /// [`KernelError`] where a pass lacks something or is too large; what the device reports.
    pub fn execute(self, recording: Recording, programs: &[(Program, Pipeline)]) -> Result<Executed> {
        let Recording { buffers, commands } = recording;
        let (made, encoder) = (buffers.iter().map(|_| None).collect(), self.device.encoder());
        let mut execution = Execution { engine: self, buffers, made, programs, encoder };
        let mut downloads = Vec::new();
        for command in commands {
            match command {
                Command::MakeResident { chunk, bytes } => execution.make_resident(chunk, bytes),
                Command::Pass(pass) => execution.encode(&pass)?,
                Command::Release(id) => execution.release(id),
                Command::HostPass { input, output, compute } => {
                    let words = execution.read(input)?;
                    execution.write(output, &compute(words))?;
                }
                Command::Download(id, what) => downloads.push((what, execution.read(id)?)),
            }
        }
        let submitted = execution.finish()?;
        Ok(Executed { submitted, downloads })
    }
}

impl Execution<'_, '_> {
    fn make_resident(&mut self, chunk: ChunkId, bytes: u64) {
        self.engine.resident.make(self.engine.device, &mut self.encoder, chunk, bytes);
    }

    /// Makes a buffer, if it is not made yet.
    fn make(&mut self, id: BufferId) -> Result<BufferSlice> {
        if let Some(slice) = &self.made[id.index()] {
            return Ok(slice.clone());
        }
        let Engine { device, pool, resident, .. } = &mut self.engine;
        let Buffer { bytes, contents } = &self.buffers[id.index()];
        let slice = match contents {
            Contents::Upload(contents) => pool.filled(device, contents, *bytes),
            Contents::Zeros => pool.zeros(device, &mut self.encoder, *bytes),
            Contents::Undefined => pool.any(device, *bytes),
            Contents::Resident { chunk, offset } => BufferSlice {
                buffer: resident.get(*chunk).ok_or(KernelError::NotResident { chunk: *chunk })?.clone(),
                offset: *offset,
                bytes: *bytes,
            },
        };
        self.made[id.index()] = Some(slice.clone());
        Ok(slice)
    }

    /// Encodes a pass.
    fn encode(&mut self, pass: &Pass) -> Result<()> {
        let mut dispatches = Vec::with_capacity(pass.dispatches.len());
        for dispatch in &pass.dispatches {
            let limit = self.engine.device.info.workgroups;
            let workgroups = dispatch.workgroups[0].max(dispatch.workgroups[1]);
            if workgroups > limit {
                return Err(KernelError::DispatchTooLarge { pass: pass.label, workgroups, limit }.into());
            }
            let pipeline = self.programs.iter().find(|(program, _)| *program == dispatch.program);
            let (_, pipeline) = pipeline.ok_or(KernelError::NoPipeline { pass: pass.label })?;
            let bound = dispatch.bindings.iter().map(|(number, id)| Ok((*number, self.make(*id)?)));
            let bound = bound.collect::<Result<Vec<_>>>()?;
            dispatches.push((pipeline, self.bind_group(pass.label, pipeline, &bound), dispatch.workgroups));
        }
        let timestamp_writes = self.engine.timer.as_mut().and_then(|t| t.writes(pass.label));
        let descriptor = wgpu::ComputePassDescriptor { label: Some(pass.label), timestamp_writes };
        let mut encoded = self.encoder.begin_compute_pass(&descriptor);
        for (pipeline, group, [x, y]) in dispatches {
            encoded.set_pipeline(&pipeline.pipeline);
            encoded.set_bind_group(0, &group, &[]);
            encoded.dispatch_workgroups(x, y, 1);
        }
        Ok(())
    }

    fn bind_group(&self, label: &str, pipeline: &Pipeline, bound: &[(u32, BufferSlice)]) -> wgpu::BindGroup {
        let resources = bound.iter().map(|(binding, slice)| (*binding, wgpu::BindingResource::Buffer(slice.binding())));
        let entries: Vec<_> = resources.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
        let (label, layout) = (Some(label), &pipeline.layout);
        let descriptor = wgpu::BindGroupDescriptor { label, layout, entries: &entries };
        self.engine.device.device.create_bind_group(&descriptor)
    }

    /// Gives a buffer that the host never writes back to the pool, for the passes that follow.
    fn release(&mut self, id: BufferId) {
        if let Some(slice) = self.made[id.index()].take() {
            self.engine.pool.release(slice);
        }
    }

    /// Submits what is encoded and reads a buffer.
    fn read(&mut self, id: BufferId) -> Result<Vec<u32>> {
        let slice = self.make(id)?;
        self.engine.device.submit(&mut self.encoder);
        self.engine.device.read(&slice.buffer, slice.bytes)
    }

    /// Writes a buffer, for the passes that follow.
    fn write(&mut self, id: BufferId, words: &[[u32; 4]]) -> Result<()> {
        let slice = self.make(id)?;
        self.engine.device.queue.write_buffer(&slice.buffer, slice.offset, bytemuck::cast_slice(words));
        Ok(())
    }

    /// Submits what is left, adds up the passes' times, and gives all buffers back to the pool.
    fn finish(mut self) -> Result<wgpu::SubmissionIndex> {
        let submitted = self.engine.device.submit(&mut self.encoder);
        if let Some(timer) = &mut self.engine.timer {
            timer.read(self.engine.device)?;
        }
        self.engine.pool.recycle();
        Ok(submitted)
    }
}
