//! A lane on the browser's own GPU, towards the page: the project's WGSL, and the packed batches.

use super::lane::Lane;
use crate::binning::batch::Input;
use crate::geometry::layout::{CHUNK, Frame};
use crate::kernels::shader::part_bytes;
use crate::kernels::shader::{self, Kernel};
use crate::method::{self, Step};
use crate::pipeline::step::{Packed, steps};
use crate::view::protocol::{GpuBatch, GpuBuffer, GpuChunk, GpuPlan, GpuShader, GpuSpan, GpuStep};
use crate::view::{Request, Response};
use crate::{Error, Result};
use bytemuck::{bytes_of, cast_slice};
use std::collections::BTreeMap;

/// Largest number of items in a batch.
const MOST_ITEMS: usize = 4096;

/// The steps that the page dispatches; or why it can't.
pub fn plan(lane: &Lane) -> GpuPlan {
    let method = lane.stepper.method();
    let (steps, why) = match steps(method, lane.stepper.items()) {
        Ok(steps) => (steps.iter().map(gpu_step).collect(), None),
        Err(why) => (Vec::new(), Some(why.to_string())),
    };
    let (tile_words, chunk_tiles) = (method::tile_words(method), CHUNK * CHUNK);
    GpuPlan { supported: why.is_none(), why, tile_words, chunk_tiles, steps }
}

fn gpu_step(step: &Step) -> GpuStep {
    match step {
        Step::Pass(pass, mode) => GpuStep { kernel: Some(Kernel::from(*pass).name()), mode: Some(*mode), share: None },
        Step::Sum => GpuStep { kernel: Some(Kernel::Sum.name()), ..GpuStep::default() },
        Step::NormalizeByCount | Step::ReadBack | Step::AccumulateCounts => {
            GpuStep { share: Some(true), ..GpuStep::default() }
        }
    }
}

/// The WGSL of a kernel, as the native GPU backend has it for hardware adapters. Its overrides keep their defaults, which suit any
/// adapter, but for those that a batch decides.
pub fn wgsl(lane: &Lane, request: &Request) -> Result<Response> {
    let name = request.query_text("kernel")?;
    let all = [Kernel::Weigh, Kernel::Count, Kernel::Fuse, Kernel::Sum];
    let Some(kernel) = all.into_iter().find(|k| k.name() == name) else {
        return Err(Error::Usage(format!("there is no kernel {name}: there are weigh, count, fuse, sum")));
    };
    let source = shader::source(lane.stepper.method(), kernel, request.query_number("wide")? != 0, 1)?;
    Ok(Response::Bytes("text/plain; charset=utf-8", source.into_bytes()))
}

/// The range of items that is requested.
fn requested_items(lane: &Lane, request: &Request) -> Result<std::ops::Range<usize>> {
    let (from, to, total) = (request.query_number("from")?, request.query_number("to")?, lane.stepper.items().len());
    if from > to || to > total || to - from > MOST_ITEMS {
        return Err(Error::Usage(format!("items {from} to {to}: give at most {MOST_ITEMS} of {total}, in order")));
    }
    Ok(from..to)
}

/// Packs the items that are requested.
pub fn pack(lane: &Lane, request: &Request) -> Result<Packed> {
    lane.stepper.pack(requested_items(lane, request)?)
}

/// Buffers one after the other, each padded to a multiple of 16 bytes.
#[derive(Default)]
struct Buffers(Vec<u8>);

impl Buffers {
    fn add(&mut self, bytes: &[u8]) -> GpuSpan {
        let at = self.0.len();
        self.0.extend_from_slice(bytes);
        self.0.resize(self.0.len().next_multiple_of(16), 0);
        GpuSpan { at, bytes: bytes.len() }
    }
}

/// A packed batch: the length of its head, the head as JSON, and the buffers.
pub fn batch(lane: &Lane, request: &Request) -> Result<Response> {
    let range = requested_items(lane, request)?;
    let Packed { batch, frame, wide, broad } = pack(lane, request)?;
    let method = lane.stepper.method();
    let steps = steps(method, lane.stepper.items())?;
    let mut bytes = Buffers::default();
    let readings = batch.cones().len();
    let shares = vec![[0u32; 4]; readings];
    // In the order of the WGSL's bindings 1, 6 and 7, whose names the page keeps for every kind of input.
    let contents: [&[u8]; 3] = match &batch.input {
        Input::Cones(input) => [cast_slice(&input.cones), cast_slice(&shares), cast_slice(&input.first_part)],
        Input::Scans(input) => [cast_slice(&input.scans), cast_slice(&input.centres), cast_slice(&input.beams)],
        Input::Updates(input) => [cast_slice(&input.cones), cast_slice(&input.shapes), cast_slice(&input.points)],
    };
    let [cones, second, third] = contents;
    let buffers = [("cones", cones), ("shares", second), ("first_part", third)];
    let buffers = buffers.map(|(name, content)| GpuBuffer { name, span: bytes.add(content) }).to_vec();
    let frame = bytes.add(bytes_of(&Frame { mode: 0, ..frame }));
    let chunk = |list: &crate::binning::batch::ChunkList| GpuChunk {
        place: [list.place.column, list.place.row],
        tiles: bytes.add(cast_slice(&list.tiles)),
        entries: bytes.add(cast_slice(&list.entries)),
        count: list.tiles.len(),
        slots: list.tiles.iter().map(|t| t.slot).collect(),
    };
    let chunks = batch.chunks.iter().map(chunk).collect();
    let parts_bytes = match steps.contains(&Step::Sum) {
        true => batch.parts() * part_bytes(false),
        false => readings * 4,
    };
    let head = GpuBatch {
        from: range.start,
        to: range.end,
        frame,
        readings,
        parts_bytes: parts_bytes.max(16),
        shaders: shaders(request, method, steps, wide, broad),
        buffers,
        chunks,
    };
    let mut head = serde_json::to_vec(&head)
        .map_err(|e| Error::Resources(format!("the head of a batch can't be written as JSON: {e}")))?;
    head.resize((4 + head.len()).next_multiple_of(16) - 4, b' ');
    let mut all = (head.len() as u32).to_le_bytes().to_vec();
    all.append(&mut head);
    all.append(&mut bytes.0);
    Ok(Response::Bytes("application/octet-stream", all))
}

fn shaders(
    request: &Request,
    method: &dyn method::Method,
    steps: &[Step],
    wide: bool,
    broad: bool,
) -> BTreeMap<&'static str, GpuShader> {
    let lane = request.query.get("lane").map_or("0", String::as_str);
    let mut shaders = BTreeMap::new();
    for step in steps {
        let kernel = match step {
            Step::Pass(pass, _) => Kernel::from(*pass),
            Step::Sum => Kernel::Sum,
            Step::NormalizeByCount | Step::ReadBack | Step::AccumulateCounts => continue,
        };
        let mut constants = BTreeMap::new();
        if kernel != Kernel::Sum {
            constants.extend(method.variant().map(|(name, on)| (name.to_string(), u8::from(on))));
            constants.insert("BROAD_BEAMS".into(), u8::from(broad));
        }
        let path = format!("api/gpu/wgsl?lane={lane}&kernel={}&wide={}", kernel.name(), u8::from(wide));
        shaders.insert(kernel.name(), GpuShader { path, entry: kernel.name(), constants });
    }
    shaders
}
