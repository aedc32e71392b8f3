//! Standard output. The first error of writing is kept until the command ends, and changes its exit code: output redirected to a
//! file on a full disk must not be lost in silence. A closed pipe, as by `head`, is no error.

use crate::{Error, Result};
use std::fmt::Arguments;
use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

static FAILED: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints a line.
pub(super) fn print_line(text: Arguments) {
    record(writeln!(io::stdout(), "{text}"));
}

/// Flushes standard output. Fails where anything since the program's start couldn't be written.
///
/// # Errors
/// [`Error::Resources`] with the first error.
pub fn finish() -> Result<()> {
    record(io::stdout().flush());
    match failed().take() {
        None => Ok(()),
        Some(e) => Err(Error::Resources(format!(
            "standard output can't be written: {e}: free space where it goes, or send it elsewhere"
        ))),
    }
}

/// Keeps the first error, unless it is a closed pipe.
pub fn record(written: io::Result<()>) {
    if let Err(e) = written
        && e.kind() != io::ErrorKind::BrokenPipe
    {
        failed().get_or_insert(e);
    }
}

fn failed() -> MutexGuard<'static, Option<io::Error>> {
    FAILED.lock().unwrap_or_else(PoisonError::into_inner)
}
