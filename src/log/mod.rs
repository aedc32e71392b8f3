//! Logs: files, folders or a stream of readings, told by their content and streamed in constant memory as often as needed.
//!
//! One file a format (see `format.rs` for the registry); `docs/formats.md` describes them for users. A log hands out
//! [`Record`](crate::reading::Record)s as they were read; [`judge`](crate::reading::judge) decides what they are worth.

mod carmen;
mod codes;
mod csv;
mod fields;
mod format;
mod input;
mod jsonl;
mod lines;
mod matlab;
mod records;
mod sensors;
mod sonar_ring_8;
mod writer;

pub use records::Records;
pub use writer::Writer;

use crate::sensor::{Kind, Overrides, Sensor};
use crate::{Error, Result};
use format::{FORMATS, Mounted, Place, Probe, Source};
use input::{Input, STDIN};
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// How to read a log.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Only sensors of this kind; `None`: what the log holds (sonar, where a folder holds both).
    pub kind: Option<Kind>,
    /// A sensor file, laid over what the log says of its sensors.
    pub sensor_file: Option<PathBuf>,
    /// Changes to every sensor, laid over all else.
    pub overrides: Overrides,
    /// A classes file: names and colours of the labels, in place of the log's.
    pub classes: Option<PathBuf>,
    /// Folder for the copy of a stream; `None`: the system's temporary folder.
    pub spool: Option<PathBuf>,
}

/// What a log holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// The format's name.
    pub format: &'static str,
    /// The sensors, complete; a record's `sensor` is an index into them.
    pub sensors: Vec<Sensor>,
    /// Names of the class labels 1, 2, …; empty if there are none.
    pub classes: Vec<String>,
}

/// A line that is no reading, though it should be one.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}")]
pub struct BadLine {
    /// The line, from 1.
    pub line: u64,
    /// What is wrong with it.
    pub what: String,
}

/// What can be wrong in the middle of a log.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// One line is bad: to be counted; the run goes on.
    #[error("{0}")]
    Line(BadLine),
    /// The log can't be read on.
    #[error("{0}")]
    Fatal(Error),
}

/// An open log.
pub struct Log {
    path: PathBuf,
    source: Box<dyn Source>,
    header: Header,
    sensors: Arc<[Mounted]>,
}

impl Log {
    /// Opens a file, a folder or, for `-`, standard input, and checks what can be checked before a run.
    ///
    /// # Errors
    /// [`Error::Input`] if it is missing, empty, of no known format or damaged at its start, or if the sensor file is bad
    /// or doesn't fit; [`Error::Usage`] if the overrides don't fit its sensors; [`Error::Resources`] if a stream can't be
    /// spooled.
    pub fn open(path: &Path, options: &Options) -> Result<Log> {
        if path == Path::new("-") {
            return Log::read(std::io::stdin().lock(), options);
        }
        if path.is_dir() {
            return Log::begin(path, &Place::Folder(path.into()), options);
        }
        Log::begin(path, &Place::File(Input::open(path, options.spool.as_deref())?), options)
    }

    /// Opens a stream, as [`Log::open`] does for `-`.
    ///
    /// # Errors
    /// As [`Log::open`].
    pub fn read(stream: impl Read, options: &Options) -> Result<Log> {
        let path = Path::new(STDIN);
        Log::begin(path, &Place::File(Input::spool(path, stream, options.spool.as_deref())?), options)
    }

    fn begin(path: &Path, place: &Place, options: &Options) -> Result<Log> {
        let head = match place {
            Place::Folder(_) => Vec::new(),
            Place::File(input) => input.head()?,
        };
        let text = String::from_utf8_lossy(head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head));
        let probe = match place {
            Place::Folder(folder) => Probe::Folder(folder),
            Place::File(_) => Probe::Text(&text),
        };
        let format = FORMATS.iter().find(|f| f.claims(&probe)).ok_or_else(|| unknown(path, &probe, &head))?;
        let source = format.open(place, options.kind)?;
        let sensors = sensors::complete(path, source.as_ref(), options)?;
        let header = Header {
            format: format.name(),
            sensors: sensors.iter().map(|m| m.sensor.clone()).collect(),
            classes: source.classes().to_vec(),
        };
        Ok(Log { path: path.into(), source, header, sensors: sensors.into() })
    }

    /// Where it lies; `<stdin>` for standard input.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its format, sensors and classes.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Where its sensors sit, as the report says it: `none` at the robot's centre (`--set mounts=none`), `preset` where the
    /// format's preset puts them, `own` where the log or a sensor file does.
    pub fn mounts(&self) -> &'static str {
        if self.sensors.iter().all(|m| m.centred) {
            "none"
        } else if self.source.has_preset() && !self.sensors.iter().any(|m| m.placed) {
            "preset"
        } else {
            "own"
        }
    }

    /// What a user should know of how it is read, in whole sentences; complete after the first pass over it.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for (i, (mounted, described)) in self.sensors.iter().zip(self.source.sensors()).enumerate() {
            let (Some(beams), Some(origin)) = (mounted.beams, self.source.beams_origin(i)) else { continue };
            let own = described.first == Some(beams.first) && described.step == Some(beams.step);
            let origin = if own { origin } else { "--set or the sensor file".into() };
            // Angles as a user writes them, without the last digits' noise.
            let degrees = |angle: f64| (angle.to_degrees() * 1e4).round() / 1e4;
            let (id, count, first, step) = (&mounted.sensor.id, beams.count, degrees(beams.first), degrees(beams.step));
            let span = degrees(beams.step * f64::from(count.saturating_sub(1)));
            notes.push(format!("{id}: {count} beams over {span}°, {step}° apart, the first at {first}°, by {origin}."));
        }
        notes.extend(self.source.notes());
        notes
    }

    /// A pass over its records, from the start; as many as are wanted, also at the same time.
    ///
    /// # Errors
    /// [`Error::Input`] if a file can't be opened any more.
    pub fn records(&self) -> Result<Records> {
        let ignored = Arc::new(AtomicU64::new(0));
        Ok(Records::new(self.source.scans(self.sensors.clone(), ignored.clone())?, ignored))
    }

    /// SHA-256 of its bytes as they are stored, in hexadecimal, as `sha256sum` gives it; of a folder, that of the files it
    /// uses, one after the other: readings, then poses (`cat sonar.txt od.txt | sha256sum`).
    ///
    /// # Errors
    /// [`Error::Input`] if a file can't be read.
    pub fn sha256(&self) -> Result<String> {
        let mut sum = Sha256::new();
        for input in self.source.inputs() {
            input.hash(&mut sum)?;
        }
        Ok(sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
    }
}

impl std::fmt::Debug for Log {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Log").field("path", &self.path).field("header", &self.header).finish_non_exhaustive()
    }
}

/// The error about a log that no format claims.
fn unknown(path: &Path, probe: &Probe<'_>, head: &[u8]) -> Error {
    let known: Vec<&str> = FORMATS.iter().map(|f| f.looks()).collect();
    let known = known.join("; ");
    if let Probe::Folder(_) = probe {
        return Error::input(path, format!("no log in this folder. Known are: {known}"));
    }
    let packed = [("xz", &b"\xfd7zXZ"[..]), ("bzip2", b"BZh"), ("zstd", b"\x28\xb5\x2f\xfd"), ("zip", b"PK\x03\x04")];
    if let Some((name, _)) = packed.iter().find(|(_, magic)| head.starts_with(magic)) {
        return Error::input(path, format!("is packed with {name}: unpack it first (gzip is unpacked on the fly)"));
    }
    if head.starts_with(b"\x89HDF\r\n") {
        let what = "is an HDF5 file: if it is a MATLAB log, load it in MATLAB and save it with save(name, '-v7')";
        return Error::input(path, what);
    }
    let odd = head.iter().filter(|b| **b < 9 || (14..32).contains(*b)).count();
    let what =
        if odd * 50 > head.len() || head.contains(&0) { "is binary, not a log" } else { "is of no known format" };
    Error::input(path, format!("{what}. Known are: {known}"))
}
