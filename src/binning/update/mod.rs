//! Snaps the updates that the feature stage makes of readings from metres to integers, and bins them into tiles in log order.
//!
//! An update lies within 512 cells of its sensor, so that 32-bit integers decide which cells it reaches.

mod batch;
pub(crate) mod reach;
mod region;
mod snap;

pub use batch::{Binned, Bins};
pub use region::{Rows, SPOT, in_fan, on_lines};
pub use snap::{FARTHEST, Snapped, check, snapped};

use crate::feature::{Case, Routine, Update};
use crate::log::reading::Reading;

/// The update of a reading without a known feature: that of the Bayesian grid, without limits.
pub fn plain(number: u64, reading: Reading) -> Update {
    let routine = Routine { weight: 1.0, free: None, arc: None, occupies: true };
    Update { reading, number, case: Case::Routine, parts: Vec::new(), routine: Some(routine) }
}
