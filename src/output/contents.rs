//! What lies in a map's folder: the map's own files, and those of others, which nothing here removes.

use super::names::{Kind, MARKER, Own, REPORT, RUN, STORE_ROOT};
use serde_json::Value;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// So many names stand in a message.
const SHOWN: usize = 3;

/// A folder's files, the map's own and others'.
#[derive(Debug, Default)]
pub(super) struct Contents {
    folder: PathBuf,
    files: Vec<PathBuf>,
    /// Each before those inside it.
    folders: Vec<PathBuf>,
    foreign: Vec<String>,
}

impl Contents {
    /// Of a folder that holds a map, or, if `partial`, one that is being written.
    pub fn of(folder: &Path, partial: bool) -> io::Result<Contents> {
        let own = own(folder, partial);
        let mut contents = Contents { folder: folder.into(), ..Contents::default() };
        contents.look(&own, folder, &mut Vec::new())?;
        contents.foreign.sort();
        Ok(contents)
    }

    fn look(&mut self, own: &Own, folder: &Path, above: &mut Vec<String>) -> io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let (name, kind) = (entry.file_name(), entry.file_type()?);
            let parts = name.to_str().map(|name| above.iter().map(String::as_str).chain([name]).collect::<Vec<_>>());
            match parts.and_then(|parts| own.kind(&parts)) {
                Some(Kind::File) if kind.is_file() => self.files.push(entry.path()),
                Some(Kind::Folder) if kind.is_dir() => {
                    self.folders.push(entry.path());
                    above.push(name.to_string_lossy().into_owned());
                    self.look(own, &entry.path(), above)?;
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

    /// Names of what isn't the map's, for a message; `None`: there is nothing.
    pub fn foreign(&self) -> Option<String> {
        let shown = self.foreign.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
        match self.foreign.len() {
            0 => None,
            n if n > SHOWN => Some(format!("{shown} and {} more", n - SHOWN)),
            _ => Some(shown),
        }
    }

    /// Removes the map's own files, and the folder if nothing else is in it. Killed halfway, it leaves what is no map any more, but
    /// still known by its layers and its marker.
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

/// What may lie in a folder, by what its report, or its unfinished run, says.
fn own(folder: &Path, partial: bool) -> Own {
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
    Own { layers, listed: texts(&report["files"]), partial }
}
