//! Estimates of the memory that a run will take.

use crate::binning::batch::PAIRS;
use crate::geometry::layout::{BLOCKS, CHUNK, Cone, ConeTileBounds, Entry, SEGMENT, TILE};
use crate::grid::GridSpec;
use crate::method::{self, Method, Unit};

/// The memory that mapping takes, bytes, with all chunks resident, if readings reach every chunk of the grid: the cells, the layers,
/// one batch of `batch` readings.
pub fn resident(grid: &GridSpec, method: &dyn Method, batch: usize) -> u64 {
    let edge = TILE * CHUNK;
    let chunks = (grid.width.div_ceil(edge) * grid.height.div_ceil(edge)) as u64;
    let state = chunks * (method::tile_words(method) * CHUNK * CHUNK * 4) as u64;
    // Layers and the combined one in f32, two counts, touched, class; then a copy of a layer to write.
    let layers = grid.cells() as u64 * (4 * (method.layers().len() as u64 + 1) + 8 + 2 + 4);
    // An update, and the same snapped: some tens of points.
    let updates = if method.unit() == Unit::Update { batch as u64 * 2048 } else { 0 };
    state + layers + batched(batch) + updates
}

/// The memory that the out-of-core pipeline takes, bytes, without the readings that it may spill: three chunks of cells in the stages
/// and a spare one, with their layers and one that is written; batches on both sides of a kernel; the totals of readings; the poses of
/// scans; the pictures.
pub fn out_of_core(grid: &GridSpec, method: &dyn Method, batch: usize, readings: u64, scans: u64) -> u64 {
    let edge = TILE * CHUNK;
    let cells = (grid.width.min(edge) * grid.height.min(edge)) as u64;
    let words = (method::tile_words(method) * CHUNK * CHUNK * 4) as u64;
    let layers = cells * (4 * (method.layers().len() as u64 + 1) + 8 + 2 + 4);
    let batch = batch.min(usize::try_from(readings).unwrap_or(usize::MAX));
    let totals = if method.rounds().is_some_and(|r| r.len() > 1) { 4 * readings } else { 0 };
    // Of each scan its pose, its reach, the offset of its beams and its node in the tree; then scans that are being snapped.
    let poses = if method.unit() == Unit::Scan { 128 * scans + (1 << 25) } else { 0 };
    4 * words + 3 * layers + 3 * batched(batch) + totals + poses + (1 << 24)
}

/// The memory that the out-of-core pipeline takes on a card, bytes: the cells of a chunk, of two that were handed over, and of one on its
/// way back; the buffers of a batch, rounded up.
pub fn card(method: &dyn Method, batch: usize) -> u64 {
    let words = (method::tile_words(method) * CHUNK * CHUNK * 4) as u64;
    let cone =
        size_of::<Cone>() + size_of::<ConeTileBounds>() + size_of::<[u32; 4]>() + BLOCKS * BLOCKS * size_of::<u32>();
    let pair = size_of::<Entry>() + size_of::<f32>();
    4 * words + 2 * (batch.next_multiple_of(SEGMENT) * cone + PAIRS * pair) as u64
}

/// The readings at a time of the out-of-core pipeline: at most `batch`, and so few that batches take at most a third of `limit`, bytes.
pub fn out_of_core_batch(batch: usize, limit: u64) -> usize {
    let fits = |n: &usize| 3 * batched(*n) <= limit / 3;
    (10..).map(|k| 1usize << k).take_while(|n| *n <= batch && fits(n)).last().unwrap_or(batch.min(1 << 10))
}

/// The memory of a batch of `batch` readings, bytes.
fn batched(batch: usize) -> u64 {
    // A cone, and its pairs with tiles, twice while they are merged; with certainty a sum's parts. A box of 64 tiles a
    // reading is ample for 5 m on 5 cm, and no batch comes to more than PAIRS.
    let pairs = (batch as u64 * 64).min(PAIRS as u64);
    batch as u64 * 80 + pairs * (2 * 24 + 8 + 64)
}
