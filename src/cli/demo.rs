//! `echogrid demo`.

use crate::Result;

/// Arguments of `demo`.
#[derive(Debug, clap::Args)]
pub struct Demo {}

impl Demo {
    /// Runs it.
    pub fn run(self) -> Result<u8> {
        Ok(0)
    }
}
