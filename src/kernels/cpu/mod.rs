//! The CPU backend. A task (rayon) is a tile; a row of 16 cells is one vector, or as many as the processor needs for it. The kernels do
//! the operations of the WGSL in the same order.

mod gro;

use super::{Backend, ChunkStates, KernelError, Limits, Shares, accumulate_counts, check_input, normalize_by_count};
use crate::binning::batch::{Batch, ChunkList, Input};
use crate::geometry::layout::{CHUNK, Frame};
use crate::grid::ChunkId;
use crate::method::driver::{Job, TileTask, simd_level};
use crate::method::settings::Settings;
use crate::method::{self, Method, Pass, Step};
use crate::{Error, Result};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

/// The CPU backend.
pub struct Cpu {
    /// `None`: the program's own pool, where it has as many threads; threads of another pool would be slow to wake.
    pool: Option<rayon::ThreadPool>,
    chunks: ChunkStates,
    /// Chunks of zeros to use again: the first touch of new memory costs a system call for each page.
    recycled: Vec<Vec<u32>>,
    /// Seconds of each kind of pass, while they are timed.
    times: Option<BTreeMap<&'static str, f64>>,
}

/// The cells of a chunk that no reading has reached, all zeros; a tile has `tile_words`.
fn fresh_chunk(recycled: &mut Vec<Vec<u32>>, tile_words: usize) -> Vec<u32> {
    let words = tile_words * CHUNK * CHUNK;
    // Zeros come from the system as needed: tiles that no reading reaches cost no memory.
    recycled.pop().filter(|zeros| zeros.len() == words).unwrap_or_else(|| vec![0; words])
}

impl Cpu {
    /// With so many threads. With 0, or as many as the caller's pool has, it uses the pool in which it is called.
    pub fn new(threads: usize) -> Result<Cpu> {
        let own = || {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|e| Error::Resources(format!("can't start {threads} threads: {e}")))
        };
        let shared = threads == 0 || threads == rayon::current_num_threads();
        let pool = if shared { None } else { Some(own()?) };
        Ok(Cpu { pool, chunks: ChunkStates::new(), recycled: Vec::new(), times: None })
    }

    /// The cells so far.
    pub fn chunks(&self) -> &ChunkStates {
        &self.chunks
    }

    /// The cells so far, to be restored to an earlier state.
    pub fn chunks_mut(&mut self) -> &mut ChunkStates {
        &mut self.chunks
    }
}

impl Backend for Cpu {
    fn name(&self) -> &'static str {
        "cpu"
    }

    fn adapter(&self) -> String {
        format!("{} threads, {}", threads(&self.pool), simd_level())
    }

    fn peaks(&mut self) -> Result<Option<super::peak::Peaks>> {
        let threads = threads(&self.pool);
        install(&self.pool, || super::peak::cpu(threads)).map(Some)
    }

    fn limits(&self) -> Limits {
        Limits {
            readings: 1 << 24,
            entries: 1 << 27,
            parts: 1 << 27,
            max_loop_iterations: usize::MAX,
            bins_tiles: false,
        }
    }

    fn apply(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        batch: &Batch,
        steps: &[Step],
        shares_so_far: &mut Shares,
    ) -> Result<()> {
        check_input(method, batch)?;
        let Cpu { pool, chunks, recycled, times } = self;
        let words = method::tile_words(method);
        for list in &batch.chunks {
            chunks.entry(list.place).or_insert_with(|| fresh_chunk(recycled, words));
        }
        if let Settings::Himm(himm) = method.settings()
            && himm.gro
        {
            gro::apply(frame, batch, chunks);
            return Ok(());
        }
        let parts: Vec<AtomicU32> = (0..batch.parts().max(batch.cones().len())).map(|_| AtomicU32::new(0)).collect();
        let counts = || parts.iter().map(|p| p.load(Ordering::Relaxed));
        let mut share = shares_so_far.clone();
        install(pool, || -> Result<()> {
            for step in steps {
                let started = Instant::now();
                match *step {
                    Step::Pass(pass, mode) => {
                        let frame = Frame { mode, ..frame };
                        for list in &batch.chunks {
                            let chunk = list.place;
                            let state = chunks.get_mut(&chunk).ok_or(KernelError::NotResident { chunk })?;
                            let work = ChunkPass { method, pass, frame: &frame, input: &batch.input, list };
                            work.run(&parts, &share, state)?;
                        }
                    }
                    Step::Sum => share = sum(batch, &parts, &share),
                    Step::NormalizeByCount => share = normalize_by_count(method, counts(), batch.cones()),
                    Step::ReadBack => shares_so_far.clone_from(&share),
                    Step::AccumulateCounts => accumulate_counts(shares_so_far, counts(), batch.cones().len()),
                }
                if let (Some(times), Some(name)) = (times.as_mut(), name(step)) {
                    *times.entry(name).or_default() += started.elapsed().as_secs_f64();
                }
            }
            Ok(())
        })
    }

    fn time_passes(&mut self) {
        self.times = Some(BTreeMap::new());
    }

    fn pass_times(&mut self) -> Vec<(&'static str, f64)> {
        self.times.take().unwrap_or_default().into_iter().collect()
    }

    fn take(&mut self, place: ChunkId) -> Result<Option<Vec<u32>>> {
        Ok(self.chunks.remove(&place))
    }

    fn recycles_buffers(&self) -> bool {
        true
    }

    fn recycle(&mut self, zeros: Vec<u32>) {
        self.recycled.push(zeros);
    }

    fn finish(&mut self, _: &dyn Method) -> Result<ChunkStates> {
        Ok(std::mem::take(&mut self.chunks))
    }
}

fn threads(pool: &Option<rayon::ThreadPool>) -> usize {
    pool.as_ref().map_or_else(rayon::current_num_threads, rayon::ThreadPool::current_num_threads)
}

fn install<R: Send>(pool: &Option<rayon::ThreadPool>, work: impl FnOnce() -> R + Send) -> R {
    match pool {
        Some(pool) => pool.install(work),
        None => rayon::scope(|_| work()),
    }
}

/// The name of a step in measurements; `None` for steps that only move data.
fn name(step: &Step) -> Option<&'static str> {
    match step {
        Step::Pass(Pass::Weigh, _) => Some("weigh"),
        Step::Pass(Pass::Count, _) => Some("count"),
        Step::Pass(Pass::Fuse, _) => Some("fuse"),
        Step::Sum => Some("sum"),
        Step::NormalizeByCount | Step::ReadBack | Step::AccumulateCounts => None,
    }
}

/// One pass over a chunk's tiles.
struct ChunkPass<'a> {
    method: &'a dyn Method,
    pass: Pass,
    frame: &'a Frame,
    input: &'a Input,
    list: &'a ChunkList,
}

impl ChunkPass<'_> {
    /// Runs the pass over the chunk's cells; a tile is a task.
    fn run(&self, parts: &[AtomicU32], shares: &[[u32; 4]], state: &mut [u32]) -> Result<()> {
        let ChunkPass { method, pass, frame, input, list } = *self;
        // Each listed tile with its own words: slots ascend, so the state is cut from the left.
        let words = method::tile_words(method);
        let (mut rest, mut cut, mut work) = (state, 0, Vec::with_capacity(list.tiles.len()));
        for tile in &list.tiles {
            let at = tile.slot as usize * words;
            let (cells, after) = std::mem::take(&mut rest).split_at_mut(at - cut).1.split_at_mut(words);
            (rest, cut) = (after, at + words);
            work.push((tile, cells));
        }
        work.into_par_iter().try_for_each(|(tile, cells)| {
            let entries = &list.entries[tile.entries[0] as usize..tile.entries[1] as usize];
            method.run(pass, &Job::new(TileTask { frame, tile, entries }, input, parts, shares), cells)
        })?;
        Ok(())
    }
}

/// The sum of each reading's parts, added in tile order to the reading's share; twin of `shaders/method/driver/sum.wgsl`.
fn sum(batch: &Batch, parts: &[AtomicU32], shares: &[[u32; 4]]) -> Shares {
    let before = |k: usize| shares.get(k).map_or(0.0, |s| f32::from_bits(s[0]));
    let part = |k: u32| f32::from_bits(parts[k as usize].load(Ordering::Relaxed));
    batch
        .first_part()
        .windows(2)
        .enumerate()
        .map(|(k, w)| {
            let sum = (w[0]..w[1]).fold(before(k), |sum, k| sum + part(k));
            [f32::to_bits(sum), 0, 0, 0]
        })
        .collect()
}
