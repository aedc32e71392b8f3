//! The names of all files that a map's folder may hold. Outputs take their names from here, and [`Folder`](super::Folder) tells
//! a map's own files by them: no other file is ever removed.

use crate::pipeline::out_of_core;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// A file's name in a map's folder; `*` stands for a layer's name, `#` for a number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Name(&'static str);

/// Constants of names, and a list of them all, so that no name is missing in the list.
macro_rules! names {
    ($all:ident: $($(#[$about:meta])* $name:ident = $text:expr;)*) => {
        $($(#[$about])* pub(crate) const $name: Name = Name($text);)*
        const $all: &[Name] = &[$($name),*];
    };
}

names! { MAP:
    /// What was run, and what came out.
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
    /// What method features found.
    FEATURES = "features.geojson";
    FEATURES_PICTURE = "features.svg";
    /// The store. zarrs makes the names in it.
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
    /// A folder that is being written, or was replaced, bears it.
    MARKER = ".echogrid-partial";
}

names! { STEPS:
    /// What a run is, and the chunks that it has finished; both go when the map is whole.
    RUN = "run.json";
    PROGRESS = "progress.jsonl";
    /// What the rounds before the last have found.
    FOUND = out_of_core::FOUND;
    FOUND_PARTIAL = out_of_core::FOUND_PARTIAL;
    /// Pictures under way.
    CANVAS = "*.canvas";
    OVERVIEW_CANVAS = "overview-#.canvas";
    FEATURES_PARTIAL = "features.geojson.partial";
    FEATURES_PICTURE_PARTIAL = "features.svg.partial";
}

/// The store's folder.
pub(crate) const STORE: &str = "map.zarr";

/// Every name that the report of a map of these layers may list, sorted.
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

/// Whether a file or a folder is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    File,
    Folder,
}

impl Name {
    /// The file in a folder; for a name that has no gap.
    pub fn at(self, folder: &Path) -> PathBuf {
        folder.join(self.0)
    }

    /// The name for a layer, or a number.
    pub fn of(self, what: impl Display) -> String {
        self.0.replace(['*', '#'], &what.to_string())
    }

    /// Whether it is the name of such a file, or of a folder on the way to it, by the path's parts.
    fn fits(self, parts: &[&str], layers: &[String]) -> Option<Kind> {
        let mut own = self.0.split('/');
        let along = parts.iter().all(|part| own.next().is_some_and(|own| fits(own, part, layers)));
        along.then(|| if own.next().is_some() { Kind::Folder } else { Kind::File })
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

/// What may lie in a folder: a whole map's files, or those of one that is being written, too.
#[derive(Debug, Clone, Default)]
pub(super) struct Own {
    /// The map's layers.
    pub layers: Vec<String>,
    /// The files that the map's report lists; maps of older versions list none, and each name of the program's is theirs.
    pub listed: Option<Vec<String>>,
    /// Whether it is being written.
    pub partial: bool,
}

impl Own {
    /// What a path, by its parts, is to the map; `None`: it isn't the map's.
    pub fn kind(&self, parts: &[&str]) -> Option<Kind> {
        let find = |names: &[Name]| names.iter().find_map(|name| name.fits(parts, &self.layers));
        if let (true, Some(kind)) = (self.partial, find(STEPS)) {
            return Some(kind);
        }
        let listed = |name: &str| self.listed.as_ref().is_none_or(|all| all.iter().any(|n| n == name));
        match (find(MAP)?, parts) {
            (Kind::File, [name]) if !self.partial && !listed(name) => find(UNLISTED),
            (kind, _) => Some(kind),
        }
    }
}

/// What a report doesn't list.
const UNLISTED: &[Name] = &[REPORT, WORKING, WORKING_PICTURE, MARKER];

#[cfg(test)]
mod tests {
    use super::*;

    fn own(partial: bool, listed: Option<&[&str]>) -> Own {
        let listed = listed.map(|names| names.iter().map(|n| n.to_string()).collect());
        Own { layers: vec!["p_occ".into(), "class".into()], listed, partial }
    }

    #[test]
    fn a_map_s_names() {
        let own = own(false, None);
        let kind = |path: &str| own.kind(&path.split('/').collect::<Vec<_>>());
        for file in ["report.json", "class.png", "p_occ.npy", "map.png", "working-12.json", "map.zarr/x/c/0"] {
            assert_eq!(kind(file), Some(Kind::File), "{file}");
        }
        for file in ["map.zarr/class/c/0/17", "map.zarr/overview/3/c/1/2", "map.zarr/overview/zarr.json"] {
            assert_eq!(kind(file), Some(Kind::File), "{file}");
        }
        for folder in ["map.zarr", "map.zarr/class", "map.zarr/class/c/0", "map.zarr/overview/11"] {
            assert_eq!(kind(folder), Some(Kind::Folder), "{folder}");
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
        assert_eq!((kind("class.png"), kind("class.npy")), (Some(Kind::File), None));
        assert_eq!((kind("report.json"), kind("working-3.png")), (Some(Kind::File), Some(Kind::File)));
        assert_eq!((kind("map.zarr"), kind("map.zarr/class/c/0/0")), (Some(Kind::Folder), Some(Kind::File)));
    }

    #[test]
    fn steps_are_a_partial_map_s_alone() {
        let own = own(true, None);
        for step in ["run.json", "progress.jsonl", "class.canvas", "overview-0.canvas", "class.npy", "found.bin"] {
            assert_eq!(own.kind(&[step]), Some(Kind::File), "{step}");
        }
        assert_eq!((own.kind(&["notes.txt"]), own.kind(&["other.canvas"])), (None, None));
    }
}
