//! The cells of the chunks that batches have reached, on the device.

use super::device::Device;
use crate::Result;
use crate::grid::ChunkId;
use crate::kernels::ChunkStates;
use std::collections::BTreeMap;

/// Memory of chunks moved to the host that is kept for other chunks, at most.
const MOST_RECYCLED: usize = 2;

/// Chunks on the device, by row and column.
#[derive(Default)]
pub struct Resident {
    chunks: BTreeMap<ChunkId, wgpu::Buffer>,
    recycled: Vec<wgpu::Buffer>,
}

impl Resident {
    /// Makes sure that a chunk is there; a new one is zeros once the encoder's commands run.
    pub fn make(&mut self, device: &Device, encoder: &mut wgpu::CommandEncoder, chunk: ChunkId, bytes: u64) {
        let recycled = &mut self.recycled;
        self.chunks.entry(chunk).or_insert_with(|| match recycled.iter().position(|b| b.size() == bytes) {
            Some(k) => {
                let buffer = recycled.swap_remove(k);
                encoder.clear_buffer(&buffer, 0, None);
                buffer
            }
            None => device.zeros("chunk", bytes),
        });
    }

    /// A chunk's buffer.
    pub fn get(&self, chunk: ChunkId) -> Option<&wgpu::Buffer> {
        self.chunks.get(&chunk)
    }

    /// Bytes of all chunks.
    pub fn bytes(&self) -> u64 {
        self.chunks.values().map(wgpu::Buffer::size).sum()
    }

    /// Moves a chunk's words to the host.
    pub fn take(&mut self, device: &Device, chunk: ChunkId) -> Result<Option<Vec<u32>>> {
        let Some(buffer) = self.chunks.remove(&chunk) else { return Ok(None) };
        let words = device.read(&buffer, buffer.size())?;
        if self.recycled.len() < MOST_RECYCLED {
            self.recycled.push(buffer);
        }
        Ok(Some(words))
    }

    /// Moves all chunks to the host.
    pub fn take_all(&mut self, device: &Device) -> Result<ChunkStates> {
        let mut states = ChunkStates::new();
        while let Some(chunk) = self.chunks.keys().next().copied() {
            states.extend(self.take(device, chunk)?.map(|words| (chunk, words)));
        }
        Ok(states)
    }
}
