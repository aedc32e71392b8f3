//! From readings to a map: snap, bin, run the method's sweeps on a backend, take the layers out.

use crate::binning::batch::{Batch, Binning, ChunkList};
use crate::binning::snap::{Edges, Footprint, region, snap};
use crate::geometry::layout::{CELL, Cone, DIRECTION, Frame, NO_ECHO, WIDE};
use crate::grid::GridSpec;
use crate::kernels::{Backend, Limits};
use crate::log::reading::{Counts, Reading};
use crate::method::{self, Method, Unit};
use crate::pipeline::finished::Finished;
use crate::pipeline::layers;
use crate::sensor::Sensor;
use crate::{Error, Result};
use rayon::prelude::*;

/// A reading, and its wedge's edges where the method needs them (`truth`).
pub type Item = (Reading, Option<Edges>);

/// Maps readings, batch by batch.
pub struct Mapper<'a> {
    grid: GridSpec,
    sensors: &'a [Sensor],
    method: &'a dyn Method,
    backend: &'a mut dyn Backend,
    batch: usize,
    counting: bool,
    /// What became of the readings: `outside`, `empty_arc` and `wide` are counted here.
    pub counts: Counts,
    /// Tiles, cones in tiles, chunks: what the batches came to.
    pub work: Work,
}

/// How much the batches held.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Work {
    /// Batches.
    pub batches: u64,
    /// (Cone, tile) pairs; of a backend that lists tiles itself those of the cones' boxes.
    pub entries: u64,
    /// Tiles reached, counted anew in each batch; none of a backend that lists tiles itself.
    pub tiles: u64,
    /// Seconds of binning, in µs.
    pub binning_us: u64,
}

impl Work {
    /// Counts a batch.
    pub(crate) fn count(&mut self, batch: &Batch) {
        self.batches += 1;
        self.entries += batch.chunks.iter().map(|c| c.pairs() as u64).sum::<u64>();
        self.tiles += batch.chunks.iter().map(|c| c.tiles.len() as u64).sum::<u64>();
    }
}

impl<'a> Mapper<'a> {
    /// A mapper of readings of these sensors; `batch`: readings at a time (the result does not depend on it).
    ///
    /// # Errors
    /// [`Error::Usage`] for a method that takes scans or updates instead of readings ([`Method::unit`]): a
    /// [`Session`](crate::pipeline::session::Session) maps a log by any method.
    pub fn new(
        grid: GridSpec,
        sensors: &'a [Sensor],
        method: &'a dyn Method,
        backend: &'a mut dyn Backend,
        batch: usize,
    ) -> Result<Self> {
        if method.unit() != Unit::Reading {
            return Err(Error::Usage(format!(
                "{} does not take readings one by one: map a log by Session::map",
                method::name(method)
            )));
        }
        let batch = batch.clamp(1, backend.limits().readings);
        let (counts, work) = (Counts::default(), Work::default());
        Ok(Mapper { grid, sensors, method, backend, batch, counting: true, counts, work })
    }

    /// Leaves `outside`, `empty_arc` and `wide` uncounted: for benchmarks of the kernels alone.
    pub fn without_counts(self) -> Self {
        Mapper { counting: false, ..self }
    }

    /// Returns when all that was applied is done.
    pub fn wait(&mut self) -> Result<()> {
        self.backend.wait()
    }

    /// One sweep over the log: `items` are its readings in order, the same in every sweep.
    ///
    /// # Errors
    /// Those of `items` and of the backend; [`Error::Usage`] for a sweep that the method does not have, or a reading of a sensor that is
    /// not among the mapper's.
    pub fn sweep(&mut self, sweep: usize, items: impl Iterator<Item = Result<Item>>) -> Result<()> {
        let (sweeps, sensors) = (self.method.sweeps().len(), self.sensors.len());
        if sweep >= sweeps {
            return Err(Error::Usage(format!("sweep {sweep}: {} has {sweeps}, from 0", method::name(self.method))));
        }
        let items = items.map(|item| match item {
            Ok((Reading { record, .. }, _)) if record.sensor as usize >= sensors => Err(Error::Usage(format!(
                "the reading of line {} names sensor {}, of {sensors}",
                record.line, record.sensor
            ))),
            item => item,
        });
        let mut held = Vec::with_capacity(items.size_hint().0.min(self.batch));
        for item in items {
            held.push(item?);
            if held.len() == self.batch {
                self.apply(sweep, &held)?;
                held.clear();
            }
        }
        self.apply(sweep, &held)
    }

    /// Maps one batch.
    fn apply(&mut self, sweep: usize, items: &[Item]) -> Result<()> {
        if items.is_empty() {
            return Ok(());
        }
        let started = std::time::Instant::now();
        let binning = Binning {
            size: [self.grid.width, self.grid.height],
            footprint: self.method.footprint(),
            no_echo_arcs: self.method.sweeps()[sweep].contains(&method::Step::NormalizeByCount),
            only: None,
        };
        let (grid, sensors, method, bins_tiles) =
            (&self.grid, self.sensors, self.method, self.backend.limits().bins_tiles);
        let snap = |item: &Item| snap_item(grid, sensors, method, item);
        // Once into the pool for all of it: its threads are slow to wake.
        let batch = rayon::scope(|_| binning.of(items, snap, bins_tiles));
        let Some(batch) = batch else { return self.halves(sweep, items) };
        let misses = (items.len() - batch.cones().len()) as u64;
        self.work.binning_us += started.elapsed().as_micros() as u64;
        let sums = self.method.sweeps()[sweep].contains(&method::Step::Sum);
        if too_large(self.method, &batch, sums, self.backend.limits(), items.len() == 1)? {
            return self.halves(sweep, items);
        }
        if sweep == 0 && self.counting {
            self.counts.outside += misses;
            count(&mut self.counts, &binning, batch.cones());
        }
        self.work.count(&batch);
        let frame = frame(&self.grid, self.method);
        self.backend.apply(self.method, frame, &batch, self.method.sweeps()[sweep], &mut Vec::new())
    }

    /// Maps a batch that is too large as two.
    fn halves(&mut self, sweep: usize, items: &[Item]) -> Result<()> {
        let (first, last) = items.split_at(items.len() / 2);
        self.apply(sweep, first)?;
        self.apply(sweep, last)
    }

    /// The finished map.
    pub fn finish(self) -> Result<Finished> {
        finish(&self.grid, self.method, self.backend, !self.counting)
    }
}

/// A backend's cells as a finished map. With `again` it gets their memory back: a benchmark's next run finds it there, as its
/// first found none.
pub(crate) fn finish(grid: &GridSpec, method: &dyn Method, backend: &mut dyn Backend, again: bool) -> Result<Finished> {
    let mut chunks = backend.finish(method)?;
    let finished = layers::from_chunks(grid, method, &chunks);
    while again
        && backend.recycles_buffers()
        && let Some((_, mut words)) = chunks.pop_first()
    {
        words.fill(0);
        backend.recycle(words);
    }
    Ok(finished)
}

/// A pass over a grid, its mode still to be set.
pub(crate) fn frame(grid: &GridSpec, method: &dyn Method) -> Frame {
    Frame {
        size: [grid.width as u32, grid.height as u32],
        mode: 0,
        scale: (grid.resolution / f64::from(CELL)) as f32,
        constants: method.constants(),
        limits: method.limits(grid.resolution),
    }
}

/// Whether a batch comes to more than a backend takes; an error where it is one reading that can't be split.
pub(crate) fn too_large(method: &dyn Method, batch: &Batch, sums: bool, limits: Limits, one: bool) -> Result<bool> {
    let entries = batch.chunks.iter().map(ChunkList::pairs).max().unwrap_or(0);
    let parts = if sums { batch.parts() } else { 0 };
    let iterations = if limits.max_loop_iterations < usize::MAX {
        batch.max_loop_iterations(method::vec4s_per_thread(method))
    } else {
        0
    };
    let too_large = entries > limits.entries || parts > limits.parts || iterations > limits.max_loop_iterations;
    if too_large && one {
        return Err(Error::Resources(format!(
            "one reading reaches {entries} tiles of a chunk, more than the adapter's limit of {}: use a coarser \
             `resolution` or `backend cpu`",
            limits.entries.min(limits.parts)
        )));
    }
    Ok(too_large)
}

/// Counts the readings that reach no cell, those without arc cells, and the wide ones.
pub(crate) fn count(counts: &mut Counts, binning: &Binning, cones: &[Cone]) {
    let size = binning.size;
    let regions = |cone: &Cone| match tip_is_arc(cone, binning.footprint, size) {
        true => (true, true),
        false => binning.regions(cone),
    };
    let found: Vec<(bool, bool)> = cones.par_iter().map(regions).collect();
    for (cone, (interior, arc)) in cones.iter().zip(found) {
        counts.wide += u64::from(cone.flags & WIDE != 0 && (interior || arc));
        counts.outside += u64::from(!interior && !arc);
        counts.empty_arc += u64::from(interior && !arc && cone.flags & NO_ECHO == 0);
    }
}

/// Snaps a reading and gives it its method's profile.
pub(crate) fn snap_item(
    grid: &GridSpec,
    sensors: &[Sensor],
    method: &dyn Method,
    (reading, edges): &Item,
) -> Option<Cone> {
    let sensor = &sensors[reading.record.sensor as usize];
    let (cone, snapped) = snap(grid, sensor, reading, method.footprint(), *edges)?;
    Some(Cone { profile: method.profile(sensor, &snapped), ..cone })
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
