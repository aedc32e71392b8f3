//! The CPU's kernels: a tile a task (rayon), a row of 16 cells a vector of whatever width the processor has. They follow the WGSL operation by operation, in the same order.

mod gro;

use super::{Backend, Chunks, Limits, Shares, shares, tally};
use crate::binning::batch::{Batch, ChunkList};
use crate::geometry::layout::{CHUNK, Frame};
use crate::method::driver::{Job, simd_level};
use crate::method::settings::Settings;
use crate::method::{self, Method, Pass, Step};
use crate::{Error, Result};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

/// The CPU backend.
pub struct Cpu {
    /// `None`: the program's own, where it has as many threads. Threads that slept are slow to wake.
    pool: Option<rayon::ThreadPool>,
    chunks: Chunks,
    /// Zeros to be used again: a first touch of new memory costs a system call a page.
    spare: Vec<Vec<u32>>,
    /// Seconds of each kind of pass, while they are timed.
    times: Option<BTreeMap<&'static str, f64>>,
}

/// A chunk of cells that no reading has reached, for a method whose tiles have so many words.
fn fresh_chunk(spare: &mut Vec<Vec<u32>>, tile_words: usize) -> Vec<u32> {
    let words = tile_words * CHUNK * CHUNK;
    // Zeros come from the system as needed: tiles that no reading reaches cost no memory.
    spare.pop().filter(|zeros| zeros.len() == words).unwrap_or_else(|| vec![0; words])
}

impl Cpu {
    /// With that many threads; 0, or as many as the pool has that this is called in: those of whatever pool it works in.
    pub fn new(threads: usize) -> Result<Cpu> {
        let own = || {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .map_err(|e| Error::Resources(format!("can't start {threads} threads: {e}")))
        };
        let shared = threads == 0 || threads == rayon::current_num_threads();
        let pool = if shared { None } else { Some(own()?) };
        Ok(Cpu { pool, chunks: Chunks::new(), spare: Vec::new(), times: None })
    }

    /// The cells so far.
    pub fn chunks(&self) -> &Chunks {
        &self.chunks
    }

    /// The same, to be set to what they were before.
    pub fn chunks_mut(&mut self) -> &mut Chunks {
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

    fn ceilings(&mut self) -> Result<Option<super::ceiling::Ceilings>> {
        let threads = threads(&self.pool);
        install(&self.pool, || super::ceiling::cpu(threads)).map(Some)
    }

    fn limits(&self) -> Limits {
        Limits { readings: 1 << 24, entries: 1 << 27, parts: 1 << 27, turns: usize::MAX, lists: false }
    }

    fn apply(
        &mut self,
        method: &dyn Method,
        frame: Frame,
        batch: &Batch,
        steps: &[Step],
        shares_so_far: &mut Shares,
    ) -> Result<()> {
        let Cpu { pool, chunks, spare, times } = self;
        let words = method::tile_words(method);
        for list in &batch.chunks {
            chunks.entry([list.place[1], list.place[0]]).or_insert_with(|| fresh_chunk(spare, words));
        }
        if let Settings::Himm(himm) = method.settings()
            && himm.gro
        {
            gro::apply(frame, batch, chunks);
            return Ok(());
        }
        let parts = batch.first_part.last().copied().unwrap_or(0) as usize;
        let parts: Vec<AtomicU32> = (0..parts.max(batch.cones.len())).map(|_| AtomicU32::new(0)).collect();
        let counts = || parts.iter().map(|p| p.load(Ordering::Relaxed));
        let mut share = shares_so_far.clone();
        install(pool, || {
            for step in steps {
                let started = Instant::now();
                match *step {
                    Step::Pass(pass, mode) => {
                        let frame = Frame { mode, ..frame };
                        for list in &batch.chunks {
                            if let Some(state) = chunks.get_mut(&[list.place[1], list.place[0]]) {
                                run(method, pass, &frame, batch, list, &parts, &share, state);
                            }
                        }
                    }
                    Step::Sum => share = sums(batch, &parts, &share),
                    Step::Share => share = shares(method, counts(), &batch.cones),
                    Step::Hand => shares_so_far.clone_from(&share),
                    Step::Tally => tally(shares_so_far, counts(), batch.cones.len()),
                }
                if let (Some(times), Some(name)) = (times.as_mut(), name(step)) {
                    *times.entry(name).or_default() += started.elapsed().as_secs_f64();
                }
            }
        });
        Ok(())
    }

    fn time_passes(&mut self) {
        self.times = Some(BTreeMap::new());
    }

    fn pass_times(&mut self) -> Vec<(&'static str, f64)> {
        self.times.take().unwrap_or_default().into_iter().collect()
    }

    fn take(&mut self, place: [u32; 2]) -> Result<Option<Vec<u32>>> {
        Ok(self.chunks.remove(&place))
    }

    fn reuses(&self) -> bool {
        true
    }

    fn spare(&mut self, zeros: Vec<u32>) {
        self.spare.push(zeros);
    }

    fn finish(&mut self, _: &dyn Method) -> Result<Chunks> {
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

/// A step's name in measurements, if it is work of the processor.
fn name(step: &Step) -> Option<&'static str> {
    match step {
        Step::Pass(Pass::Weigh, _) => Some("weigh"),
        Step::Pass(Pass::Count, _) => Some("count"),
        Step::Pass(Pass::Fuse, _) => Some("fuse"),
        Step::Sum => Some("sum"),
        Step::Share | Step::Hand | Step::Tally => None,
    }
}

/// One pass over a chunk's tiles.
#[allow(clippy::too_many_arguments, reason = "the bindings of a dispatch")]
fn run(
    method: &dyn Method,
    pass: Pass,
    frame: &Frame,
    batch: &Batch,
    list: &ChunkList,
    parts: &[AtomicU32],
    shares: &[[u32; 4]],
    state: &mut [u32],
) {
    // Each listed tile with its own words: slots ascend, so the state is cut from the left.
    let words = method::tile_words(method);
    let (mut rest, mut cut, mut work) = (state, 0, Vec::with_capacity(list.tiles.len()));
    for tile in &list.tiles {
        let at = tile.slot as usize * words;
        let (cells, after) = std::mem::take(&mut rest).split_at_mut(at - cut).1.split_at_mut(words);
        (rest, cut) = (after, at + words);
        work.push((tile, cells));
    }
    work.into_par_iter().for_each(|(tile, cells)| {
        let entries = &list.entries[tile.entries[0] as usize..tile.entries[1] as usize];
        let Batch { cones, scans, beams, centres, shapes, points, .. } = batch;
        method.run(
            pass,
            &Job { frame, cones, tile, entries, parts, shares, scans, beams, centres, shapes, points },
            cells,
        );
    });
}

/// The sum of each reading's parts, added in tile order to what its share holds; twin of `shaders/method/driver/sum.wgsl`.
fn sums(batch: &Batch, parts: &[AtomicU32], shares: &[[u32; 4]]) -> Shares {
    let before = |k: usize| shares.get(k).map_or(0.0, |s| f32::from_bits(s[0]));
    let part = |k: u32| f32::from_bits(parts[k as usize].load(Ordering::Relaxed));
    batch
        .first_part
        .windows(2)
        .enumerate()
        .map(|(k, w)| {
            let sum = (w[0]..w[1]).fold(before(k), |sum, k| sum + part(k));
            [f32::to_bits(sum), 0, 0, 0]
        })
        .collect()
}
