//! Checks the memory that a map needs before it is allocated.

use super::GridSpec;
use crate::support::memory::{available, format_size};
use crate::{Error, Result};

impl GridSpec {
    /// Checks that a map on this grid, which needs `needed` bytes, fits the cap, bytes, and the machine's free memory.
    /// `remedy` tells the user what to do.
    ///
    /// # Errors
    /// [`Error::Resources`] if it does not fit.
    pub fn check_memory(&self, needed: u64, cap: Option<u64>, remedy: &str) -> Result<()> {
        let limit = match (cap, available()) {
            (Some(cap), _) if needed > cap => format!("`memory` allows {}", format_size(cap)),
            (_, Some(free)) if needed > free => format!("this machine has {} free", format_size(free)),
            _ => return Ok(()),
        };
        let (width, height, resolution) = (self.width, self.height, self.resolution);
        Err(Error::Resources(format!(
            "a map of {width} × {height} cells of {resolution} m needs {}, but {limit}: {remedy}",
            format_size(needed)
        )))
    }
}
