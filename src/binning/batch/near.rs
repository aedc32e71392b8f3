//! Readings for a backend that lists tiles itself: of each chunk the cones whose boxes meet it; `shaders/binning/list/near.wgsl` goes on.

use super::{Batch, Binning, ChunkList, Shape};
use crate::geometry::layout::{CHUNK, Cone, NO_ECHO, Near, WIDE};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A run of cones, what they are near by row and column of the chunk, and where each one's parts begin; all counted from the run's
/// first.
#[derive(Default)]
struct Run {
    cones: Vec<Cone>,
    chunks: BTreeMap<[u32; 2], Vec<Near>>,
    first_part: Vec<u32>,
    parts: u32,
}

impl Binning {
    /// Snaps items and sorts their cones by chunk, in log order, tiles left to the backend, in one go over all threads; what has no
    /// cone is left out. A part stands for each tile of a cone's box, chunk by chunk and in each tile row by tile row: those of tiles
    /// off the arc stay 0, which changes no sum.
    ///
    /// # Errors
    /// The cones, where one reaches farther than 1024 cells: backends list tiles in 32 bits.
    pub fn near<T: Sync>(&self, items: &[T], snap: impl Fn(&T) -> Option<Cone> + Sync) -> Result<Batch, Vec<Cone>> {
        let run = items.len().div_ceil(4 * rayon::current_num_threads()).max(64);
        let runs: Vec<Run> = items.par_chunks(run).map(|items| self.near_run(items.iter().filter_map(&snap))).collect();
        let count = runs.iter().map(|r| r.cones.len()).sum();
        let mut batch = Batch { cones: Vec::with_capacity(count), ..Batch::default() };
        batch.first_part.reserve(count + 1);
        let mut places: BTreeMap<[u32; 2], Vec<Near>> = BTreeMap::new();
        let (mut parts, mut flags) = (0, 0);
        for run in runs {
            let cones = batch.cones.len() as u32;
            batch.first_part.extend(run.first_part.iter().map(|p| p.saturating_add(parts)));
            for (place, near) in run.chunks {
                let moved =
                    near.into_iter().map(|n| Near { cone: n.cone + cones, part: n.part.saturating_add(parts), ..n });
                places.entry(place).or_default().extend(moved);
            }
            flags |= run.cones.iter().fold(0, |flags, c| flags | c.flags);
            batch.cones.extend(run.cones.iter().map(|c| Cone { index: c.index + cones, ..*c }));
            parts = u32::saturating_add(parts, run.parts);
        }
        if flags & WIDE != 0 {
            return Err(batch.cones);
        }
        batch.first_part.push(parts);
        let list = |([row, column], near): ([u32; 2], Vec<Near>)| {
            let place = [column, row];
            ChunkList { place, near, ..ChunkList::default() }
        };
        batch.chunks = places.into_iter().map(list).collect();
        Ok(batch)
    }

    /// What some readings are near.
    fn near_run(&self, cones: impl Iterator<Item = Cone>) -> Run {
        let mut run = Run::default();
        for (index, cone) in (0..).zip(cones) {
            run.cones.push(Cone { index, ..cone });
            run.first_part.push(run.parts);
            let shape = Shape::of(&cone, self.footprint);
            let spans = self.spans(&cone, &shape);
            let arcs = cone.flags & NO_ECHO == 0 || self.no_echo_arcs;
            for place in self.chunks_of_shape(&cone, &shape) {
                let [rows, columns] = self.within(spans.clone(), place);
                let tile = |at: i64, k: usize| (at - i64::from(place[k]) * CHUNK as i64) as u32;
                let low = [tile(columns.start, 0), tile(rows.start, 1)];
                let high = [tile(columns.end, 0), tile(rows.end, 1)];
                let near = Near { cone: index, part: run.parts, low, high };
                run.chunks.entry([place[1], place[0]]).or_default().push(near);
                // More than fit are more than a batch may have.
                run.parts = run.parts.saturating_add(if arcs { (high[0] - low[0]) * (high[1] - low[1]) } else { 0 });
            }
        }
        run
    }
}
