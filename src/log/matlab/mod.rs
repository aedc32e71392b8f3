//! MATLAB's `.mat` files, version 5, with laser scans as hit points: `robotPose`, a struct of x, y and h, a number a scan;
//! `laserScan`, a cell a scan, of 2 × N hit points in the robot's frame, or 3 × N with class labels in the third row.
//!
//! Files with other variables are read by `--fields` (`fields`, `scan_data`, `named`), and so are Octave's text files (`octave`).
//! A "line" of such a log is a scan, counted from 1.

use super::format::{Format, LogPath, Probe, Source};
use super::input::Input;
use super::lines::unreadable;
use super::opening::{lasers_only, require_file};
use crate::sensor::Kind;
use crate::{Error, Result};
use array::Array;
use point_log::PointLog;
use std::io::Read;

mod array;
mod element;
mod fields;
mod named;
mod octave;
mod point_log;
mod scan_data;
mod scan_values;
mod variables;

/// The format.
pub(crate) struct Matlab;

impl Format for Matlab {
    fn name(&self) -> &'static str {
        "matlab"
    }

    fn describe(&self) -> &'static str {
        "a MATLAB .mat file (version 5 to 7) of poses and scans"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        matches!(probe, Probe::Text(text) if text.starts_with("MATLAB 5.0 MAT-file") || text.starts_with("MATLAB 7.3 MAT-file"))
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = require_file(place, ".mat")?;
        let bytes = whole(input)?;
        let fail = |what: String| Error::input(input.path(), what);
        let found = variables::read(&bytes, &["robotPose", "laserScan"]).map_err(fail)?;
        if found.wanted.is_empty() && !found.names.is_empty() {
            return named::open(input, &variables::read_all(&bytes).map_err(fail)?, None, kind);
        }
        lasers_only(input, kind, self.name())?;
        Ok(Box::new(PointLog::of(input, found).map_err(fail)?))
    }
}

/// The format of Octave's text files.
pub(crate) struct Octave;

impl Format for Octave {
    fn name(&self) -> &'static str {
        "octave"
    }

    fn describe(&self) -> &'static str {
        "an Octave text file (save -text) of poses and scans"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        matches!(probe, Probe::Text(text) if octave::is_octave_text(text))
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = require_file(place, "Octave")?;
        named::open(input, &all_variables(input)?, None, kind)
    }
}

/// Opens a MATLAB or Octave file with variables named by `--fields`; returns the format's name too.
///
/// # Errors
/// [`Error::Usage`] if it is no such file or the text is wrong; [`Error::Input`] if the variables make no log.
pub(super) fn open_fields(place: &LogPath, text: &str, kind: Option<Kind>) -> Result<(&'static str, Box<dyn Source>)> {
    let input = require_file(place, ".mat")?;
    let head = input.head()?;
    let head = String::from_utf8_lossy(&head);
    let probe = Probe::Text(&head);
    let format: &dyn Format = if Octave.sniff(&probe) { &Octave } else { &Matlab };
    if !format.sniff(&probe) {
        let what = format!(
            "--fields {text}: {} is no MATLAB or Octave file; of a table, --columns names the columns",
            input.path().display()
        );
        return Err(Error::Usage(what));
    }
    Ok((format.name(), named::open(input, &all_variables(input)?, Some(text), kind)?))
}

/// All variables of a MATLAB or Octave file.
fn all_variables(input: &Input) -> Result<Vec<(String, Array)>> {
    let bytes = whole(input)?;
    let fail = |what: String| Error::input(input.path(), what);
    match bytes.starts_with(b"MATLAB") {
        true => variables::read_all(&bytes).map_err(fail),
        false => {
            if bytes.len() as u64 > element::MAX_BYTES {
                return Err(fail("is more than 512 MiB to read: save fewer scans in a file".into()));
            }
            let text = std::str::from_utf8(&bytes)
                .map_err(|e| Error::caused(input.path(), format!("is not UTF-8 text: {e}"), e))?;
            octave::read(text).map_err(fail)
        }
    }
}

/// The bytes of a file, up to one more than [`element::MAX_BYTES`].
fn whole(input: &Input) -> Result<Vec<u8>> {
    let fail = |what: String| Error::input(input.path(), what);
    let mut bytes = Vec::new();
    let read = input.reader()?.take(element::MAX_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|e| unreadable(input.path(), None, e))?;
    if bytes.starts_with(b"MATLAB 7.3") {
        let what = "is a version 7.3 file (HDF5): load it in MATLAB and save it with save(name, '-v7')";
        return Err(fail(what.into()));
    }
    Ok(bytes)
}
