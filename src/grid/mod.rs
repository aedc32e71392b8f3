//! The grid ([`GridSpec`]), its chunks ([`ChunkId`]), and the finished map ([`Map`]) with its layers ([`Layer`]).

mod chunk;
mod layer;
mod memory;
mod spec;

pub use chunk::{ChunkId, EDGE, chunks, part};
pub use layer::{Class, Data, Layer, Map, Palette, Scale};
pub use spec::GridSpec;
