//! Simulated worlds, where the truth is known: walls, boxes and circles with a trajectory through them, the readings of
//! sonars and lasers in them, and the true map. `docs/worlds.md` describes the files.

pub mod random;
pub mod shape;
pub mod rig;
pub mod truth;

mod builder;
mod campus;
mod cone;
mod corner;
mod file;
mod image;
mod index;
mod model;
mod path;
mod rig_table;
mod scene;
mod shipped;
mod simulate;
mod sonar;
mod text;

pub use model::World;
pub use path::TimedPose;
pub use rig::{RIGS, Rig};
pub(crate) use shipped::meant;
pub use shipped::{SHIPPED, Shipped};
pub use simulate::{Simulated, Simulation, scan, simulate};
pub use sonar::Physics;
pub use truth::true_map;
