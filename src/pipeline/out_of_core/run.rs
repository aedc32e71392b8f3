//! A log under way, chunk by chunk: readings are sorted to chunks once, then each chunk takes its own, round by round.

use super::busy::Busy;
use super::reader::{Reader, Source, binning};
use super::stages::{Chunk, Round, Take};
use super::{Bins, Scanned};
use crate::geometry::layout::Cone;
use crate::grid::{Place, part};
use crate::kernels::{Backend, Limits, Shares};
use crate::log::reading::Counts;
use crate::method::settings::Settings;
use crate::method::{Method, Steps};
use crate::pipeline::layers;
use crate::pipeline::mapper::{Item, count, frame, snap_item};
use crate::pipeline::session::Session;
use crate::{Error, Result};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

/// A log under way, chunk by chunk.
pub struct Run<'a> {
    session: &'a Session,
    method: &'a dyn Method,
    batch: usize,
    source: Source,
    /// What each reading's rounds have found: the bits of a sum, or a count.
    found: Vec<u32>,
    /// `outside`, `empty_arc` and `wide` are counted while readings are sorted.
    pub counts: Counts,
    /// How long the stages of the last round had work.
    pub busy: Busy,
}

/// What a backend made of the busiest chunk in a short time.
#[derive(Debug, Clone, Default)]
pub struct Calibration {
    /// Readings gone over.
    pub readings: u64,
    /// Seconds that it took.
    pub seconds: f64,
    /// What the chunk came to; `None` where nothing reached it.
    pub chunk: Option<Chunk>,
}

impl<'a> Run<'a> {
    /// Sorts the session's readings to chunks; `progress` hears of each. `batch`: readings at a time; `memory`: what the readings
    /// may take, bytes, before they are spilled to `folder`.
    ///
    /// # Errors
    /// The log's, and [`Error::Resources`] where readings can't be spilled to `folder`.
    pub fn begin(
        session: &'a Session,
        batch: usize,
        folder: &Path,
        memory: u64,
        progress: &dyn Fn(u64),
    ) -> Result<Run<'a>> {
        let method = session.method.as_ref();
        let source = match method.settings() {
            Settings::Csm(csm) => {
                let selection = csm.selection(session.grid.resolution);
                let scans = session.scans()?;
                Source::Scans(Box::new(Scanned::read(&session.grid, selection, scans, (folder, memory), progress)?))
            }
            _ => Source::Readings(Bins::new(folder, memory)),
        };
        let (found, counts, busy) = (Vec::new(), Counts::default(), Busy::default());
        let mut run = Run { session, method, batch, source, found, counts, busy };
        if let Source::Readings(_) = run.source {
            run.sort(progress)?;
        }
        Ok(run)
    }

    /// Sorts all readings to chunks.
    fn sort(&mut self, progress: &dyn Fn(u64)) -> Result<()> {
        let (mut held, mut number) = (Vec::with_capacity(self.batch), 0u64);
        for item in self.session.items()? {
            held.push(item?);
            progress(1);
            if held.len() == self.batch {
                self.sort_batch(&held, &mut number)?;
                held.clear();
            }
        }
        self.sort_batch(&held, &mut number)?;
        if self.method.rounds().is_some_and(|rounds| rounds.len() > 1) {
            self.found = vec![0; number as usize];
        }
        Ok(())
    }

    /// Sorts some readings, the first of which is the log's `number`-th.
    fn sort_batch(&mut self, items: &[Item], number: &mut u64) -> Result<()> {
        let Source::Readings(bins) = &mut self.source else { return Ok(()) };
        let (grid, sensors) = (&self.session.grid, self.session.sensors());
        let binning = binning(grid, self.method, &[], None);
        let first = *number;
        *number += items.len() as u64;
        if *number > u64::from(u32::MAX) {
            return Err(Error::Resources("more than 4294967295 used readings: map the log in parts".into()));
        }
        let cones: Vec<Option<(Cone, Vec<[u32; 2]>)>> = items
            .par_iter()
            .enumerate()
            .map(|(k, item)| {
                let cone = Cone { index: (first + k as u64) as u32, ..snap_item(grid, sensors, self.method, item)? };
                Some((cone, binning.chunks_of(&cone)))
            })
            .collect();
        let snapped: Vec<Cone> = cones.iter().flatten().map(|c| c.0).collect();
        self.counts.outside += (cones.len() - snapped.len()) as u64;
        count(&mut self.counts, &binning, &snapped);
        for (cone, chunks) in cones.into_iter().flatten() {
            for [column, row] in chunks {
                bins.push([row, column], cone)?;
            }
        }
        Ok(())
    }

    /// The chunks that readings reach, row by row, and how many readings each has.
    pub fn places(&self) -> Vec<(Place, u64)> {
        self.source.places()
    }

    /// Bytes that were spilled to disk.
    pub fn spilled(&self) -> u64 {
        self.source.spilled()
    }

    /// What the rounds before the last have found, to be kept or given back.
    pub fn found(&mut self) -> &mut Vec<u32> {
        &mut self.found
    }

    /// Tries a backend on the busiest chunk for about so many seconds.
    ///
    /// # Errors
    /// The backend's.
    pub fn calibrate(&self, backend: &mut dyn Backend, seconds: f64) -> Result<Calibration> {
        let Some((place, count)) = self.places().into_iter().max_by_key(|p| p.1) else {
            return Ok(Calibration::default());
        };
        let rounds = self.method.rounds().unwrap_or_default();
        let last = rounds.last().copied().unwrap_or_default();
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
            let finished = layers::from_chunks(&grid, self.method, &[([0, 0], words)].into());
            Chunk { place: [0, 0], finished }
        });
        Ok(Calibration { readings, seconds, chunk })
    }

    /// The rounds before the last: each reading's sum, or count, over all chunks.
    ///
    /// # Errors
    /// The log's and the backend's.
    pub fn gather(&mut self, backend: &mut dyn Backend, progress: &dyn Fn(u64)) -> Result<()> {
        let [before @ .., _] = self.method.rounds().unwrap_or_default() else { return Ok(()) };
        before.iter().try_for_each(|round| self.round(backend, round, &self.places(), progress, None))
    }

    /// The last round: each chunk but those `done` is run to its end and given to `take`, in order, on a thread of its own.
    ///
    /// # Errors
    /// The log's, the backend's and those of `take`.
    pub fn finish(
        &mut self,
        backend: &mut dyn Backend,
        done: &BTreeSet<Place>,
        progress: &dyn Fn(u64),
        take: &mut Take,
    ) -> Result<()> {
        let rounds = self.method.rounds().unwrap_or_default();
        let Some(last) = rounds.last() else { return Ok(()) };
        let places: Vec<(Place, u64)> = self.places().into_iter().filter(|(place, _)| !done.contains(place)).collect();
        self.round(backend, last, &places, progress, Some(take))
    }

    fn round(
        &mut self,
        backend: &mut dyn Backend,
        traversals: &'static [Steps],
        places: &[(Place, u64)],
        progress: &dyn Fn(u64),
        take: Option<&mut Take>,
    ) -> Result<()> {
        let mut found = std::mem::take(&mut self.found);
        let reader = self.reader(backend.limits());
        let round = Round { grid: &self.session.grid, method: self.method, traversals, places, progress };
        let busy = round.run(&reader, backend, &mut found, take);
        self.found = found;
        self.busy = busy?;
        Ok(())
    }

    fn reader(&self, limits: Limits) -> Reader<'_> {
        Reader { source: &self.source, grid: &self.session.grid, method: self.method, batch: self.batch, limits }
    }
}
