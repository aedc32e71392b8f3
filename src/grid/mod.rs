//! The grid: which cells there are ([`GridSpec`]) and what a finished map holds ([`Map`], its [`Layer`]s).

mod chunk;
mod layer;
mod memory;
mod spec;

pub use chunk::{ChunkId, EDGE, chunks, part};
pub use layer::{Class, Data, Layer, Map, Palette, Scale};
pub use spec::GridSpec;
