//! What every room may use: errors, suggestions for unknown names, lines of 100 columns, the machine's memory, file access at an
//! offset.

pub mod error;
pub mod memory;
pub(crate) mod positional_io;
pub(crate) mod suggest;
pub(crate) mod wrap;
