//! An open log: finds its format, completes its sensors, and hands out passes over its records.

use super::format::{LogPath, Probe, Source};
use super::formats::FORMATS;
use super::input::{Input, STDIN};
use super::mounting::MountedSensor;
use super::options::Options;
use super::records::Records;
use super::{matlab, poses, sensors, table, unknown};
use crate::sensor::Sensor;
use crate::{Error, Result};
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// The format, sensors and classes of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// The format's name.
    pub format: &'static str,
    /// The sensors, complete; a record's `sensor` is an index into them.
    pub sensors: Vec<Sensor>,
    /// Names of the class labels 1, 2, …; empty if there are none.
    pub classes: Vec<String>,
}

/// An open log.
pub struct Log {
    path: PathBuf,
    pub(super) source: Box<dyn Source>,
    header: Header,
    pub(super) sensors: Arc<[MountedSensor]>,
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
            return Log::open_at(path, &LogPath::Folder(path.into()), options);
        }
        Log::open_at(path, &LogPath::File(Input::open(path, options.spool.as_deref())?), options)
    }

    /// Opens a stream, as [`Log::open`] does for `-`.
    ///
    /// # Errors
    /// As [`Log::open`].
    pub fn read(stream: impl Read, options: &Options) -> Result<Log> {
        let path = Path::new(STDIN);
        Log::open_at(path, &LogPath::File(Input::spool(path, stream, options.spool.as_deref())?), options)
    }

    fn open_at(path: &Path, place: &LogPath, options: &Options) -> Result<Log> {
        let head = match place {
            LogPath::Folder(_) => Vec::new(),
            LogPath::File(input) => input.head()?,
        };
        let text = String::from_utf8_lossy(head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head));
        let probe = match place {
            LogPath::Folder(folder) => Probe::Folder(folder),
            LogPath::File(_) => Probe::Text(&text),
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
                let format = FORMATS.iter().find(|f| f.sniff(&probe));
                let format = format.ok_or_else(|| unknown::unknown(path, &probe, &head))?;
                (format.name(), format.open(place, options.kind)?)
            }
        };
        let sensors = sensors::complete(path, source.as_ref(), options)?;
        source.check_sensors(&sensors)?;
        let source = Log::with_poses(path, source, &sensors, options)?;
        let header = Header {
            format: name,
            sensors: sensors.iter().map(|m| m.sensor.clone()).collect(),
            classes: source.classes().to_vec(),
        };
        Ok(Log { path: path.into(), source, header, sensors: sensors.into(), mapping: options.mapping() })
    }

    /// Replaces the log's poses by those of another file, if one is given. A log without poses and without such a file is an error.
    fn with_poses(
        path: &Path,
        source: Box<dyn Source>,
        sensors: &[MountedSensor],
        options: &Options,
    ) -> Result<Box<dyn Source>> {
        match &options.poses {
            Some(poses) => Ok(Box::new(poses::PosedLog::of(source, sensors, poses, options.pose_columns.as_deref())?)),
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

    /// Its path; `<stdin>` for standard input.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its format, sensors and classes.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The source of its sensors' positions, for the report: `none`, all at the robot's centre (`--set mounts=none`); `preset`, the
    /// format's preset; `own`, the log or a sensor file.
    pub fn mounts(&self) -> &'static str {
        if self.sensors.iter().all(|m| m.centred) {
            "none"
        } else if self.source.has_preset() && !self.sensors.iter().any(|m| m.placed) {
            "preset"
        } else {
            "own"
        }
    }

    /// The options that name its columns, variables and poses, with their texts (`columns`, `fields`, `poses`, `pose_columns`).
    pub fn mapping(&self) -> &[(&'static str, String)] {
        &self.mapping
    }

    /// Starts a pass over its records. Any number of passes may run, also at the same time.
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
