//! Reads a map piece by piece. A piece is an inner chunk of 256 × 256 cells, a sixteenth of a shard. zarrs reads a piece without testing
//! its checksum, so it is located and decoded here.

use super::{CHUNK, SHARD, Tried};
use crate::grid::Data;
use crate::support::positional_io;
use crate::{Error, Result};
use serde_json::Value;
use std::collections::HashMap;
use std::fs::File;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use zarrs::array::data_type::{self, Float32DataType, Int8DataType, UInt8DataType, UInt32DataType};
use zarrs::array::{
    Array, ArrayToBytesCodecTraits, CodecChain, CodecOptions, DataType, ElementOwned, FillValue, FromArrayBytes,
};
use zarrs::filesystem::FilesystemStore;
use zarrs::metadata::v3::MetadataV3;

/// The number of pieces along a shard's edge, and in a shard.
const ACROSS: usize = SHARD / CHUNK;
const PIECES: usize = ACROSS * ACROSS;
/// The offset and the length of a piece that isn't stored.
const ABSENT: u64 = u64::MAX;
/// The most shards whose index is cached.
const INDEXES: usize = 4096;

/// The size of a shard's index with its checksum, bytes.
const INDEX: usize = 16 * PIECES + 4;

/// The offset and the length of each piece in its shard's file; `None`: the shard isn't stored.
type Index = Option<Arc<Vec<u64>>>;

/// An array that is read piece by piece.
pub(crate) struct Pieces {
    array: Array<FilesystemStore>,
    folder: PathBuf,
    codecs: CodecChain,
    index_codecs: CodecChain,
    indexes: Mutex<HashMap<[usize; 2], Index>>,
}

impl Pieces {
    /// Opens an array whose `zarr.json` lies in `folder`. An array with shards or pieces of another size than echogrid's is an error.
    pub(super) fn of(array: Array<FilesystemStore>, folder: PathBuf) -> Tried<Pieces> {
        let metadata = serde_json::to_value(array.metadata())?;
        let sharding = &metadata["codecs"][0]["configuration"];
        let edges = |of: &Value| of.as_array().map(|a| a.iter().filter_map(Value::as_u64).collect::<Vec<u64>>());
        let shard = edges(&metadata["chunk_grid"]["configuration"]["chunk_shape"]);
        let (wanted, piece) = (vec![SHARD as u64; 2], edges(&sharding["chunk_shape"]));
        if shard != Some(wanted) || piece != Some(vec![CHUNK as u64; 2]) || sharding["index_location"] == "start" {
            return Err(format!("{} isn't stored as echogrid stores a layer", folder.display()).into());
        }
        let chain = |key: &str| -> Tried<CodecChain> {
            let codecs: Vec<MetadataV3> = serde_json::from_value(sharding[key].clone())?;
            Ok(CodecChain::from_metadata(&codecs)?)
        };
        let (codecs, index_codecs) = (chain("codecs")?, chain("index_codecs")?);
        Ok(Pieces { array, folder, codecs, index_codecs, indexes: Mutex::default() })
    }

    /// Columns and rows of the array.
    pub fn extent(&self) -> [usize; 2] {
        let side = |k: usize| self.array.shape().get(k).map_or(0, |n| *n as usize);
        [side(1), side(0)]
    }

    /// The size of a value, bytes.
    pub fn value_bytes(&self) -> usize {
        self.array.fill_value().as_ne_bytes().len()
    }

    /// Reads the piece in a column and row of pieces, row by row from the bottom, cropped at the array's edge; `None`: it isn't stored, as
    /// all of it is the fill value.
    ///
    /// # Errors
    /// [`Error::Input`] names the shard's file where it is damaged.
    pub fn read(&self, [column, row]: [usize; 2]) -> Result<Option<Data>> {
        let shard = [column / ACROSS, row / ACROSS];
        let file = self.folder.join(format!("c/{}/{}", shard[1], shard[0]));
        self.try_read(&file, shard, [column, row]).map_err(|e| {
            let what = "map the log anew; `echogrid check` lists all that is damaged";
            Error::input(&file, format!("it is damaged, or was written anew meanwhile ({e}): {what}"))
        })
    }

    fn try_read(&self, path: &Path, shard: [usize; 2], [column, row]: [usize; 2]) -> Tried<Option<Data>> {
        let known = self.indexes().get(&shard).cloned();
        if let Some(None) = known {
            return Ok(None);
        }
        let file = match File::open(path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
                self.remember(shard, None);
                return Ok(None);
            }
            file => file?,
        };
        let index = match known.flatten() {
            Some(index) => index,
            None => {
                let index = Arc::new(self.index(&file)?);
                self.remember(shard, Some(index.clone()));
                index
            }
        };
        let at = row % ACROSS * ACROSS + column % ACROSS;
        let (offset, length) = match index.get(2 * at..2 * at + 2) {
            Some(&[ABSENT, ABSENT]) => return Ok(None),
            Some(&[offset, length]) => (offset, length),
            _ => return Err("it has no such piece".into()),
        };
        if offset.checked_add(length).is_none_or(|end| end > file.metadata().map_or(0, |m| m.len())) {
            return Err("it is cut off".into());
        }
        let mut bytes = vec![0; length as usize];
        positional_io::read_exact(&file, &mut bytes, offset)?;
        self.decode(bytes, [column, row]).map(Some)
    }

    fn index(&self, file: &File) -> Tried<Vec<u64>> {
        let start = file.metadata()?.len().checked_sub(INDEX as u64).ok_or("it is cut off")?;
        let mut bytes = vec![0; INDEX];
        positional_io::read_exact(file, &mut bytes, start)?;
        let shape = [ACROSS, ACROSS, 2].map(|n| n as u64);
        decode::<u64>(&self.index_codecs, bytes, &shape, &data_type::uint64(), &ABSENT.into())
    }

    /// Decodes the bytes of a piece, and crops it at the array's edge.
    fn decode(&self, bytes: Vec<u8>, [column, row]: [usize; 2]) -> Tried<Data> {
        let [width, height] = self.extent();
        let (width, height) = (CHUNK.min(width - column * CHUNK), CHUNK.min(height - row * CHUNK));
        fn crop<T: ElementOwned + Copy>(of: &Pieces, bytes: Vec<u8>, width: usize, height: usize) -> Tried<Vec<T>> {
            let (kind, fill) = (of.array.data_type(), of.array.fill_value());
            let all: Vec<T> = decode(&of.codecs, bytes, &[CHUNK as u64; 2], kind, fill)?;
            if width == CHUNK {
                return Ok(all.into_iter().take(CHUNK * height).collect());
            }
            Ok(all.chunks_exact(CHUNK).take(height).flat_map(|row| row[..width].iter().copied()).collect())
        }
        let kind = self.array.data_type();
        Ok(match kind {
            k if k.is::<Float32DataType>() => Data::F32(crop(self, bytes, width, height)?),
            k if k.is::<UInt32DataType>() => Data::U32(crop(self, bytes, width, height)?),
            k if k.is::<UInt8DataType>() => Data::U8(crop(self, bytes, width, height)?),
            k if k.is::<Int8DataType>() => Data::I8(crop(self, bytes, width, height)?),
            _ => return Err(format!("its data type is none that echogrid writes: {kind:?}").into()),
        })
    }

    fn indexes(&self) -> std::sync::MutexGuard<'_, HashMap<[usize; 2], Index>> {
        self.indexes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn remember(&self, shard: [usize; 2], index: Index) {
        let mut indexes = self.indexes();
        if indexes.len() >= INDEXES {
            indexes.clear();
        }
        indexes.insert(shard, index);
    }
}

/// Decodes bytes by a chain of codecs, which tests their checksum.
fn decode<T: ElementOwned>(
    codecs: &CodecChain,
    bytes: Vec<u8>,
    shape: &[u64],
    kind: &DataType,
    fill: &FillValue,
) -> Tried<Vec<T>> {
    let sides: Vec<NonZeroU64> = shape.iter().filter_map(|n| NonZeroU64::new(*n)).collect();
    let values = codecs.decode(bytes.into(), &sides, kind, fill, &CodecOptions::default())?.into_owned();
    Ok(Vec::<T>::from_array_bytes(values, shape, kind)?)
}
