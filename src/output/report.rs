//! `report.json`: what was run, on what, with which result, in one object a machine can read. The caller says what it
//! alone knows in a [`RunInfo`]; the rest is counted from the map.

use super::unwritable;
use crate::Result;
use crate::feature::Summary;
use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use crate::log::BadLines;
use crate::log::reading::Counts;
use crate::sensor::{AtMax, Kind, Sensor};
use rayon::prelude::*;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Value, json};
use std::path::Path;

/// What only the caller knows of a run.
#[derive(Debug, Clone, Default)]
pub struct RunInfo {
    /// Every parameter with its value, defaults too ([`parameters`] makes them from texts).
    pub parameters: serde_json::Map<String, Value>,
    /// The log.
    pub log: LogInfo,
    /// The log's sensors.
    pub sensors: Vec<Sensor>,
    /// What became of its readings.
    pub readings: Counts,
    /// Wall time of each stage so far, in order; writing adds its own.
    pub seconds: Vec<(String, f64)>,
    /// How long each of the threads of the `map` stage had work, seconds; empty where it has one.
    pub busy: Vec<(String, f64)>,
    /// oracle, cpu or gpu.
    pub backend: String,
    /// The adapter's name, where the backend has one.
    pub adapter: Option<String>,
    /// Lines that couldn't be read.
    pub bad_lines: BadLines,
    /// Names of the class labels, "free" last, where the method tells them apart.
    pub classes: Vec<String>,
    /// What the method's features came to, where it has some.
    pub features: Option<Summary>,
}

/// Which log a map was made of.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LogInfo {
    /// Its path as given; `<stdin>` is standard input.
    pub path: String,
    /// The SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// How the beams of its lasers lie, and by what.
    pub beams: Vec<String>,
    /// How it was read, where a user should know: codes taken for a missing return, messages left out, doubts.
    pub notes: Vec<String>,
}

/// A sensor, complete; lengths in metres and angles in radians, to 1e-9.
#[derive(Debug, Clone, Serialize)]
pub struct SensorReport {
    /// Its name in the log.
    pub id: String,
    /// Sonar or laser.
    pub kind: Kind,
    /// Its place in the robot's frame, forward.
    pub x: f64,
    /// Its place in the robot's frame, to the left.
    pub y: f64,
    /// Its bearing in the robot's frame.
    pub axis: f64,
    /// Half the beam's width.
    pub half_width: f64,
    /// Ranges below this are rejected.
    pub r_min: f64,
    /// Ranges above this are no echo.
    pub r_max: f64,
    /// What a range of just `r_max` is.
    pub at_r_max: AtMax,
    /// Echoes from beyond this are rejected.
    pub hit_range: f64,
    /// How far a missing echo frees the cone.
    pub no_echo_range: f64,
    /// Half the depth of the arc.
    pub epsilon: f64,
}

/// Where a map's cells are, and how many are what.
#[derive(Debug, Clone, Serialize)]
pub struct Cells {
    /// World x of the left edge, metres.
    pub x0: f64,
    /// World y of the bottom edge, metres.
    pub y0: f64,
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Cells that a reading reached.
    pub touched: u64,
    /// Cells of class occupied.
    pub occupied: u64,
    /// Cells of class empty.
    pub empty: u64,
    /// Cells of class unknown, reached or not.
    pub unknown: u64,
}

/// A layer's values in brief. Not-a-number and infinities are `null` in the file.
#[derive(Debug, Clone, Serialize)]
pub struct LayerReport {
    /// The sum over all cells in f64: chunk by chunk of 1024 × 1024 cells, in each row by row, from the lower left.
    pub sum: f64,
    /// The smallest value.
    pub min: f64,
    /// The largest value.
    pub max: f64,
    /// Its colours: `{"grey": [low, high]}`, `{"signed": limit}`, `{"heat": [low, high]}` or `{"classes": [[r, g, b], …]}`.
    pub scale: Value,
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
    /// What became of its readings.
    pub readings: Counts,
    /// Lines that couldn't be read.
    pub bad_lines: BadLines,
    /// The grid and its classes.
    pub cells: Cells,
    /// Cell updates.
    pub updates: u64,
    /// Each layer in brief, in the map's order.
    #[serde(serialize_with = "as_object")]
    pub layers: Vec<(String, LayerReport)>,
    /// What the cells' α gained, where the method counts it: occupied, free; or the classes, then free.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub increments: Vec<f64>,
    /// Names of the class labels, "free" last, where the method tells them apart.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub classes: Vec<String>,
    /// What the method's features came to, where it has some.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub features: Option<Summary>,
    /// Wall time of each stage, seconds.
    #[serde(serialize_with = "as_object")]
    pub seconds: Vec<(String, f64)>,
    /// How long each of the threads of the `map` stage had work, seconds.
    #[serde(serialize_with = "as_object", skip_serializing_if = "Vec::is_empty")]
    pub busy: Vec<(String, f64)>,
    /// The process's largest resident memory so far, bytes, where the system tells.
    pub peak_memory: Option<u64>,
    /// oracle, cpu or gpu.
    pub backend: String,
    /// The adapter's name, where the backend has one.
    pub adapter: Option<String>,
    /// The map's files, but for its store and its `working-N` files: when the folder is replaced, no other may be in it.
    pub files: Vec<String>,
    /// Version of echogrid.
    pub version: String,
}

/// What a part of a map comes to.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Tally {
    cells: [u64; 4],
    updates: u64,
    increments: Vec<Bits>,
    layers: Vec<[Bits; 3]>,
}

/// An f64 that JSON keeps to the bit, infinities too.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Bits(u64);

impl Tally {
    /// Of a part with its values.
    pub fn of(part: &Map) -> Tally {
        fn fold(values: impl Iterator<Item = f64>) -> [f64; 3] {
            let start = [0.0, f64::INFINITY, f64::NEG_INFINITY];
            values.fold(start, |[s, a, b], v| [s + v, a.min(v), b.max(v)])
        }
        let layer = |l: &Layer| match &l.data {
            Data::F32(v) => fold(v.iter().map(|v| f64::from(*v))),
            Data::U32(v) => fold(v.iter().map(|v| f64::from(*v))),
            Data::U8(v) => fold(v.iter().map(|v| f64::from(*v))),
            Data::I8(v) => fold(v.iter().map(|v| f64::from(*v))),
        };
        let count = |name: &str, value: i8| match part.layer(name).map(|l| &l.data) {
            Some(Data::U8(v)) => v.iter().filter(|v| i16::from(**v) == i16::from(value)).count() as u64,
            Some(Data::I8(v)) => v.iter().filter(|v| **v == value).count() as u64,
            _ => 0,
        };
        Tally {
            cells: [count("touched", 1), count("class", 1), count("class", -1), count("class", 0)],
            updates: part.updates,
            increments: part.increments.iter().map(|v| Bits(v.to_bits())).collect(),
            layers: part.layers.par_iter().map(|l| layer(l).map(|v| Bits(v.to_bits()))).collect(),
        }
    }

    /// Sum, least and largest value of its first layer.
    pub fn first_layer(&self) -> [f64; 3] {
        self.layers.first().map_or([0.0; 3], |l| l.map(|b| f64::from_bits(b.0)))
    }

    /// Of a part that nothing reached.
    pub fn unreached(heads: &[Layer], cells: usize) -> Tally {
        let layer = |l: &Layer| [l.fill * cells as f64, l.fill, l.fill].map(|v| Bits(v.to_bits()));
        Tally {
            cells: [0, 0, 0, cells as u64],
            updates: 0,
            increments: Vec::new(),
            layers: heads.iter().map(layer).collect(),
        }
    }
}

impl Report {
    /// Adds up the parts of a map, in their order, and joins what the caller knows. `heads` are the layers without values.
    pub(super) fn of<'a>(
        grid: &GridSpec,
        method: &str,
        heads: &[Layer],
        tallies: impl Iterator<Item = &'a Tally>,
        info: &RunInfo,
    ) -> Report {
        let mut layers: Vec<(String, LayerReport)> =
            heads.iter().map(|l| (l.name.clone(), LayerReport::start(l.scale))).collect();
        let (mut cells, mut updates, mut increments) = ([0; 4], 0, Vec::new());
        for tally in tallies {
            (0..4).for_each(|k| cells[k] += tally.cells[k]);
            updates += tally.updates;
            let gains: Vec<f64> = tally.increments.iter().map(|b| f64::from_bits(b.0)).collect();
            crate::method::add(&gains, &mut increments);
            layers
                .iter_mut()
                .zip(&tally.layers)
                .for_each(|((_, all), part)| all.add(part.map(|b| f64::from_bits(b.0))));
        }
        Report {
            method: method.into(),
            parameters: info.parameters.clone(),
            log: info.log.clone(),
            sensors: info.sensors.iter().map(|s| SensorReport::of(s, grid.resolution)).collect(),
            readings: info.readings,
            bad_lines: info.bad_lines.clone(),
            cells: Cells {
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

impl SensorReport {
    fn of(sensor: &Sensor, resolution: f64) -> SensorReport {
        SensorReport {
            id: sensor.id.clone(),
            kind: sensor.kind,
            x: tidy(sensor.x),
            y: tidy(sensor.y),
            axis: tidy(sensor.axis),
            half_width: tidy(sensor.half_width),
            r_min: tidy(sensor.r_min),
            r_max: tidy(sensor.r_max),
            at_r_max: sensor.at_r_max,
            hit_range: tidy(sensor.hit_range),
            no_echo_range: tidy(sensor.no_echo_range),
            epsilon: tidy(sensor.epsilon(resolution)),
        }
    }
}

/// A length or an angle to 1e-9, so that no -2.8000000000000003 is shown; never −0.
pub fn tidy(value: f64) -> f64 {
    let rounded = (value * 1e9).round() / 1e9;
    if rounded.is_finite() { rounded + 0.0 } else { value }
}

impl LayerReport {
    /// Of no cell yet.
    fn start(scale: Scale) -> LayerReport {
        let scale = match scale {
            Scale::Grey { low, high } => json!({ "grey": [low, high] }),
            Scale::Signed { limit } => json!({ "signed": limit }),
            Scale::Heat { low, high } => json!({ "heat": [low, high] }),
            Scale::Classes(palette) => json!({ "classes": palette.colours() }),
        };
        LayerReport { sum: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY, scale }
    }

    fn add(&mut self, [sum, min, max]: [f64; 3]) {
        self.sum += sum;
        (self.min, self.max) = (self.min.min(min), self.max.max(max));
    }
}

/// Parameters from their texts: numbers and true/false as such, the rest as text.
pub fn parameters<K: Into<String>>(texts: impl IntoIterator<Item = (K, String)>) -> serde_json::Map<String, Value> {
    let value = |text: String| match serde_json::from_str::<Value>(&text) {
        Ok(value @ (Value::Number(_) | Value::Bool(_))) => value,
        _ => Value::String(text),
    };
    texts.into_iter().map(|(k, text)| (k.into(), value(text))).collect()
}

/// The process's largest resident memory so far in bytes, or `None` where the system doesn't tell.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib * 1024)
}

pub(super) fn write(path: &Path, report: &Report) -> Result<()> {
    let save = || -> std::io::Result<()> {
        let mut text = serde_json::to_vec_pretty(report)?;
        text.push(b'\n');
        std::fs::write(path, text)
    };
    save().map_err(|e| unwritable(path, e))
}

/// Pairs as an object that keeps their order.
fn as_object<T: Serialize, S: Serializer>(
    pairs: &[(String, T)],
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(k, v)| (k, v)))
}
