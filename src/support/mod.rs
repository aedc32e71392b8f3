//! What every room may use: errors, "did you mean", lines of 100 columns, the machine's memory, files read and written at a
//! position.

pub mod error;
pub mod memory;
pub(crate) mod positioned;
pub(crate) mod similar;
pub(crate) mod wrapped;
