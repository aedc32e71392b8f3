//! The output folder: work lies in `DIR.partial/` and becomes `DIR` by renaming, so that a killed run leaves the old map
//! or the new one, never half of either.
//!
//! The old map steps aside as `DIR.old-PID` before the new one takes its place; a run killed between the two renames is
//! mended by the next [`Folder::prepare`]. Nothing is ever removed that echogrid didn't write.

use super::writer::RUN;
use crate::{Error, Result};
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

/// Lies in a partial folder, locked by the run that writes it, and in an old map that steps aside. Without it nothing
/// beside DIR is taken for ours: `map.old-2024` may well be the user's.
const MARKER: &str = ".echogrid-partial";

/// An output folder being written. Dropped without [`Folder::finish`], it removes its partial folder and those it made above.
#[derive(Debug)]
pub struct Folder {
    target: PathBuf,
    partial: PathBuf,
    /// Held open for its lock: a second run on the same folder sees it.
    marker: Option<File>,
    /// Whether an earlier run's work lies in the partial folder: no error removes it.
    resumed: bool,
    /// Folders above it that were made for it, the innermost first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Checks, before the long run, that `path` may become a map, and opens `path.partial` beside it, afresh.
    pub fn prepare(path: &Path) -> Result<Folder> {
        Folder::open(path, false)
    }

    /// The same; with `resume`, an unfinished map that a killed run left in `path.partial` stays, to be gone on with.
    /// Without it such a one is an error.
    pub fn open(path: &Path, resume: bool) -> Result<Folder> {
        let target = resolve(path)?;
        let parent = parent_of(&target);
        if let Some(file) = parent.ancestors().find(|a| a.is_file()) {
            return Err(unusable(path, &format!("{} is a file", file.display())));
        }
        let made: Vec<PathBuf> = parent.ancestors().take_while(|a| !a.exists()).map(PathBuf::from).collect();
        let mut folder = Folder { partial: beside(&target, ".partial"), target, marker: None, resumed: false, made };
        fs::create_dir_all(&parent).map_err(|e| unusable(path, &format!("its parent can't be made: {e}")))?;
        recover(&folder.target)?;
        check_target(&folder.target)?;
        folder.marker = Some(open_partial(&folder.partial, resume)?);
        folder.resumed = folder.partial.join(RUN).exists();
        Ok(folder)
    }

    /// Leaves the partial folder where it is, to be gone on with; the lock is given up.
    pub fn keep(mut self) {
        self.marker = None;
    }

    /// Where the files are to be written.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Makes what was written the user's folder, in place of an older map, and returns its path.
    pub fn finish(mut self) -> Result<PathBuf> {
        let place = |e: std::io::Error| {
            let (partial, target) = (self.partial.display(), self.target.display());
            Error::Resources(format!("{partial} can't become {target}: {e}; the folder's parent must stay writable"))
        };
        check_target(&self.target)?;
        let free = |n: &u32| !beside(&self.target, &format!(".old-{n}")).exists();
        let number = (std::process::id()..).find(free).unwrap_or_default();
        let old = beside(&self.target, &format!(".old-{number}"));
        let replaces = is_map(&self.target);
        if replaces {
            File::create(self.target.join(MARKER)).map_err(place)?;
            fs::rename(&self.target, &old).map_err(place)?;
        } else if self.target.is_dir() {
            fs::remove_dir(&self.target).map_err(place)?; // empty: check_target saw to that
        }
        if let Err(e) = fs::rename(&self.partial, &self.target) {
            let error = place(e);
            if replaces {
                fs::rename(&old, &self.target).map_err(place)?;
                let _ = fs::remove_file(self.target.join(MARKER));
            }
            return Err(error);
        }
        self.marker = None;
        // The map stands. A leftover beside it is only untidy, and the next run removes it.
        let _ = fs::remove_file(self.target.join(MARKER));
        if replaces {
            let _ = remove(&old);
        }
        Ok(self.target.clone())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if self.marker.take().is_some() && !self.resumed {
            let _ = remove(&self.partial);
        }
        // What holds a map or anything else stays: only empty folders can be removed so.
        for folder in &self.made {
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}

/// Whether a folder is a complete map of echogrid's: a report that names a method and a version, and a Zarr store.
pub(super) fn is_map(path: &Path) -> bool {
    let Ok(text) = fs::read(path.join("report.json")) else { return false };
    let Ok(report) = serde_json::from_slice::<serde_json::Value>(&text) else { return false };
    report.get("method").is_some() && report.get("version").is_some() && path.join("map.zarr").is_dir()
}

/// Whether a folder is meant as a map, whole or damaged: no log looks so.
pub(crate) fn seems_map(path: &Path) -> bool {
    path.join("map.zarr").is_dir() || path.join("report.json").is_file()
}

/// Old maps that a killed run left beside `target`.
pub(super) fn leftovers(target: &Path) -> Vec<PathBuf> {
    let Some(name) = target.file_name().and_then(|n| n.to_str()) else { return Vec::new() };
    let Ok(entries) = fs::read_dir(parent_of(target)) else { return Vec::new() };
    let is_old = |found: &str| {
        let pid = found.strip_prefix(name).and_then(|rest| rest.strip_prefix(".old-"));
        pid.is_some_and(|p| !p.is_empty() && p.bytes().all(|b| b.is_ascii_digit()))
    };
    let names = entries.flatten().filter(|e| e.file_name().to_str().is_some_and(is_old));
    let mut paths: Vec<PathBuf> = names.map(|e| e.path()).filter(|p| p.join(MARKER).exists()).collect();
    paths.sort();
    paths
}

/// Finishes what a killed run began: an old map returns if nothing took its place, else it goes.
fn recover(target: &Path) -> Result<()> {
    for old in leftovers(target) {
        if is_map(target) {
            remove(&old).map_err(|e| unusable(&old, &format!("it is an old map that can't be removed: {e}")))?;
        } else if !target.exists() && is_map(&old) {
            fs::rename(&old, target).map_err(|e| unusable(target, &format!("{} can't return: {e}", old.display())))?;
            let _ = fs::remove_file(target.join(MARKER));
        }
    }
    Ok(())
}

/// Only what doesn't exist, an empty folder, or a map may be replaced.
fn check_target(target: &Path) -> Result<()> {
    let Ok(meta) = fs::metadata(target) else { return Ok(()) };
    if !meta.is_dir() {
        return Err(unusable(target, "it is a file"));
    }
    if is_mount(target, &meta) {
        return Err(blocked(target, "it is a mount point, which no rename can replace", "give a folder inside it"));
    }
    let mut entries = fs::read_dir(target).map_err(|e| unusable(target, &e.to_string()))?;
    if entries.next().is_some() && !is_map(target) {
        return Err(unusable(target, "it holds files and is no echogrid map, so it is left as it is"));
    }
    Ok(())
}

/// Makes the partial folder afresh and locks its marker.
fn open_partial(partial: &Path, resume: bool) -> Result<File> {
    let marker = partial.join(MARKER);
    if partial.exists() {
        if !partial.is_dir() || !is_ours(partial) {
            return Err(blocked(partial, "it is in the way and echogrid didn't write it", "move it"));
        }
        if File::open(&marker).is_ok_and(|file| locked(&file)) {
            return Err(blocked(partial, "another run is writing it", "wait for that run"));
        }
        if partial.join(RUN).exists() {
            if !resume {
                let what = "it holds an unfinished map";
                return Err(blocked(partial, what, "go on with it by --resume, or remove it"));
            }
        } else {
            remove(partial)
                .map_err(|e| unusable(partial, &format!("a killed run left it and it can't be removed: {e}")))?;
        }
    }
    fs::create_dir_all(partial).map_err(|e| unusable(partial, &e.to_string()))?;
    let file = File::create(&marker).map_err(|e| unusable(partial, &e.to_string()))?;
    match locked(&file) {
        true => Err(blocked(partial, "another run is writing it", "wait for that run")),
        false => Ok(file),
    }
}

/// Whether another run holds the lock, and goes on to: a killed one takes a while to die. A file system without locks only
/// loses the warning about two runs at once.
fn locked(file: &File) -> bool {
    for wait in [0, 100, 400, 1500] {
        std::thread::sleep(std::time::Duration::from_millis(wait));
        if !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return false;
        }
    }
    true
}

/// Whether a partial folder is echogrid's: its marker, or nothing at all.
fn is_ours(partial: &Path) -> bool {
    let empty = fs::read_dir(partial).is_ok_and(|mut entries| entries.next().is_none());
    partial.join(MARKER).exists() || empty
}

/// Removes a folder of ours so that a kill halfway leaves it recognisable: the report goes first, so that it is no map
/// any more, the marker last.
fn remove(path: &Path) -> std::io::Result<()> {
    let _ = fs::remove_file(path.join("report.json"));
    let marker = path.join(MARKER);
    for entry in fs::read_dir(path)? {
        let entry = entry?.path();
        if entry == marker {
            continue;
        } else if entry.is_dir() && !entry.is_symlink() {
            fs::remove_dir_all(&entry)?;
        } else {
            fs::remove_file(&entry)?;
        }
    }
    if marker.exists() {
        fs::remove_file(&marker)?;
    }
    fs::remove_dir(path)
}

/// The folder that is meant, through links and dots, so that its partial lies on the same file system.
fn resolve(path: &Path) -> Result<PathBuf> {
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

fn parent_of(target: &Path) -> PathBuf {
    target.parent().unwrap_or(Path::new(".")).to_path_buf()
}

fn beside(target: &Path, suffix: &str) -> PathBuf {
    let mut name = target.file_name().unwrap_or_default().to_os_string();
    name.push(suffix);
    target.with_file_name(name)
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

fn unusable(path: &Path, why: &str) -> Error {
    refuse(path, why, "")
}

/// `remedy`: what else would help.
fn blocked(path: &Path, why: &str, remedy: &str) -> Error {
    refuse(path, why, &format!("{remedy}, or "))
}

fn refuse(path: &Path, why: &str, remedy: &str) -> Error {
    let path = path.display();
    Error::Resources(format!("{path} can't be the output: {why}; {remedy}give another folder with -o"))
}
