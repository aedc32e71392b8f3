//! Writing a finished map: a folder with a Zarr store, pictures, a map for ROS 2, and a report. One format a file; each
//! writes into the folder it is given, and [`Folder`] alone decides when that folder becomes the user's.

mod folder;
mod npy;
mod png;
mod report;
mod ros;
mod working;
mod zarr;

pub use folder::Folder;
pub use png::write_picture;
pub use report::{BadLines, Cells, LayerReport, LogInfo, Report, RunInfo, SensorReport, parameters, peak_memory, tidy};
pub use ros::read_ros;
pub use working::write_working;
pub use zarr::{StoredMap, read_map};

use crate::grid::{Layer, Map};
use crate::{Error, Result};
use std::path::Path;
use std::time::Instant;

/// Writes every file of a map into an open folder, the report last, and returns that report. The folder becomes the
/// user's with [`Folder::finish`].
///
/// `npy` adds one `.npy` file a layer.
/// `combined` is drawn as `map.png`.
pub fn write_map(folder: &Folder, map: &Map, combined: &Layer, info: &RunInfo, npy: bool) -> Result<Report> {
    let start = Instant::now();
    check(map)?;
    let place = folder.path();
    for layer in &map.layers {
        // A layer of that name is the combined one, drawn below.
        if layer.name != "map" {
            write_picture(&place.join(format!("{}.png", layer.name)), map, layer)?;
        }
    }
    write_picture(&place.join("map.png"), map, combined)?;
    ros::write(place, map)?;
    if npy {
        for layer in &map.layers {
            npy::write(&place.join(format!("{}.npy", layer.name)), &map.grid, &layer.data)?;
        }
    }
    zarr::write(&place.join("map.zarr"), map, info)?;
    let mut report = Report::new(map, info);
    report.seconds.push(("write".into(), start.elapsed().as_secs_f64()));
    report::write(&place.join("report.json"), &report)?;
    Ok(report)
}

/// What every writer relies on: layers of the grid's size, names that are file names, the two layers of every map.
fn check(map: &Map) -> Result<()> {
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

/// "PATH can't be written: CAUSE" with what to do about it: every writer's error.
fn unwritable(path: &Path, cause: impl std::fmt::Display) -> Error {
    let path = path.display();
    Error::Resources(format!("{path} can't be written: {cause}; free space there, or give another folder with -o"))
}
