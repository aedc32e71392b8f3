//! An open device: buffers, submissions, reading back, and the errors that it reports by itself.

use super::adapter;
use crate::kernels::adapter::AdapterInfo;
use crate::{Error, Result};
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::BufferUsages as Usage;

/// An adapter's device and queue.
pub struct Device {
    /// The adapter.
    pub info: AdapterInfo,
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    /// The first error that the device reported by itself: out of memory, lost.
    failure: Arc<Mutex<Option<String>>>,
    /// The buffer through which the host reads, used again.
    staging: Mutex<Option<wgpu::Buffer>>,
}

impl Device {
    /// Opens the best adapter; with `hardware` a software adapter is refused.
    pub fn open(hardware: bool) -> Result<Device> {
        let (info, device, queue) = adapter::open(hardware)?;
        Ok(Device::new(info, device, queue))
    }

    /// Takes over a device that is open.
    pub fn new(info: AdapterInfo, device: wgpu::Device, queue: wgpu::Queue) -> Device {
        let failure = Arc::new(Mutex::new(None));
        let report = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            report.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error.to_string());
        }));
        Device { info, device, queue, failure, staging: Mutex::new(None) }
    }

    /// The largest buffer that is bound whole, bytes.
    pub fn bindable(&self) -> usize {
        self.info.binding.min(self.info.buffer).min(1 << 30) as usize
    }

    /// A buffer of zeros that can be read back.
    pub fn zeros(&self, label: &str, size: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size.max(16),
            usage: Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// A module of this project's own WGSL.
    pub fn module(&self, label: &str, source: String) -> wgpu::ShaderModule {
        let module =
            wgpu::ShaderModuleDescriptor { label: Some(label), source: wgpu::ShaderSource::Wgsl(source.into()) };
        let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..wgpu::ShaderRuntimeChecks::checked() };
        // A counter in every loop keeps compilers from unrolling: csm's search for the 16th distance takes 3.5 times as long with it.
        // SAFETY: every loop of the kernels ends, and every other check stays. Most count towards a limit that stands; a stage ends
        // after where it began (driver/stage); a binary search halves what is left (scan/order); csm's steps are 1 mm at least.
        unsafe { self.device.create_shader_module_trusted(module, checks) }
    }

    /// An empty list of commands.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("batch") })
    }

    /// Submits the commands so far and begins a new list.
    pub fn submit(&self, encoder: &mut wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        let full = std::mem::replace(encoder, self.encoder());
        self.queue.submit([full.finish()])
    }

    /// Waits for a submission, or for all.
    pub fn wait(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<()> {
        let until = wgpu::PollType::Wait { submission_index, timeout: None };
        let lost = |e| Error::NoAdapter(format!("{} stopped answering: {e}", self.info));
        self.device.poll(until).map(|_| ()).map_err(lost)
    }

    /// Copies a buffer's first bytes to the host.
    pub fn read(&self, buffer: &wgpu::Buffer, bytes: u64) -> Result<Vec<u32>> {
        let lost = |e: &dyn std::fmt::Display| Error::NoAdapter(format!("{}: reading back failed: {e}", self.info));
        let mut kept = self.staging.lock().unwrap_or_else(PoisonError::into_inner);
        let staging = kept.take().filter(|s| s.size() >= bytes).unwrap_or_else(|| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("staging"),
                size: bytes,
                usage: Usage::MAP_READ | Usage::COPY_DST,
                mapped_at_creation: false,
            })
        });
        let mut encoder = self.encoder();
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, bytes);
        self.queue.submit([encoder.finish()]);
        let (send, receive) = std::sync::mpsc::channel();
        staging.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
            // The receiver waits below; it is gone only if this call is.
            let _ = send.send(result);
        });
        self.wait(None)?;
        receive.recv().map_err(|e| lost(&e))?.map_err(|e| lost(&e))?;
        let words = bytemuck::pod_collect_to_vec(&staging.get_mapped_range(..bytes).map_err(|e| lost(&e))?);
        staging.unmap();
        *kept = Some(staging);
        Ok(words)
    }

    /// Fails if the device has reported an error by itself. `resident`: bytes of the chunks' cells, for the message.
    pub fn healthy(&self, resident: u64) -> Result<()> {
        match self.failure.lock().unwrap_or_else(PoisonError::into_inner).as_deref() {
            None => Ok(()),
            Some(what) => Err(Error::Resources(format!(
                "{} failed with {} of cells resident: {what}; give smaller --bounds, a coarser --resolution, a smaller \
                 --batch, or --backend cpu",
                self.info,
                crate::support::memory::format_size(resident)
            ))),
        }
    }
}
