//! Paths of an output folder and of the folders beside it.

use super::errors::{blocked, unusable};
use crate::Result;
use std::fs;
use std::path::{Path, PathBuf};

/// Resolves links and dots, so that the partial folder lies on the same file system.
pub(super) fn resolve(path: &Path) -> Result<PathBuf> {
    let resolved = if path.exists() { fs::canonicalize(path) } else { std::path::absolute(path) };
    let target = resolved.map_err(|e| unusable(path, &e.to_string()))?;
    if target.is_symlink() {
        return Err(blocked(path, "it is a link to nothing", "remove it"));
    }
    match target.file_name() {
        Some(_) => Ok(target),
        None => Err(unusable(path, "it has no name, as out/map has")),
    }
}

/// The first free name beside a folder, such as DIR.old-77, counted from a number on.
pub(super) fn free(target: &Path, what: &str, from: u32) -> PathBuf {
    let name = |n: u32| beside(target, &format!(".{what}-{n}"));
    (from..).map(name).find(|path| fs::symlink_metadata(path).is_err()).unwrap_or_else(|| name(from))
}

/// The parent of a folder.
pub(super) fn parent_of(target: &Path) -> PathBuf {
    target.parent().unwrap_or(Path::new(".")).to_path_buf()
}

/// The path of a folder with a suffix to its name.
pub(super) fn beside(target: &Path, suffix: &str) -> PathBuf {
    let mut name = target.file_name().unwrap_or_default().to_os_string();
    name.push(suffix);
    target.with_file_name(name)
}
