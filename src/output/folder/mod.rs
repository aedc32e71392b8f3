//! The output folder. A map is written to `DIR.partial/`, which is renamed to `DIR` at the end, so that a killed run leaves the old map
//! or the new one, never half of either.
//!
//! The old map is renamed to `DIR.old-PID` first; the next [`Folder::prepare`] mends a run that was killed between the two renames.
//! Files that echogrid didn't write are never removed: a folder that holds any ([`Contents`]) is refused, before the run and once more at
//! its end.

mod errors;
mod partial;
mod paths;
mod recover;
mod target;

pub(super) use recover::leftovers;
pub(super) use target::is_map;
pub(crate) use target::seems_map;

use super::contents::Contents;
use super::names::{MARKER, RUN};
use crate::{Error, Result};
use errors::unusable;
use partial::open_partial;
use paths::{beside, free, parent_of, resolve};
use recover::recover;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use target::{check_foreign, check_target};

/// What to do with an unfinished map that a killed run left beside the output folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unfinished {
    /// Refuse it with an error.
    #[default]
    Refuse,
    /// Keep it, to resume it.
    Resume,
    /// Remove it.
    Discard,
}

/// An output folder that is being written. Dropped without [`Folder::finish`], it removes its partial folder and the parents that it
/// made.
#[derive(Debug)]
pub struct Folder {
    target: PathBuf,
    partial: PathBuf,
    /// The marker file in the partial folder. A folder beside DIR without it is not echogrid's: `map.old-2024` may be the user's. It
    /// is held open for its lock, which a second run on the same folder sees.
    marker: Option<File>,
    /// Whether the partial folder holds the work of an earlier run, which no error may remove.
    resumed: bool,
    /// The parent folders that were made for it, the innermost first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Checks, before the long run, that `path` may become a map, and creates `path.partial` beside it.
    ///
    /// # Errors
    /// As [`Folder::open`].
    pub fn prepare(path: &Path) -> Result<Folder> {
        Folder::open(path, Unfinished::Refuse)
    }

    /// Checks that `path` may become a map, and creates nothing.
    ///
    /// # Errors
    /// [`Error::Resources`] where it holds files other than those of an echogrid map; it names them.
    pub fn check(path: &Path) -> Result<()> {
        check_target(&resolve(path)?)
    }

    /// As [`Folder::prepare`]; `unfinished`: what to do with an unfinished map that a killed run left in `path.partial`.
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

    /// Keeps the partial folder, so that it can be resumed, and releases its lock.
    pub fn keep(mut self) {
        self.marker = None;
    }

    /// The folder to write the files to.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Renames the partial folder to the user's, in place of an older map, and returns its path.
    ///
    /// # Errors
    /// [`Error::Resources`] where that can't be done, or where files that aren't the older map's have come into the folder meanwhile. The
    /// new map is kept beside the folder then, and the error says where.
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
        // Under its new name nobody adds to the old map: files that came since the first check are seen now.
        let checked = if replaces { check_foreign(&old, &self.target) } else { Ok(()) };
        if let Err(error) = checked.and_then(|()| fs::rename(&self.partial, &self.target).map_err(place)) {
            if replaces {
                fs::rename(&old, &self.target).map_err(place)?;
                let _ = fs::remove_file(MARKER.at(&self.target));
            }
            return Err(error);
        }
        self.marker = None;
        // The map is complete. The next run removes what can't be removed here.
        let _ = fs::remove_file(MARKER.at(&self.target));
        if replaces {
            let _ = Contents::of(&old, false).and_then(Contents::remove);
        }
        Ok(())
    }

    /// Renames the partial folder to a name that no run removes, and returns it; where that fails it keeps its name.
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
        // Only empty folders can be removed: a parent that holds anything stays.
        for folder in &self.made {
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}
