//! Standard output. Its first error is remembered, and asked for when the command ends: what a user redirected to a file on a full
//! disk must not be lost with exit code 0. A reader that went away, as `head` does, has all it wants and is no error.

use crate::{Error, Result};
use std::fmt::Arguments;
use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

static FAILED: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints a line.
pub(super) fn line(text: Arguments) {
    keep(writeln!(io::stdout(), "{text}"));
}

/// Writes out what is held back, and says whether all of it, from the program's start on, could be written.
///
/// # Errors
/// [`Error::Resources`] with the first error.
pub fn finish() -> Result<()> {
    keep(io::stdout().flush());
    match failed().take() {
        None => Ok(()),
        Some(e) => Err(Error::Resources(format!(
            "standard output can't be written: {e}: free space where it goes, or send it elsewhere"
        ))),
    }
}

/// Remembers the first error.
pub fn keep(written: io::Result<()>) {
    if let Err(e) = written
        && e.kind() != io::ErrorKind::BrokenPipe
    {
        failed().get_or_insert(e);
    }
}

fn failed() -> MutexGuard<'static, Option<io::Error>> {
    FAILED.lock().unwrap_or_else(PoisonError::into_inner)
}
