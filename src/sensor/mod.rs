//! Sensors: where a transducer sits on the robot, what it sees, and which of its ranges are valid.
//!
//! A sensor is described by a preset, by the log's header, by a TOML file (`--sensor-file`) and by `--set key=value`; a later source
//! overrides an earlier one. Lengths are metres, angles radians, counter-clockwise from the robot's forward axis.

mod description;
mod file;
mod limits;
mod model;
mod overrides;
mod parameter;
mod quantity;
mod value;

pub use description::Description;
pub use file::{SensorFile, preset};
pub use model::{AtMax, Kind, Sensor};
pub use overrides::{Mounts, OVERRIDE_KEYS, Overrides};
pub use parameter::ParameterDoc;
pub use quantity::{angle, length};

pub(crate) use value::{SensorKey, SensorValue};
