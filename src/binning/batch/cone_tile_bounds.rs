//! The box of tiles of each cone, chunk by chunk, for a backend that bins cones into tiles itself. The GPU continues from it
//! with `shaders/binning/list/cone_tile_bounds.wgsl`.

use super::{Batch, Binning, ChunkList, ConeInput, Input, Shape};
use crate::geometry::layout::{Cone, ConeTileBounds, NO_ECHO, TILE, WIDE};
use crate::grid::ChunkId;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A run of cones, their boxes by chunk, and the index of each cone's first part. All indices count from the run's first.
#[derive(Default)]
struct Run {
    cones: Vec<Cone>,
    chunks: BTreeMap<ChunkId, Vec<ConeTileBounds>>,
    first_part: Vec<u32>,
    parts: u32,
}

impl Binning {
    /// Snaps items and sorts their cones by chunk, in log order, on all threads; the backend finds the tiles. Items without a cone
    /// are left out. Every tile of a cone's box has a part, chunk by chunk and in each chunk tile row by tile row. The parts of tiles
    /// off the arc stay 0, which changes no sum.
    ///
    /// # Errors
    /// Returns the cones if one reaches farther than 1024 cells, because backends bin tiles in 32 bits.
    pub fn bound_cones<T: Sync>(
        &self,
        items: &[T],
        snap: impl Fn(&T) -> Option<Cone> + Sync,
    ) -> Result<Batch, Vec<Cone>> {
        let run = items.len().div_ceil(4 * rayon::current_num_threads()).max(64);
        let runs: Vec<Run> =
            items.par_chunks(run).map(|items| self.cone_bounds_of(items.iter().filter_map(&snap))).collect();
        let count = runs.iter().map(|r| r.cones.len()).sum();
        let mut input = ConeInput { cones: Vec::with_capacity(count), first_part: Vec::with_capacity(count + 1) };
        let mut places: BTreeMap<ChunkId, Vec<ConeTileBounds>> = BTreeMap::new();
        let (mut parts, mut flags) = (0, 0);
        for run in runs {
            let cones = input.cones.len() as u32;
            input.first_part.extend(run.first_part.iter().map(|p| p.saturating_add(parts)));
            for (place, bounds) in run.chunks {
                let moved = |b: ConeTileBounds| ConeTileBounds {
                    cone: b.cone + cones,
                    part: b.part.saturating_add(parts),
                    ..b
                };
                places.entry(place).or_default().extend(bounds.into_iter().map(moved));
            }
            flags |= run.cones.iter().fold(0, |flags, c| flags | c.flags);
            input.cones.extend(run.cones.iter().map(|c| Cone { index: c.index + cones, ..*c }));
            parts = u32::saturating_add(parts, run.parts);
        }
        if flags & WIDE != 0 {
            return Err(input.cones);
        }
        input.first_part.push(parts);
        let list = |(place, cone_bounds): (ChunkId, Vec<ConeTileBounds>)| ChunkList {
            place,
            cone_bounds,
            ..ChunkList::default()
        };
        Ok(Batch { chunks: places.into_iter().map(list).collect(), input: Input::Cones(input) })
    }

    /// The boxes of some readings' cones, chunk by chunk.
    fn cone_bounds_of(&self, cones: impl Iterator<Item = Cone>) -> Run {
        let mut run = Run::default();
        for (index, cone) in (0..).zip(cones) {
            run.cones.push(Cone { index, ..cone });
            run.first_part.push(run.parts);
            let shape = Shape::of(&cone, self.footprint);
            let spans = self.spans(&cone, &shape);
            let arcs = cone.flags & NO_ECHO == 0 || self.no_echo_arcs;
            for place in self.chunks_of_shape(&cone, &shape) {
                let [rows, columns] = self.within(spans.clone(), place);
                let tile = |at: i64, k: usize| (at - (place.first_cell()[k] / TILE) as i64) as u32;
                let low = [tile(columns.start, 0), tile(rows.start, 1)];
                let high = [tile(columns.end, 0), tile(rows.end, 1)];
                let bounds = ConeTileBounds { cone: index, part: run.parts, low, high };
                run.chunks.entry(place).or_default().push(bounds);
                // A number of parts that does not fit is larger than a batch may have.
                run.parts = run.parts.saturating_add(if arcs { (high[0] - low[0]) * (high[1] - low[1]) } else { 0 });
            }
        }
        run
    }
}
