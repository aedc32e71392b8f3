//! An open map whose cells stay on disk until they are needed; its description is in memory.

use super::piece::Pieces;
use super::{Cause, OVERVIEW, Tried, read, reduced};
use crate::grid::{GridSpec, Scale};
use crate::output::names::{REPORT, STORE};
use crate::{Error, Result};
use serde_json::Value;
use std::path::{Path, PathBuf};
use zarrs::array::Array;
use zarrs::filesystem::FilesystemStore;

/// A layer of a stored map.
pub(crate) struct StoredLayer {
    /// Its name.
    pub name: String,
    /// What it is, in which unit.
    pub about: String,
    /// Its colours.
    pub scale: Scale,
    /// The value where no reading reached.
    pub fill: f64,
    /// Its values, to be read piece by piece.
    pub pieces: Pieces,
}

/// A map on disk of which only the description has been read.
pub(crate) struct Stored {
    /// Its folder.
    pub path: PathBuf,
    /// The cells.
    pub grid: GridSpec,
    /// Its method.
    pub method: String,
    /// `report.json`.
    pub report: Value,
    /// Its layers.
    pub layers: Vec<StoredLayer>,
    /// The levels of the overview: the combined layer's palette entries on a scale from −1 to 1, each level half the size of the one
    /// before. Empty for a map without an overview.
    pub overview: Vec<Pieces>,
}

impl Stored {
    /// Opens a map's folder. The time does not depend on the size of the map.
    ///
    /// # Errors
    /// [`Error::Input`] if it is no map, or its description can't be read.
    pub fn open(path: &Path) -> Result<Stored> {
        let (zarr, report) = (path.join(STORE), REPORT.at(path));
        if !zarr.is_dir() || !report.is_file() {
            let what = "it is no echogrid map: a folder with report.json and map.zarr is wanted";
            return Err(Error::input(path, what));
        }
        let anew = |e: Cause| format!("it can't be read: {e}; map the log anew");
        let text = std::fs::read(&report).map_err(|e| Error::input(&report, e.to_string()))?;
        let report = serde_json::from_slice(&text).map_err(|e| Error::input(&report, anew(e.into())))?;
        Stored::read(path, &zarr, report).map_err(|e| Error::input(&zarr, anew(e)))
    }

    fn read(path: &Path, zarr: &Path, report: Value) -> Tried<Stored> {
        let reader = read::StoreReader::open(zarr)?;
        let (grid, method) = (reader.grid, reader.method());
        if grid.cells() == 0 {
            return Err("it has no cell".into());
        }
        let levels = overview(&reader, zarr)?;
        let fills: Vec<f64> = (0..reader.names().len()).map(|k| reader.fill(k)).collect();
        let layer = |((name, array), fill): ((String, Array<FilesystemStore>), f64)| -> Tried<StoredLayer> {
            let about = array.attributes().get("long_name").and_then(Value::as_str).unwrap_or_default().to_string();
            let (scale, folder) = (read::scale(&array), zarr.join(&name));
            Ok(StoredLayer { name, about, scale, fill, pieces: Pieces::of(array, folder)? })
        };
        let layers = reader.arrays().zip(fills).map(layer).collect::<Tried<_>>()?;
        Ok(Stored { path: path.into(), grid, method, report, layers, overview: levels })
    }

    /// The index of a layer.
    pub fn layer(&self, name: &str) -> Option<usize> {
        self.layers.iter().position(|l| l.name == name)
    }

    /// The size of all layers' values in memory, bytes.
    pub fn bytes(&self) -> u64 {
        let cell: usize = self.layers.iter().map(|l| l.pieces.value_bytes()).sum();
        cell as u64 * self.grid.cells() as u64
    }
}

/// Opens the levels of the overview that its group lists.
fn overview(reader: &read::StoreReader, zarr: &Path) -> Tried<Vec<Pieces>> {
    let folder = zarr.join(OVERVIEW);
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let count = reader.levels(OVERVIEW)?;
    let level = |k: usize| -> Tried<Pieces> {
        let pieces = Pieces::of(reader.array(&format!("{}/{k}", OVERVIEW))?, folder.join(k.to_string()))?;
        match pieces.extent() == reduced(&reader.grid, 1 << k) {
            true => Ok(pieces),
            false => Err(format!("level {k} of its overview doesn't fit its layers").into()),
        }
    };
    (0..count).map(level).collect()
}
