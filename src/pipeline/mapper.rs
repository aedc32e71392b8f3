//! The incremental pipeline for readings: a [`Mapper`] snaps and bins them batch by batch and runs the method's sweeps on a backend,
//! with every chunk resident.

use crate::grid::GridSpec;
use crate::kernels::Backend;
use crate::log::reading::{Counts, Reading};
use crate::method::{self, Method, Step, Unit};
use crate::pipeline::batching::{
    BatchStatistics, binning, count_reached, exceeds_limits, frame, snap_reading, take_map, take_map_and_recycle,
};
use crate::pipeline::finished::FinishedMap;
use crate::pipeline::readings::ReadingInput;
use crate::sensor::Sensor;
use crate::{Error, Result};

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
    /// The size of the batches.
    pub statistics: BatchStatistics,
}

impl<'a> Mapper<'a> {
    /// Creates a mapper for readings of these sensors; `batch`: readings at a time (the result does not depend on it).
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
        let (counts, statistics) = (Counts::default(), BatchStatistics::default());
        Ok(Mapper { grid, sensors, method, backend, batch, counting: true, counts, statistics })
    }

    /// Leaves `outside`, `empty_arc` and `wide` uncounted: for benchmarks of the kernels alone.
    pub fn without_counts(self) -> Self {
        Mapper { counting: false, ..self }
    }

    /// Returns when the backend has run all batches.
    ///
    /// # Errors
    /// The backend's.
    pub fn wait(&mut self) -> Result<()> {
        self.backend.wait()
    }

    /// Runs one sweep over the log. `items` are its readings in order, the same in every sweep.
    ///
    /// # Errors
    /// Those of `items` and of the backend; [`Error::Usage`] for a sweep that the method does not have, or a reading of a sensor that is
    /// not among the mapper's.
    pub fn sweep(&mut self, sweep: usize, items: impl Iterator<Item = Result<ReadingInput>>) -> Result<()> {
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
    fn apply(&mut self, sweep: usize, items: &[ReadingInput]) -> Result<()> {
        if items.is_empty() {
            return Ok(());
        }
        let started = std::time::Instant::now();
        let steps = self.method.sweeps()[sweep];
        let (grid, sensors, method, limits) = (&self.grid, self.sensors, self.method, self.backend.limits());
        let binning = binning(grid, method, steps);
        let snap = |item: &ReadingInput| snap_reading(grid, sensors, method, item);
        // Once into the pool for all of it: its threads are slow to wake.
        let batch = rayon::scope(|_| binning.of(items, snap, limits.bins_tiles));
        let Some(batch) = batch else { return self.apply_halves(sweep, items) };
        let misses = (items.len() - batch.cones().len()) as u64;
        self.statistics.binning_us += started.elapsed().as_micros() as u64;
        let sums = steps.contains(&Step::Sum);
        if exceeds_limits(method, &batch, sums, limits, items.len() == 1)? {
            return self.apply_halves(sweep, items);
        }
        if sweep == 0 && self.counting {
            self.counts.outside += misses;
            count_reached(&mut self.counts, &binning, batch.cones());
        }
        self.statistics.count(&batch);
        self.backend.apply(method, frame(&self.grid, method), &batch, steps, &mut Vec::new())
    }

    /// Maps a batch that exceeds the backend's limits as two.
    fn apply_halves(&mut self, sweep: usize, items: &[ReadingInput]) -> Result<()> {
        let (first, last) = items.split_at(items.len() / 2);
        self.apply(sweep, first)?;
        self.apply(sweep, last)
    }

    /// Takes the finished map from the backend.
    ///
    /// # Errors
    /// The backend's.
    pub fn finish(self) -> Result<FinishedMap> {
        match self.counting {
            true => take_map(&self.grid, self.method, self.backend),
            false => take_map_and_recycle(&self.grid, self.method, self.backend),
        }
    }
}
