//! `map.zarr`: every layer as a Zarr version 3 array that Python, Julia and JavaScript open, with the cell centres in
//! metres beside them, and reading it back.
//!
//! A shard is 1024 × 1024 cells in inner chunks of 256 × 256. Chunks wholly of the fill value are not stored: a huge map
//! costs what was seen of it. One writer a shard: two would lose each other's chunks silently.

use super::{RunInfo, folder, unwritable};
use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use crate::{Error, Result};
use rayon::prelude::*;
use serde_json::{Map as Object, Value, json};
use std::path::Path;
use std::sync::Arc;
use zarrs::array::codec::{Crc32cCodec, ShardingCodecOptions, SubchunkWriteOrder, ZstdCodec};
use zarrs::array::data_type::{self, Float32DataType, Int8DataType, UInt8DataType, UInt32DataType};
use zarrs::array::{
    Array, ArrayBuilder, ArrayMetadataOptions, BytesToBytesCodecTraits, CodecSpecificOptions, DataType, Element,
    ElementOwned, FillValue,
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

/// Writes the store at `path`.
pub(super) fn write(path: &Path, map: &Map, info: &RunInfo) -> Result<()> {
    write_store(path, map, info).map_err(|e| unwritable(path, e))
}

/// Any of zarrs's errors: they all become one message.
type Cause = Box<dyn std::error::Error + Send + Sync>;
type Tried<T> = std::result::Result<T, Cause>;

fn write_store(path: &Path, map: &Map, info: &RunInfo) -> Tried<()> {
    let store = Arc::new(FilesystemStore::new(path)?);
    GroupBuilder::new().attributes(attributes(map, info)).build(store.clone(), "/")?.store_metadata()?;
    let grid = &map.grid;
    write_axis(&store, "x", grid.width, |k| grid.centre(k, 0).0)?;
    write_axis(&store, "y", grid.height, |k| grid.centre(0, k).1)?;
    for layer in &map.layers {
        match &layer.data {
            Data::F32(v) => write_layer(&store, grid, layer, v, data_type::float32(), layer.fill as f32)?,
            Data::U32(v) => write_layer(&store, grid, layer, v, data_type::uint32(), layer.fill as u32)?,
            Data::U8(v) => write_layer(&store, grid, layer, v, data_type::uint8(), layer.fill as u8)?,
            Data::I8(v) => write_layer(&store, grid, layer, v, data_type::int8(), layer.fill as i8)?,
        }
    }
    Ok(())
}

fn attributes(map: &Map, info: &RunInfo) -> Object<String, Value> {
    let GridSpec { anchor, resolution, i0, j0, width, height } = map.grid;
    let names: Vec<&str> = map.layers.iter().map(|l| l.name.as_str()).collect();
    let all = json!({
        "method": map.method,
        "parameters": info.parameters,
        "log_sha256": info.log.sha256,
        "resolution": resolution,
        "anchor": [anchor.0, anchor.1],
        "first_cell": [i0, j0],
        "size": [width, height],
        "layers": names,
        "updates": map.updates,
        "version": env!("CARGO_PKG_VERSION"),
    });
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

fn write_layer<T>(
    store: &Arc<FilesystemStore>,
    grid: &GridSpec,
    layer: &Layer,
    values: &[T],
    kind: DataType,
    fill: T,
) -> Tried<()>
where
    T: Element + Copy + Send + Sync,
    FillValue: From<T>,
{
    let shape = vec![grid.height as u64, grid.width as u64];
    let mut builder = ArrayBuilder::new(shape, vec![SHARD as u64; 2], kind, FillValue::from(fill));
    builder.subchunk_shape(vec![CHUNK as u64; 2]).dimension_names(Some(["y", "x"]));
    let (scale, ends) = match layer.scale {
        Scale::Grey { low, high } => ("grey", [low, high]),
        Scale::Signed { limit } => ("signed", [-limit, limit]),
    };
    builder.attributes_mut().extend([
        ("long_name".into(), json!(layer.about)),
        ("scale".into(), json!(scale)),
        ("colour_range".into(), json!(ends)),
    ]);
    let array = finish(&mut builder, store, &layer.name)?;
    let (down, across) = (grid.height.div_ceil(SHARD), grid.width.div_ceil(SHARD));
    (0..down * across).into_par_iter().try_for_each(|k| {
        let (row, column) = (k / across, k % across);
        let shard = cut(grid, values, row * SHARD, column * SHARD, fill);
        array.store_chunk(&[row as u64, column as u64], shard)
    })?;
    Ok(())
}

/// One shard's values; beyond the grid's edge the fill value.
fn cut<T: Copy>(grid: &GridSpec, values: &[T], row: usize, column: usize, fill: T) -> Vec<T> {
    let mut shard = vec![fill; SHARD * SHARD];
    let columns = SHARD.min(grid.width - column);
    for (line, r) in shard.chunks_exact_mut(SHARD).zip(row..grid.height) {
        let start = r * grid.width + column;
        line[..columns].copy_from_slice(&values[start..start + columns]);
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
    let report = serde_json::from_slice(&std::fs::read(path.join("report.json"))?)?;
    let store = Arc::new(FilesystemStore::new(path.join("map.zarr"))?);
    let attributes = Group::open(store.clone(), "/")?.attributes().clone();
    let grid = read_grid(&attributes).ok_or("its attributes don't describe a grid")?;
    let names = attributes.get("layers").and_then(Value::as_array).ok_or("its attributes don't name its layers")?;
    let names = names.iter().filter_map(Value::as_str);
    let layers = names.map(|name| read_layer(&store, &grid, name)).collect::<Tried<Vec<Layer>>>()?;
    let method = attributes.get("method").and_then(Value::as_str).unwrap_or_default().to_string();
    let updates = attributes.get("updates").and_then(Value::as_u64).unwrap_or_default();
    Ok(StoredMap { map: Map { grid, method, layers, updates }, attributes, report })
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

fn read_layer(store: &Arc<FilesystemStore>, grid: &GridSpec, name: &str) -> Tried<Layer> {
    let array = Array::open(store.clone(), &format!("/{name}"))?;
    if array.shape() != [grid.height as u64, grid.width as u64] {
        return Err(format!("layer {name} is {:?}, the grid {} by {}", array.shape(), grid.height, grid.width).into());
    }
    fn all<T: ElementOwned>(array: &Array<FilesystemStore>) -> Tried<Vec<T>> {
        Ok(array.retrieve_array_subset(&array.subset_all())?)
    }
    let kind = array.data_type();
    let data = if kind.is::<Float32DataType>() {
        Data::F32(all(&array)?)
    } else if kind.is::<UInt32DataType>() {
        Data::U32(all(&array)?)
    } else if kind.is::<UInt8DataType>() {
        Data::U8(all(&array)?)
    } else if kind.is::<Int8DataType>() {
        Data::I8(all(&array)?)
    } else {
        return Err(format!("layer {name} has a data type that echogrid doesn't write: {kind:?}").into());
    };
    let fill = array.fill_value().as_ne_bytes();
    let fill = match (&data, fill) {
        (Data::F32(_), &[a, b, c, d]) => f64::from(f32::from_ne_bytes([a, b, c, d])),
        (Data::U32(_), &[a, b, c, d]) => f64::from(u32::from_ne_bytes([a, b, c, d])),
        (Data::I8(_), &[a]) => f64::from(a as i8),
        (_, &[a, ..]) => f64::from(a),
        _ => 0.0,
    };
    let ends = array.attributes().get("colour_range").and_then(Value::as_array);
    let end = |k: usize, default: f64| ends.and_then(|e| e.get(k)).and_then(Value::as_f64).unwrap_or(default);
    let scale = match array.attributes().get("scale").and_then(Value::as_str) {
        Some("signed") => Scale::Signed { limit: end(1, 1.0) },
        _ => Scale::Grey { low: end(0, 0.0), high: end(1, 1.0) },
    };
    Ok(Layer { name: name.into(), about: "", data, fill, scale })
}
