//! The errors of an output folder: the path, the reason and a remedy.

use crate::Error;
use std::path::Path;

/// A path can't be the output, for this reason.
pub(super) fn unusable(path: &Path, why: &str) -> Error {
    refuse(path, why, "")
}

/// A path can't be the output, for this reason; `remedy`: what the user can do besides giving another folder.
pub(super) fn blocked(path: &Path, why: &str, remedy: &str) -> Error {
    refuse(path, why, &format!("{remedy}, or "))
}

fn refuse(path: &Path, why: &str, remedy: &str) -> Error {
    let path = path.display();
    Error::Resources(format!("{path} can't be the output: {why}; {remedy}give another folder with -o"))
}
