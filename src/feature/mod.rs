//! The feature-based occupancy grid's stage on the CPU (IJCAI 2007): it finds walls and corners in a log of sonar readings,
//! associates each reading with them, and says what each updates, where, and when.

pub mod associate;
pub mod atlas;
pub mod corner;
pub mod decide;
pub mod draw;
pub mod features;
pub mod limit;
pub mod line;
mod merged;
pub mod near;
pub mod phantom;
pub mod ping;
pub mod rcd;
pub mod ring;
pub mod rules;
pub mod run;
pub mod stage;
mod update;
pub mod vote;
pub mod wall;

pub use decide::Case;
pub use features::{Corner, Features, Known, Spot, Wall};
pub use ping::Ping;
pub use rcd::{Rcd, Source};
pub use rules::Rules;
pub use run::{Found, Summary, Times, WINDOW, memory, run};
pub use stage::{Stage, Tally};
pub use update::{Fan, Origin, Part, Routine, Update};
