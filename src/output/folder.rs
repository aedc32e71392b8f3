//! The output folder: work lies in `DIR.partial/` and becomes `DIR` by renaming, so that a killed run leaves the old map
//! or the new one, never half of either.
//!
//! The old map steps aside as `DIR.old-PID` before the new one takes its place; a run killed between the two renames is
//! mended by the next [`Folder::prepare`]. Nothing is ever removed that echogrid didn't write: a folder that holds anything
//! else ([`Contents`]) is refused, before the run and once more at its end.

use super::contents::Contents;
use super::names::{MARKER, REPORT, RUN, STORE, STORE_ROOT};
use crate::{Error, Result};
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

/// What becomes of an unfinished map that a killed run left beside the output folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unfinished {
    /// It is an error.
    #[default]
    Refuse,
    /// It stays, to be gone on with.
    Resume,
    /// It is removed.
    Discard,
}

/// An output folder being written. Dropped without [`Folder::finish`], it removes its partial folder and those it made above.
#[derive(Debug)]
pub struct Folder {
    target: PathBuf,
    partial: PathBuf,
    /// The marker lies in a partial folder, and in an old map that steps aside: without it nothing beside DIR is taken for
    /// ours, as `map.old-2024` may well be the user's. Held open for its lock: a second run on the same folder sees it.
    marker: Option<File>,
    /// Whether an earlier run's work lies in the partial folder: no error removes it.
    resumed: bool,
    /// Folders above it that were made for it, the innermost first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Checks, before the long run, that `path` may become a map, and opens `path.partial` beside it, afresh.
    pub fn prepare(path: &Path) -> Result<Folder> {
        Folder::open(path, Unfinished::Refuse)
    }

    /// Checks that `path` may become a map, and opens nothing.
    ///
    /// # Errors
    /// [`Error::Resources`] where it holds anything but an echogrid map's own files, which are named.
    pub fn check(path: &Path) -> Result<()> {
        check_target(&resolve(path)?)
    }

    /// As [`Folder::prepare`]; `unfinished` says what becomes of an unfinished map that a killed run left in `path.partial`.
    ///
    /// # Errors
    /// [`Error::Resources`] where the folder can't be made or may not be replaced.
    pub fn open(path: &Path, unfinished: Unfinished) -> Result<Folder> {
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
        folder.marker = Some(open_partial(&folder.partial, unfinished)?);
        folder.resumed = RUN.at(&folder.partial).exists();
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
    ///
    /// # Errors
    /// [`Error::Resources`] where that can't be done, or where files that aren't the older map's have come into the folder
    /// meanwhile. What was written stays beside it then, and the error says where.
    pub fn finish(mut self) -> Result<PathBuf> {
        match self.replace() {
            Ok(()) => Ok(self.target.clone()),
            Err(error) => Err(error.and(&format!("the new map is whole and lies in {}", self.set_aside().display()))),
        }
    }

    fn replace(&mut self) -> Result<()> {
        let place = |e: std::io::Error| {
            let (partial, target) = (self.partial.display(), self.target.display());
            Error::Resources(format!("{partial} can't become {target}: {e}; the folder's parent must stay writable"))
        };
        check_target(&self.target)?;
        let old = free(&self.target, "old", std::process::id());
        let replaces = is_map(&self.target);
        if replaces {
            File::create(MARKER.at(&self.target)).map_err(place)?;
            fs::rename(&self.target, &old).map_err(place)?;
        } else if self.target.is_dir() {
            fs::remove_dir(&self.target).map_err(place)?; // empty: check_target saw to that
        }
        // Nobody finds the old map by its name any more: what came into it since it was checked is seen now.
        let checked = if replaces { check_foreign(&old, &self.target) } else { Ok(()) };
        if let Err(error) = checked.and_then(|()| fs::rename(&self.partial, &self.target).map_err(place)) {
            if replaces {
                fs::rename(&old, &self.target).map_err(place)?;
                let _ = fs::remove_file(MARKER.at(&self.target));
            }
            return Err(error);
        }
        self.marker = None;
        // The map stands. A leftover beside it is only untidy, and the next run removes it.
        let _ = fs::remove_file(MARKER.at(&self.target));
        if replaces {
            let _ = Contents::of(&old, false).and_then(Contents::remove);
        }
        Ok(())
    }

    /// Gives what was written a name of its own that no run removes; where that can't be done, it stays where it is.
    fn set_aside(&mut self) -> PathBuf {
        self.marker = None;
        let aside = free(&self.target, "new", 1);
        if fs::rename(&self.partial, &aside).is_err() {
            return self.partial.clone();
        }
        let _ = fs::remove_file(MARKER.at(&aside));
        aside
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if self.marker.take().is_some() && !self.resumed {
            let _ = Contents::of(&self.partial, true).and_then(Contents::remove);
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
    let Ok(text) = fs::read(REPORT.at(path)) else { return false };
    let Ok(report) = serde_json::from_slice::<serde_json::Value>(&text) else { return false };
    report.get("method").is_some() && report.get("version").is_some() && STORE_ROOT.at(path).is_file()
}

/// Whether a folder is meant as a map, whole or damaged: no log looks so.
pub(crate) fn seems_map(path: &Path) -> bool {
    path.join(STORE).is_dir() || REPORT.at(path).is_file()
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
    let mut paths: Vec<PathBuf> = names.map(|e| e.path()).filter(|p| MARKER.at(p).exists()).collect();
    paths.sort();
    paths
}

/// Finishes what a killed run began: an old map returns if nothing took its place, else it goes.
fn recover(target: &Path) -> Result<()> {
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
    if entries.next().is_none() {
        return Ok(());
    }
    if !is_map(target) {
        return Err(unusable(target, "it holds files and is no echogrid map, so it is left as it is"));
    }
    check_foreign(target, target)
}

/// A map that holds anything but its own files is not replaced; `target` is its name.
fn check_foreign(map: &Path, target: &Path) -> Result<()> {
    let contents = Contents::of(map, false).map_err(|e| unusable(target, &e.to_string()))?;
    match contents.foreign() {
        None => Ok(()),
        Some(foreign) => {
            let what = format!("beside the files of a map it holds {foreign}");
            Err(blocked(target, &what, "move what is yours out of it"))
        }
    }
}

/// Makes the partial folder afresh, or opens it as it is to be gone on with, and locks its marker.
fn open_partial(partial: &Path, unfinished: Unfinished) -> Result<File> {
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
    MARKER.at(partial).exists() || empty
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

/// The first free name beside a folder, such as DIR.old-77, from a number on.
fn free(target: &Path, what: &str, from: u32) -> PathBuf {
    let name = |n: u32| beside(target, &format!(".{what}-{n}"));
    (from..).map(name).find(|path| fs::symlink_metadata(path).is_err()).unwrap_or_else(|| name(from))
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
