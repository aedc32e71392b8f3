//! A round over the chunks as three stages, each on a thread, with bounded queues between them: read and bin ahead; run the kernels;
//! make the layers of finished chunks and hand them to the sink.

use super::busy::{StageClock, StageTimes};
use super::reader::{BinnedBatch, ChunkReader};
use crate::grid::{ChunkId, GridSpec, part};
use crate::kernels::{Backend, ChunkStates, Shares, normalize_by_count};
use crate::method::{Method, Step, Steps};
use crate::pipeline::batching::frame;
use crate::pipeline::finished::FinishedMap;
use crate::pipeline::layers;
use crate::{Error, Result};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// A finished chunk.
#[derive(Debug, Clone)]
pub struct FinishedChunk {
    /// Row and column.
    pub place: ChunkId,
    /// Its part of the map, on its part of the grid.
    pub finished: FinishedMap,
}

/// Receives the finished chunks, in order.
pub type OnChunk<'a> = dyn FnMut(FinishedChunk) -> Result<()> + Send + 'a;

/// One round over the chunks.
pub(super) struct Round<'a> {
    pub grid: &'a GridSpec,
    pub method: &'a dyn Method,
    /// The steps of each pass over a chunk's readings.
    pub traversals: &'static [Steps],
    /// The chunks, each with its number of readings.
    pub places: &'a [(ChunkId, u64)],
    /// Receives the number of readings done since its last call.
    pub progress: &'a dyn Fn(u64),
}

impl Round<'_> {
    /// Runs the round. `totals` holds the total of each reading so far; it is empty for a method of one round. With `take` it is the
    /// last round: chunks are finished and handed to `take`.
    ///
    /// # Errors
    /// The first error of the stages, in the order of the data.
    pub fn run(
        &self,
        reader: &ChunkReader,
        backend: &mut dyn Backend,
        totals: &mut [u32],
        take: Option<&mut OnChunk>,
    ) -> Result<StageTimes> {
        let (grid, method, last) = (self.grid, self.method, take.is_some());
        let (places, traversals) = (self.places, self.traversals);
        std::thread::scope(|scope| {
            let (ready, batches) = sync_channel(1);
            let (finished, words) = sync_channel(1);
            let (give_back, zeros) = sync_channel(1);
            let give_back = backend.recycles_buffers().then_some(give_back);
            let reading = scope.spawn(move || read(reader, places, traversals, &ready));
            let taking = take.map(|take| scope.spawn(move || finish(grid, method, &words, give_back.as_ref(), take)));
            let kernels = self.kernels(backend, totals, Queues { batches, finished, zeros, last });
            // A stage that panicked closed its queue, which looks like an end.
            let read = reading.join().map_err(|_| died("the chunks' reader"));
            let taken = taking.map_or(Ok(0.0), |t| t.join().unwrap_or_else(|_| Err(died("the chunks' writer"))));
            Ok(StageTimes { kernels: kernels?, read: read?, take: taken? })
        })
    }

    /// The second stage: runs the kernels over each batch. The queues close when it ends, so that no other stage waits for it.
    fn kernels(&self, backend: &mut dyn Backend, totals: &mut [u32], queues: Queues) -> Result<f64> {
        let Queues { batches, finished, zeros, last: last_round } = queues;
        let rounds = self.method.rounds().unwrap_or_default();
        let counted = rounds.iter().copied().flatten().any(|steps| steps.contains(&Step::AccumulateCounts));
        let mut clock = StageClock::start();
        while let Ok(batch) = clock.wait(|| batches.recv()) {
            let BinnedBatch { place, steps, batch, numbers, readings, last } = batch?;
            let before = numbers.iter().map(|n| totals.get(*n as usize).copied().unwrap_or(0));
            let mut share: Shares = match last_round && counted {
                true => normalize_by_count(self.method, before, batch.cones()),
                false => before.map(|word| [word, 0, 0, 0]).collect(),
            };
            zeros.try_iter().for_each(|zeros| backend.recycle(zeros));
            backend.apply(self.method, frame(self.grid, self.method), &batch, steps, &mut share)?;
            if !last_round {
                numbers.iter().zip(&share).for_each(|(n, s)| totals[*n as usize] = s[0]);
            }
            (self.progress)(readings);
            let words = if last { backend.take(place)? } else { None };
            // There is more to come for the chunk, or nothing has reached it.
            let Some(mut words) = words else { continue };
            if last_round {
                // A last stage that failed has the error.
                if clock.wait(|| finished.send((place, words))).is_err() {
                    break;
                }
            } else if backend.recycles_buffers() {
                words.fill(0);
                backend.recycle(words);
            }
        }
        Ok(clock.worked())
    }
}

/// The queues of the second stage.
struct Queues {
    batches: Receiver<Result<BinnedBatch>>,
    finished: SyncSender<(ChunkId, Vec<u32>)>,
    /// The zeroed memory of finished chunks, to be reused.
    zeros: Receiver<Vec<u32>>,
    /// Whether it is the last round.
    last: bool,
}

/// The first stage: reads the chunks' readings and bins them, one batch ahead.
fn read(
    reader: &ChunkReader,
    places: &[(ChunkId, u64)],
    traversals: &'static [Steps],
    ready: &SyncSender<Result<BinnedBatch>>,
) -> f64 {
    let mut clock = StageClock::start();
    let ahead = places.iter().try_for_each(|(place, count)| {
        let give = &mut |batch| clock.wait(|| ready.send(Ok(batch)).is_ok());
        reader.batches(*place, *count, traversals, give)
    });
    if let Err(e) = ahead {
        // A second stage that ended has an error of its own.
        let _ = ready.send(Err(e));
    }
    clock.worked()
}

/// The third stage: makes the layers of each chunk and has it taken.
fn finish(
    grid: &GridSpec,
    method: &dyn Method,
    words: &Receiver<(ChunkId, Vec<u32>)>,
    give_back: Option<&SyncSender<Vec<u32>>>,
    take: &mut OnChunk,
) -> Result<f64> {
    let mut clock = StageClock::start();
    while let Ok((place, words)) = clock.wait(|| words.recv()) {
        let mut cells: ChunkStates = [(ChunkId::default(), words)].into();
        let finished = layers::from_chunks(&part(grid, place), method, &cells);
        if let (Some(give_back), Some((_, mut words))) = (give_back, cells.pop_first()) {
            words.fill(0);
            // If the one before is still there, one is enough.
            let _ = give_back.try_send(words);
        }
        take(FinishedChunk { place, finished })?;
    }
    Ok(clock.worked())
}

fn died(stage: &str) -> Error {
    Error::Resources(format!("{stage} died; this is a defect of echogrid: please report it"))
}
