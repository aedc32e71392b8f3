//! Warnings about a log.

use super::log_arguments::LogArguments;
use super::print_note;
use super::set::without_effect;
use crate::log::reading::Counts;
use crate::pipeline::session::Session;

/// Prints the warnings about a log: parameters without effect, bad lines, and how the log was read.
pub fn warn_of_log(arguments: &LogArguments, session: &Session) {
    warn_of_unused_parameters(arguments, session);
    warn_of_bad_lines(session, "mend them, or give --strict to write nothing then; the exit code is 6");
    print_log_notes(session);
}

/// Warns of parameters given by `--set` that have no effect.
pub fn warn_of_unused_parameters(arguments: &LogArguments, session: &Session) {
    for (key, why) in without_effect(&session.method.settings(), &arguments.set) {
        print_note!("--set {key} has no effect with {why}");
    }
}

/// Prints the notes on how a log was read.
pub fn print_log_notes(session: &Session) {
    let path = session.log.path().display();
    for text in session.notes() {
        print_note!("{path}: {text}");
    }
}

/// Warns of bad lines, with the first few; `remedy`: what to do about them.
pub fn warn_of_bad_lines(session: &Session, remedy: &str) {
    let bad = &session.survey.bad_lines;
    let path = session.log.path().display();
    let what = match bad.count {
        0 => return,
        1 => "1 bad line was left out".into(),
        n if n > bad.first.len() as u64 => format!("{n} bad lines were left out; the first"),
        n => format!("{n} bad lines were left out"),
    };
    let quoted: String = bad.first.iter().map(|line| format!("  {line}\n")).collect();
    print_note!("{path}: {what}:\n{quoted}  ({remedy})");
}

/// Warns of a pose that jumps, unless `--bounds` keep the grid from following it.
pub fn warn_of_jump(arguments: &LogArguments, session: &Session) {
    if let (None, Some((line, what))) = (&arguments.bounds, session.survey.jump()) {
        let path = session.log.path().display();
        print_note!("{path}:{line}: {what}, and the grid follows it; if that is wrong, mend the line or give --bounds");
    }
}

/// Warns where no reading reaches the bounds.
pub fn warn_of_empty_map(counts: &Counts, session: &Session) {
    if counts.outside == counts.used {
        let [x0, y0, x1, y1] = session.survey.covered;
        print_note!("no reading reaches these --bounds: the log covers {x0:.2},{y0:.2},{x1:.2},{y1:.2}");
    }
}
