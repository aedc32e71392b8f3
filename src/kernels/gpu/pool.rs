//! Buffers that are used again: a card's memory is slow to allocate, and a batch is soon over.
//!
//! Submissions run in order, and what the host writes comes before the next of them. So a buffer may be taken again as soon as all that
//! uses it is submitted, done or not; and one that the host never writes as soon as that is recorded.

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

/// Buffers to be used again.
#[derive(Default)]
pub struct Pool {
    /// Those that nothing uses any more.
    free: Vec<wgpu::Buffer>,
    /// Those that only what is recorded since the last [`Pool::recycle`] uses: the host may not write them.
    scratch: Vec<wgpu::Buffer>,
    /// Those taken since then.
    taken: Vec<wgpu::Buffer>,
}

impl Pool {
    /// So many bytes, whatever they are, for kernels to write.
    pub fn any(&mut self, device: &Device, bytes: u64) -> Piece {
        let found = find(&mut self.scratch, bytes);
        self.piece(device, found, bytes)
    }

    /// So many zeros, once the encoder's commands run.
    pub fn zeros(&mut self, device: &Device, encoder: &mut wgpu::CommandEncoder, bytes: u64) -> Piece {
        let piece = self.any(device, bytes);
        encoder.clear_buffer(&piece.buffer, 0, Some(piece.bytes));
        piece
    }

    /// A copy of `contents`, or where there is nothing, something to bind.
    pub fn filled<T: Pod>(&mut self, device: &Device, contents: &[T]) -> Piece {
        let piece = self.piece(device, None, size_of_val(contents).max(size_of::<T>()) as u64);
        device.queue.write_buffer(&piece.buffer, 0, bytemuck::cast_slice(contents));
        piece
    }

    fn piece(&mut self, device: &Device, found: Option<wgpu::Buffer>, bytes: u64) -> Piece {
        let bytes = bytes.max(16);
        let buffer = found.or_else(|| find(&mut self.free, bytes)).unwrap_or_else(|| {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pooled"),
                size: bytes.next_power_of_two().min(device.found.buffer).max(bytes),
                usage: Usage::STORAGE | Usage::UNIFORM | Usage::COPY_SRC | Usage::COPY_DST,
                mapped_at_creation: false,
            })
        });
        self.taken.push(buffer.clone());
        Piece { buffer, bytes }
    }

    /// Takes a piece of [`Pool::any`] back that nothing uses but what is recorded.
    pub fn done(&mut self, piece: Piece) {
        self.taken.retain(|b| *b != piece.buffer);
        self.scratch.push(piece.buffer);
    }

    /// Takes everything back: all that uses it is submitted.
    pub fn recycle(&mut self) {
        self.free.append(&mut self.taken);
        self.free.append(&mut self.scratch);
    }
}

/// Takes the smallest buffer that is large enough out; a much larger one is left for who needs it.
fn find(buffers: &mut Vec<wgpu::Buffer>, bytes: u64) -> Option<wgpu::Buffer> {
    let fits = |b: &wgpu::Buffer| (bytes..=2 * bytes.next_power_of_two()).contains(&b.size());
    let found = buffers.iter().enumerate().filter(|(_, b)| fits(b)).min_by_key(|(_, b)| b.size())?.0;
    Some(buffers.swap_remove(found))
}
