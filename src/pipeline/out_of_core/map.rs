//! Maps a log into a sink of chunks. A resumed run skips the chunks that the sink has, and reads the totals of the first rounds back.

use super::{FinishedChunk, OutOfCoreRun, ResourcePlan};
use crate::grid::{ChunkId, chunks};
use crate::kernels::Backend;
use crate::log::reading::Counts;
use crate::pipeline::session::Session;
use crate::{Error, Result};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

/// The file that keeps the totals of the first rounds for a resumed run.
pub const TOTALS: &str = "found.bin";
/// The name of [`TOTALS`] while it is written.
pub const TOTALS_PARTIAL: &str = "found.partial";

/// The sink of finished chunks, such as the files of a map.
pub trait ChunkSink: Send {
    /// The chunks that are written, by this run or an earlier one.
    fn done(&self) -> BTreeSet<ChunkId>;

    /// Writes a chunk that is not written yet.
    ///
    /// # Errors
    /// [`Error::Resources`] where it can't be written.
    fn write(&mut self, chunk: &FinishedChunk) -> Result<()>;
}

/// Starts the progress report of a stage. It gets the stage's name (`sorting`, `weighing` or [`MAPPING`]) and the number of readings
/// that the stage goes over, each counted as often as it is taken; the function that it returns receives the number of readings done
/// since its last call.
pub type Progress<'a> = &'a dyn Fn(&'static str, u64) -> Box<dyn Fn(u64)>;

/// The counts and times of a mapped log.
#[derive(Debug, Clone)]
pub struct MappingStatistics {
    /// What became of the log's readings.
    pub counts: Counts,
    /// Seconds of each stage.
    pub seconds: Vec<(String, f64)>,
    /// Busy seconds of each thread of the last round: `read` (and bin) ahead, `kernels`, `take` (and write) finished chunks.
    pub busy: Vec<(String, f64)>,
}

/// The name of the last stage: its chunks are written as they are finished.
pub const MAPPING: &str = "mapping";

/// The output of a run.
pub struct MapOutput<'a> {
    /// The folder of spilled readings and of the totals that a resumed run needs.
    pub folder: &'a Path,
    /// The progress of each stage.
    pub progress: Progress<'a>,
    /// The sink of finished chunks.
    pub sink: &'a mut dyn ChunkSink,
}

/// Maps a log into a sink of chunks.
///
/// # Errors
/// The log's; [`Error::Resources`] where something can't be written; the backend's.
pub fn map(
    session: &Session,
    backend: &mut dyn Backend,
    plan: &ResourcePlan,
    output: MapOutput,
) -> Result<MappingStatistics> {
    let MapOutput { folder, progress, sink } = output;
    let (mut seconds, mut clock) = (Vec::new(), Instant::now());
    let mut lap = |stage: &str| {
        seconds.push((stage.to_string(), clock.elapsed().as_secs_f64()));
        clock = Instant::now();
    };
    let used = session.survey.counts.used;
    let mut run = OutOfCoreRun::begin(session, plan.batch, folder, plan.bins, &*progress("sorting", used))?;
    lap("bin");
    let binned: u64 = run.chunks().iter().map(|p| p.1).sum();
    let kept_totals = folder.join(TOTALS);
    let before = run.first_rounds();
    if !before.is_empty() {
        match read_totals(&kept_totals, run.totals().len()) {
            Some(totals) => *run.totals() = totals,
            None => {
                let traversals = before.iter().map(|r| r.len() as u64).sum::<u64>();
                run.gather(backend, &*progress("weighing", binned * traversals))?;
                write_totals(folder, run.totals())?;
            }
        }
        lap("gather");
    }
    let done = sink.done();
    let rest = run.chunks().iter().filter(|p| !done.contains(&p.0)).map(|p| p.1).sum::<u64>();
    let traversals = run.last_round().len() as u64;
    let bar = progress(MAPPING, rest * traversals);
    run.finish(backend, &done, &*bar, &mut |chunk| sink.write(&chunk))?;
    lap("map");
    let _ = std::fs::remove_file(&kept_totals);
    debug_assert!(chunks(&session.grid).count() >= sink.done().len());
    let Counts { outside, empty_arc, wide, .. } = run.counts;
    let counts = Counts { outside, empty_arc, wide, ..session.survey.counts };
    let busy = [("read", run.busy.read), ("kernels", run.busy.kernels), ("take", run.busy.take)];
    Ok(MappingStatistics { counts, seconds, busy: busy.map(|(thread, s)| (thread.to_string(), s)).into() })
}

/// Writes the totals with a checksum. The file appears whole or not at all.
fn write_totals(folder: &Path, totals: &[u32]) -> Result<()> {
    let [path, partial] = [TOTALS, TOTALS_PARTIAL].map(|name| folder.join(name));
    let full =
        |e: std::io::Error| Error::Resources(format!("{} can't be written: {e}; free space there", path.display()));
    let bytes: &[u8] = bytemuck::cast_slice(totals);
    std::fs::write(&partial, [&Sha256::digest(bytes)[..], bytes].concat()).map_err(full)?;
    std::fs::rename(&partial, &path).map_err(full)
}

/// Reads the totals that an earlier run wrote for so many readings; `None`: there are none, or the file is damaged.
fn read_totals(path: &Path, readings: usize) -> Option<Vec<u32>> {
    let kept = std::fs::read(path).ok()?;
    let (sum, bytes) = kept.split_at_checked(32)?;
    let whole = bytes.len() == 4 * readings && Sha256::digest(bytes)[..] == *sum;
    whole.then(|| bytemuck::pod_collect_to_vec(bytes))
}
