//! Logs of range readings: files, folders or a stream, recognised by their content and read in constant memory, as often as needed.
//!
//! Each format is one file or folder; `formats` is their registry, and `docs/formats.md` describes them for users. A log yields
//! [`Record`](crate::log::reading::Record)s as they were read; [`classify`](crate::log::reading::classify) applies the sensor's limits.

mod aria;
mod bad_lines;
mod carmen;
mod cells;
pub mod classes;
mod cmu;
mod csv;
mod fields;
mod format;
mod formats;
mod gzip;
mod input;
mod json_error;
mod json_line;
mod jsonl;
mod lines;
mod log_file;
mod matlab;
mod mounting;
mod no_return;
mod notes;
mod opening;
mod options;
mod player;
mod poses;
mod preamble;
mod problem;
pub mod reading;
mod records;
mod rostopic;
mod scan;
mod sensor_ids;
mod sensors;
mod sick;
mod snapshot;
mod snapshot_reader;
mod sonar_ring_8;
mod table;
mod text;
mod track;
mod unknown;
mod values;
mod writer;

pub use bad_lines::BadLines;
pub use log_file::{Header, Log};
pub use options::Options;
pub use problem::{BadLine, Problem};
pub use records::Records;
pub use writer::Writer;
