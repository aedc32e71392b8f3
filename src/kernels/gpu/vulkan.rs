//! Why the Vulkan loader finds no adapter: it is not there, there is no driver, or a driver's file (a manifest in JSON that names
//! the driver's library) is broken. The loader itself says nothing of it unless `VK_LOADER_DEBUG` is set.
//!
//! The manifests are looked for where the loader does. Windows and macOS have other places, and other adapters than Vulkan's.

use super::adapter::REMEDY;
use std::path::{Path, PathBuf};

/// Variables that name the manifests instead of the folders; the first that is set counts.
const NAMED: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];
/// Variables by which the loader leaves drivers out.
const FILTERS: [&str; 2] = ["VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"];
/// Broken files that a message tells.
const TOLD: usize = 3;

/// A driver's manifest.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Manifest {
    /// Where it lies.
    pub file: PathBuf,
    /// What is wrong with it, if something is.
    pub problem: Option<String>,
}

/// What the Vulkan loader has to go by.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct Drivers {
    /// Why the loader's library can't be opened; `None`: it can.
    pub no_loader: Option<String>,
    /// The environment variable that names the drivers, if one is set.
    pub named_by: Option<&'static str>,
    /// The folders that were searched, where none is.
    pub folders: Vec<PathBuf>,
    /// The manifests, in the loader's order.
    pub manifests: Vec<Manifest>,
}

impl Drivers {
    /// Looks for the loader and its drivers.
    pub fn look() -> Drivers {
        let mut drivers = Drivers { no_loader: library::loader().err(), ..Drivers::default() };
        let set = |name: &&&str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
        drivers.named_by = NAMED.iter().find(set).copied();
        let list = |name: &str| -> Vec<PathBuf> {
            std::env::var_os(name).map_or_else(Vec::new, |v| std::env::split_paths(&v).collect())
        };
        let mut files: Vec<PathBuf> = list("VK_ADD_DRIVER_FILES").iter().flat_map(|path| listed(path)).collect();
        match drivers.named_by {
            Some(name) => files.extend(list(name).iter().flat_map(|path| listed(path))),
            None => {
                drivers.folders = folders(|name| std::env::var_os(name).unwrap_or_default());
                files.extend(drivers.folders.iter().filter(|f| f.is_dir()).flat_map(|f| listed(f)));
            }
        }
        files.retain(|file| !file.as_os_str().is_empty());
        drivers.manifests = files.into_iter().map(|file| Manifest { problem: problem(&file), file }).collect();
        drivers
    }

    /// The manifests that are broken.
    pub fn broken(&self) -> impl Iterator<Item = &Manifest> {
        self.manifests.iter().filter(|m| m.problem.is_some())
    }

    /// Why there is no adapter, and what to do about it.
    pub fn why_none(&self) -> String {
        const DEBUG: &str = "VK_LOADER_DEBUG=error shows what the Vulkan loader says";
        if cfg!(any(windows, target_os = "macos")) {
            return REMEDY.into();
        }
        if let Some(cause) = &self.no_loader {
            return format!(
                "the Vulkan loader can't be opened ({cause}): install it and a driver (Debian and Ubuntu: apt-get install \
                 libvulkan1, and mesa-vulkan-drivers for a software adapter), or use --backend cpu"
            );
        }
        let broken: Vec<String> = self.broken().take(TOLD).map(Manifest::to_string).collect();
        let broken = broken.join("; ");
        let filter = FILTERS.iter().find(|name| std::env::var_os(name).is_some());
        match (broken.is_empty(), self.named_by, filter) {
            (false, Some(name), _) => {
                format!(
                    "{name} names no driver that can be used ({broken}): mend it or unset {name}; {DEBUG}; or use --backend cpu"
                )
            }
            (false, None, _) => format!(
                "a Vulkan driver's file is broken ({broken}): mend it or take it away, or name the drivers to use by \
                 VK_DRIVER_FILES; {DEBUG}; or use --backend cpu"
            ),
            (true, _, Some(name)) => {
                format!(
                    "{name} is set, and leaves out every driver that finds one: unset it; {DEBUG}; or use --backend cpu"
                )
            }
            (true, Some(name), None) if self.manifests.is_empty() => {
                format!("{name} names no driver's file: mend it or unset it; {DEBUG}; or use --backend cpu")
            }
            (true, _, None) if self.manifests.is_empty() => REMEDY.into(),
            (true, _, None) => {
                let names: Vec<_> = self.manifests.iter().map(|m| m.file.display().to_string()).collect();
                format!("the Vulkan drivers find none here ({}); {DEBUG}; {REMEDY}", names.join(", "))
            }
        }
    }
}

impl std::fmt::Display for Manifest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.problem.as_deref().unwrap_or("it is fine"))
    }
}

/// The folders of manifests, in the loader's order; `variable`: an environment variable's value, empty where it isn't set.
fn folders(variable: impl Fn(&str) -> std::ffi::OsString) -> Vec<PathBuf> {
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
fn listed(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(path) else { return vec![path.into()] };
    let mut files: Vec<PathBuf> =
        entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "json")).collect();
    files.sort();
    files
}

/// What is wrong with a manifest; nothing, if its driver can be opened or is one of another architecture.
fn problem(file: &Path) -> Option<String> {
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

/// Whether libraries can be opened.
#[cfg(all(unix, not(target_os = "macos")))]
mod library {
    use libloading::Library;
    use std::path::Path;

    /// The Vulkan loader.
    pub fn loader() -> Result<(), String> {
        open(Path::new("libvulkan.so.1")).or_else(|why| open(Path::new("libvulkan.so")).map_err(|_| why)).map(drop)
    }

    /// A driver.
    pub fn driver(path: &Path) -> Result<(), String> {
        let library = open(path)?;
        let names: [&[u8]; 2] = [b"vk_icdGetInstanceProcAddr\0", b"vkGetInstanceProcAddr\0"];
        // SAFETY: the symbols' addresses are neither called nor read through.
        let found = names.iter().any(|name| unsafe { library.get::<*const ()>(name) }.is_ok());
        // Not closed: some drivers leave threads behind.
        std::mem::forget(library);
        if found { Ok(()) } else { Err("it is no Vulkan driver".into()) }
    }

    fn open(path: &Path) -> Result<Library, String> {
        // SAFETY: the libraries are those that the loader opens by itself, with what they do when they are opened.
        unsafe { Library::new(path) }.map_err(|e| e.to_string())
    }
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
mod library {
    use std::path::Path;

    pub fn loader() -> Result<(), String> {
        Ok(())
    }

    pub fn driver(_: &Path) -> Result<(), String> {
        Ok(())
    }
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

    #[test]
    fn the_reason_fits_what_is_there() {
        let broken = Manifest { file: "/x/a.json".into(), problem: Some("it is not JSON (…)".into()) };
        let fine = Manifest { file: "/x/b.json".into(), problem: None };
        let none = Drivers::default();
        for (drivers, begins, ends) in [
            (none.clone(), "install a GPU driver with Vulkan", "or use --backend cpu"),
            (
                Drivers { no_loader: Some("libvulkan.so.1: …".into()), ..none.clone() },
                "the Vulkan loader can't be opened (lib",
                "cpu",
            ),
            (
                Drivers { named_by: Some("VK_DRIVER_FILES"), manifests: vec![broken.clone()], ..none.clone() },
                "VK_DRIVER_FILES names no driver that can be used (/x/a.json: it is not JSON (…)): mend it or unset VK_DRIVER_FILES",
                "; VK_LOADER_DEBUG=error shows what the Vulkan loader says; or use --backend cpu",
            ),
            (
                Drivers { manifests: vec![fine.clone(), broken], ..none.clone() },
                "a Vulkan driver's file is broken (/x/a.json: it is not JSON (…)): mend it or take it away, or name",
                "; VK_LOADER_DEBUG=error shows what the Vulkan loader says; or use --backend cpu",
            ),
            (
                Drivers { manifests: vec![fine], ..none },
                "the Vulkan drivers find none here (/x/b.json); VK_LOADER",
                "cpu",
            ),
        ] {
            let why = drivers.why_none();
            assert!(why.starts_with(begins) && why.ends_with(ends), "{why}");
        }
    }
}
