//! `map.zarr`: every layer as a Zarr version 3 array that Python, Julia and JavaScript open, with the cell centres in
//! metres beside them; `read` reads it back.
//!
//! A shard is 1024 × 1024 cells in inner chunks of 256 × 256. Chunks wholly of the fill value are not stored: a huge map
//! costs what was seen of it. One writer a shard: two would lose each other's chunks silently.

use super::png::reduced;
use super::{MapSchema, RunInfo, unwritable};
use crate::Result;
use crate::grid::{ChunkId, Data, GridSpec, Layer, Map, Scale};
use rayon::prelude::*;
use serde_json::{Map as Object, Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::codec::{Crc32cCodec, ShardingCodecOptions, SubchunkWriteOrder, ZstdCodec};
use zarrs::array::data_type;
use zarrs::array::{
    Array, ArrayBuilder, ArrayMetadataOptions, BytesToBytesCodecTraits, CodecSpecificOptions, DataType, FillValue,
};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::GroupBuilder;

mod piece;
mod read;
mod stored;

pub(crate) use piece::Pieces;
pub(super) use read::StoreReader;
pub use read::{StoredMap, read_map};
pub(crate) use stored::{Stored, StoredLayer};

const SHARD: usize = 1024;
const CHUNK: usize = 256;
/// The cells of a chunk of the arrays x and y.
const AXIS: usize = 1 << 16;

/// Any error of zarrs.
pub(super) type Cause = Box<dyn std::error::Error + Send + Sync>;
pub(super) type Tried<T> = std::result::Result<T, Cause>;

/// A store that is being written: its arrays exist, its chunks come one by one.
pub(super) struct Store {
    path: PathBuf,
    grid: GridSpec,
    store: Arc<FilesystemStore>,
    layers: Vec<Array<FilesystemStore>>,
    overview: Vec<Array<FilesystemStore>>,
}

impl Store {
    /// Creates the arrays of a map's layers and of so many levels of the overview.
    ///
    /// # Errors
    /// [`Error::Resources`](crate::Error::Resources) if they can't be written.
    pub fn open(path: &Path, schema: &MapSchema, levels: usize) -> Result<Store> {
        Store::create(path, schema, levels).map_err(|e| unwritable(path, e))
    }

    fn create(path: &Path, schema: &MapSchema, levels: usize) -> Tried<Store> {
        let (grid, combined) = (&schema.grid, &schema.combined);
        let store = Arc::new(FilesystemStore::new(path)?);
        write_axis(&store, "x", grid.width, |k| grid.centre(k, 0).0)?;
        write_axis(&store, "y", grid.height, |k| grid.centre(0, k).1)?;
        let create = |layer: &Layer| match layer.data {
            Data::F32(_) => array(&store, grid, layer, data_type::float32(), (layer.fill as f32).into()),
            Data::U32(_) => array(&store, grid, layer, data_type::uint32(), (layer.fill as u32).into()),
            Data::U8(_) => array(&store, grid, layer, data_type::uint8(), (layer.fill as u8).into()),
            Data::I8(_) => array(&store, grid, layer, data_type::int8(), (layer.fill as i8).into()),
        };
        let layers = schema.layers.iter().map(create).collect::<Tried<_>>()?;
        let level = |k: usize| {
            let [width, height] = reduced(grid, 1 << k);
            let grid = GridSpec { width, height, ..*grid };
            let layer = Layer { name: format!("{OVERVIEW}/{k}"), data: Data::U8(Vec::new()), ..combined.clone() };
            array(&store, &grid, &layer, data_type::uint8(), 0u8.into())
        };
        GroupBuilder::new()
            .attributes(multiscales(grid, combined, levels))
            .build(store.clone(), &format!("/{OVERVIEW}"))?
            .store_metadata()?;
        let overview = (0..levels).map(level).collect::<Tried<_>>()?;
        Ok(Store { path: path.into(), grid: *grid, store, layers, overview })
    }

    /// Writes a chunk's part of every layer, each as a shard. Inner chunks of fill values are not stored.
    pub fn chunk(&self, ChunkId { row, column }: ChunkId, part: &Map) -> Result<()> {
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

    /// Writes a shard of a level of the overview: palette entries, bottom row first.
    pub fn overview(&self, level: usize, ChunkId { row, column }: ChunkId, entries: &[u8]) -> Result<()> {
        let [width, height] = reduced(&self.grid, 1 << level);
        let size = |all: usize, first: u32| SHARD.min(all - first as usize * SHARD);
        let grid = GridSpec { width: size(width, column), height: size(height, row), ..self.grid };
        let at = [u64::from(row), u64::from(column)];
        self.overview[level].store_chunk(&at, padded(&grid, entries, 0u8)).map_err(|e| unwritable(&self.path, e))
    }

    /// Writes the attributes of the store, which completes it.
    pub fn close(self, attributes: Object<String, Value>) -> Result<()> {
        let write = || -> Tried<()> {
            GroupBuilder::new().attributes(attributes).build(self.store.clone(), "/")?.store_metadata()?;
            Ok(())
        };
        write().map_err(|e| unwritable(&self.path, e))
    }
}

/// The group of the combined layer's levels.
const OVERVIEW: &str = "overview";

/// The attributes of the overview: its levels as a multiscale image of OME-NGFF 0.5, and the meaning of an entry.
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

/// The attributes of the store, without those that are known only at the end.
pub(super) fn attributes(schema: &MapSchema, info: &RunInfo) -> Object<String, Value> {
    let GridSpec { anchor, resolution, i0, j0, width, height } = &schema.grid;
    let names: Vec<&str> = schema.layers.iter().map(|l| l.name.as_str()).collect();
    let mut all = json!({
        "method": schema.method,
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

/// Builds an array with the codecs of every array: zstd and a checksum; equal values give equal bytes.
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

/// Writes the centres of the cells along one axis, metres.
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

/// Creates the array of a layer, in shards of 1024 × 1024 cells.
fn array(
    store: &Arc<FilesystemStore>,
    grid: &GridSpec,
    layer: &Layer,
    kind: DataType,
    fill: FillValue,
) -> Tried<Array<FilesystemStore>> {
    let shape = vec![grid.height as u64, grid.width as u64];
    let mut builder = ArrayBuilder::new(shape, vec![SHARD as u64; 2], kind, fill);
    builder.subchunk_shape(vec![CHUNK as u64; 2]).dimension_names(Some(["y", "x"]));
    let (scale, ends) = match layer.scale {
        Scale::Grey { low, high } => ("grey", [low, high]),
        Scale::Signed { limit } => ("signed", [-limit, limit]),
        Scale::Heat { low, high } => ("heat", [low, high]),
        Scale::Classes(palette) => ("classes", [0.0, palette.colours().len() as f64]),
    };
    if let Scale::Classes(palette) = layer.scale {
        builder.attributes_mut().insert("class_colours".into(), json!(palette.colours()));
    }
    builder.attributes_mut().extend([
        ("long_name".into(), json!(layer.about)),
        ("scale".into(), json!(scale)),
        ("colour_range".into(), json!(ends)),
    ]);
    finish(&mut builder, store, &layer.name)
}

/// The values of one shard, padded with the fill value beyond the grid's edge.
fn padded<T: Copy>(part: &GridSpec, values: &[T], fill: T) -> Vec<T> {
    let mut shard = vec![fill; SHARD * SHARD];
    for (line, row) in shard.chunks_exact_mut(SHARD).zip(values.chunks_exact(part.width)) {
        line[..part.width].copy_from_slice(row);
    }
    shard
}
