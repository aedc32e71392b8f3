//! Buffers that are used again: a card's memory is slow to allocate, and a batch is soon over.

use super::device::Device;
use bytemuck::Pod;
use wgpu::BufferUsages as Usage;

/// The first bytes of a buffer that may be longer.
pub struct Piece {
    /// The buffer.
    pub buffer: wgpu::Buffer,
    /// How many of its bytes are meant.
    pub bytes: u64,
}

impl Piece {
    /// What a pass binds.
    pub fn binding(&self) -> wgpu::BufferBinding<'_> {
        wgpu::BufferBinding { buffer: &self.buffer, offset: 0, size: std::num::NonZero::new(self.bytes) }
    }
}

/// Buffers that nothing uses now, and those that were taken since the last [`Pool::taken`].
#[derive(Default)]
pub struct Pool {
    free: Vec<wgpu::Buffer>,
    taken: Vec<wgpu::Buffer>,
}

impl Pool {
    /// So many bytes, whatever they are.
    pub fn any(&mut self, device: &Device, bytes: u64) -> Piece {
        let bytes = bytes.max(16);
        let room = bytes.next_power_of_two();
        // A much larger one is left for who needs it.
        let fits = |b: &wgpu::Buffer| (bytes..=2 * room).contains(&b.size());
        let found = self.free.iter().enumerate().filter(|(_, b)| fits(b)).min_by_key(|(_, b)| b.size()).map(|f| f.0);
        let buffer = match found {
            Some(k) => self.free.swap_remove(k),
            None => device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pooled"),
                size: room.min(device.found.buffer).max(bytes),
                usage: Usage::STORAGE | Usage::UNIFORM | Usage::COPY_SRC | Usage::COPY_DST,
                mapped_at_creation: false,
            }),
        };
        self.taken.push(buffer.clone());
        Piece { buffer, bytes }
    }

    /// So many zeros, once the encoder's commands run.
    pub fn zeros(&mut self, device: &Device, encoder: &mut wgpu::CommandEncoder, bytes: u64) -> Piece {
        let piece = self.any(device, bytes);
        encoder.clear_buffer(&piece.buffer, 0, Some(piece.bytes));
        piece
    }

    /// A copy of `contents`, or where there is nothing, something to bind.
    pub fn filled<T: Pod>(&mut self, device: &Device, contents: &[T]) -> Piece {
        let piece = self.any(device, size_of_val(contents).max(size_of::<T>()) as u64);
        device.queue.write_buffer(&piece.buffer, 0, bytemuck::cast_slice(contents));
        piece
    }

    /// What was taken since the last call: to be given back by [`Pool::free`] when the device is done with it.
    pub fn taken(&mut self) -> Vec<wgpu::Buffer> {
        std::mem::take(&mut self.taken)
    }

    /// Takes buffers back.
    pub fn free(&mut self, buffers: Vec<wgpu::Buffer>) {
        self.free.extend(buffers);
    }
}
