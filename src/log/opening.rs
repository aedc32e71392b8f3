//! Checks that several formats share when they open a log.

use super::format::LogPath;
use super::input::Input;
use crate::sensor::Kind;
use crate::{Error, Result};

/// The file of a format that is one file.
///
/// # Errors
/// [`Error::Usage`] if it is a folder.
pub(super) fn require_file<'a>(place: &'a LogPath, format: &str) -> Result<&'a Input> {
    match place {
        LogPath::File(input) => Ok(input),
        LogPath::Folder(_) => Err(Error::Usage(format!("a {format} log is a file"))),
    }
}

/// The file of a format that is one file and holds only lasers. `title` is the format's name in the message about a folder, `name`
/// that in the message about sonars.
///
/// # Errors
/// [`Error::Usage`] if it is a folder; [`Error::Input`] if sonars are asked for.
pub(super) fn laser_file<'a>(place: &'a LogPath, kind: Option<Kind>, title: &str, name: &str) -> Result<&'a Input> {
    let input = require_file(place, title)?;
    lasers_only(input, kind, name)?;
    Ok(input)
}

/// Refuses sonars where a log holds only lasers.
///
/// # Errors
/// [`Error::Input`] if sonars are asked for.
pub(super) fn lasers_only(input: &Input, kind: Option<Kind>, format: &str) -> Result<()> {
    match kind {
        Some(Kind::Sonar) => Err(Error::input(
            input.path(),
            format!("a {format} log holds laser readings only: leave out --sensor sonar"),
        )),
        _ => Ok(()),
    }
}
