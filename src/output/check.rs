//! Checks whether a stored map is whole: every shard is read, which tests its checksums, and the layers' sums and ranges are compared with
//! the report.

use super::names::{REPORT, STORE};
use super::zarr::{StoreReader, Tried};
use super::{folder, report};
use crate::grid::chunks;
use crate::grid::{ChunkId, Map};
use crate::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// The result of a check.
#[derive(Debug, Clone, Default)]
pub struct Checked {
    /// Layers read.
    pub layers: usize,
    /// Shards that are stored.
    pub shards: u64,
    /// Size of the stored shards, bytes.
    pub bytes: u64,
    /// What is wrong; empty if the map is whole.
    pub problems: Vec<String>,
}

/// Checks a map's folder, one shard at a time. `progress` is called before each.
///
/// # Errors
/// [`Error::Input`] if it is no map. Damage is no error but a problem in the result.
pub fn check(path: &Path, progress: &dyn Fn()) -> Result<Checked> {
    if !folder::is_map(path) {
        return Err(Error::input(path, "it is no echogrid map: a folder with report.json and map.zarr is wanted"));
    }
    let unreadable = |e: super::zarr::Cause| Error::input(path.join(STORE), format!("it can't be read: {e}"));
    let text = std::fs::read(REPORT.at(path)).map_err(|e| Error::input(path, e.to_string()))?;
    let stored: Value = serde_json::from_slice(&text).map_err(|e| Error::input(REPORT.at(path), e.to_string()))?;
    let reader = StoreReader::open(&path.join(STORE)).map_err(unreadable)?;
    let mut found = Checked { layers: reader.names().len(), ..Checked::default() };
    for (k, name) in reader.names().iter().enumerate() {
        let mut all = [0.0, f64::INFINITY, f64::NEG_INFINITY];
        let mut damaged = false;
        for at in chunks(&reader.grid) {
            progress();
            match reader.stored(k, at) {
                Some(bytes) => (found.shards, found.bytes) = (found.shards + 1, found.bytes + bytes),
                None => {
                    // All of it is the fill value: there is nothing to test, and its sum is known.
                    let part = reader.fill(k) * crate::grid::part(&reader.grid, at).cells() as f64;
                    all = [all[0] + part, all[1].min(reader.fill(k)), all[2].max(reader.fill(k))];
                    continue;
                }
            }
            match shard_statistics(&reader, k, at) {
                Ok([sum, min, max]) => all = [all[0] + sum, all[1].min(min), all[2].max(max)],
                Err(e) => {
                    damaged = true;
                    found.problems.push(format!("{name}, shard row {} column {}: {e}", at.row, at.column));
                }
            }
        }
        let of = |key: &str| stored["layers"][name][key].as_f64();
        let close = |a: f64, b: Option<f64>| b.is_none_or(|b| (a - b).abs() <= 1e-9 * b.abs().max(1.0));
        let agrees = close(all[0], of("sum")) && close(all[1], of("min")) && close(all[2], of("max"));
        if !agrees && !damaged {
            found.problems.push(format!(
                "{name}: its sum is {}, its values {} to {}, but report.json says {}: shards are missing or from another run",
                all[0], all[1], all[2], stored["layers"][name]
            ));
        }
    }
    Ok(found)
}

/// The sum, the least and the largest value of a shard.
fn shard_statistics(reader: &StoreReader, layer: usize, at: ChunkId) -> Tried<[f64; 3]> {
    let layer = reader.shard(layer, at)?;
    let map = Map {
        grid: crate::grid::part(&reader.grid, at),
        method: String::new(),
        layers: vec![layer],
        updates: 0,
        increments: Vec::new(),
    };
    Ok(report::ChunkStatistics::of(&map).first_layer())
}
