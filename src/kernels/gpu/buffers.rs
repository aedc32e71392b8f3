//! The buffers of a batch: those of its input, of each kind its own, and those of each chunk that it reaches. Their fields have the
//! names of the WGSL's bindings.

use super::recording::{BufferId, Contents, Recording};
use super::tile_binner::{self, BinnedTiles};
use super::work::{Capacity, Work};
use crate::binning::batch::{ChunkList, ConeInput, Input, ScanInput, UpdateInput};
use crate::geometry::layout::{CHUNK, Tile};
use crate::kernels::KernelError;
use crate::method::{Pass, Step};

/// The buffers of a batch's input.
pub enum InputBuffers {
    /// Of readings.
    Cones(ConeBuffers),
    /// Of scans.
    Scans(ScanBuffers),
    /// Of updates.
    Updates(UpdateBuffers),
}

/// The buffers of readings.
pub struct ConeBuffers {
    cones: BufferId,
    shares: BufferId,
    /// Where a step needs them: the parts of the readings' sums, or the readings' counts.
    parts: Option<BufferId>,
    /// Where a step sums.
    first_part: Option<BufferId>,
}

/// The buffers of scans.
pub struct ScanBuffers {
    scans: BufferId,
    centres: BufferId,
    beams: BufferId,
}

/// The buffers of updates.
pub struct UpdateBuffers {
    cones: BufferId,
    shapes: BufferId,
    points: BufferId,
}

impl InputBuffers {
    /// Of a batch.
    pub fn new<'a>(recording: &mut Recording<'a>, work: &Work<'a>, capacity: Capacity) -> InputBuffers {
        match &work.batch.input {
            Input::Cones(input) => InputBuffers::Cones(ConeBuffers::new(recording, work, input, capacity)),
            Input::Scans(ScanInput { scans, beams, centres }) => InputBuffers::Scans(ScanBuffers {
                scans: recording.upload(scans),
                centres: recording.upload(centres),
                beams: recording.upload(beams),
            }),
            Input::Updates(UpdateInput { cones, shapes, points }) => InputBuffers::Updates(UpdateBuffers {
                cones: recording.upload(cones),
                shapes: recording.upload(shapes),
                points: recording.upload(points),
            }),
        }
    }

    /// The buffer of that name, if this kind of input has it.
    pub fn get(&self, name: &str) -> Option<BufferId> {
        match (self, name) {
            (InputBuffers::Cones(b), "cones") => Some(b.cones),
            (InputBuffers::Cones(b), "shares") => Some(b.shares),
            (InputBuffers::Cones(b), "parts") => b.parts,
            (InputBuffers::Cones(b), "first_part") => b.first_part,
            (InputBuffers::Scans(b), "scans") => Some(b.scans),
            (InputBuffers::Scans(b), "centres") => Some(b.centres),
            (InputBuffers::Scans(b), "beams") => Some(b.beams),
            (InputBuffers::Updates(b), "cones") => Some(b.cones),
            (InputBuffers::Updates(b), "shapes") => Some(b.shapes),
            (InputBuffers::Updates(b), "points") => Some(b.points),
            _ => None,
        }
    }
}

impl ConeBuffers {
    fn new<'a>(recording: &mut Recording<'a>, work: &Work<'a>, input: &'a ConeInput, capacity: Capacity) -> Self {
        let sums = work.steps.contains(&Step::Sum);
        let counts = work.steps.iter().any(|step| matches!(step, Step::Pass(Pass::Count, _)));
        let parts = match (sums, counts) {
            (true, _) => Some(work.batch.parts() * capacity.part_bytes),
            (false, true) => Some(input.cones.len() * size_of::<u32>()),
            (false, false) => None,
        };
        ConeBuffers {
            cones: recording.upload(&input.cones),
            shares: recording.upload(work.shares),
            parts: parts.map(|bytes| recording.buffer(bytes as u64, Contents::Zeros)),
            first_part: sums.then(|| recording.upload(&input.first_part)),
        }
    }
}

/// The buffers of a chunk in one batch, or, where the adapter does not bind all of the chunk's cells at once, of some of its tiles.
pub struct ChunkBuffers {
    tiles: BufferId,
    entries: BufferId,
    state: BufferId,
    /// A workgroup for each listed tile.
    pub workgroups: u32,
}

impl ChunkBuffers {
    /// The buffer of that name, if a chunk has it.
    pub fn get(&self, name: &str) -> Option<BufferId> {
        match name {
            "tiles" => Some(self.tiles),
            "entries" => Some(self.entries),
            "state" => Some(self.state),
            _ => None,
        }
    }
}

/// The buffers of every chunk of a batch; where the host has not listed a chunk's tiles, the GPU does.
///
/// # Errors
/// [`KernelError::MissingBuffer`] where the input has no cones to list.
pub fn make_chunks<'a>(
    recording: &mut Recording<'a>,
    work: &Work<'a>,
    input: &InputBuffers,
    capacity: Capacity,
) -> Result<Vec<ChunkBuffers>, KernelError> {
    let mut chunks = Vec::new();
    for list in &work.batch.chunks {
        if list.cone_bounds.is_empty() {
            listed_by_host(recording, work, list, capacity, &mut chunks);
        } else {
            let missing = KernelError::MissingBuffer { pass: tile_binner::LABEL, binding: "cones" };
            let cones = input.get("cones").ok_or(missing)?;
            chunks.push(listed_by_gpu(recording, work, cones, list)?);
        }
    }
    Ok(chunks)
}

/// A chunk with the host's lists, in as many pieces as its cells are bound in.
fn listed_by_host<'a>(
    recording: &mut Recording<'a>,
    work: &Work<'a>,
    list: &'a ChunkList,
    capacity: Capacity,
    chunks: &mut Vec<ChunkBuffers>,
) {
    let (all, slots) = ((CHUNK * CHUNK) as u32, capacity.tiles_per_binding as u32);
    let entries = recording.upload(&list.entries);
    for first in (0..all).step_by(slots as usize) {
        let piece: Vec<Tile>;
        let (tiles, workgroups) = if slots == all {
            (recording.upload(&list.tiles), list.tiles.len())
        } else {
            let within = |t: &&Tile| (first..first + slots).contains(&t.slot);
            piece = list.tiles.iter().filter(within).map(|t| Tile { slot: t.slot - first, ..*t }).collect();
            (recording.upload_owned(&piece), piece.len())
        };
        if workgroups > 0 {
            let state = cells(recording, work, list, first, slots);
            chunks.push(ChunkBuffers { tiles, entries, state, workgroups: workgroups as u32 });
        }
    }
}

/// A chunk whose tiles the GPU lists: every tile has a list, empty or not.
fn listed_by_gpu<'a>(
    recording: &mut Recording<'a>,
    work: &Work<'a>,
    cones: BufferId,
    list: &'a ChunkList,
) -> Result<ChunkBuffers, KernelError> {
    let no_echo_arcs = work.steps.iter().any(|s| matches!(s, Step::NormalizeByCount | Step::AccumulateCounts));
    let params = tile_binner::params(work.frame.size, list, work.method.footprint(), no_echo_arcs);
    let BinnedTiles { tiles, entries } = tile_binner::record(recording, cones, list, params)?;
    let all = (CHUNK * CHUNK) as u32;
    let state = cells(recording, work, list, 0, all);
    Ok(ChunkBuffers { tiles, entries, state, workgroups: all })
}

/// The cells of some of a chunk's tiles, from a slot on.
fn cells(recording: &mut Recording, work: &Work, list: &ChunkList, first: u32, slots: u32) -> BufferId {
    let offset = u64::from(first) * work.tile_bytes();
    let contents = Contents::Resident { chunk: list.place, offset };
    recording.buffer(u64::from(slots) * work.tile_bytes(), contents)
}
