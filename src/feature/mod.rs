//! The stage of the feature-based occupancy grid on the CPU (IJCAI 2007): it finds walls and corners in a log of sonar readings,
//! associates each reading with them, and computes each reading's update.

pub mod associate;
pub mod corner;
pub mod decide;
pub mod draw;
pub mod features;
pub mod limit;
pub mod line;
mod merged;
pub mod observations;
pub mod phantom;
pub mod ping;
pub mod rcd;
pub mod ring;
pub mod rules;
pub mod run;
pub mod spatial;
pub mod stage;
mod update;
pub mod vote;
pub mod wall;

pub use decide::Case;
pub use features::{Corner, FeatureMap, Features, PointFeature, Wall};
pub use ping::Ping;
pub use rcd::{Rcd, Source};
pub use rules::Rules;
pub use run::{StageResult, Summary, Times, WINDOW, memory, run};
pub use stage::{Stage, StageCounts};
pub use update::{Fan, Origin, Part, Routine, Update};
