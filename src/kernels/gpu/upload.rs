//! A batch's buffers on the device.

use super::device::Device;
use super::lists::{Listed, Lister};
use super::pool::{Piece, Pool};
use super::slots;
use super::timer::Timer;
use crate::binning::batch::{Batch, ChunkList};
use crate::geometry::layout::{CHUNK, Frame, Tile};
use crate::kernels::Shares;
use crate::method::{self, Method, Step, Unit};

/// A chunk's buffers for one batch, or, where an adapter doesn't bind all of its cells at once, those of some of its tiles.
pub struct ChunkBuffers {
    pub tiles: Piece,
    pub entries: Piece,
    pub groups: u32,
    pub place: [u32; 2],
    /// Which of the cells' bytes they are: from where, how many.
    pub cells: (u64, u64),
}

/// A batch's buffers. Of scans, where a method takes them: the scans themselves, for shares the centres of the cells, for first parts
/// the beams; of updates for shares their shapes, for first parts their points.
pub struct BatchBuffers {
    pub cones: Piece,
    pub parts: Piece,
    pub shares: Piece,
    pub first_part: Piece,
    pub chunks: Vec<ChunkBuffers>,
}

/// Where a batch goes.
pub struct Upload<'a> {
    pub device: &'a Device,
    pub pool: &'a mut Pool,
    pub encoder: &'a mut wgpu::CommandEncoder,
    pub timer: Option<&'a mut Timer>,
    pub lister: Option<&'a Lister>,
    /// Bytes of a part of a sum.
    pub part: usize,
}

impl Upload<'_> {
    /// Uploads a batch, and records what lists its tiles where that is left to the GPU.
    pub fn batch(
        mut self,
        (method, frame, steps): (&dyn Method, Frame, &[Step]),
        batch: &Batch,
        shares_so_far: &Shares,
    ) -> BatchBuffers {
        let device = self.device;
        let cones = match method.unit() {
            Unit::Scan => self.pool.filled(device, &batch.scans),
            Unit::Reading | Unit::Update => self.pool.filled(device, &batch.cones),
        };
        let parts = match steps.contains(&Step::Sum) {
            true => batch.first_part.last().copied().unwrap_or(0) as usize * self.part,
            false => batch.cones.len() * size_of::<u32>(),
        };
        let mut chunks = Vec::new();
        for list in &batch.chunks {
            if list.near.is_empty() {
                chunks.extend(self.chunk(method, list));
            } else {
                chunks.extend(self.listed(method, frame, steps, (&cones, list)));
            }
        }
        BatchBuffers {
            chunks,
            parts: self.pool.zeros(device, self.encoder, parts as u64),
            shares: match method.unit() {
                Unit::Reading => self.pool.filled(device, shares_so_far),
                Unit::Scan => self.pool.filled(device, &batch.centres),
                Unit::Update => self.pool.filled(device, &batch.shapes),
            },
            first_part: match method.unit() {
                Unit::Reading => self.pool.filled(device, &batch.first_part),
                Unit::Scan => self.pool.filled(device, &batch.beams),
                Unit::Update => self.pool.filled(device, &batch.points),
            },
            cones,
        }
    }

    /// A chunk with its lists, in as many parts as its cells are bound in.
    fn chunk(&mut self, method: &dyn Method, list: &ChunkList) -> Vec<ChunkBuffers> {
        let (tile, slots) = (tile_bytes(method), slots(self.device, method) as u32);
        let part = |first: u32| {
            let within = |t: &&Tile| (first..first + slots).contains(&t.slot);
            let tiles: Vec<Tile> =
                list.tiles.iter().filter(within).map(|t| Tile { slot: t.slot - first, ..*t }).collect();
            (!tiles.is_empty()).then(|| ChunkBuffers {
                tiles: self.pool.filled(self.device, &tiles),
                entries: self.pool.filled(self.device, &list.entries),
                groups: tiles.len() as u32,
                place: [list.place[1], list.place[0]],
                cells: (u64::from(first) * tile, u64::from(slots) * tile),
            })
        };
        (0..(CHUNK * CHUNK) as u32).step_by(slots as usize).filter_map(part).collect()
    }

    /// A chunk whose tiles the GPU lists, all of its slots.
    fn listed(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        steps: &[Step],
        (cones, list): (&Piece, &ChunkList),
    ) -> Option<ChunkBuffers> {
        let arcs = steps.iter().any(|s| matches!(s, Step::Share | Step::Tally));
        let how = Lister::how(&frame, list, method.footprint(), arcs);
        let stamps = self.timer.as_mut().and_then(|t| t.writes("list"));
        let Listed { tiles, entries } =
            self.lister?.record((self.device, self.pool), self.encoder, (cones, list, how), stamps);
        let groups = (CHUNK * CHUNK) as u32;
        let cells = (0, u64::from(groups) * tile_bytes(method));
        Some(ChunkBuffers { tiles, entries, groups, place: [list.place[1], list.place[0]], cells })
    }
}

fn tile_bytes(method: &dyn Method) -> u64 {
    (method::tile_words(method) * size_of::<u32>()) as u64
}
