//! The rounds over the chunks: one thread reads and bins ahead, this one runs the kernels, one takes finished chunks.

use super::scanned::Scanned;
use super::{Bins, Place, part};
use crate::batch::{Batch, Binning, snapped};
use crate::kernels::{Backend, Chunks, Limits, Shares, shares};
use crate::layers;
use crate::layout::Cone;
use crate::mapper::{Finished, count, frame, snap_item, too_large};
use crate::method::settings::Settings;
use crate::method::{Method, Step, Steps};
use crate::reading::Counts;
use crate::session::Session;
use crate::{Error, Result};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

/// A finished chunk.
#[derive(Debug, Clone)]
pub struct Chunk {
    /// Row and column.
    pub place: Place,
    /// Its part of the map, on its part of the grid.
    pub finished: Finished,
}

/// A log under way, chunk by chunk.
pub struct Run<'a> {
    session: &'a Session,
    method: &'a dyn Method,
    batch: usize,
    source: Source,
    /// What each reading's rounds have found: the bits of a sum, or a count.
    found: Vec<u32>,
    /// `outside`, `empty_arc` and `wide` are counted while binning.
    pub counts: Counts,
    /// How long the threads of the last round had work.
    pub busy: Busy,
}

/// Seconds that the threads of a round had work.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Busy {
    /// Reading and binning ahead.
    pub read: f64,
    /// Running kernels.
    pub kernels: f64,
    /// Taking finished chunks.
    pub take: f64,
}

/// A thread's time, but for that it waits.
struct Clock {
    started: Instant,
    waited: Duration,
}

impl Clock {
    fn start() -> Clock {
        Clock { started: Instant::now(), waited: Duration::ZERO }
    }

    /// Does what is but waiting for another thread.
    fn wait<T>(&mut self, what: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let done = what();
        self.waited += started.elapsed();
        done
    }

    fn worked(&self) -> f64 {
        (self.started.elapsed() - self.waited).as_secs_f64()
    }
}

/// What the chunks are made of.
enum Source {
    /// Readings, by chunk.
    Readings(Bins),
    /// Scans, and where their poses are.
    Scans(Box<Scanned>),
}

/// A batch of one chunk's readings, binned, with its readings' numbers in the log.
struct Ready {
    place: Place,
    steps: Steps,
    batch: Batch,
    numbers: Vec<u32>,
    /// How many readings it is, in the chunk's count.
    readings: u64,
    /// Whether it is the chunk's last of this round.
    last: bool,
}

impl<'a> Run<'a> {
    /// Bins the session's readings; `progress` hears of each.
    ///
    /// # Errors
    /// The log's, and [`Error::Resources`] where readings can't be spilled to `folder`.
    pub fn begin(
        session: &'a Session,
        batch: usize,
        folder: &std::path::Path,
        memory: u64,
        progress: &dyn Fn(u64),
    ) -> Result<Run<'a>> {
        let method = session.method.as_ref();
        if let Settings::Csm(csm) = method.settings() {
            let scanned = Scanned::read(&session.grid, csm, session.scans()?, (folder, memory), progress)?;
            let source = Source::Scans(Box::new(scanned));
            return Ok(Run {
                session,
                method,
                batch,
                source,
                found: Vec::new(),
                counts: Counts::default(),
                busy: Busy::default(),
            });
        }
        let source = Source::Readings(Bins::new(folder, memory));
        let mut run =
            Run { session, method, batch, source, found: Vec::new(), counts: Counts::default(), busy: Busy::default() };
        let (mut held, mut number) = (Vec::with_capacity(batch), 0u64);
        for item in session.items()? {
            held.push(item?);
            progress(1);
            if held.len() == batch {
                run.bin(&held, &mut number)?;
                held.clear();
            }
        }
        run.bin(&held, &mut number)?;
        if method.rounds().is_some_and(|rounds| rounds.len() > 1) {
            run.found = vec![0; number as usize];
        }
        Ok(run)
    }

    fn bin(&mut self, items: &[crate::mapper::Item], number: &mut u64) -> Result<()> {
        let (grid, sensors) = (&self.session.grid, self.session.sensors());
        let binning = self.binning(&[], None);
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
                if let Source::Readings(bins) = &mut self.source {
                    bins.push([row, column], cone)?;
                }
            }
        }
        Ok(())
    }

    fn binning(&self, steps: &[Step], only: Option<Place>) -> Binning {
        Binning {
            size: [self.session.grid.width, self.session.grid.height],
            footprint: self.method.footprint(),
            no_echo_arcs: steps.contains(&Step::Tally),
            only: only.map(|[row, column]| [column, row]),
        }
    }

    /// The chunks that readings reach, row by row, and how many readings each has.
    pub fn places(&self) -> Vec<(Place, u64)> {
        match &self.source {
            Source::Readings(bins) => bins.places(),
            Source::Scans(scans) => scans.places(),
        }
    }

    /// Bytes that were spilled.
    pub fn spilled(&self) -> u64 {
        match &self.source {
            Source::Readings(bins) => bins.spilled(),
            Source::Scans(scans) => scans.spilled(),
        }
    }

    /// What the rounds before the last have found, to be kept or given back.
    pub fn found(&mut self) -> &mut Vec<u32> {
        &mut self.found
    }

    /// Tries a backend on the busiest chunk for about so many seconds: how many of its readings were gone over, in what
    /// time, and what the chunk came to.
    pub fn calibrate(&self, backend: &mut dyn Backend, seconds: f64) -> Result<(u64, f64, Option<Chunk>)> {
        let Some((place, count)) = self.places().into_iter().max_by_key(|p| p.1) else { return Ok((0, 0.0, None)) };
        let rounds = self.method.rounds().unwrap_or_default();
        let last = rounds.last().copied().unwrap_or_default();
        let (started, mut done, mut failed) = (Instant::now(), 0, None);
        self.read_ahead(place, count, &last[..last.len().min(1)], backend.limits(), &mut |ready| {
            let mut share: Shares = vec![[1, 0, 0, 0]; ready.numbers.len()];
            let frame = frame(&self.session.grid, self.method);
            failed = backend.apply(self.method, frame, &ready.batch, ready.steps, &mut share).err();
            done += ready.readings;
            failed.is_none() && started.elapsed().as_secs_f64() < seconds
        })?;
        if let Some(e) = failed {
            return Err(e);
        }
        backend.wait()?;
        let taken = started.elapsed().as_secs_f64();
        let grid = part(&self.session.grid, place);
        let chunk = backend.take(place)?.map(|words| {
            let finished = layers::from_chunks(&grid, self.method, &[([0, 0], words)].into());
            Chunk { place: [0, 0], finished }
        });
        Ok((done, taken, chunk))
    }

    /// The rounds before the last: each reading's sum, or count, over all chunks.
    pub fn gather(&mut self, backend: &mut dyn Backend, progress: &dyn Fn(u64)) -> Result<()> {
        let [before @ .., _] = self.method.rounds().unwrap_or_default() else { return Ok(()) };
        before.iter().try_for_each(|round| self.round(backend, round, &self.places(), progress, None))
    }

    /// The last round: each chunk but those `done` is run to its end and given to `take`, in order, on a thread of its own.
    pub fn finish(
        &mut self,
        backend: &mut dyn Backend,
        done: &BTreeSet<Place>,
        progress: &dyn Fn(u64),
        take: &mut (dyn FnMut(Chunk) -> Result<()> + Send),
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
        take: Option<&mut (dyn FnMut(Chunk) -> Result<()> + Send)>,
    ) -> Result<()> {
        let (session, method, limits) = (self.session, self.method, backend.limits());
        let tallied = method.rounds().unwrap_or_default().iter().copied().flatten().any(|s| s.contains(&Step::Tally));
        let mut found = std::mem::take(&mut self.found);
        let this = &*self;
        let last_round = take.is_some();
        let result = std::thread::scope(|scope| {
            let (ready, batches) = sync_channel::<Result<Ready>>(1);
            let reader = scope.spawn(move || {
                let mut clock = Clock::start();
                let ahead = places.iter().try_for_each(|(place, count)| {
                    let give = &mut |batch| clock.wait(|| ready.send(Ok(batch)).is_ok());
                    this.read_ahead(*place, *count, traversals, limits, give)
                });
                if let Err(e) = ahead {
                    let _ = ready.send(Err(e));
                }
                clock.worked()
            });
            let (finished, chunks) = sync_channel::<(Place, Vec<u32>)>(1);
            let (give_back, zeros) = sync_channel::<Vec<u32>>(1);
            let reuses = backend.reuses();
            let taker = take.map(|take| {
                scope.spawn(move || {
                    let mut clock = Clock::start();
                    while let Ok((place, words)) = clock.wait(|| chunks.recv()) {
                        let grid = part(&session.grid, place);
                        let mut cells: Chunks = [([0, 0], words)].into();
                        let finished = layers::from_chunks(&grid, method, &cells);
                        if reuses && let Some((_, mut words)) = cells.pop_first() {
                            words.fill(0);
                            // If the one before is still there, one is enough.
                            let _ = give_back.try_send(words);
                        }
                        take(Chunk { place, finished })?;
                    }
                    Ok(clock.worked())
                })
            });
            let work = || -> Result<f64> {
                // Gone with this closure, so that the reader never waits for one that failed.
                let (mut clock, batches) = (Clock::start(), batches);
                while let Ok(batch) = clock.wait(|| batches.recv()) {
                    let Ready { place, steps, batch, numbers, readings, last } = batch?;
                    let before = numbers.iter().map(|n| found.get(*n as usize).copied().unwrap_or(0));
                    let mut share: Shares = match last_round && tallied {
                        true => shares(method, before, &batch.cones),
                        false => before.map(|word| [word, 0, 0, 0]).collect(),
                    };
                    zeros.try_iter().for_each(|zeros| backend.spare(zeros));
                    backend.apply(method, frame(&session.grid, method), &batch, steps, &mut share)?;
                    if !last_round {
                        numbers.iter().zip(&share).for_each(|(n, s)| found[*n as usize] = s[0]);
                    }
                    progress(readings);
                    if last && let Some(mut words) = backend.take(place)? {
                        if !last_round && reuses {
                            words.fill(0);
                            backend.spare(words);
                        } else if last_round && clock.wait(|| finished.send((place, words))).is_err() {
                            // A taker that failed has the error.
                            break;
                        }
                    }
                }
                Ok(clock.worked())
            };
            let worked = work();
            drop(finished);
            // A thread that died closed its channel, which looks like an end.
            let died =
                |who: &str| Error::Resources(format!("{who} died; this is a defect of echogrid: please report it"));
            let read = reader.join().map_err(|_| died("the chunks' reader"));
            let taken = taker.map_or(Ok(0.0), |t| t.join().unwrap_or_else(|_| Err(died("the chunks' writer"))));
            let kernels = worked?;
            Ok(Busy { read: read?, kernels, take: taken? })
        });
        self.found = found;
        self.busy = result?;
        Ok(())
    }

    /// Reads a chunk's readings, batch by batch, and bins them; stops when nobody takes them any more.
    fn read_ahead(
        &self,
        place: Place,
        count: u64,
        traversals: &'static [Steps],
        limits: Limits,
        give: &mut dyn FnMut(Ready) -> bool,
    ) -> Result<()> {
        let batch = self.batch.clamp(1, limits.readings);
        let bins = match &self.source {
            Source::Readings(bins) => bins,
            Source::Scans(scans) => {
                return scans.batches(place, batch, limits, &mut |batch, share, last| {
                    let readings = (share * count as f64) as u64;
                    give(Ready { place, steps: traversals[0], batch, numbers: Vec::new(), readings, last })
                });
            }
        };
        for (t, steps) in traversals.iter().enumerate() {
            let binning = self.binning(steps, Some(place));
            for first in (0..count as usize).step_by(batch) {
                let cones = bins.read(place, first, batch)?;
                let last = t + 1 == traversals.len() && first + batch >= count as usize;
                if !self.split(&binning, cones, steps, place, last, limits, give)? {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Bins cones, in halves where they come to too much; whether they were all taken.
    #[allow(clippy::too_many_arguments, reason = "it calls itself with a half")]
    fn split(
        &self,
        binning: &Binning,
        cones: Vec<Cone>,
        steps: Steps,
        place: Place,
        last: bool,
        limits: Limits,
        give: &mut dyn FnMut(Ready) -> bool,
    ) -> Result<bool> {
        let numbers: Vec<u32> = cones.iter().map(|c| c.index).collect();
        let batch = binning.of(&cones, snapped, limits.lists);
        let fits = match &batch {
            Some(batch) => !too_large(self.method, batch, steps.contains(&Step::Sum), limits, cones.len() == 1)?,
            None => false,
        };
        match batch.filter(|_| fits) {
            Some(batch) => Ok(give(Ready { place, steps, batch, readings: numbers.len() as u64, numbers, last })),
            None => {
                let (head, tail) = cones.split_at(cones.len() / 2);
                Ok(self.split(binning, head.to_vec(), steps, place, false, limits, give)?
                    && self.split(binning, tail.to_vec(), steps, place, last, limits, give)?)
            }
        }
    }
}
