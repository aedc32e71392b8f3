//! Writes a finished map: a folder with a Zarr store, pictures, a map for ROS 2, and a report. Each format is a file here, and writes into
//! the folder that it is given; [`Folder`] alone decides when that folder becomes the user's.

mod check;
mod contents;
mod features;
mod figure;
mod folder;
pub(crate) mod names;
mod npy;
pub(crate) mod png;
mod raster;
mod report;
mod ros;
mod schema;
pub(crate) mod svg;
mod working;
mod writer;
mod zarr;

pub use check::{Checked, check};
pub use features::write_features;
pub(crate) use folder::seems_map;
pub use folder::{Folder, Unfinished};
pub use png::write_picture;
pub use report::{CellCounts, LayerReport, LogInfo, Report, RunInfo, SensorReport, parameters, peak_memory, tidy};
pub use ros::{RosMap, read_ros};
pub use schema::{MapSchema, crop, schema};
pub(crate) use working::{ConeOutline, own_is, weigher};
pub use working::{WorkingRequest, write_working};
pub use writer::{MapWriter, begun};
pub(crate) use zarr::{Pieces, Stored, StoredLayer};
pub use zarr::{StoredMap, read_map};

use crate::grid::{Layer, Map};
use crate::grid::{chunks, part};
use crate::{Error, Result};
use std::path::Path;

/// Writes every file of a map into an open folder, the report last, and returns the report. The folder becomes the user's with
/// [`Folder::finish`]. `combined` is drawn as `map.png`; `npy` adds one `.npy` file per layer.
///
/// # Errors
/// [`Error::Usage`] for a map whose layers can't be written, [`Error::Resources`] if a file can't be written.
pub fn write_map(folder: &Folder, map: &Map, combined: &Layer, info: &RunInfo, npy: bool) -> Result<Report> {
    writable(map)?;
    let layers = map.layers.iter().map(schema).collect();
    let schema = MapSchema { grid: map.grid, method: map.method.clone(), layers, combined: schema(combined), npy };
    let mut writer = MapWriter::open(folder.path(), schema, info, false)?;
    // The chunks' updates add up to the map's. Those of a part are not known, so that the first chunk takes all.
    let (mut updates, mut increments) = (map.updates, map.increments.clone());
    for at in chunks(&map.grid) {
        let layers = map.layers.iter().map(|layer| crop(&map.grid, layer, at)).collect();
        let part = Map {
            grid: part(&map.grid, at),
            method: map.method.clone(),
            layers,
            updates,
            increments: std::mem::take(&mut increments),
        };
        writer.chunk(at, &part, &crop(&map.grid, combined, at))?;
        updates = 0;
    }
    writer.finish(info)
}

/// Removes echogrid's files from a partial folder, and the folder if nothing else is in it.
pub(crate) fn discard(partial: &Path) {
    let _ = contents::Contents::of(partial, true).and_then(contents::Contents::remove);
}

/// Checks what every writer relies on: layers of the grid's size, names that are file names, the layers `touched` and `class`.
fn writable(map: &Map) -> Result<()> {
    let wrong = |what: String| Err(Error::Usage(format!("the map can't be written: {what}")));
    for layer in &map.layers {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if layer.name.is_empty() || !layer.name.chars().all(plain) || ["x", "y"].contains(&layer.name.as_str()) {
            return wrong(format!("\"{}\" is no layer name: letters, digits, _ and -, not x or y", layer.name));
        }
        if layer.data.len() != map.grid.cells() {
            let (found, cells) = (layer.data.len(), map.grid.cells());
            return wrong(format!("layer {} holds {found} values for {cells} cells", layer.name));
        }
    }
    for name in ["touched", "class"] {
        if map.layer(name).is_none() {
            return wrong(format!("it has no layer {name}"));
        }
    }
    Ok(())
}

/// The error of every writer: "PATH can't be written: CAUSE", and a remedy.
fn unwritable(path: &Path, cause: impl std::fmt::Display) -> Error {
    let path = path.display();
    Error::Resources(format!("{path} can't be written: {cause}; free space there, or give another folder with -o"))
}
