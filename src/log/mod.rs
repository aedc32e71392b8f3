//! Logs: files, folders or a stream of readings, told by their content and streamed in constant memory as often as needed.
//!
//! One file a format (see `format.rs` for the registry); `docs/formats.md` describes them for users. A log hands out
//! [`Record`](crate::log::reading::Record)s as they were read; [`judge`](crate::log::reading::judge) decides what they are worth.

mod aria;
mod bytes;
mod carmen;
pub mod classes;
mod cmu;
mod codes;
mod csv;
mod fields;
mod format;
mod gzip;
mod input;
mod jsonl;
mod lines;
mod matlab;
mod player;
mod poses;
pub mod reading;
mod records;
mod rostopic;
mod sensors;
mod sonar_ring_8;
mod table;
mod text;
mod track;
mod unknown;
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
    /// What the columns of a plain table hold, such as `t,x,y,heading:deg,range:cm` (docs/formats.md); the log is read as one.
    pub columns: Option<String>,
    /// Which variables of a MATLAB or Octave file are what, such as `pose=P,ranges=R,angles=A` (docs/formats.md).
    pub fields: Option<String>,
    /// A file of the robot's poses by time, in place of the log's.
    pub poses: Option<PathBuf>,
    /// What the columns of a table of poses hold, such as `t,x,y,heading`.
    pub pose_columns: Option<String>,
    /// A classes file: names and colours of the labels, in place of the log's.
    pub classes: Option<PathBuf>,
    /// Folder for the copy of a stream; `None`: the system's temporary folder.
    pub spool: Option<PathBuf>,
}

impl Options {
    fn mapping(&self) -> Vec<(&'static str, String)> {
        let poses = self.poses.as_ref().map(|path| path.display().to_string());
        [("columns", &self.columns), ("fields", &self.fields), ("poses", &poses), ("pose_columns", &self.pose_columns)]
            .into_iter()
            .filter_map(|(name, text)| Some((name, text.clone()?)))
            .collect()
    }
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
    mapping: Vec<(&'static str, String)>,
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
        if let Some(error) = unknown::binary(path, &head) {
            return Err(error);
        }
        let (name, source) = match (&options.columns, &options.fields) {
            (Some(_), Some(_)) => {
                let what = "--columns names those of a table, --fields the variables of a MATLAB or Octave file: give one of them";
                return Err(Error::Usage(what.into()));
            }
            (Some(columns), None) => (table::NAME, table::open(place, options, columns)?),
            (None, Some(fields)) => matlab::open_fields(place, fields, options.kind)?,
            (None, None) => {
                let format = FORMATS.iter().find(|f| f.claims(&probe));
                let format = format.ok_or_else(|| unknown::unknown(path, &probe, &head))?;
                (format.name(), format.open(place, options.kind)?)
            }
        };
        let sensors = sensors::complete(path, source.as_ref(), options)?;
        source.ready(&sensors)?;
        let source = Log::posed(path, source, &sensors, options)?;
        let header = Header {
            format: name,
            sensors: sensors.iter().map(|m| m.sensor.clone()).collect(),
            classes: source.classes().to_vec(),
        };
        Ok(Log { path: path.into(), source, header, sensors: sensors.into(), mapping: options.mapping() })
    }

    /// The log with the poses of another file, if one is given; refuses a log that has none and is given none.
    fn posed(path: &Path, source: Box<dyn Source>, sensors: &[Mounted], options: &Options) -> Result<Box<dyn Source>> {
        match &options.poses {
            Some(poses) => Ok(Box::new(poses::Posed::of(source, sensors, poses, options.pose_columns.as_deref())?)),
            None if options.pose_columns.is_some() => Err(Error::Usage(
                "--pose-columns names the columns of a file of poses: give it with --poses FILE".into(),
            )),
            None if source.has_poses() => Ok(source),
            None => Err(Error::input(
                path,
                "holds readings, but no poses of the robot, and without them there is no map: give a file of poses by time with \
                 --poses FILE, such as what `rostopic echo -p /odom` (or /amcl_pose) writes, or rows of t x y heading \
                 (docs/formats.md)",
            )),
        }
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

    /// What the user said of its columns, variables and poses, by the options' names (`columns`, `fields`, `poses`, `pose_columns`).
    pub fn mapping(&self) -> &[(&'static str, String)] {
        &self.mapping
    }

    /// How the beams of its lasers lie, and by what, in whole sentences.
    pub fn beams(&self) -> Vec<String> {
        self.layouts().into_iter().map(|layout| layout.0).collect()
    }

    /// The same, each with whether it is plain.
    fn layouts(&self) -> Vec<(String, bool)> {
        let mut layouts = Vec::new();
        for (i, (mounted, described)) in self.sensors.iter().zip(self.source.sensors()).enumerate() {
            let (Some(beams), Some((origin, plain))) = (mounted.beams, self.source.beams_origin(i)) else { continue };
            let own = described.first == Some(beams.first) && described.step == Some(beams.step);
            let origin = if own { origin } else { "--set or the sensor file".into() };
            // Angles as a user writes them, without the last digits' noise.
            let degrees = |angle: f64| (angle.to_degrees() * 1e4).round() / 1e4;
            let (id, count, first, step) = (&mounted.sensor.id, beams.count, degrees(beams.first), degrees(beams.step));
            let span = degrees(beams.step * f64::from(count.saturating_sub(1)));
            let text = format!("{id}: {count} beams over {span}°, {step}° apart, the first at {first}°, by {origin}.");
            layouts.push((text, plain && own));
        }
        layouts
    }

    /// What a user should know of how it is read, in whole sentences; complete after the first pass over it.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.layouts().into_iter().filter(|(_, plain)| !plain).map(|l| l.0).collect();
        // Where the user has said where the scale ends, that counts.
        let own =
            self.sensors.iter().zip(self.source.sensors()).map(|(m, d)| d.r_max.is_none_or(|r| r == m.sensor.r_max));
        notes.extend(own.enumerate().filter(|(_, own)| *own).filter_map(|(i, _)| self.source.silence(i)));
        notes.extend(self.source.notes());
        let inputs = self.source.inputs();
        let of = |input: &&Input| -> Vec<String> {
            let name = input.path().file_name().unwrap_or_default().display();
            let whose = if inputs.len() > 1 { format!("{name}: ") } else { String::new() };
            input.notes().into_iter().map(|note| format!("{whose}{note}")).collect()
        };
        notes.extend(inputs.iter().flat_map(of));
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
