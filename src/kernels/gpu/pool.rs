//! A pool of buffers: a card's memory is slow to allocate, and batches are short.
//!
//! Submissions run in order, and the host's writes come before the next submission. So a buffer may be taken again once all commands that
//! use it are submitted, finished or not. A buffer that the host never writes may be taken again once those commands are recorded.

use super::device::Device;
use wgpu::BufferUsages as Usage;

/// Some bytes of a buffer that may be longer.
#[derive(Debug, Clone)]
pub struct BufferSlice {
    /// The buffer.
    pub buffer: wgpu::Buffer,
    /// Bytes before the first.
    pub offset: u64,
    /// How many bytes.
    pub bytes: u64,
}

impl BufferSlice {
    /// What a pass binds.
    pub fn binding(&self) -> wgpu::BufferBinding<'_> {
        let size = std::num::NonZero::new(self.bytes);
        wgpu::BufferBinding { buffer: &self.buffer, offset: self.offset, size }
    }
}

/// Buffers to use again.
#[derive(Default)]
pub struct Pool {
    /// Those that no command uses any more.
    free: Vec<wgpu::Buffer>,
    /// Those that only commands recorded since the last [`Pool::recycle`] use: the host must not write them.
    scratch: Vec<wgpu::Buffer>,
    /// Those taken since the last [`Pool::recycle`].
    taken: Vec<wgpu::Buffer>,
}

impl Pool {
    /// A buffer of so many bytes with any contents, for kernels to write.
    pub fn any(&mut self, device: &Device, bytes: u64) -> BufferSlice {
        let found = find(&mut self.scratch, bytes);
        self.slice(device, found, bytes)
    }

    /// A buffer of so many zeros, once the encoder's commands run.
    pub fn zeros(&mut self, device: &Device, encoder: &mut wgpu::CommandEncoder, bytes: u64) -> BufferSlice {
        let slice = self.any(device, bytes);
        encoder.clear_buffer(&slice.buffer, 0, Some(slice.bytes));
        slice
    }

    /// A buffer of so many bytes that begins with a copy of `contents`.
    pub fn filled(&mut self, device: &Device, contents: &[u8], bytes: u64) -> BufferSlice {
        let slice = self.slice(device, None, bytes);
        device.queue.write_buffer(&slice.buffer, 0, contents);
        slice
    }

    fn slice(&mut self, device: &Device, found: Option<wgpu::Buffer>, bytes: u64) -> BufferSlice {
        let bytes = bytes.max(16);
        let buffer = found.or_else(|| find(&mut self.free, bytes)).unwrap_or_else(|| {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pooled"),
                size: bytes.next_power_of_two().min(device.info.buffer).max(bytes),
                usage: Usage::STORAGE | Usage::UNIFORM | Usage::COPY_SRC | Usage::COPY_DST,
                mapped_at_creation: false,
            })
        });
        self.taken.push(buffer.clone());
        BufferSlice { buffer, offset: 0, bytes }
    }

    /// Takes back a buffer that only recorded commands use and that the host does not write.
    pub fn release(&mut self, slice: BufferSlice) {
        self.taken.retain(|b| *b != slice.buffer);
        self.scratch.push(slice.buffer);
    }

    /// Takes everything back: all commands are submitted.
    pub fn recycle(&mut self) {
        self.free.append(&mut self.taken);
        self.free.append(&mut self.scratch);
    }
}

/// Takes out the smallest buffer that is large enough; much larger ones are left for larger needs.
fn find(buffers: &mut Vec<wgpu::Buffer>, bytes: u64) -> Option<wgpu::Buffer> {
    let fits = |b: &wgpu::Buffer| (bytes..=2 * bytes.next_power_of_two()).contains(&b.size());
    let found = buffers.iter().enumerate().filter(|(_, b)| fits(b)).min_by_key(|(_, b)| b.size())?.0;
    Some(buffers.swap_remove(found))
}
