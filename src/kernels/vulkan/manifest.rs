//! The manifests of Vulkan drivers: where they lie, and what is wrong with one.

use super::library;
use std::path::{Path, PathBuf};

/// A driver's manifest.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Manifest {
    /// Where it lies.
    pub file: PathBuf,
    /// What is wrong with it, if something is.
    pub problem: Option<String>,
}

impl std::fmt::Display for Manifest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.problem.as_deref().unwrap_or("it is fine"))
    }
}

/// The folders of manifests, in the loader's order; `variable`: an environment variable's value, empty where it isn't set.
pub(super) fn folders(variable: impl Fn(&str) -> std::ffi::OsString) -> Vec<PathBuf> {
    let or = |name: &str, default: &str| match variable(name) {
        set if set.is_empty() => default.into(),
        set => set,
    };
    let home = PathBuf::from(variable("HOME"));
    let own = |name: &str, default: &str| PathBuf::from(or(name, &home.join(default).to_string_lossy()));
    let several = |name: &str, default: &str| std::env::split_paths(&or(name, default)).collect::<Vec<_>>();
    let mut all = vec![own("XDG_CONFIG_HOME", ".config")];
    all.extend(several("XDG_CONFIG_DIRS", "/etc/xdg"));
    all.extend(["/usr/local/etc".into(), "/etc".into(), own("XDG_DATA_HOME", ".local/share")]);
    all.extend(several("XDG_DATA_DIRS", "/usr/local/share:/usr/share"));
    let mut folders: Vec<PathBuf> = Vec::new();
    for folder in all.iter().filter(|f| f.is_absolute()).map(|f| f.join("vulkan/icd.d")) {
        if !folders.contains(&folder) {
            folders.push(folder);
        }
    }
    folders
}

/// What a path in a list stands for: itself, or a folder's manifests by their names.
pub(super) fn listed(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return vec![path.into()] };
    let mut files: Vec<PathBuf> =
        entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "json")).collect();
    files.sort();
    files
}

/// What is wrong with a manifest; nothing, if its driver can be opened or is one of another architecture.
pub(super) fn problem(file: &Path) -> Option<String> {
    let text = match std::fs::read(file) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Some("there is no such file".into()),
        Err(e) => return Some(format!("it can't be read ({e})")),
    };
    let manifest: serde_json::Value = match serde_json::from_slice(&text) {
        Ok(manifest) => manifest,
        Err(e) => return Some(format!("it is not JSON ({e})")),
    };
    let Some(name) = manifest["ICD"]["library_path"].as_str().filter(|name| !name.is_empty()) else {
        return Some("it names no library (ICD.library_path)".into());
    };
    // A name without a slash is looked for where the system keeps its libraries, another from the manifest's folder on.
    let path = match name.contains('/') {
        true => file.parent().unwrap_or(Path::new("")).join(name),
        false => name.into(),
    };
    if name.contains('/') && !path.exists() {
        return Some(format!("its library {} isn't there", path.display()));
    }
    let other = |why: &String| manifest["ICD"]["library_arch"] == "32" || why.contains("ELFCLASS");
    let why = library::driver(&path).err().filter(|why| !other(why))?;
    Some(format!("its library {} can't be used ({why})", path.display()))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_manifest_is_told_what_is_wrong_with_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("icd.json");
        assert_eq!(problem(&file).unwrap(), "there is no such file");
        std::fs::write(folder.path().join("text.so"), "no library").unwrap();
        for (text, what) in [
            ("", "it is not JSON (EOF while parsing"),
            ("{\"ICD\":", "it is not JSON (EOF while parsing a value at line 1 column 7)"),
            ("{}", "it names no library (ICD.library_path)"),
            ("{\"ICD\":{\"library_path\":7}}", "it names no library (ICD.library_path)"),
            ("{\"ICD\":{\"library_path\":\"./none.so\"}}", "none.so isn't there"),
            ("{\"ICD\":{\"library_path\":\"/nowhere/none.so\"}}", "its library /nowhere/none.so isn't there"),
            (
                "{\"ICD\":{\"library_path\":\"libnosuchthing.so\"}}",
                "libnosuchthing.so can't be used (libnosuchthing.so: cannot open",
            ),
            ("{\"ICD\":{\"library_path\":\"./text.so\"}}", "text.so can't be used ("),
            ("{\"ICD\":{\"library_path\":\"libc.so.6\"}}", "libc.so.6 can't be used (it is no Vulkan driver)"),
        ] {
            std::fs::write(&file, text).unwrap();
            let told = problem(&file).unwrap();
            assert!(told.contains(what), "{text}: {told}");
        }
        std::fs::write(&file, "{\"ICD\":{\"library_path\":\"./text.so\",\"library_arch\":\"32\"}}").unwrap();
        assert_eq!(problem(&file), None, "a driver of another architecture is no fault");
    }

    #[test]
    fn where_manifests_are_looked_for() {
        let of = |name: &str| match name {
            "HOME" => "/home/me".into(),
            "XDG_DATA_DIRS" => "/opt/share:/usr/share:/opt/share".into(),
            _ => std::ffi::OsString::new(),
        };
        let shown: Vec<String> = folders(of).iter().map(|f| f.display().to_string()).collect();
        assert_eq!(
            shown,
            [
                "/home/me/.config/vulkan/icd.d",
                "/etc/xdg/vulkan/icd.d",
                "/usr/local/etc/vulkan/icd.d",
                "/etc/vulkan/icd.d",
                "/home/me/.local/share/vulkan/icd.d",
                "/opt/share/vulkan/icd.d",
                "/usr/share/vulkan/icd.d"
            ]
        );
    }
}
