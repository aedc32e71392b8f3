//! Exit codes: 0 done · 1 differs · 2 bad usage · 3 bad input · 4 no adapter · 5 out of memory or space, or output not writable ·
//! 6 done, but some lines were bad · 130, 143 ended by Ctrl-C or SIGTERM.

use crate::pipeline::session::Session;
use crate::{Error, ErrorKind};

/// The maps, backends or scores are not as demanded.
pub(super) const DIFFERS: u8 = 1;
/// Done, but some lines of the log were bad.
const BAD_LINES: u8 = 6;
/// Added to a signal's number, as shells do.
pub(super) const SIGNALLED: i32 = 128;

/// The exit code of an error.
pub fn exit_code(error: &Error) -> u8 {
    match error.kind() {
        ErrorKind::Usage => 2,
        ErrorKind::Input => 3,
        ErrorKind::NoAdapter => 4,
        ErrorKind::Resources => 5,
    }
}

/// The exit code of a run that mapped its log.
pub(super) fn done(session: &Session) -> u8 {
    if session.survey.bad_lines.count > 0 { BAD_LINES } else { 0 }
}
