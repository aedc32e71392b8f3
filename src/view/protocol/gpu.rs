//! `api/gpu/…`: the page maps on the browser's own GPU, and the server compares.

use serde::Serialize;
use std::collections::BTreeMap;
#[cfg(test)]
use ts_rs::TS;

/// `api/gpu/plan`: the steps that the page dispatches for each batch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct GpuPlan {
    /// Whether the page can map by this method.
    pub supported: bool,
    /// Why it can't.
    pub why: Option<String>,
    /// 32-bit words of a tile of 16 × 16 cells.
    pub tile_words: usize,
    /// Tiles of a chunk.
    pub chunk_tiles: usize,
    /// The steps in order.
    pub steps: Vec<GpuStep>,
}

/// A step: a kernel with its mode, or the host's share computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct GpuStep {
    /// The kernel to dispatch.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub kernel: Option<&'static str>,
    /// The mode to write into the frame first.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub mode: Option<u32>,
    /// The server turns the counts of arc cells into shares.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, ts(optional))]
    pub share: Option<bool>,
}

/// Bytes of a batch, counted from its first buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct GpuSpan {
    /// The first byte.
    pub at: usize,
    /// How many.
    pub bytes: usize,
}

/// A named buffer of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct GpuBuffer {
    /// Its name.
    pub name: &'static str,
    /// Where its bytes are.
    #[serde(flatten)]
    pub span: GpuSpan,
}

/// A shader of a batch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct GpuShader {
    /// The request that gives its WGSL.
    pub path: String,
    /// Its entry point.
    pub entry: &'static str,
    /// Its pipeline constants.
    pub constants: BTreeMap<String, u8>,
}

/// A chunk that a batch changes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct GpuChunk {
    /// Its column and row.
    pub place: [u32; 2],
    /// Its tiles.
    pub tiles: GpuSpan,
    /// The tiles' lists of readings.
    pub entries: GpuSpan,
    /// How many tiles: a workgroup each.
    pub count: usize,
    /// The tiles' slots in the chunk.
    pub slots: Vec<u32>,
}

/// `api/gpu/batch`: the JSON head of a batch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct GpuBatch {
    /// The first item.
    pub from: usize,
    /// The item behind the last.
    pub to: usize,
    /// The uniform.
    pub frame: GpuSpan,
    /// Readings in the batch.
    pub readings: usize,
    /// Bytes of the buffer for partial sums.
    pub parts_bytes: usize,
    /// Shaders by kernel.
    pub shaders: BTreeMap<&'static str, GpuShader>,
    /// Buffers, in the order of their bindings.
    pub buffers: Vec<GpuBuffer>,
    /// Chunks.
    pub chunks: Vec<GpuChunk>,
}

/// `api/gpu/words`: the page's cells compared with the server's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(TS))]
pub struct GpuCheck {
    /// Tiles compared.
    pub tiles: usize,
    /// Cells compared.
    pub cells: u64,
    /// Cells that other readings reach.
    pub membership_differences: u64,
    /// Cells with other values.
    pub value_differences: u64,
    /// The largest difference of a value.
    pub largest: Option<f64>,
}
