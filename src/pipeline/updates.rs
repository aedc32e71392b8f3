//! Updates that features made of readings, snapped, binned and applied window by window, in order.

use crate::Result;
use crate::binning::batch::PAIRS;
use crate::binning::update::{Binned, Bins, Snapped, snapped};
use crate::feature::Update;
use crate::geometry::layout::Cone;
use crate::grid::GridSpec;
use crate::kernels::Backend;
use crate::log::reading::Counts;
use crate::method::Method;
use crate::pipeline::mapper::{Work, frame, too_large};
use crate::sensor::Sensor;
use rayon::prelude::*;
use std::borrow::Borrow;
use std::time::Instant;

/// Applies updates in order, `batch` at a time (the result doesn't depend on it); says how many reached no cell
/// (`outside`), or none that they occupy (`empty_arc`), and what the batches came to. `progress` hears of updates.
///
/// # Errors
/// The updates'; [`crate::Error::Usage`] for one that reaches farther than 512 cells; the backend's.
pub fn apply<U: Borrow<Update> + Sync>(
    grid: &GridSpec,
    sensors: &[Sensor],
    method: &dyn Method,
    backend: &mut dyn Backend,
    batch: usize,
    updates: impl Iterator<Item = Result<U>>,
    progress: &dyn Fn(u64),
) -> Result<(Counts, Work)> {
    let batch = batch.clamp(1, backend.limits().readings);
    let mut applier = Applier { grid, sensors, method, backend, counts: Counts::default(), work: Work::default() };
    let mut held = Vec::with_capacity(batch.min(1024));
    for update in updates {
        held.push(update?);
        if held.len() == batch {
            applier.apply(&held)?;
            progress(held.len() as u64);
            held.clear();
        }
    }
    applier.apply(&held)?;
    progress(held.len() as u64);
    Ok((applier.counts, applier.work))
}

/// A run under way.
struct Applier<'a> {
    grid: &'a GridSpec,
    sensors: &'a [Sensor],
    method: &'a dyn Method,
    backend: &'a mut dyn Backend,
    counts: Counts,
    work: Work,
}

impl Applier<'_> {
    /// Snaps one window, and applies it.
    fn apply<U: Borrow<Update> + Sync>(&mut self, updates: &[U]) -> Result<()> {
        let started = Instant::now();
        let (grid, sensors, method) = (self.grid, self.sensors, self.method);
        let snap = |update: &U| snapped(grid, sensors, &|s, cone| method.profile(s, cone), update.borrow());
        let found = updates.par_iter().with_min_len(64).map(snap).collect::<Result<Vec<_>>>()?;
        let reaching: Vec<Snapped> = found.into_iter().flatten().collect();
        self.counts.outside += (updates.len() - reaching.len()) as u64;
        self.work.binning_us += started.elapsed().as_micros() as u64;
        self.run(&reaching)
    }

    /// Bins a window and runs it, as two where it is too large.
    fn run(&mut self, updates: &[Snapped]) -> Result<()> {
        if updates.is_empty() {
            return Ok(());
        }
        let started = Instant::now();
        let (limits, one) = (self.backend.limits(), updates.len() == 1);
        let bins = Bins { size: [self.grid.width, self.grid.height] };
        // A cone is so many points.
        let points = limits.readings.saturating_mul(size_of::<Cone>() / size_of::<[i32; 2]>());
        let pairs: usize = updates.par_iter().with_min_len(64).map(|u| bins.at_most(u)).sum();
        if !one && (pairs > PAIRS || updates.iter().map(|u| u.points.len()).sum::<usize>() > points) {
            return self.halves(updates);
        }
        let Binned { batch, outside, empty_arc } = bins.bin(updates);
        self.work.binning_us += started.elapsed().as_micros() as u64;
        if too_large(self.method, &batch, false, limits, one)? {
            return self.halves(updates);
        }
        self.counts.outside += outside;
        self.counts.empty_arc += empty_arc;
        self.work.count(&batch);
        let (frame, steps) = (frame(self.grid, self.method), self.method.sweeps()[0]);
        self.backend.apply(self.method, frame, &batch, steps, &mut Vec::new())
    }

    fn halves(&mut self, updates: &[Snapped]) -> Result<()> {
        let (first, last) = updates.split_at(updates.len() / 2);
        self.run(first)?;
        self.run(last)
    }
}
