//! A log to a map's files, chunk by chunk: what is done first, with how much memory, and what a resumed run needn't do again.

use super::{Run, places};
use crate::grid::GridSpec;
use crate::kernels::Backend;
use crate::memory::{self, show};
use crate::output::MapWriter;
use crate::output::names::{FOUND, FOUND_PARTIAL};
use crate::reading::Counts;
use crate::session::Session;
use crate::{Error, Result};
use sha2::{Digest, Sha256};
use std::path::Path;
use std::time::Instant;

/// How a run is to be done, checked before it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Readings at a time.
    pub batch: usize,
    /// What the run takes, bytes, apart from the binned readings.
    pub needed: u64,
    /// What the binned readings may take, bytes, before they are spilled.
    pub bins: u64,
    /// What the cells and batches take on a card, bytes, where a GPU maps.
    pub card: u64,
    /// What its files take on disk, bytes, without what is compressed.
    pub disk: u64,
}

/// Hears of a stage, by a word for people (`sorting`, `weighing`, [`MAPPING`]), and how many readings it goes over, each as often as
/// it is taken; what it gives hears of readings as they are done.
pub type Progress<'a> = &'a dyn Fn(&'static str, u64) -> Box<dyn Fn(u64)>;

/// Memory that a run leaves alone where no cap is given, as a share: others want some too.
const SPARE: u64 = 4;

impl Plan {
    /// The plan for a log under a cap, bytes; `batch`: readings at a time at most.
    ///
    /// # Errors
    /// [`Error::Resources`] where the cap, or the machine, has too little.
    pub fn of(session: &Session, batch: usize, cap: Option<u64>) -> Result<Plan> {
        let free = memory::available().map(|free| free - free / SPARE);
        let limit = [cap, free].into_iter().flatten().min().unwrap_or(4 << 30);
        let (grid, method, used) = (&session.grid, session.method.as_ref(), session.survey.counts.used);
        let batch = memory::whole_batch(batch, limit);
        let needed = memory::whole(grid, method, batch, used, session.survey.scans);
        let card = memory::card(method, batch);
        session.check_memory(needed, cap)?;
        // map.pgm, and the levels of the overview
        let disk = grid.cells() as u64 + grid.cells() as u64 / 3;
        Ok(Plan { batch, needed, bins: limit.saturating_sub(needed) / 2, card, disk })
    }

    /// Fails where a card would need more than the cap, bytes. No adapter tells how much it has free: one that runs out says so.
    ///
    /// # Errors
    /// [`Error::Resources`].
    pub fn check_card(&self, session: &Session, cap: Option<u64>) -> Result<()> {
        match cap {
            Some(cap) if self.card > cap => Err(session.explain(Error::Resources(format!(
                "the cells of a chunk and a batch take {} on the card, but --memory allows {}: give more, or use --backend cpu",
                show(self.card),
                show(cap)
            )))),
            _ => Ok(()),
        }
    }

    /// Fails where the map's files don't fit into a folder; `npy`: every layer is written as an array, too.
    pub fn check_space(&self, session: &Session, folder: &Path, npy: bool) -> Result<()> {
        let GridSpec { width, height, resolution, .. } = session.grid;
        let arrays = 4 * session.method.layers().len() as u64 + 2;
        let needed = self.disk + if npy { arrays * session.grid.cells() as u64 } else { 0 };
        match memory::space(folder) {
            Some(free) if needed > free => Err(session.explain(Error::Resources(format!(
                "the files of a map of {width} × {height} cells of {resolution} m take {} and more, but there are {} free: \
                 give smaller --bounds or a coarser --resolution",
                show(needed),
                show(free)
            )))),
            _ => Ok(()),
        }
    }
}

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
    writer: &mut MapWriter,
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
    let found = FOUND.at(folder);
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
    let done = writer.done();
    let rest = run.places().iter().filter(|p| !done.contains(&p.0)).map(|p| p.1).sum::<u64>();
    let traversals = rounds.last().map_or(1, |r| r.len() as u64);
    let bar = progress(MAPPING, rest * traversals);
    run.finish(backend, &done, &*bar, &mut |chunk| {
        let crate::mapper::Finished { map, combined, .. } = &chunk.finished;
        writer.chunk(chunk.place, map, combined)
    })?;
    lap("map");
    let _ = std::fs::remove_file(&found);
    debug_assert!(places(&session.grid).count() >= writer.done().len());
    let Counts { outside, empty_arc, wide, .. } = run.counts;
    let counts = Counts { outside, empty_arc, wide, ..session.survey.counts };
    let busy = [("read", run.busy.read), ("kernels", run.busy.kernels), ("take", run.busy.take)];
    Ok(Done { counts, seconds, busy: busy.map(|(thread, s)| (thread.to_string(), s)).into() })
}

/// Keeps what was found, with a checksum, whole or not at all.
fn keep(folder: &Path, found: &[u32]) -> Result<()> {
    let [path, partial] = [FOUND, FOUND_PARTIAL].map(|name| name.at(folder));
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
