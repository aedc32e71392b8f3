//! A run over a log, chunk by chunk: readings are sorted to chunks once, then each chunk takes its own, round by round.

use super::ChunkBins;
use super::busy::StageTimes;
use super::reader::{ChunkReader, InputSource};
use super::sort::Sorter;
use super::stages::{FinishedChunk, OnChunk, Round};
use crate::grid::{ChunkId, part};
use crate::kernels::{Backend, Limits, Shares};
use crate::log::reading::Counts;
use crate::method::{self, Input, Method, Steps};
use crate::pipeline::batching::frame;
use crate::pipeline::layers;
use crate::pipeline::scans::{ChunkedScans, Spill};
use crate::pipeline::session::Session;
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

/// A run over a log, chunk by chunk.
pub struct OutOfCoreRun<'a> {
    session: &'a Session,
    method: &'a dyn Method,
    /// The traversals of each round: those before the last gather totals, the last one updates.
    first_rounds: &'static [&'static [Steps]],
    last_round: &'static [Steps],
    batch: usize,
    source: InputSource,
    /// The total of each reading from the first rounds: the bits of a sum, or a count. Empty for a method of one round.
    totals: Vec<u32>,
    /// `outside`, `empty_arc` and `wide` are counted while readings are sorted.
    pub counts: Counts,
    /// The busy times of the stages of the last round.
    pub busy: StageTimes,
}

/// The work of a backend on the busiest chunk in a short time.
#[derive(Debug, Clone, Default)]
pub struct Calibration {
    /// Readings done.
    pub readings: u64,
    /// Seconds that they took.
    pub seconds: f64,
    /// The chunk after those readings; `None` where nothing reached it.
    pub chunk: Option<FinishedChunk>,
}

impl<'a> OutOfCoreRun<'a> {
    /// Begins a run: sorts the session's readings to chunks. `batch`: readings at a time; `memory`: the memory that the sorted readings
    /// may take, bytes, before they are spilled to `folder`. `progress` receives the number of readings sorted since its last call.
    ///
    /// # Errors
    /// The log's; [`Error::Resources`] where readings can't be spilled to `folder`; [`Error::Usage`] for a method without
    /// [rounds](Method::rounds).
    pub fn begin(
        session: &'a Session,
        batch: usize,
        folder: &Path,
        memory: u64,
        progress: &dyn Fn(u64),
    ) -> Result<OutOfCoreRun<'a>> {
        let method = session.method.as_ref();
        let Some((last_round, first_rounds)) = method.rounds().and_then(|rounds| rounds.split_last()) else {
            let name = method::name(method);
            return Err(Error::Usage(format!("{name} can't run chunk by chunk: map the log by Session::map")));
        };
        let (source, counts, readings) = match method.input(session.grid.resolution) {
            Input::Readings => {
                let mut sorter = Sorter::new(session, ChunkBins::new(folder, memory));
                sorter.sort(batch, progress)?;
                (InputSource::Readings(sorter.bins), sorter.counts, sorter.readings)
            }
            Input::Scans { selection, .. } => {
                let spill = Spill { folder: folder.into(), memory };
                let scans = ChunkedScans::read(&session.grid, selection, session.scans()?, &spill, progress)?;
                (InputSource::Scans(Box::new(scans)), Counts::default(), 0)
            }
            Input::Updates(_) => {
                return Err(Error::Usage("updates can't be sorted to chunks: map the log by Session::map".into()));
            }
        };
        let totals = if first_rounds.is_empty() { Vec::new() } else { vec![0; readings as usize] };
        let busy = StageTimes::default();
        Ok(OutOfCoreRun { session, method, first_rounds, last_round, batch, source, totals, counts, busy })
    }

    /// The chunks that readings reach, row by row, each with its number of readings.
    pub fn chunks(&self) -> Vec<(ChunkId, u64)> {
        self.source.chunks()
    }

    /// Bytes that were spilled to disk.
    pub fn spilled(&self) -> u64 {
        self.source.spilled()
    }

    /// The rounds before the last, which gather the totals of readings.
    pub fn first_rounds(&self) -> &'static [&'static [Steps]] {
        self.first_rounds
    }

    /// The traversals of the last round, which leaves the map.
    pub fn last_round(&self) -> &'static [Steps] {
        self.last_round
    }

    /// The total of each reading, to be kept for a resumed run or restored from it.
    pub fn totals(&mut self) -> &mut Vec<u32> {
        &mut self.totals
    }

    /// Tries a backend on the busiest chunk for about so many seconds.
    ///
    /// # Errors
    /// The backend's.
    pub fn calibrate(&self, backend: &mut dyn Backend, seconds: f64) -> Result<Calibration> {
        // Without a reading on the grid there is nothing to try.
        let Some((place, count)) = self.chunks().into_iter().max_by_key(|p| p.1) else {
            return Ok(Calibration::default());
        };
        let last = self.last_round;
        let (started, mut readings, mut failed) = (Instant::now(), 0, None);
        self.reader(backend.limits()).batches(place, count, &last[..last.len().min(1)], &mut |ready| {
            let mut share: Shares = vec![[1, 0, 0, 0]; ready.numbers.len()];
            let frame = frame(&self.session.grid, self.method);
            failed = backend.apply(self.method, frame, &ready.batch, ready.steps, &mut share).err();
            readings += ready.readings;
            failed.is_none() && started.elapsed().as_secs_f64() < seconds
        })?;
        if let Some(e) = failed {
            return Err(e);
        }
        backend.wait()?;
        let seconds = started.elapsed().as_secs_f64();
        let grid = part(&self.session.grid, place);
        let chunk = backend.take(place)?.map(|words| {
            let finished = layers::from_chunks(&grid, self.method, &[(ChunkId::default(), words)].into());
            FinishedChunk { place: ChunkId::default(), finished }
        });
        Ok(Calibration { readings, seconds, chunk })
    }

    /// Runs the rounds before the last, which total each reading's cells over all chunks.
    ///
    /// # Errors
    /// The log's and the backend's.
    pub fn gather(&mut self, backend: &mut dyn Backend, progress: &dyn Fn(u64)) -> Result<()> {
        let places = self.chunks();
        self.first_rounds.iter().try_for_each(|traversals| {
            let round = Round { grid: &self.session.grid, method: self.method, traversals, places: &places, progress };
            self.run_round(backend, &round, None)
        })
    }

    /// Runs the last round: each chunk but those in `done` is finished and handed to `take`, in order, on a thread of its own.
    ///
    /// # Errors
    /// The log's, the backend's and those of `take`.
    pub fn finish(
        &mut self,
        backend: &mut dyn Backend,
        done: &BTreeSet<ChunkId>,
        progress: &dyn Fn(u64),
        take: &mut OnChunk,
    ) -> Result<()> {
        let places: Vec<(ChunkId, u64)> =
            self.chunks().into_iter().filter(|(place, _)| !done.contains(place)).collect();
        let (grid, traversals) = (&self.session.grid, self.last_round);
        let round = Round { grid, method: self.method, traversals, places: &places, progress };
        self.run_round(backend, &round, Some(take))
    }

    fn run_round(&mut self, backend: &mut dyn Backend, round: &Round, take: Option<&mut OnChunk>) -> Result<()> {
        let mut totals = std::mem::take(&mut self.totals);
        let busy = round.run(&self.reader(backend.limits()), backend, &mut totals, take);
        self.totals = totals;
        self.busy = busy?;
        Ok(())
    }

    fn reader(&self, limits: Limits) -> ChunkReader<'_> {
        ChunkReader { source: &self.source, grid: &self.session.grid, method: self.method, batch: self.batch, limits }
    }
}
