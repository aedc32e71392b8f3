//! The grid: which cells there are ([`GridSpec`]) and what a finished map holds ([`Map`], its [`Layer`]s).

mod layer;
mod spec;

pub use layer::{Class, Data, Layer, Map, Palette, Scale};
pub use spec::GridSpec;
