//! A lane on the page's own GPU: the project's WGSL, the packed batches, and what came of them held against the CPU's cells.

use super::lane::Lane;
use crate::geometry::layout::{CHUNK, Frame, TILE, TILE_CELLS};
use crate::kernels::gpu::part_bytes;
use crate::kernels::gpu::shader::{self, Kernel};
use crate::kernels::{self, Chunks};
use crate::method::{self, Pass, Step, Unit};
use crate::pipeline::step::{Cell, Packed, Tiles, cell_of, steps, tile_at, tile_of};
use crate::view::{Answer, Ask};
use crate::{Error, Result};
use bytemuck::bytes_of;
use serde_json::{Map, Value, json};

/// Items in a batch at most.
const MOST: usize = 4096;

fn kernel(pass: Pass) -> Kernel {
    pass.into()
}

/// The steps that the page dispatches; or why it can't.
pub fn plan(lane: &Lane) -> Value {
    let method = lane.stepper.method();
    let mut told = json!({
        "supported": false, "why": null, "tile_words": method::tile_words(method), "chunk_tiles": CHUNK * CHUNK, "steps": [],
    });
    match steps(method, lane.stepper.items()) {
        Err(why) => told["why"] = json!(why.to_string()),
        Ok(steps) => {
            let step = |step: &Step| match step {
                Step::Pass(pass, mode) => json!({"kernel": kernel(*pass).name(), "mode": mode}),
                Step::Sum => json!({"kernel": Kernel::Sum.name()}),
                Step::Share | Step::Hand | Step::Tally => json!({"share": true}),
            };
            told["supported"] = json!(true);
            told["steps"] = json!(steps.iter().map(step).collect::<Vec<_>>());
        }
    }
    told
}

/// The source of a kernel, as the project's own GPU backend has it for hardware; its overrides keep their defaults, which suit any adapter,
/// but for those that the batch decides.
pub fn wgsl(lane: &Lane, ask: &Ask) -> Result<Answer> {
    let name = ask.text("kernel")?;
    let all = [Kernel::Weigh, Kernel::Count, Kernel::Fuse, Kernel::Sum];
    let Some(kernel) = all.into_iter().find(|k| k.name() == name) else {
        return Err(Error::Usage(format!("there is no kernel {name}: there are weigh, count, fuse, sum")));
    };
    let source = shader::source(lane.stepper.method(), kernel, ask.number("wide")? != 0, 1);
    Ok(Answer::Bytes("text/plain; charset=utf-8", source.into_bytes()))
}

/// The items that are asked for.
fn asked(lane: &Lane, ask: &Ask) -> Result<std::ops::Range<usize>> {
    let (from, to, total) = (ask.number("from")?, ask.number("to")?, lane.stepper.items().len());
    if from > to || to > total || to - from > MOST {
        return Err(Error::Usage(format!("items {from} to {to}: give at most {MOST} of {total}, in order")));
    }
    Ok(from..to)
}

fn pack(lane: &Lane, ask: &Ask) -> Result<Packed> {
    lane.stepper.pack(asked(lane, ask)?)
}

/// Buffers one after the other, each from a multiple of 16 bytes on.
#[derive(Default)]
struct Buffers(Vec<u8>);

impl Buffers {
    fn add(&mut self, bytes: &[u8]) -> Value {
        let at = self.0.len();
        self.0.extend_from_slice(bytes);
        self.0.resize(self.0.len().next_multiple_of(16), 0);
        json!({"at": at, "bytes": bytes.len()})
    }
}

/// A batch, packed.
pub fn batch(lane: &Lane, ask: &Ask) -> Result<Answer> {
    let range = asked(lane, ask)?;
    let Packed { batch, frame, wide, broad } = pack(lane, ask)?;
    let method = lane.stepper.method();
    let steps = steps(method, lane.stepper.items())?;
    let mut bytes = Buffers::default();
    let updates = method.unit() == Unit::Update;
    let shares = vec![[0u32; 4]; batch.cones.len()];
    let named = |name: &str, mut told: Value| {
        told["name"] = json!(name);
        told
    };
    let mut buffers = vec![named("cones", bytes.add(bytemuck::cast_slice(&batch.cones)))];
    buffers.push(named(
        "shares",
        bytes.add(if updates { bytemuck::cast_slice(&batch.shapes) } else { bytemuck::cast_slice(&shares) }),
    ));
    let places: &[u8] =
        if updates { bytemuck::cast_slice(&batch.points) } else { bytemuck::cast_slice(&batch.first_part) };
    buffers.push(named("first_part", bytes.add(places)));
    let frame = bytes.add(bytes_of(&Frame { mode: 0, ..frame }));
    let chunks: Vec<Value> = batch
        .chunks
        .iter()
        .map(|list| {
            let slots: Vec<u32> = list.tiles.iter().map(|t| t.slot).collect();
            json!({
                "place": list.place,
                "tiles": bytes.add(bytemuck::cast_slice(&list.tiles)),
                "entries": bytes.add(bytemuck::cast_slice(&list.entries)),
                "count": list.tiles.len(),
                "slots": slots,
            })
        })
        .collect();
    let sums = steps.contains(&Step::Sum);
    let parts = batch.first_part.last().copied().unwrap_or(0) as usize;
    let parts = if sums { parts * part_bytes(false) } else { batch.cones.len() * 4 };
    let mut head = json!({
        "from": range.start,
        "to": range.end,
        "frame": frame,
        "readings": batch.cones.len(),
        "parts_bytes": parts.max(16),
        "shaders": shaders(ask, method, steps, wide, broad),
        "buffers": buffers,
        "chunks": chunks,
    })
    .to_string()
    .into_bytes();
    head.resize((4 + head.len()).next_multiple_of(16) - 4, b' ');
    let mut all = (head.len() as u32).to_le_bytes().to_vec();
    all.append(&mut head);
    all.append(&mut bytes.0);
    Ok(Answer::Bytes("application/octet-stream", all))
}

fn shaders(ask: &Ask, method: &dyn method::Method, steps: &[Step], wide: bool, broad: bool) -> Value {
    let lane = ask.query.get("lane").map_or("0", String::as_str);
    let mut shaders = Map::new();
    for step in steps {
        let kernel = match step {
            Step::Pass(pass, _) => kernel(*pass),
            Step::Sum => Kernel::Sum,
            Step::Share | Step::Hand | Step::Tally => continue,
        };
        let mut constants = Map::new();
        if kernel != Kernel::Sum {
            constants.extend(method.variant().map(|(name, on)| (name.to_string(), json!(u8::from(on)))));
            constants.insert("BROAD_BEAMS".into(), json!(u8::from(broad)));
        }
        let path = format!("api/gpu/wgsl?lane={lane}&kernel={}&wide={}", kernel.name(), u8::from(wide));
        shaders.insert(kernel.name().into(), json!({"path": path, "entry": kernel.name(), "constants": constants}));
    }
    Value::Object(shaders)
}

/// Words that a page sent.
fn received(ask: &Ask) -> Result<Vec<u32>> {
    if !ask.body.len().is_multiple_of(4) {
        return Err(Error::Usage(format!("{} bytes are no whole number of words", ask.body.len())));
    }
    Ok(ask.body.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect())
}

/// Each reading's share from its count of arc cells.
pub fn share(lane: &Lane, ask: &Ask) -> Result<Answer> {
    let (packed, counts) = (pack(lane, ask)?, received(ask)?);
    let cones = &packed.batch.cones;
    if counts.len() != cones.len() {
        return Err(Error::Usage(format!("{} counts were sent for {} readings", counts.len(), cones.len())));
    }
    let shares = kernels::shares(lane.stepper.method(), counts.into_iter(), cones);
    Ok(Answer::Bytes("application/octet-stream", bytemuck::cast_slice(&shares).to_vec()))
}

/// Takes the words of some tiles, keeps them as what the page shows, and holds them against the CPU's; also the tiles.
pub fn words(lane: &mut Lane, ask: &Ask) -> Result<(Value, Tiles)> {
    let to = ask.number("to")?;
    if to != lane.stepper.position() {
        let at = lane.stepper.position();
        return Err(Error::Usage(format!("the page's cells are those of position {to}, the log stands at {at}")));
    }
    let size = method::tile_words(lane.stepper.method());
    let sent = received(ask)?;
    let (count, rest) = sent.split_first().map_or((0, &sent[..]), |(n, rest)| (*n as usize, rest));
    if count.checked_mul(3 + size) != Some(rest.len()) {
        let what = format!("{} words were sent for {count} tiles of {size}, each with its three numbers", rest.len());
        return Err(Error::Usage(what));
    }
    let (tiles, words) = rest.split_at(3 * count);
    let own = lane.stepper.chunks();
    // No memory is taken for chunks that no reading reached.
    let within = |t: &&[u32]| own.contains_key(&[t[1], t[0]]) && (t[2] as usize) < CHUNK * CHUNK;
    if let Some(tile) = tiles.chunks_exact(3).find(|t| !within(t)) {
        return Err(Error::Usage(format!("no reading reached tile {tile:?}")));
    }
    let page = lane.page.get_or_insert_with(Chunks::new);
    let mut reached = Tiles::new();
    for (tile, sent) in tiles.chunks_exact(3).zip(words.chunks_exact(size)) {
        let (chunk, slot) = ([tile[1], tile[0]], tile[2]);
        let state = page.entry(chunk).or_insert_with(|| vec![0; size * CHUNK * CHUNK]);
        state[slot as usize * size..][..size].copy_from_slice(sent);
        reached.insert(tile_at(chunk, slot));
    }
    lane.unsent.retain(|tile| !reached.contains(tile));
    let mut compared = reached.clone();
    if !ask.query.contains_key("more") {
        // What the page left out is wrong there, unless it is as it was.
        compared.extend(std::mem::take(&mut lane.unsent));
    }
    Ok((compare(lane, &compared), reached))
}

/// The page's tiles against the CPU's.
fn compare(lane: &Lane, tiles: &Tiles) -> Value {
    let (method, none) = (lane.stepper.method(), Chunks::new());
    let (own, page) = (lane.stepper.chunks(), lane.page.as_ref().unwrap_or(&none));
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
    json!({
        "tiles": tiles.len(),
        "cells": cells,
        "membership_differences": membership,
        "value_differences": values,
        "largest": super::number(largest),
    })
}
