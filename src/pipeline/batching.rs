//! Steps that every pipeline shares: it snaps readings, bins them to batches, checks a batch against the backend's limits, and takes
//! the finished map from the backend.

use crate::binning::batch::{Batch, Binning, ChunkList};
use crate::binning::snap::{Footprint, region, snap};
use crate::geometry::layout::{CELL, Cone, DIRECTION, Frame, NO_ECHO, WIDE};
use crate::grid::GridSpec;
use crate::kernels::{Backend, ChunkStates, Limits};
use crate::log::reading::Counts;
use crate::method::{self, Method, Step};
use crate::pipeline::finished::FinishedMap;
use crate::pipeline::layers;
use crate::pipeline::readings::ReadingInput;
use crate::sensor::Sensor;
use crate::{Error, Result};
use rayon::prelude::*;

/// The size of the batches of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BatchStatistics {
    /// Batches.
    pub batches: u64,
    /// (Cone, tile) pairs; of a backend that lists tiles itself those of the cones' boxes.
    pub entries: u64,
    /// Tiles reached, counted anew in each batch; none of a backend that lists tiles itself.
    pub tiles: u64,
    /// Time of binning on the host, µs.
    pub binning_us: u64,
}

impl BatchStatistics {
    /// Counts a batch.
    pub(crate) fn count(&mut self, batch: &Batch) {
        self.batches += 1;
        self.entries += batch.chunks.iter().map(|c| c.pairs() as u64).sum::<u64>();
        self.tiles += batch.chunks.iter().map(|c| c.tiles.len() as u64).sum::<u64>();
    }
}

/// The frame of a pass over a grid, its mode still to be set.
pub(crate) fn frame(grid: &GridSpec, method: &dyn Method) -> Frame {
    Frame {
        size: [grid.width as u32, grid.height as u32],
        mode: 0,
        scale: (grid.resolution / f64::from(CELL)) as f32,
        constants: method.constants(),
        limits: method.limits(grid.resolution),
    }
}

/// The binning of a method's readings onto all chunks of a grid, for a sweep with these steps.
pub(crate) fn binning(grid: &GridSpec, method: &dyn Method, steps: &[Step]) -> Binning {
    Binning {
        size: [grid.width, grid.height],
        footprint: method.footprint(),
        no_echo_arcs: steps.contains(&Step::NormalizeByCount),
        only: None,
    }
}

/// Snaps a reading to integers, with the profile of the method; `None`: its cone does not reach the grid.
pub(crate) fn snap_reading(
    grid: &GridSpec,
    sensors: &[Sensor],
    method: &dyn Method,
    (reading, edges): &ReadingInput,
) -> Option<Cone> {
    let sensor = &sensors[reading.record.sensor as usize];
    let (cone, snapped) = snap(grid, sensor, reading, method.footprint(), *edges)?;
    Some(Cone { profile: method.profile(sensor, &snapped), ..cone })
}

/// Whether a batch exceeds the limits of a backend, so that it has to be split. `sums`: its steps add the parts of readings' sums.
///
/// # Errors
/// [`Error::Resources`] where `one`: the batch is a single input, which can't be split.
pub(crate) fn exceeds_limits(
    method: &dyn Method,
    batch: &Batch,
    sums: bool,
    limits: Limits,
    one: bool,
) -> Result<bool> {
    let entries = batch.chunks.iter().map(ChunkList::pairs).max().unwrap_or(0);
    let parts = if sums { batch.parts() } else { 0 };
    let iterations = if limits.max_loop_iterations < usize::MAX {
        batch.max_loop_iterations(method::vec4s_per_thread(method))
    } else {
        0
    };
    let exceeds = entries > limits.entries || parts > limits.parts || iterations > limits.max_loop_iterations;
    if exceeds && one {
        return Err(Error::Resources(format!(
            "one reading reaches {entries} tiles of a chunk, more than the adapter's limit of {}: use a coarser \
             `resolution` or `backend cpu`",
            limits.entries.min(limits.parts)
        )));
    }
    Ok(exceeds)
}

/// Counts the readings that reach no cell, those without arc cells, and the wide ones.
pub(crate) fn count_reached(counts: &mut Counts, binning: &Binning, cones: &[Cone]) {
    let size = binning.size;
    let regions = |cone: &Cone| match tip_is_arc(cone, binning.footprint, size) {
        true => (true, true),
        false => binning.regions(cone),
    };
    let reached: Vec<(bool, bool)> = cones.par_iter().map(regions).collect();
    for (cone, (interior, arc)) in cones.iter().zip(reached) {
        counts.wide += u64::from(cone.flags & WIDE != 0 && (interior || arc));
        counts.outside += u64::from(!interior && !arc);
        counts.empty_arc += u64::from(interior && !arc && cone.flags & NO_ECHO == 0);
    }
}

/// Whether a cell near the tip of the axis is on the reading's arc: nearly every hit has one there.
fn tip_is_arc(cone: &Cone, footprint: Footprint, size: [usize; 2]) -> bool {
    if cone.flags & NO_ECHO != 0 {
        return false;
    }
    let range = match footprint {
        Footprint::Axis => i64::from(cone.reach[0]),
        _ => (i64::from(cone.reach[0]) + i64::from(cone.reach[1])) / 2,
    };
    let tip = [0, 1].map(|k| {
        let along = i64::from(cone.axis[k]) * range / i64::from(DIRECTION);
        (i64::from(cone.sensor[k]) + along).div_euclid(i64::from(CELL))
    });
    (-1..=1).any(|j| {
        (-1..=1).any(|i| {
            let [x, y] = [tip[0] + i, tip[1] + j];
            let within = x >= 0 && y >= 0 && x < size[0] as i64 && y < size[1] as i64;
            within && region(cone, footprint, x, y).1
        })
    })
}

/// Takes the cells from a backend, as a finished map.
///
/// # Errors
/// The backend's.
pub(crate) fn take_map(grid: &GridSpec, method: &dyn Method, backend: &mut dyn Backend) -> Result<FinishedMap> {
    Ok(layers::from_chunks(grid, method, &backend.finish(method)?))
}

/// Takes the cells from a backend as [`take_map`] does, and gives the backend their memory back: the next run of a benchmark reuses it.
///
/// # Errors
/// The backend's.
pub(crate) fn take_map_and_recycle(
    grid: &GridSpec,
    method: &dyn Method,
    backend: &mut dyn Backend,
) -> Result<FinishedMap> {
    let mut chunks: ChunkStates = backend.finish(method)?;
    let finished = layers::from_chunks(grid, method, &chunks);
    while backend.recycles_buffers()
        && let Some((_, mut words)) = chunks.pop_first()
    {
        words.fill(0);
        backend.recycle(words);
    }
    Ok(finished)
}
