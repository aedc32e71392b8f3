//! `map.zarr`: every layer as a Zarr version 3 array that Python, Julia and JavaScript open, with the cell centres in
//! metres beside them, and reading it back.
//!
//! A shard is 1024 × 1024 cells in inner chunks of 256 × 256. Chunks wholly of the fill value are not stored: a huge map
//! costs what was seen of it. One writer a shard: two would lose each other's chunks silently.

use super::png::reduced;
use super::{RunInfo, folder, unwritable};
use crate::grid::{Data, GridSpec, Layer, Map, Palette, Scale};
use crate::whole::{Place, part, places};
use crate::{Error, Result};
use rayon::prelude::*;
use serde_json::{Map as Object, Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::codec::{Crc32cCodec, ShardingCodecOptions, SubchunkWriteOrder, ZstdCodec};
use zarrs::array::data_type::{self, Float32DataType, Int8DataType, UInt8DataType, UInt32DataType};
use zarrs::array::{
    Array, ArrayBuilder, ArrayMetadataOptions, BytesToBytesCodecTraits, CodecSpecificOptions, DataType, ElementOwned,
    FillValue,
};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::{Group, GroupBuilder};

const SHARD: usize = 1024;
const CHUNK: usize = 256;
/// Cells of x or y a chunk: one file each up to this size.
const AXIS: usize = 1 << 16;

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

/// Any of zarrs's errors: they all become one message.
pub(super) type Cause = Box<dyn std::error::Error + Send + Sync>;
pub(super) type Tried<T> = std::result::Result<T, Cause>;

/// A store under way: its arrays are there, chunks come one by one.
pub(super) struct Store {
    path: PathBuf,
    grid: GridSpec,
    store: Arc<FilesystemStore>,
    layers: Vec<Array<FilesystemStore>>,
    overview: Vec<Array<FilesystemStore>>,
}

impl Store {
    /// Makes the arrays of a grid's layers (`heads` hold no values), and those of the overview's levels.
    pub fn open(path: &Path, grid: &GridSpec, heads: &[Layer], combined: &Layer, levels: usize) -> Result<Store> {
        Store::make(path, grid, heads, combined, levels).map_err(|e| unwritable(path, e))
    }

    fn make(path: &Path, grid: &GridSpec, heads: &[Layer], combined: &Layer, levels: usize) -> Tried<Store> {
        let store = Arc::new(FilesystemStore::new(path)?);
        write_axis(&store, "x", grid.width, |k| grid.centre(k, 0).0)?;
        write_axis(&store, "y", grid.height, |k| grid.centre(0, k).1)?;
        let layer = |head: &Layer| match head.data {
            Data::F32(_) => array(&store, grid, head, data_type::float32(), (head.fill as f32).into()),
            Data::U32(_) => array(&store, grid, head, data_type::uint32(), (head.fill as u32).into()),
            Data::U8(_) => array(&store, grid, head, data_type::uint8(), (head.fill as u8).into()),
            Data::I8(_) => array(&store, grid, head, data_type::int8(), (head.fill as i8).into()),
        };
        let layers = heads.iter().map(layer).collect::<Tried<_>>()?;
        let level = |k: usize| {
            let [width, height] = reduced(grid, 1 << k);
            let grid = GridSpec { width, height, ..*grid };
            let head = Layer { name: format!("{OVERVIEW}/{k}"), data: Data::U8(Vec::new()), ..combined.clone() };
            array(&store, &grid, &head, data_type::uint8(), 0u8.into())
        };
        GroupBuilder::new()
            .attributes(multiscales(grid, combined, levels))
            .build(store.clone(), &format!("/{OVERVIEW}"))?
            .store_metadata()?;
        let overview = (0..levels).map(level).collect::<Tried<_>>()?;
        Ok(Store { path: path.into(), grid: *grid, store, layers, overview })
    }

    /// Writes a chunk's part of every layer, a shard each; what is all fill is not stored.
    pub fn chunk(&self, [row, column]: [u32; 2], part: &Map) -> Result<()> {
        let at = [u64::from(row), u64::from(column)];
        let shard = |(array, layer): (&Array<FilesystemStore>, &Layer)| -> Tried<()> {
            match &layer.data {
                Data::F32(v) => array.store_chunk(&at, padded(&part.grid, v, layer.fill as f32))?,
                Data::U32(v) => array.store_chunk(&at, padded(&part.grid, v, layer.fill as u32))?,
                Data::U8(v) => array.store_chunk(&at, padded(&part.grid, v, layer.fill as u8))?,
                Data::I8(v) => array.store_chunk(&at, padded(&part.grid, v, layer.fill as i8))?,
            }
            Ok(())
        };
        let pairs: Vec<_> = self.layers.iter().zip(&part.layers).collect();
        pairs.into_par_iter().try_for_each(shard).map_err(|e| unwritable(&self.path, e))
    }

    /// Writes a shard of an overview's level: palette entries, rows from the bottom.
    pub fn overview(&self, level: usize, [row, column]: [u32; 2], entries: &[u8]) -> Result<()> {
        let [width, height] = reduced(&self.grid, 1 << level);
        let size = |all: usize, first: u32| SHARD.min(all - first as usize * SHARD);
        let grid = GridSpec { width: size(width, column), height: size(height, row), ..self.grid };
        let at = [u64::from(row), u64::from(column)];
        self.overview[level].store_chunk(&at, padded(&grid, entries, 0u8)).map_err(|e| unwritable(&self.path, e))
    }

    /// Writes the store's attributes, the last thing.
    pub fn close(self, attributes: Object<String, Value>) -> Result<()> {
        let write = || -> Tried<()> {
            GroupBuilder::new().attributes(attributes).build(self.store.clone(), "/")?.store_metadata()?;
            Ok(())
        };
        write().map_err(|e| unwritable(&self.path, e))
    }
}

/// Group of the combined layer's levels.
const OVERVIEW: &str = "overview";

/// The levels as OME-NGFF 0.5 describes a multiscale image, and what an entry is.
fn multiscales(grid: &GridSpec, combined: &Layer, levels: usize) -> Object<String, Value> {
    let axis = |name: &str| json!({"name": name, "type": "space", "unit": "meter"});
    let level = |k: usize| {
        let edge = grid.resolution * f64::from(1u32 << k);
        json!({"path": k.to_string(), "coordinateTransformations": [
            {"type": "scale", "scale": [edge, edge]},
            {"type": "translation", "translation": [grid.y0() + edge / 2.0, grid.x0() + edge / 2.0]},
        ]})
    };
    let levels: Vec<Value> = (0..levels).map(level).collect();
    let all = json!({
        "ome": {"version": "0.5", "multiscales": [{
            "name": combined.name, "axes": [axis("y"), axis("x")], "datasets": levels,
            "type": "strongest of each block",
        }]},
        "long_name": combined.about,
        "entries": "0: not reached; 1 to 255: -1 (surely empty) to 1 (surely occupied), 128: 0",
    });
    match all {
        Value::Object(object) => object,
        _ => Object::new(),
    }
}

/// The store's own attributes, but for what is known at the end.
pub(super) fn attributes(grid: &GridSpec, method: &str, heads: &[Layer], info: &RunInfo) -> Object<String, Value> {
    let GridSpec { anchor, resolution, i0, j0, width, height } = grid;
    let names: Vec<&str> = heads.iter().map(|l| l.name.as_str()).collect();
    let mut all = json!({
        "method": method,
        "parameters": info.parameters,
        "log_sha256": info.log.sha256,
        "resolution": resolution,
        "anchor": [anchor.0, anchor.1],
        "first_cell": [i0, j0],
        "size": [width, height],
        "layers": names,
        "version": env!("CARGO_PKG_VERSION"),
    });
    if !info.classes.is_empty() {
        all["classes"] = json!(info.classes);
    }
    match all {
        Value::Object(object) => object,
        _ => Object::new(),
    }
}

/// What every array has in common: zstd, a checksum, and the same bytes for the same values.
fn finish(builder: &mut ArrayBuilder, store: &Arc<FilesystemStore>, name: &str) -> Tried<Array<FilesystemStore>> {
    let codecs: Vec<Arc<dyn BytesToBytesCodecTraits>> =
        vec![Arc::new(ZstdCodec::new(1, false)), Arc::new(Crc32cCodec::new())];
    // Inner chunks in the order they are ready in would give other bytes each run.
    let order = ShardingCodecOptions::default().with_subchunk_write_order(SubchunkWriteOrder::C);
    builder.bytes_to_bytes_codecs(codecs);
    builder.codec_specific_options(CodecSpecificOptions::default().with_option(order));
    let array = builder.build(store.clone(), &format!("/{name}"))?;
    array.store_metadata_opt(&ArrayMetadataOptions::default().with_include_zarrs_metadata(false))?;
    Ok(array)
}

/// Cell centres along one axis, metres.
fn write_axis(store: &Arc<FilesystemStore>, name: &str, cells: usize, centre: impl Fn(usize) -> f64) -> Tried<()> {
    let chunk = cells.min(AXIS);
    let fill = FillValue::from(f64::NAN);
    let mut builder = ArrayBuilder::new(vec![cells as u64], vec![chunk as u64], data_type::float64(), fill);
    builder.dimension_names(Some([name]));
    builder.attributes_mut().extend([
        ("units".into(), json!("m")),
        ("long_name".into(), json!(format!("{name} of the cell's centre"))),
        ("axis".into(), json!(name.to_uppercase())),
    ]);
    let array = finish(&mut builder, store, name)?;
    for first in (0..cells).step_by(chunk) {
        let centres: Vec<f64> = (first..first + chunk).map(|k| if k < cells { centre(k) } else { f64::NAN }).collect();
        array.store_chunk(&[(first / chunk) as u64], centres)?;
    }
    Ok(())
}

/// An array of a layer: shards of 1024 × 1024 cells.
fn array(
    store: &Arc<FilesystemStore>,
    grid: &GridSpec,
    head: &Layer,
    kind: DataType,
    fill: FillValue,
) -> Tried<Array<FilesystemStore>> {
    let shape = vec![grid.height as u64, grid.width as u64];
    let mut builder = ArrayBuilder::new(shape, vec![SHARD as u64; 2], kind, fill);
    builder.subchunk_shape(vec![CHUNK as u64; 2]).dimension_names(Some(["y", "x"]));
    let (scale, ends) = match head.scale {
        Scale::Grey { low, high } => ("grey", [low, high]),
        Scale::Signed { limit } => ("signed", [-limit, limit]),
        Scale::Heat { low, high } => ("heat", [low, high]),
        Scale::Classes(palette) => ("classes", [0.0, palette.colours().len() as f64]),
    };
    if let Scale::Classes(palette) = head.scale {
        builder.attributes_mut().insert("class_colours".into(), json!(palette.colours()));
    }
    builder.attributes_mut().extend([
        ("long_name".into(), json!(head.about)),
        ("scale".into(), json!(scale)),
        ("colour_range".into(), json!(ends)),
    ]);
    finish(&mut builder, store, &head.name)
}

/// One shard's values; beyond the grid's edge the fill value.
fn padded<T: Copy>(part: &GridSpec, values: &[T], fill: T) -> Vec<T> {
    let mut shard = vec![fill; SHARD * SHARD];
    for (line, row) in shard.chunks_exact_mut(SHARD).zip(values.chunks_exact(part.width)) {
        line[..part.width].copy_from_slice(row);
    }
    shard
}

/// Reads a map folder back: every layer, the grid, the attributes and the report.
pub fn read_map(path: &Path) -> Result<StoredMap> {
    if !folder::is_map(path) {
        let what = match folder::leftovers(path).as_slice() {
            [] => "it is no echogrid map: a folder with report.json and map.zarr is wanted".into(),
            [old, ..] => format!("a killed run left the map at {}: move it back", old.display()),
        };
        return Err(Error::input(path, what));
    }
    read_folder(path).map_err(|e| Error::input(path.join("map.zarr"), format!("it can't be read: {e}")))
}

fn read_folder(path: &Path) -> Tried<StoredMap> {
    let report: Value = serde_json::from_slice(&std::fs::read(path.join("report.json"))?)?;
    let reader = Reader::open(&path.join("map.zarr"))?;
    let layers = (0..reader.arrays.len()).map(|k| reader.layer(k)).collect::<Tried<Vec<Layer>>>()?;
    let attributes = reader.attributes;
    let method = attributes.get("method").and_then(Value::as_str).unwrap_or_default().to_string();
    let updates = attributes.get("updates").and_then(Value::as_u64).unwrap_or_default();
    let increments = serde_json::from_value(report["increments"].clone()).unwrap_or_default();
    let map = Map { grid: reader.grid, method, layers, updates, increments };
    Ok(StoredMap { map, attributes, report })
}

/// An open store.
pub(super) struct Reader {
    path: PathBuf,
    /// The cells.
    pub grid: GridSpec,
    attributes: Object<String, Value>,
    arrays: Vec<Array<FilesystemStore>>,
    names: Vec<String>,
}

impl Reader {
    /// Opens a store's layers.
    pub fn open(path: &Path) -> Tried<Reader> {
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
        Ok(Reader { path: path.into(), grid, attributes, arrays, names })
    }

    /// The layers' names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Bytes of a layer's shard; `None`: it is not stored, all of it is fill.
    pub fn stored(&self, layer: usize, [row, column]: [u32; 2]) -> Option<u64> {
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

    /// A whole layer.
    pub fn layer(&self, layer: usize) -> Tried<Layer> {
        let shards: Vec<Place> = places(&self.grid).collect();
        let parts = shards.into_par_iter().map(|at| Ok((at, self.shard(layer, at)?))).collect::<Tried<Vec<_>>>()?;
        let Some((_, first)) = parts.first() else { return Err("the grid has no cell".into()) };
        fn paste<T: Copy>(all: &mut [T], grid: &GridSpec, [row, column]: Place, values: &[T]) {
            let width = part(grid, [row, column]).width;
            for (k, line) in values.chunks_exact(width).enumerate() {
                let at = (row as usize * SHARD + k) * grid.width + column as usize * SHARD;
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
                _ => {}
            }
        }
        Ok(Layer { data, name: first.name.clone(), ..*first })
    }

    /// A layer's part in a shard. The whole shard is read: of a part of an inner chunk no checksum would be tested.
    pub fn shard(&self, layer: usize, at: Place) -> Tried<Layer> {
        let (array, name) = (&self.arrays[layer], &self.names[layer]);
        let GridSpec { width, height, .. } = part(&self.grid, at);
        let at = at.map(u64::from);
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
        let ends = array.attributes().get("colour_range").and_then(Value::as_array);
        let end = |k: usize, default: f64| ends.and_then(|e| e.get(k)).and_then(Value::as_f64).unwrap_or(default);
        let scale = match array.attributes().get("scale").and_then(Value::as_str) {
            Some("signed") => Scale::Signed { limit: end(1, 1.0) },
            Some("heat") => Scale::Heat { low: end(0, 0.0), high: end(1, 1.0) },
            Some("classes") => {
                let colours = array.attributes().get("class_colours").cloned().unwrap_or_default();
                let colours: Vec<[u8; 3]> = serde_json::from_value(colours).unwrap_or_default();
                Scale::Classes(Palette::of(&colours).unwrap_or(Palette::plain()))
            }
            _ => Scale::Grey { low: end(0, 0.0), high: end(1, 1.0) },
        };
        Ok(Layer { name: name.clone(), about: "", data, fill: self.fill(layer), scale })
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
