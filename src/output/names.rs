//! The names of all files that a map's folder may hold. Every writer takes its names from here, and [`Folder`](super::Folder) recognizes a
//! map's own files by them; no other file is ever removed.

use crate::pipeline::out_of_core;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// The name of a file in a map's folder; `*` stands for a layer's name, `#` for a number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FileName(&'static str);

/// Defines constants of names together with a list of them, so that the list is complete.
macro_rules! names {
    ($all:ident: $($(#[$about:meta])* $name:ident = $text:expr;)*) => {
        $($(#[$about])* pub(crate) const $name: FileName = FileName($text);)*
        const $all: &[FileName] = &[$($name),*];
    };
}

names! { MAP:
    /// The report of the run.
    REPORT = "report.json";
    /// A map for ROS: its picture and its description.
    PGM = "map.pgm";
    YAML = "map.yaml";
    /// The combined layer's picture.
    PICTURE = "map.png";
    LAYER_PICTURE = "*.png";
    LAYER_ARRAY = "*.npy";
    /// A counting sensor model's layers side by side.
    FIGURE = "figure.svg";
    /// The features of method features.
    FEATURES = "features.geojson";
    FEATURES_PICTURE = "features.svg";
    /// The store. zarrs chooses the names in it.
    STORE_ROOT = "map.zarr/zarr.json";
    AXIS_X = "map.zarr/x/zarr.json";
    AXIS_X_CHUNK = "map.zarr/x/c/#";
    AXIS_Y = "map.zarr/y/zarr.json";
    AXIS_Y_CHUNK = "map.zarr/y/c/#";
    ARRAY = "map.zarr/*/zarr.json";
    ARRAY_SHARD = "map.zarr/*/c/#/#";
    OVERVIEW = "map.zarr/overview/zarr.json";
    OVERVIEW_LEVEL = "map.zarr/overview/#/zarr.json";
    OVERVIEW_SHARD = "map.zarr/overview/#/c/#/#";
    /// One reading explained. The report doesn't list these two: they are written after it.
    WORKING = "working-#.json";
    WORKING_PICTURE = "working-#.png";
    /// The marker of a folder that is being written, or was replaced.
    MARKER = ".echogrid-partial";
}

names! { STEPS:
    /// The description of a run, and the chunks that it has finished; both are removed when the map is whole.
    RUN = "run.json";
    PROGRESS = "progress.jsonl";
    /// The totals of readings from the rounds before the last.
    TOTALS = out_of_core::TOTALS;
    TOTALS_PARTIAL = out_of_core::TOTALS_PARTIAL;
    /// Pictures while they are written.
    CANVAS = "*.canvas";
    OVERVIEW_CANVAS = "overview-#.canvas";
    FEATURES_PARTIAL = "features.geojson.partial";
    FEATURES_PICTURE_PARTIAL = "features.svg.partial";
}

/// The store's folder.
pub(crate) const STORE: &str = "map.zarr";

/// The names that the report of a map of these layers may list, sorted.
pub(super) fn of(layers: &[String]) -> Vec<String> {
    let listed = MAP.iter().filter(|name| !name.0.contains(['/', '#']) && name.0 != MARKER.0);
    let mut all: Vec<String> = listed
        .flat_map(|name| match name.0.contains('*') {
            true => layers.iter().map(|layer| name.of(layer)).collect(),
            false => vec![name.0.to_string()],
        })
        .collect();
    all.sort();
    all.dedup();
    all
}

/// The kind of an entry of a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EntryKind {
    File,
    Folder,
}

impl FileName {
    /// The path in a folder, for a name without placeholder.
    pub fn at(self, folder: &Path) -> PathBuf {
        folder.join(self.0)
    }

    /// The name for a layer or a number, in place of the placeholder.
    pub fn of(self, what: impl Display) -> String {
        self.0.replace(['*', '#'], &what.to_string())
    }

    /// Matches a path, by its parts, with the name: a file, or a folder on the way to it; `None`: neither.
    fn fits(self, parts: &[&str], layers: &[String]) -> Option<EntryKind> {
        let mut own = self.0.split('/');
        let along = parts.iter().all(|part| own.next().is_some_and(|own| fits(own, part, layers)));
        along.then(|| if own.next().is_some() { EntryKind::Folder } else { EntryKind::File })
    }
}

/// Whether a part of a path fits a part of a name.
fn fits(own: &str, part: &str, layers: &[String]) -> bool {
    let Some(at) = own.find(['*', '#']) else { return own == part };
    let inner = part.strip_prefix(&own[..at]).and_then(|rest| rest.strip_suffix(&own[at + 1..]));
    inner.is_some_and(|inner| match own.as_bytes()[at] {
        b'*' => layers.iter().any(|layer| layer == inner),
        _ => inner.parse::<u64>().is_ok_and(|n| n.to_string() == inner),
    })
}

/// The names that a map may use in its folder.
#[derive(Debug, Clone, Default)]
pub(super) struct OwnNames {
    /// The map's layers.
    pub layers: Vec<String>,
    /// The files that the map's report lists; `None`: a map of an older version, which may use every name.
    pub listed: Option<Vec<String>>,
    /// Whether the map is being written, so that the files of a run count, too.
    pub partial: bool,
}

impl OwnNames {
    /// The kind of the map's entry at a path, by its parts; `None`: the path isn't the map's.
    pub fn kind(&self, parts: &[&str]) -> Option<EntryKind> {
        let find = |names: &[FileName]| names.iter().find_map(|name| name.fits(parts, &self.layers));
        if let (true, Some(kind)) = (self.partial, find(STEPS)) {
            return Some(kind);
        }
        let listed = |name: &str| self.listed.as_ref().is_none_or(|all| all.iter().any(|n| n == name));
        match (find(MAP)?, parts) {
            (EntryKind::File, [name]) if !self.partial && !listed(name) => find(UNLISTED),
            (kind, _) => Some(kind),
        }
    }
}

/// The names that a report doesn't list.
const UNLISTED: &[FileName] = &[REPORT, WORKING, WORKING_PICTURE, MARKER];

#[cfg(test)]
mod tests {
    use super::*;

    fn own(partial: bool, listed: Option<&[&str]>) -> OwnNames {
        let listed = listed.map(|names| names.iter().map(|n| n.to_string()).collect());
        OwnNames { layers: vec!["p_occ".into(), "class".into()], listed, partial }
    }

    #[test]
    fn a_map_s_names() {
        let own = own(false, None);
        let kind = |path: &str| own.kind(&path.split('/').collect::<Vec<_>>());
        for file in ["report.json", "class.png", "p_occ.npy", "map.png", "working-12.json", "map.zarr/x/c/0"] {
            assert_eq!(kind(file), Some(EntryKind::File), "{file}");
        }
        for file in ["map.zarr/class/c/0/17", "map.zarr/overview/3/c/1/2", "map.zarr/overview/zarr.json"] {
            assert_eq!(kind(file), Some(EntryKind::File), "{file}");
        }
        for folder in ["map.zarr", "map.zarr/class", "map.zarr/class/c/0", "map.zarr/overview/11"] {
            assert_eq!(kind(folder), Some(EntryKind::Folder), "{folder}");
        }
        for foreign in [
            "notes.txt",
            "other.png",
            "class.PNG",
            "class.png/x",
            "class",
            "working-x.png",
            "working-01.png",
            "working-.png",
            "map.zarr/other",
            "map.zarr/class/c/0/1/2",
            "map.zarr/class/notes",
            "map.zarr/c",
            "run.json",
            "class.canvas",
            ".DS_Store",
            "map.zarr/.zgroup",
        ] {
            assert_eq!(kind(foreign), None, "{foreign}");
        }
    }

    #[test]
    fn a_report_s_list_decides_where_there_is_one() {
        let own = own(false, Some(&["class.png", "map.png"]));
        let kind = |path: &str| own.kind(&path.split('/').collect::<Vec<_>>());
        assert_eq!((kind("class.png"), kind("class.npy")), (Some(EntryKind::File), None));
        assert_eq!((kind("report.json"), kind("working-3.png")), (Some(EntryKind::File), Some(EntryKind::File)));
        assert_eq!((kind("map.zarr"), kind("map.zarr/class/c/0/0")), (Some(EntryKind::Folder), Some(EntryKind::File)));
    }

    #[test]
    fn steps_are_a_partial_map_s_alone() {
        let own = own(true, None);
        for step in ["run.json", "progress.jsonl", "class.canvas", "overview-0.canvas", "class.npy", "found.bin"] {
            assert_eq!(own.kind(&[step]), Some(EntryKind::File), "{step}");
        }
        assert_eq!((own.kind(&["notes.txt"]), own.kind(&["other.canvas"])), (None, None));
    }
}
