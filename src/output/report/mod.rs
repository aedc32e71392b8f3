//! `report.json`: the run, its input and its result in one JSON object. The caller describes the run in a [`RunInfo`]; the rest is
//! counted from the map.

mod parts;
mod statistics;
mod values;

pub use parts::{CellCounts, LayerReport, SensorReport};
pub(super) use statistics::ChunkStatistics;
pub use values::{parameters, peak_memory, tidy};

use super::{MapSchema, unwritable};
use crate::Result;
use crate::feature::Summary;
use crate::log::BadLines;
use crate::log::reading::Counts;
use crate::sensor::Sensor;
use serde::{Serialize, Serializer};
use serde_json::Value;
use statistics::F64Bits;
use std::path::Path;

/// The description of a run, by its caller.
#[derive(Debug, Clone, Default)]
pub struct RunInfo {
    /// Every parameter with its value, defaults too ([`parameters`] makes them from texts).
    pub parameters: serde_json::Map<String, Value>,
    /// The log.
    pub log: LogInfo,
    /// The log's sensors.
    pub sensors: Vec<Sensor>,
    /// What became of the log's readings.
    pub readings: Counts,
    /// Wall time of each stage so far, in order; writing adds its own.
    pub seconds: Vec<(String, f64)>,
    /// Busy seconds of each thread of the `map` stage; empty where it has one thread.
    pub busy: Vec<(String, f64)>,
    /// oracle, cpu or gpu.
    pub backend: String,
    /// The adapter's name, where the backend has one.
    pub adapter: Option<String>,
    /// Lines that couldn't be read.
    pub bad_lines: BadLines,
    /// Names of the class labels, "free" last, where the method tells them apart.
    pub classes: Vec<String>,
    /// A summary of the features, for a method that finds features.
    pub features: Option<Summary>,
}

/// The log of a map.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LogInfo {
    /// Its path as given; `<stdin>` is standard input.
    pub path: String,
    /// The SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// The layout of its lasers' beams, and where the layout is from.
    pub beams: Vec<String>,
    /// Notes on how it was read: codes taken for a missing return, messages left out, warnings.
    pub notes: Vec<String>,
}

/// The whole of `report.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// The method's name.
    pub method: String,
    /// Every parameter with its value.
    pub parameters: serde_json::Map<String, Value>,
    /// The log.
    pub log: LogInfo,
    /// Its sensors.
    pub sensors: Vec<SensorReport>,
    /// What became of the log's readings.
    pub readings: Counts,
    /// Lines that couldn't be read.
    pub bad_lines: BadLines,
    /// The grid and its classes.
    pub cells: CellCounts,
    /// Cell updates.
    pub updates: u64,
    /// Each layer's summary, in the map's order.
    #[serde(serialize_with = "as_object")]
    pub layers: Vec<(String, LayerReport)>,
    /// Sums of what the cells' α gained, for a method with α: occupied, free; or the classes, then free.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub increments: Vec<f64>,
    /// Names of the class labels, "free" last, where the method tells them apart.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub classes: Vec<String>,
    /// A summary of the features, for a method that finds features.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub features: Option<Summary>,
    /// Wall time of each stage, seconds.
    #[serde(serialize_with = "as_object")]
    pub seconds: Vec<(String, f64)>,
    /// Busy seconds of each thread of the `map` stage.
    #[serde(serialize_with = "as_object", skip_serializing_if = "Vec::is_empty")]
    pub busy: Vec<(String, f64)>,
    /// The peak of the process's resident memory so far, bytes, where the system tells.
    pub peak_memory: Option<u64>,
    /// oracle, cpu or gpu.
    pub backend: String,
    /// The adapter's name, where the backend has one.
    pub adapter: Option<String>,
    /// The map's files, without its store and its `working-N` files. A folder that holds any other file is not replaced.
    pub files: Vec<String>,
    /// Version of echogrid.
    pub version: String,
}

impl Report {
    /// Sums the statistics of a map's chunks, in their order, and joins the description of the run.
    pub(super) fn of<'a>(
        schema: &MapSchema,
        chunks: impl Iterator<Item = &'a ChunkStatistics>,
        info: &RunInfo,
    ) -> Report {
        let mut layers: Vec<(String, LayerReport)> =
            schema.layers.iter().map(|l| (l.name.clone(), LayerReport::start(l.scale))).collect();
        let (mut cells, mut updates, mut increments) = ([0; 4], 0, Vec::new());
        for chunk in chunks {
            (0..4).for_each(|k| cells[k] += chunk.cells[k]);
            updates += chunk.updates;
            let gains: Vec<f64> = chunk.increments.iter().map(|b| b.value()).collect();
            crate::method::add(&gains, &mut increments);
            layers.iter_mut().zip(&chunk.layers).for_each(|((_, all), part)| all.add(part.map(F64Bits::value)));
        }
        let grid = &schema.grid;
        Report {
            method: schema.method.clone(),
            parameters: info.parameters.clone(),
            log: info.log.clone(),
            sensors: info.sensors.iter().map(|s| SensorReport::of(s, grid.resolution)).collect(),
            readings: info.readings,
            bad_lines: info.bad_lines.clone(),
            cells: CellCounts {
                x0: tidy(grid.x0()),
                y0: tidy(grid.y0()),
                resolution: grid.resolution,
                width: grid.width,
                height: grid.height,
                touched: cells[0],
                occupied: cells[1],
                empty: cells[2],
                unknown: cells[3],
            },
            updates,
            layers,
            increments,
            classes: info.classes.clone(),
            features: info.features.clone(),
            seconds: info.seconds.clone(),
            busy: info.busy.clone(),
            peak_memory: peak_memory(),
            backend: info.backend.clone(),
            adapter: info.adapter.clone(),
            files: Vec::new(),
            version: env!("CARGO_PKG_VERSION").into(),
        }
    }
}

/// Writes `report.json`.
///
/// # Errors
/// [`Error::Resources`](crate::Error::Resources) if it can't be written.
pub(super) fn write(path: &Path, report: &Report) -> Result<()> {
    let save = || -> std::io::Result<()> {
        let mut text = serde_json::to_vec_pretty(report)?;
        text.push(b'\n');
        std::fs::write(path, text)
    };
    save().map_err(|e| unwritable(path, e))
}

/// Serializes pairs as an object that keeps their order.
fn as_object<T: Serialize, S: Serializer>(
    pairs: &[(String, T)],
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(k, v)| (k, v)))
}
