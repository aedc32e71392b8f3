//! The contents of a map's folder: the map's own files, and foreign ones, which are never removed.

use super::names::{EntryKind, MARKER, OwnNames, REPORT, RUN, STORE_ROOT};
use serde_json::Value;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The most names of foreign files in a message.
const SHOWN: usize = 3;

/// The files of a folder, the map's own and foreign ones.
#[derive(Debug, Default)]
pub(super) struct Contents {
    folder: PathBuf,
    files: Vec<PathBuf>,
    /// The map's own folders, each before those inside it.
    folders: Vec<PathBuf>,
    foreign: Vec<String>,
}

impl Contents {
    /// Lists the contents of a folder that holds a map or, if `partial`, one that is being written.
    pub fn of(folder: &Path, partial: bool) -> io::Result<Contents> {
        let own = own_names(folder, partial);
        let mut contents = Contents { folder: folder.into(), ..Contents::default() };
        contents.list(&own, folder, &mut Vec::new())?;
        contents.foreign.sort();
        Ok(contents)
    }

    fn list(&mut self, own: &OwnNames, folder: &Path, above: &mut Vec<String>) -> io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let (name, kind) = (entry.file_name(), entry.file_type()?);
            let parts = name.to_str().map(|name| above.iter().map(String::as_str).chain([name]).collect::<Vec<_>>());
            match parts.and_then(|parts| own.kind(&parts)) {
                Some(EntryKind::File) if kind.is_file() => self.files.push(entry.path()),
                Some(EntryKind::Folder) if kind.is_dir() => {
                    self.folders.push(entry.path());
                    above.push(name.to_string_lossy().into_owned());
                    self.list(own, &entry.path(), above)?;
                    above.pop();
                }
                _ => {
                    let end = if kind.is_dir() { "/" } else { "" };
                    let above: String = above.iter().map(|part| format!("{part}/")).collect();
                    self.foreign.push(format!("{above}{}{end}", name.to_string_lossy()));
                }
            }
        }
        Ok(())
    }

    /// The names of foreign files, for a message; `None`: there are none.
    pub fn foreign(&self) -> Option<String> {
        let shown = self.foreign.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
        match self.foreign.len() {
            0 => None,
            n if n > SHOWN => Some(format!("{shown} and {} more", n - SHOWN)),
            _ => Some(shown),
        }
    }

    /// Removes the map's own files, and the folder if nothing else is in it. If it is killed halfway, the rest is no map any more, but
    /// still lists its layers and bears its marker.
    pub fn remove(mut self) -> io::Result<()> {
        let last = [REPORT, RUN, MARKER].map(|name| name.at(&self.folder));
        let root = STORE_ROOT.at(&self.folder);
        self.files.sort_by_key(|file| match last.iter().position(|l| l == file) {
            Some(place) => 2 + place,
            None => usize::from(*file != root),
        });
        let (most, end): (Vec<_>, Vec<_>) = self.files.iter().partition(|file| !last.contains(file));
        most.into_iter().try_for_each(fs::remove_file)?;
        for folder in self.folders.iter().rev() {
            match fs::remove_dir(folder) {
                Err(e) if e.kind() != io::ErrorKind::DirectoryNotEmpty => return Err(e),
                _ => {}
            }
        }
        end.into_iter().try_for_each(fs::remove_file)?;
        match self.foreign.is_empty() {
            true => fs::remove_dir(&self.folder),
            false => Ok(()),
        }
    }
}

/// The names that the map in a folder may use, by its report or by the description of its unfinished run.
fn own_names(folder: &Path, partial: bool) -> OwnNames {
    let read = |path: PathBuf| -> Value {
        fs::read(path).ok().and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default()
    };
    let texts = |list: &Value| -> Option<Vec<String>> {
        Some(list.as_array()?.iter().filter_map(Value::as_str).map(String::from).collect())
    };
    let report = read(REPORT.at(folder));
    let mut layers: Vec<String> = report["layers"].as_object().into_iter().flat_map(|l| l.keys().cloned()).collect();
    if partial {
        layers.extend(texts(&read(RUN.at(folder))["layers"]).unwrap_or_default());
    }
    OwnNames { layers, listed: texts(&report["files"]), partial }
}
