//! A lane on the browser's own GPU, from the page: its counts turned into shares, and its cells compared with the CPU's.

use super::lane::Lane;
use super::webgpu_batch::pack;
use crate::geometry::layout::{CHUNK, TILE, TILE_CELLS};
use crate::grid::ChunkId;
use crate::kernels::{self, ChunkStates};
use crate::method;
use crate::pipeline::step::{Cell, Tiles, cell_of, tile_at, tile_of};
use crate::view::protocol::{GpuCheck, finite};
use crate::view::{Request, Response};
use crate::{Error, Result};

/// The 32-bit words of a request's body.
fn body_words(request: &Request) -> Result<Vec<u32>> {
    if !request.body.len().is_multiple_of(4) {
        return Err(Error::Usage(format!("{} bytes are no whole number of words", request.body.len())));
    }
    Ok(request.body.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect())
}

/// Each reading's share from its count of arc cells.
pub fn share(lane: &Lane, request: &Request) -> Result<Response> {
    let (packed, counts) = (pack(lane, request)?, body_words(request)?);
    let cones = packed.batch.cones();
    if counts.len() != cones.len() {
        return Err(Error::Usage(format!("{} counts were sent for {} readings", counts.len(), cones.len())));
    }
    let shares = kernels::normalize_by_count(lane.stepper.method(), counts.into_iter(), cones);
    Ok(Response::Bytes("application/octet-stream", bytemuck::cast_slice(&shares).to_vec()))
}

/// Takes the words of some tiles from the page, keeps them as what `backend=webgpu` shows, and compares them with the CPU's. Returns the
/// tiles too.
pub fn words(lane: &mut Lane, request: &Request) -> Result<(GpuCheck, Tiles)> {
    let to = request.query_number("to")?;
    if to != lane.stepper.position() {
        let at = lane.stepper.position();
        return Err(Error::Usage(format!("the page's cells are those of position {to}, the log stands at {at}")));
    }
    let size = method::tile_words(lane.stepper.method());
    let sent = body_words(request)?;
    let (count, rest) = sent.split_first().map_or((0, &sent[..]), |(n, rest)| (*n as usize, rest));
    if count.checked_mul(3 + size) != Some(rest.len()) {
        let what = format!("{} words were sent for {count} tiles of {size}, each with its three numbers", rest.len());
        return Err(Error::Usage(what));
    }
    let (tiles, words) = rest.split_at(3 * count);
    let own = lane.stepper.chunks();
    // A tile is sent as its chunk's column and row, and its slot.
    let chunk = |t: &[u32]| ChunkId { column: t[0], row: t[1] };
    // No memory is allocated for chunks that no reading reached.
    let within = |t: &&[u32]| own.contains_key(&chunk(t)) && (t[2] as usize) < CHUNK * CHUNK;
    if let Some(tile) = tiles.chunks_exact(3).find(|t| !within(t)) {
        return Err(Error::Usage(format!("no reading reached tile {tile:?}")));
    }
    let page = lane.webgpu.get_or_insert_with(ChunkStates::new);
    let mut reached = Tiles::new();
    for (tile, sent) in tiles.chunks_exact(3).zip(words.chunks_exact(size)) {
        let (chunk, slot) = (chunk(tile), tile[2]);
        let state = page.entry(chunk).or_insert_with(|| vec![0; size * CHUNK * CHUNK]);
        state[slot as usize * size..][..size].copy_from_slice(sent);
        reached.insert(tile_at(chunk, slot));
    }
    lane.unsent.retain(|tile| !reached.contains(tile));
    let mut compared = reached.clone();
    if !request.query.contains_key("more") {
        // A tile that the page left out differs, unless it is unchanged.
        compared.extend(std::mem::take(&mut lane.unsent));
    }
    Ok((compare(lane, &compared), reached))
}

/// Compares the page's tiles with the CPU's.
fn compare(lane: &Lane, tiles: &Tiles) -> GpuCheck {
    let (method, none) = (lane.stepper.method(), ChunkStates::new());
    let (own, page) = (lane.stepper.chunks(), lane.webgpu.as_ref().unwrap_or(&none));
    let planes = method::planes(method);
    let (mut cells, mut membership, mut values, mut largest) = (0u64, 0u64, 0u64, 0f64);
    for tile in tiles {
        cells += TILE_CELLS as u64;
        let [a, b] = [own, page].map(|chunks| tile_of(chunks, planes, *tile));
        if a == b {
            continue;
        }
        for at in 0..TILE_CELLS {
            let [row, column] = tile.map(|t| t as usize * TILE);
            let (column, row) = (column + at % TILE, row + at / TILE);
            let [a, b] = [own, page].map(|chunks| Cell::of(method, cell_of(chunks, planes, column, row).as_deref()));
            membership += u64::from((a.interior, a.arc) != (b.interior, b.arc));
            values += u64::from(a.values != b.values);
            largest = a.values.iter().zip(&b.values).map(|(a, b)| f64::from(a - b).abs()).fold(largest, f64::max);
        }
    }
    GpuCheck {
        tiles: tiles.len(),
        cells,
        membership_differences: membership,
        value_differences: values,
        largest: finite(largest),
    }
}
