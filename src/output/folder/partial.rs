//! The partial folder of a map that is being written, and its lock.

use super::Unfinished;
use super::errors::{blocked, unusable};
use crate::Result;
use crate::output::contents::Contents;
use crate::output::names::{MARKER, RUN};
use std::fs::{self, File, TryLockError};
use std::path::Path;

/// Creates the partial folder, or opens that of an earlier run to resume it, and locks its marker.
pub(super) fn open_partial(partial: &Path, unfinished: Unfinished) -> Result<File> {
    let marker = MARKER.at(partial);
    if partial.exists() {
        if !partial.is_dir() || !is_ours(partial) {
            return Err(blocked(partial, "it is in the way and echogrid didn't write it", "move it"));
        }
        if File::open(&marker).is_ok_and(|file| locked(&file)) {
            return Err(blocked(partial, "another run is writing it", "wait for that run"));
        }
        let contents = Contents::of(partial, true).map_err(|e| unusable(partial, &e.to_string()))?;
        if let Some(foreign) = contents.foreign() {
            let what = format!("a killed run left it, and it holds {foreign}, which is no file of a map");
            return Err(blocked(partial, &what, "move what is yours out of it"));
        }
        match (RUN.at(partial).exists(), unfinished) {
            (true, Unfinished::Resume) => {}
            (true, Unfinished::Refuse) => {
                let remedy = "go on with it by `echogrid map --resume`, discard it by `echogrid map --overwrite`";
                return Err(blocked(partial, "it holds an unfinished map", remedy));
            }
            _ => contents
                .remove()
                .map_err(|e| unusable(partial, &format!("a killed run left it and it can't be removed: {e}")))?,
        }
    }
    fs::create_dir_all(partial).map_err(|e| unusable(partial, &e.to_string()))?;
    let file = File::create(&marker).map_err(|e| unusable(partial, &e.to_string()))?;
    match locked(&file) {
        true => Err(blocked(partial, "another run is writing it", "wait for that run")),
        false => Ok(file),
    }
}

/// Locks a marker; whether another run holds the lock. It waits a little, as a killed run takes a while to die. A file system without
/// locks only loses the check for two runs at once.
fn locked(file: &File) -> bool {
    for wait in [0, 100, 400, 1500] {
        std::thread::sleep(std::time::Duration::from_millis(wait));
        if !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return false;
        }
    }
    true
}

/// Whether a partial folder is echogrid's: it has the marker, or it is empty.
fn is_ours(partial: &Path) -> bool {
    let empty = fs::read_dir(partial).is_ok_and(|mut entries| entries.next().is_none());
    MARKER.at(partial).exists() || empty
}
