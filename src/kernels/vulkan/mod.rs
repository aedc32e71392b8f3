//! Why the Vulkan loader finds no adapter: it is not installed, there is no driver, or a driver's manifest (a JSON file that names
//! the driver's library) is broken. The loader itself says nothing of it unless `VK_LOADER_DEBUG` is set.
//!
//! The manifests are looked for where the loader does. Windows and macOS have other places, and other adapters than Vulkan's.

mod library;
mod manifest;

pub use manifest::Manifest;

use super::adapter::REMEDY;
use manifest::{folders, listed, problem};
use std::path::PathBuf;

/// Variables that name the manifests instead of the folders; the first that is set counts.
const NAMED: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];
/// Variables by which the loader leaves drivers out.
const FILTERS: [&str; 2] = ["VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"];
/// The most broken manifests that a message names.
const MOST_NAMED: usize = 3;

/// What the Vulkan loader finds on this machine.
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
        let broken: Vec<String> = self.broken().take(MOST_NAMED).map(Manifest::to_string).collect();
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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

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
