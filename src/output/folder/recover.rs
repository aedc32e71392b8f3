//! Mends what a run left that was killed while it replaced a map.

use super::errors::{blocked, unusable};
use super::paths::parent_of;
use super::target::is_map;
use crate::Result;
use crate::output::contents::Contents;
use crate::output::names::MARKER;
use std::fs;
use std::path::{Path, PathBuf};

/// The old maps that killed runs left beside `target`; none where its parent can't be read.
pub(in crate::output) fn leftovers(target: &Path) -> Vec<PathBuf> {
    let Some(name) = target.file_name().and_then(|n| n.to_str()) else { return Vec::new() };
    let Ok(entries) = fs::read_dir(parent_of(target)) else { return Vec::new() };
    let is_old = |found: &str| {
        let pid = found.strip_prefix(name).and_then(|rest| rest.strip_prefix(".old-"));
        pid.is_some_and(|p| !p.is_empty() && p.bytes().all(|b| b.is_ascii_digit()))
    };
    let names = entries.flatten().filter(|e| e.file_name().to_str().is_some_and(is_old));
    let mut paths: Vec<PathBuf> = names.map(|e| e.path()).filter(|p| MARKER.at(p).exists()).collect();
    paths.sort();
    paths
}

/// Mends a killed run: an old map is restored if no new one took its place, else removed.
pub(super) fn recover(target: &Path) -> Result<()> {
    for old in leftovers(target) {
        if is_map(target) {
            let unremovable =
                |e: std::io::Error| unusable(&old, &format!("it is an old map that can't be removed: {e}"));
            let contents = Contents::of(&old, false).map_err(unremovable)?;
            if let Some(foreign) = contents.foreign() {
                let what = format!("a killed run left {}, which holds {foreign}, not the map's", old.display());
                return Err(blocked(target, &what, "move what is yours"));
            }
            contents.remove().map_err(unremovable)?;
        } else if !target.exists() && is_map(&old) {
            fs::rename(&old, target).map_err(|e| unusable(target, &format!("{} can't return: {e}", old.display())))?;
            let _ = fs::remove_file(MARKER.at(target));
        }
    }
    Ok(())
}
