//! The time that a run would need, from trials.

use crate::cli::interrupt;
use crate::cli::progress::spinner;
use crate::grid::ChunkId;
use crate::method::{self, Unit};
use crate::oracle;
use crate::output::{LogInfo, MapSchema, MapWriter, RunInfo, schema};
use crate::pipeline::out_of_core::FinishedChunk;
use crate::pipeline::session::Session;
use crate::{Error, Result};
use serde::Serialize;
use std::time::Instant;

/// How long a backend is tried, seconds.
pub(super) const TRIAL_SECONDS: f64 = 1.0;

/// The time that a backend would need, from a trial run.
#[derive(Debug, Serialize)]
pub(super) struct TimeEstimate {
    pub backend: &'static str,
    pub adapter: String,
    /// Why the backend was chosen; empty where the user chose it.
    pub why: String,
    /// Readings a second on the busiest chunk, binning included.
    pub readings_per_second: f64,
    /// Seconds to write a chunk like it.
    pub chunk_seconds: f64,
    /// Seconds of the whole run.
    pub seconds: f64,
}

/// How the oracle is tried.
pub(super) struct OracleTrial {
    /// Readings at a time.
    pub batch: usize,
    /// Memory that may be used, bytes; `None`: what the machine has free.
    pub memory: Option<u64>,
    /// Seconds that reading the log took.
    pub before: f64,
    /// Whether to show no spinner.
    pub quiet: bool,
}

/// The time that the f64 reference would need, from a trial with some of the readings. `None` where the map doesn't fit in `memory`, and
/// for methods whose cost of a reading depends on the others.
pub(super) fn of_oracle(session: &Session, trial: &OracleTrial) -> Result<Option<TimeEstimate>> {
    let fits = session.check_memory(session.memory(trial.batch), trial.memory).is_ok();
    if session.method.unit() != Unit::Reading || !fits {
        return Ok(None);
    }
    let _progress = spinner("trying", trial.quiet);
    let time = |count: usize| -> Result<f64> {
        let items = session.readings()?.take(count).collect::<Result<Vec<_>>>()?;
        let readings: Vec<_> = items.iter().map(|i| i.0).collect();
        let wedges: Option<Vec<_>> = items.iter().map(|i| i.1).collect();
        let started = Instant::now();
        oracle::map(&session.grid, session.sensors(), &readings, &session.method.settings(), wedges.as_deref())?;
        Ok(started.elapsed().as_secs_f64())
    };
    let (used, cells) = (session.survey.counts.used, time(0)?);
    let (mut count, mut seconds) = (1, 0.0);
    while count < used as usize && seconds < TRIAL_SECONDS {
        count = (4 * count).min(used as usize);
        seconds = time(count)? - cells;
    }
    let rate = count as f64 / seconds.max(1e-9);
    Ok(Some(TimeEstimate {
        backend: "oracle",
        adapter: "f64, one reading at a time".into(),
        why: String::new(),
        readings_per_second: rate,
        chunk_seconds: 0.0,
        seconds: trial.before + cells + used as f64 / rate,
    }))
}

/// Writes a chunk to a temporary folder; the seconds that it took.
pub(super) fn time_of_writing(session: &Session, chunk: &FinishedChunk) -> Result<f64> {
    let folder = tempfile::tempdir().map_err(|e| Error::Resources(format!("no temporary folder: {e}")))?;
    let map = &chunk.finished.map;
    let layers = map.layers.iter().map(schema).collect();
    let method = method::name(session.method.as_ref()).to_string();
    let combined = schema(&chunk.finished.combined);
    let schema = MapSchema { grid: map.grid, method, layers, combined, npy: false };
    let info = RunInfo { log: LogInfo::default(), ..RunInfo::default() };
    let mut writer = MapWriter::open(folder.path(), schema, &info, false)?;
    // Signals are deferred, so that the folder is removed.
    let _guard = interrupt::defer_signals();
    let started = Instant::now();
    writer.chunk(ChunkId::default(), map, &chunk.finished.combined)?;
    Ok(started.elapsed().as_secs_f64())
}
