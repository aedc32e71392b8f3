//! `echogrid bench`.

use crate::Result;

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub struct Bench {}

impl Bench {
    /// Runs it.
    pub fn run(self) -> Result<u8> {
        Ok(0)
    }
}
