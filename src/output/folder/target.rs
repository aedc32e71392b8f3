//! Checks of the folder that a map is to replace.

use super::errors::{blocked, unusable};
use super::paths::parent_of;
use crate::Result;
use crate::output::contents::Contents;
use crate::output::names::{REPORT, STORE, STORE_ROOT};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// Whether a folder is a complete map of echogrid: a report that names a method and a version, and a Zarr store.
pub(in crate::output) fn is_map(path: &Path) -> bool {
    let Ok(text) = fs::read(REPORT.at(path)) else { return false };
    let Ok(report) = serde_json::from_slice::<serde_json::Value>(&text) else { return false };
    report.get("method").is_some() && report.get("version").is_some() && STORE_ROOT.at(path).is_file()
}

/// Whether a folder is a map, whole or damaged, and not a log.
pub(crate) fn seems_map(path: &Path) -> bool {
    path.join(STORE).is_dir() || REPORT.at(path).is_file()
}

/// Checks that `target` does not exist, is an empty folder, or is a map: only these may be replaced.
pub(super) fn check_target(target: &Path) -> Result<()> {
    let meta = match fs::metadata(target) {
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => return Ok(()),
        meta => meta.map_err(|e| unusable(target, &e.to_string()))?,
    };
    if !meta.is_dir() {
        return Err(unusable(target, "it is a file"));
    }
    if is_mount(target, &meta) {
        return Err(blocked(target, "it is a mount point, which no rename can replace", "give a folder inside it"));
    }
    let mut entries = fs::read_dir(target).map_err(|e| unusable(target, &e.to_string()))?;
    if entries.next().is_none() {
        return Ok(());
    }
    if !is_map(target) {
        return Err(unusable(target, "it holds files and is no echogrid map, so it is left as it is"));
    }
    check_foreign(target, target)
}

/// Checks that a map holds no files but its own; `target` is its name in the error.
pub(super) fn check_foreign(map: &Path, target: &Path) -> Result<()> {
    let contents = Contents::of(map, false).map_err(|e| unusable(target, &e.to_string()))?;
    match contents.foreign() {
        None => Ok(()),
        Some(foreign) => {
            let what = format!("beside the files of a map it holds {foreign}");
            Err(blocked(target, &what, "move what is yours out of it"))
        }
    }
}

#[cfg(unix)]
fn is_mount(target: &Path, meta: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(parent_of(target)).is_ok_and(|parent| parent.dev() != meta.dev())
}

#[cfg(not(unix))]
fn is_mount(_: &Path, _: &fs::Metadata) -> bool {
    false
}
