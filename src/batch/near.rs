//! Readings for a backend that lists tiles itself: of each chunk the cones whose boxes meet it; `shaders/list/near.wgsl` goes on.

use super::{Batch, Binning, ChunkList, Shape};
use crate::layout::{CHUNK, Cone, NO_ECHO, Near, WIDE};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What a run of readings is near, by row and column of the chunk; and where each reading's parts begin in the run.
#[derive(Default)]
struct Run {
    chunks: BTreeMap<[u32; 2], Vec<Near>>,
    first_part: Vec<u32>,
    parts: u32,
}

impl Binning {
    /// Bins snapped readings, or, for a backend that `lists` tiles itself, sorts them by chunk alone. It does so in 32 bits: where a
    /// reading reaches farther than 1024 cells, they are binned here.
    pub fn sort(&self, cones: Vec<Cone>, lists: bool) -> Batch {
        if lists && cones.iter().all(|c| c.flags & WIDE == 0) { self.near(cones) } else { self.bin(cones) }
    }

    /// Sorts snapped readings by chunk, in log order, tiles left to the backend. A part stands for each tile of a cone's box, chunk by
    /// chunk and in each tile row by tile row: those of tiles off the arc stay 0, which changes no sum.
    pub fn near(&self, mut cones: Vec<Cone>) -> Batch {
        let run = cones.len().div_ceil(4 * rayon::current_num_threads()).max(64);
        let run_of = |(n, cones): (usize, &mut [Cone])| self.near_run((n * run) as u32, cones);
        let runs: Vec<Run> = cones.par_chunks_mut(run).enumerate().map(run_of).collect();
        let mut first_part = Vec::with_capacity(cones.len() + 1);
        let mut places: BTreeMap<[u32; 2], Vec<Near>> = BTreeMap::new();
        let mut before = 0;
        for run in runs {
            first_part.extend(run.first_part.iter().map(|p| p + before));
            for (place, near) in run.chunks {
                let moved = near.into_iter().map(|n| Near { part: n.part + before, ..n });
                places.entry(place).or_default().extend(moved);
            }
            before += run.parts;
        }
        first_part.push(before);
        let chunks = places
            .into_iter()
            .map(|([row, column], near)| ChunkList { place: [column, row], near, ..ChunkList::default() })
            .collect();
        Batch { chunks, cones, first_part, ..Batch::default() }
    }

    /// What some readings are near, of which the first is the batch's `first`.
    fn near_run(&self, first: u32, cones: &mut [Cone]) -> Run {
        let mut run = Run::default();
        for (index, cone) in (first..).zip(cones) {
            cone.index = index;
            run.first_part.push(run.parts);
            let shape = Shape::of(cone, self.footprint);
            let spans = self.spans(cone, &shape);
            let arcs = cone.flags & NO_ECHO == 0 || self.no_echo_arcs;
            for place in self.chunks_of_shape(cone, &shape) {
                let [rows, columns] = self.within(spans.clone(), place);
                let tile = |at: i64, k: usize| (at - i64::from(place[k]) * CHUNK as i64) as u32;
                let low = [tile(columns.start, 0), tile(rows.start, 1)];
                let high = [tile(columns.end, 0), tile(rows.end, 1)];
                run.chunks.entry([place[1], place[0]]).or_default().push(Near { cone: index, part: run.parts, low, high });
                run.parts += if arcs { (high[0] - low[0]) * (high[1] - low[1]) } else { 0 };
            }
        }
        run
    }
}
