//! A log to a map's files, chunk by chunk: what is done first, and what a resumed run needn't do again.

use super::{Chunk, Plan, Run};
use crate::grid::{Place, places};
use crate::kernels::Backend;
use crate::log::reading::Counts;
use crate::pipeline::session::Session;
use crate::{Error, Result};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

/// The file that keeps what the first rounds found, for a resumed run.
pub const FOUND: &str = "found.bin";
/// The same while it is written.
pub const FOUND_PARTIAL: &str = "found.partial";

/// Where finished chunks go.
pub trait ChunkSink: Send {
    /// The chunks that an earlier run wrote.
    fn done(&self) -> BTreeSet<Place>;

    /// Writes a chunk, once.
    ///
    /// # Errors
    /// [`Error::Resources`] where it can't be written.
    fn write(&mut self, chunk: &Chunk) -> Result<()>;
}

/// Hears of a stage, by a word for people (`sorting`, `weighing`, [`MAPPING`]), and how many readings it goes over, each as often as
/// it is taken; what it gives hears of readings as they are done.
pub type Progress<'a> = &'a dyn Fn(&'static str, u64) -> Box<dyn Fn(u64)>;

/// What a log's mapping came to.
#[derive(Debug, Clone)]
pub struct Done {
    /// What became of its readings.
    pub counts: Counts,
    /// Seconds of each stage.
    pub seconds: Vec<(String, f64)>,
    /// Seconds that each thread of the last stage had work: `read` ahead, `kernels`, `take` finished chunks and write them.
    pub busy: Vec<(String, f64)>,
}

/// The last stage's name: its chunks are written as they are finished.
pub const MAPPING: &str = "mapping";

/// Maps a log into an open map. Spilled readings and what a resumed run needs lie in `folder`.
///
/// # Errors
/// The log's; [`Error::Resources`] where something can't be written; the backend's.
pub fn map(
    session: &Session,
    backend: &mut dyn Backend,
    plan: &Plan,
    folder: &Path,
    progress: Progress,
    sink: &mut dyn ChunkSink,
) -> Result<Done> {
    let (mut seconds, mut clock) = (Vec::new(), Instant::now());
    let mut lap = |stage: &str| {
        seconds.push((stage.to_string(), clock.elapsed().as_secs_f64()));
        clock = Instant::now();
    };
    let used = session.survey.counts.used;
    let mut run = Run::begin(session, plan.batch, folder, plan.bins, &*progress("sorting", used))?;
    lap("bin");
    let rounds = session.method.rounds().unwrap_or_default();
    let binned: u64 = run.places().iter().map(|p| p.1).sum();
    let found = folder.join(FOUND);
    if let [before @ .., _] = rounds
        && !before.is_empty()
    {
        match recall(&found, run.found().len()) {
            Some(words) => *run.found() = words,
            None => {
                let traversals = before.iter().map(|r| r.len() as u64).sum::<u64>();
                run.gather(backend, &*progress("weighing", binned * traversals))?;
                keep(folder, run.found())?;
            }
        }
        lap("gather");
    }
    let done = sink.done();
    let rest = run.places().iter().filter(|p| !done.contains(&p.0)).map(|p| p.1).sum::<u64>();
    let traversals = rounds.last().map_or(1, |r| r.len() as u64);
    let bar = progress(MAPPING, rest * traversals);
    run.finish(backend, &done, &*bar, &mut |chunk| sink.write(&chunk))?;
    lap("map");
    let _ = std::fs::remove_file(&found);
    debug_assert!(places(&session.grid).count() >= sink.done().len());
    let Counts { outside, empty_arc, wide, .. } = run.counts;
    let counts = Counts { outside, empty_arc, wide, ..session.survey.counts };
    let busy = [("read", run.busy.read), ("kernels", run.busy.kernels), ("take", run.busy.take)];
    Ok(Done { counts, seconds, busy: busy.map(|(thread, s)| (thread.to_string(), s)).into() })
}

/// Keeps what was found, with a checksum, whole or not at all.
fn keep(folder: &Path, found: &[u32]) -> Result<()> {
    let [path, partial] = [FOUND, FOUND_PARTIAL].map(|name| folder.join(name));
    let full =
        |e: std::io::Error| Error::Resources(format!("{} can't be written: {e}; free space there", path.display()));
    let bytes: &[u8] = bytemuck::cast_slice(found);
    std::fs::write(&partial, [&Sha256::digest(bytes)[..], bytes].concat()).map_err(full)?;
    std::fs::rename(&partial, &path).map_err(full)
}

/// What an earlier run found for so many readings, if it is whole.
fn recall(path: &Path, readings: usize) -> Option<Vec<u32>> {
    let kept = std::fs::read(path).ok()?;
    let (sum, bytes) = kept.split_at_checked(32)?;
    let whole = bytes.len() == 4 * readings && Sha256::digest(bytes)[..] == *sum;
    whole.then(|| bytemuck::pod_collect_to_vec(bytes))
}
