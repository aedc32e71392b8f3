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

/// What a format is shown to tell whether a log is its own.
pub(crate) enum Probe<'a> {
    /// A folder.
    Folder(&'a Path),
    /// The first bytes of a file, unpacked.
    Text(&'a str),
}

/// Where a log lies.
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
    /// What it looks like, for the message about an unknown format.
    fn describe(&self) -> &'static str;
    /// Whether a log is of this format.
    fn sniff(&self, probe: &Probe<'_>) -> bool;
    /// Opens a log, checking all that can be checked before a run. `kind`: which sensors are wanted.
    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>>;
}

/// An open log of some format.
pub(crate) trait Source: Send + Sync {
    /// Its sensors, as far as the format or the log describes them.
    fn sensors(&self) -> &[Description];
    /// The line of the log that describes them, if one does.
    fn sensor_line(&self) -> Option<u64> {
        None
    }
    /// Whether the beams of a laser scan are laid out by its sensor (else each record carries its own heading).
    fn has_beams(&self) -> bool;
    /// Whether it has the robot's poses; a log without them needs `--poses`.
    fn has_poses(&self) -> bool {
        true
    }
    /// Refuses sensors that, complete as they are, don't say what the log leaves open.
    fn check_sensors(&self, _sensors: &[MountedSensor]) -> Result<()> {
        Ok(())
    }
    /// Whether a preset of the program, not the log, describes its sensors.
    fn has_preset(&self) -> bool {
        false
    }
    /// Where the layout of a sensor's beams comes from, and whether that is plain: nothing that a user should look at.
    fn beams_origin(&self, _sensor: usize) -> Option<(String, bool)> {
        None
    }
    /// What of a sensor's ranges is taken for no return, if any is, in a whole sentence.
    fn no_return_note(&self, _sensor: usize) -> Option<String> {
        None
    }
    /// Names of the class labels 1, 2, …
    fn classes(&self) -> &[String] {
        &[]
    }
    /// What a user should know of how the log is read, in whole sentences: what was taken for a missing return, which messages are
    /// left out, which layout of beams was assumed.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
    /// The files it reads, in a fixed order: the checksum runs over them.
    fn inputs(&self) -> Vec<&Input>;
    /// A pass over the log from its start. Lines of other kinds are counted in `ignored`.
    fn scans(&self, sensors: Arc<[MountedSensor]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>>;
}

/// What a pass gives.
pub(crate) type RecordQueue = VecDeque<std::result::Result<Record, Problem>>;

/// A pass over a log.
pub(crate) trait ScanReader: Send {
    /// Reads on by a line or a scan and appends what it held, if anything; `false` at the end.
    fn fill(&mut self, items: &mut RecordQueue) -> bool;
}
