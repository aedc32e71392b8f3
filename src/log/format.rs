//! The interface of a log format: it recognises a log by its content, describes its sensors, and reads its scans.

use super::input::Input;
use super::mounting::MountedSensor;
use super::problem::Problem;
use crate::Result;
use crate::log::reading::Record;
use crate::sensor::{Description, Kind};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// The start of a log, by which a format recognises it.
pub(crate) enum Probe<'a> {
    /// The path of a folder.
    Folder(&'a Path),
    /// The first bytes of a file, unpacked.
    Text(&'a str),
}

/// A log's folder or file.
#[derive(Clone)]
pub(crate) enum LogPath {
    /// A folder of files.
    Folder(std::path::PathBuf),
    /// One file or stream.
    File(Input),
}

/// A log format.
pub(crate) trait Format: Sync {
    /// Its name, in reports.
    fn name(&self) -> &'static str;
    /// A short description of its content, for the message about an unknown format.
    fn describe(&self) -> &'static str;
    /// Whether a log is of this format, by its start.
    fn sniff(&self, probe: &Probe<'_>) -> bool;
    /// Opens a log and checks all that can be checked before a run. `kind`: the kind of sensors to read.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if the log is damaged or holds no such sensors.
    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>>;
}

/// An open log of some format.
pub(crate) trait Source: Send + Sync {
    /// Its sensors, as far as the format or the log describes them.
    fn sensors(&self) -> &[Description];
    /// The line of the log that describes its sensors, if there is one.
    fn sensor_line(&self) -> Option<u64> {
        None
    }
    /// Whether the bearings of a laser's beams come from its sensor; otherwise each record has its own heading.
    fn has_beams(&self) -> bool;
    /// Whether it has the robot's poses; a log without them needs `--poses`.
    fn has_poses(&self) -> bool {
        true
    }
    /// Checks that the completed sensors give what the log does not.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) that says what is missing.
    fn check_sensors(&self, _sensors: &[MountedSensor]) -> Result<()> {
        Ok(())
    }
    /// Whether its sensors come from a preset of the program instead of the log.
    fn has_preset(&self) -> bool {
        false
    }
    /// The origin of a sensor's beam layout, and whether it is certain; an uncertain one is shown to the user.
    fn beams_origin(&self, _sensor: usize) -> Option<(String, bool)> {
        None
    }
    /// The ranges of a sensor that are read as no return, if there are any, as a sentence.
    fn no_return_note(&self, _sensor: usize) -> Option<String> {
        None
    }
    /// Names of the class labels 1, 2, …
    fn classes(&self) -> &[String] {
        &[]
    }
    /// Notes for the user on how the log is read, as sentences: assumed beam layouts, messages that are left out.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
    /// The files it reads, in a fixed order: the checksum runs over them.
    fn inputs(&self) -> Vec<&Input>;
    /// Starts a pass over the log. Lines of other kinds are counted in `ignored`.
    fn scans(&self, sensors: Arc<[MountedSensor]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>>;
}

/// Records and problems that were read and not yet taken.
pub(crate) type RecordQueue = VecDeque<std::result::Result<Record, Problem>>;

/// One pass over a log.
pub(crate) trait ScanReader: Send {
    /// Reads the next line or scan and appends its records; `false` at the end of the log.
    fn fill(&mut self, items: &mut RecordQueue) -> bool;
}
