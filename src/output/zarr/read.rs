//! Reads a map's folder back.

use super::{SHARD, Tried};
use crate::grid::{ChunkId, chunks, part};
use crate::grid::{Data, GridSpec, Layer, Map, Palette, Scale};
use crate::output::folder;
use crate::output::names::{REPORT, STORE};
use crate::{Error, Result};
use rayon::prelude::*;
use serde_json::{Map as Object, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::data_type::{Float32DataType, Int8DataType, UInt8DataType, UInt32DataType};
use zarrs::array::{Array, ElementOwned};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::Group;

/// A map read back from its folder.
#[derive(Debug, Clone)]
pub struct StoredMap {
    /// The map. Its layers' `about` is empty: that text is in the arrays' `long_name`.
    pub map: Map,
    /// The store's attributes: method, parameters, the log's checksum, the grid.
    pub attributes: Object<String, Value>,
    /// `report.json`.
    pub report: Value,
}

/// Reads a map's folder back: every layer, the grid, the attributes and the report.
///
/// # Errors
/// [`Error::Input`] if it is no map, or is damaged.
pub fn read_map(path: &Path) -> Result<StoredMap> {
    if !folder::is_map(path) {
        let what = match folder::leftovers(path).as_slice() {
            [] => "it is no echogrid map: a folder with report.json and map.zarr is wanted".into(),
            [old, ..] => format!("a killed run left the map at {}: move it back", old.display()),
        };
        return Err(Error::input(path, what));
    }
    read_folder(path).map_err(|e| Error::input(path.join(STORE), format!("it can't be read: {e}")))
}

fn read_folder(path: &Path) -> Tried<StoredMap> {
    let report: Value = serde_json::from_slice(&std::fs::read(REPORT.at(path))?)?;
    let reader = StoreReader::open(&path.join(STORE))?;
    let layers = (0..reader.arrays.len()).map(|k| reader.layer(k)).collect::<Tried<Vec<Layer>>>()?;
    let method = reader.method();
    let attributes = reader.attributes;
    let updates = attributes.get("updates").and_then(Value::as_u64).unwrap_or_default();
    let increments = serde_json::from_value(report["increments"].clone()).unwrap_or_default();
    let map = Map { grid: reader.grid, method, layers, updates, increments };
    Ok(StoredMap { map, attributes, report })
}

/// An open store.
pub(in crate::output) struct StoreReader {
    path: PathBuf,
    store: Arc<FilesystemStore>,
    /// The cells.
    pub grid: GridSpec,
    attributes: Object<String, Value>,
    arrays: Vec<Array<FilesystemStore>>,
    names: Vec<String>,
}

impl StoreReader {
    /// Opens a store's layers.
    pub fn open(path: &Path) -> Tried<StoreReader> {
        let store = Arc::new(FilesystemStore::new(path)?);
        let attributes = Group::open(store.clone(), "/")?.attributes().clone();
        let grid = read_grid(&attributes).ok_or("its attributes don't describe a grid")?;
        let names = attributes.get("layers").and_then(Value::as_array).ok_or("its attributes don't name its layers")?;
        let names: Vec<String> = names.iter().filter_map(Value::as_str).map(String::from).collect();
        let array = |name: &String| -> Tried<Array<FilesystemStore>> {
            let array = Array::open(store.clone(), &format!("/{name}"))?;
            if array.shape() != [grid.height as u64, grid.width as u64] {
                let shape = array.shape();
                return Err(format!("layer {name} is {shape:?}, the grid {} by {}", grid.height, grid.width).into());
            }
            Ok(array)
        };
        let arrays = names.iter().map(array).collect::<Tried<_>>()?;
        Ok(StoreReader { path: path.into(), store, grid, attributes, arrays, names })
    }

    /// The method's name.
    pub fn method(&self) -> String {
        self.attributes.get("method").and_then(Value::as_str).unwrap_or_default().to_string()
    }

    /// Opens another array of the store.
    pub(super) fn array(&self, name: &str) -> Tried<Array<FilesystemStore>> {
        Ok(Array::open(self.store.clone(), &format!("/{name}"))?)
    }

    /// The number of levels of a group of the store.
    pub(super) fn levels(&self, name: &str) -> Tried<usize> {
        let group = Group::open(self.store.clone(), &format!("/{name}"))?;
        let levels = group.attributes().get("ome").and_then(|ome| ome["multiscales"][0]["datasets"].as_array());
        Ok(levels.map_or(0, Vec::len).min(25))
    }

    /// The arrays of the layers, each with its name.
    pub(super) fn arrays(self) -> impl Iterator<Item = (String, Array<FilesystemStore>)> {
        self.names.into_iter().zip(self.arrays)
    }

    /// The layers' names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The stored size of a layer's shard, bytes; `None`: it is not stored, as all of it is the fill value.
    pub fn stored(&self, layer: usize, ChunkId { row, column }: ChunkId) -> Option<u64> {
        let file = self.path.join(&self.names[layer]).join(format!("c/{row}/{column}"));
        std::fs::metadata(file).ok().map(|m| m.len())
    }

    /// A layer's fill value.
    pub fn fill(&self, layer: usize) -> f64 {
        let array = &self.arrays[layer];
        let kind = array.data_type();
        match *array.fill_value().as_ne_bytes() {
            [a, b, c, d] if kind.is::<Float32DataType>() => f64::from(f32::from_ne_bytes([a, b, c, d])),
            [a, b, c, d] => f64::from(u32::from_ne_bytes([a, b, c, d])),
            [a, ..] if kind.is::<Int8DataType>() => f64::from(a as i8),
            [a, ..] => f64::from(a),
            [] => 0.0,
        }
    }

    /// Reads a whole layer.
    pub fn layer(&self, layer: usize) -> Tried<Layer> {
        let shards: Vec<ChunkId> = chunks(&self.grid).collect();
        let parts = shards.into_par_iter().map(|at| Ok((at, self.shard(layer, at)?))).collect::<Tried<Vec<_>>>()?;
        let Some((_, first)) = parts.first() else { return Err("the grid has no cell".into()) };
        fn paste<T: Copy>(all: &mut [T], grid: &GridSpec, chunk: ChunkId, values: &[T]) {
            let width = part(grid, chunk).width;
            for (k, line) in values.chunks_exact(width).enumerate() {
                let at = (chunk.row as usize * SHARD + k) * grid.width + chunk.column as usize * SHARD;
                all[at..at + width].copy_from_slice(line);
            }
        }
        let cells = self.grid.cells();
        let mut data = match first.data {
            Data::F32(_) => Data::F32(vec![0.0; cells]),
            Data::U32(_) => Data::U32(vec![0; cells]),
            Data::U8(_) => Data::U8(vec![0; cells]),
            Data::I8(_) => Data::I8(vec![0; cells]),
        };
        for (at, part) in &parts {
            match (&mut data, &part.data) {
                (Data::F32(all), Data::F32(v)) => paste(all, &self.grid, *at, v),
                (Data::U32(all), Data::U32(v)) => paste(all, &self.grid, *at, v),
                (Data::U8(all), Data::U8(v)) => paste(all, &self.grid, *at, v),
                (Data::I8(all), Data::I8(v)) => paste(all, &self.grid, *at, v),
                _ => return Err(format!("the shards of layer {} differ in type", first.name).into()),
            }
        }
        Ok(Layer { data, name: first.name.clone(), ..*first })
    }

    /// Reads a layer's part in a shard. The whole shard is read, so that every checksum is tested.
    pub fn shard(&self, layer: usize, at: ChunkId) -> Tried<Layer> {
        let (array, name) = (&self.arrays[layer], &self.names[layer]);
        let GridSpec { width, height, .. } = part(&self.grid, at);
        let at = [at.row, at.column].map(u64::from);
        fn all<T: ElementOwned + Copy>(
            array: &Array<FilesystemStore>,
            at: &[u64],
            width: usize,
            height: usize,
        ) -> Tried<Vec<T>> {
            let shard: Vec<T> = array.retrieve_chunk(at)?;
            Ok(shard.chunks_exact(SHARD).take(height).flat_map(|row| row[..width].iter().copied()).collect())
        }
        let kind = array.data_type();
        let data = if kind.is::<Float32DataType>() {
            Data::F32(all(array, &at, width, height)?)
        } else if kind.is::<UInt32DataType>() {
            Data::U32(all(array, &at, width, height)?)
        } else if kind.is::<UInt8DataType>() {
            Data::U8(all(array, &at, width, height)?)
        } else if kind.is::<Int8DataType>() {
            Data::I8(all(array, &at, width, height)?)
        } else {
            return Err(format!("layer {name} has a data type that echogrid doesn't write: {kind:?}").into());
        };
        Ok(Layer { name: name.clone(), about: "", data, fill: self.fill(layer), scale: scale(array) })
    }
}

/// The colour scale of a layer.
pub(super) fn scale(array: &Array<FilesystemStore>) -> Scale {
    let ends = array.attributes().get("colour_range").and_then(Value::as_array);
    let end = |k: usize, default: f64| ends.and_then(|e| e.get(k)).and_then(Value::as_f64).unwrap_or(default);
    match array.attributes().get("scale").and_then(Value::as_str) {
        Some("signed") => Scale::Signed { limit: end(1, 1.0) },
        Some("heat") => Scale::Heat { low: end(0, 0.0), high: end(1, 1.0) },
        Some("classes") => {
            let colours = array.attributes().get("class_colours").cloned().unwrap_or_default();
            let colours: Vec<[u8; 3]> = serde_json::from_value(colours).unwrap_or_default();
            Scale::Classes(Palette::of(&colours).unwrap_or(Palette::plain()))
        }
        _ => Scale::Grey { low: end(0, 0.0), high: end(1, 1.0) },
    }
}

fn read_grid(attributes: &Object<String, Value>) -> Option<GridSpec> {
    let pair =
        |key: &str| attributes.get(key)?.as_array().filter(|a| a.len() == 2).map(|a| (a[0].clone(), a[1].clone()));
    let (anchor, first, size) = (pair("anchor")?, pair("first_cell")?, pair("size")?);
    Some(GridSpec {
        anchor: (anchor.0.as_f64()?, anchor.1.as_f64()?),
        resolution: attributes.get("resolution")?.as_f64()?,
        i0: first.0.as_i64()?,
        j0: first.1.as_i64()?,
        width: usize::try_from(size.0.as_u64()?).ok()?,
        height: usize::try_from(size.1.as_u64()?).ok()?,
    })
}
