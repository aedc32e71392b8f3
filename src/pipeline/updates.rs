//! The incremental pipeline for updates of the feature stage: an [`Updater`] snaps, bins and applies them batch by batch, in order.

use crate::Result;
use crate::binning::batch::PAIRS;
use crate::binning::update::{Binned, Bins, Snapped, snapped as snap_update};
use crate::feature::Update;
use crate::geometry::layout::Cone;
use crate::grid::GridSpec;
use crate::kernels::Backend;
use crate::log::reading::Counts;
use crate::method::Method;
use crate::pipeline::batching::{BatchStatistics, exceeds_limits, frame};
use crate::sensor::Sensor;
use rayon::prelude::*;
use std::borrow::Borrow;
use std::time::Instant;

/// Applies updates batch by batch, in order.
pub struct Updater<'a> {
    grid: &'a GridSpec,
    sensors: &'a [Sensor],
    method: &'a dyn Method,
    backend: &'a mut dyn Backend,
    batch: usize,
    /// What became of the updates: those that reached no cell (`outside`), and those that reached none that they occupy (`empty_arc`).
    pub counts: Counts,
    /// The size of the batches.
    pub statistics: BatchStatistics,
}

impl<'a> Updater<'a> {
    /// Creates an updater for updates of readings of these sensors; `batch`: updates at a time (the result does not depend on it).
    pub fn new(
        grid: &'a GridSpec,
        sensors: &'a [Sensor],
        method: &'a dyn Method,
        backend: &'a mut dyn Backend,
        batch: usize,
    ) -> Self {
        let batch = batch.clamp(1, backend.limits().readings);
        let (counts, statistics) = (Counts::default(), BatchStatistics::default());
        Updater { grid, sensors, method, backend, batch, counts, statistics }
    }

    /// Applies updates in order. `progress` receives the number of updates done since its last call.
    ///
    /// # Errors
    /// The updates'; [`crate::Error::Usage`] for one that reaches farther than 512 cells; the backend's.
    pub fn apply<U: Borrow<Update> + Sync>(
        &mut self,
        updates: impl Iterator<Item = Result<U>>,
        progress: &dyn Fn(u64),
    ) -> Result<()> {
        let mut held = Vec::with_capacity(self.batch.min(1024));
        for update in updates {
            held.push(update?);
            if held.len() == self.batch {
                self.apply_batch(&held)?;
                progress(held.len() as u64);
                held.clear();
            }
        }
        self.apply_batch(&held)?;
        progress(held.len() as u64);
        Ok(())
    }

    /// Snaps one batch, and applies it.
    fn apply_batch<U: Borrow<Update> + Sync>(&mut self, updates: &[U]) -> Result<()> {
        let started = Instant::now();
        let (grid, sensors, method) = (self.grid, self.sensors, self.method);
        let snap = |update: &U| snap_update(grid, sensors, &|s, cone| method.profile(s, cone), update.borrow());
        let snapped = updates.par_iter().with_min_len(64).map(snap).collect::<Result<Vec<_>>>()?;
        let reaching: Vec<Snapped> = snapped.into_iter().flatten().collect();
        self.counts.outside += (updates.len() - reaching.len()) as u64;
        self.statistics.binning_us += started.elapsed().as_micros() as u64;
        self.run(&reaching)
    }

    /// Bins snapped updates and runs them, in halves where they exceed the backend's limits.
    fn run(&mut self, updates: &[Snapped]) -> Result<()> {
        if updates.is_empty() {
            return Ok(());
        }
        let started = Instant::now();
        let (limits, one) = (self.backend.limits(), updates.len() == 1);
        let bins = Bins { size: [self.grid.width, self.grid.height] };
        // The backend's limit counts cones; updates upload points in their place.
        let points = limits.readings.saturating_mul(size_of::<Cone>() / size_of::<[i32; 2]>());
        let pairs: usize = updates.par_iter().with_min_len(64).map(|u| bins.at_most(u)).sum();
        if !one && (pairs > PAIRS || updates.iter().map(|u| u.points.len()).sum::<usize>() > points) {
            return self.run_halves(updates);
        }
        let Binned { batch, outside, empty_arc } = bins.bin(updates);
        self.statistics.binning_us += started.elapsed().as_micros() as u64;
        if exceeds_limits(self.method, &batch, false, limits, one)? {
            return self.run_halves(updates);
        }
        self.counts.outside += outside;
        self.counts.empty_arc += empty_arc;
        self.statistics.count(&batch);
        let (frame, steps) = (frame(self.grid, self.method), self.method.sweeps()[0]);
        self.backend.apply(self.method, frame, &batch, steps, &mut Vec::new())
    }

    fn run_halves(&mut self, updates: &[Snapped]) -> Result<()> {
        let (first, last) = updates.split_at(updates.len() / 2);
        self.run(first)?;
        self.run(last)
    }
}
