//! The feature-based occupancy grid's stage on the CPU (IJCAI 2007): it finds walls and corners in a log of sonar readings,
//! associates each reading with them, and says what each updates, where, and when.

mod update;

pub use update::{Fan, Part, Routine, Update};
