//! Measures kernel throughput: the same readings run through a backend several times, and the median counts.
//!
//! The time is that of a run from readings in memory to cells in the backend's memory: snapping, binning, upload, every pass.
//! A run reuses the memory of the cells of the run before, on the CPU zeroed between the runs.
//! A cell update is one (reading, cell) pair with the cell's centre inside the cone, counted by the kernels themselves.

use crate::Result;
use crate::bench::workload::{Workload, walls};
use crate::binning::batch::BATCH;
use crate::binning::scan::Scans;
use crate::feature::Update;
use crate::geometry::layout::{Beam, Cone, Entry, Scan, Shapes};
use crate::kernels::Backend;
use crate::kernels::dry::Dry;
use crate::kernels::peak::Peaks;
use crate::method::{Input, Method, Step, Unit, tile_words};
use crate::pipeline::batching::{BatchStatistics, take_map_and_recycle};
use crate::pipeline::mapper::Mapper;
use crate::pipeline::scans::{ChunkedScans, Spill};
use crate::pipeline::updates::Updater;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// The throughput of one method on one backend over one workload.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measurement {
    /// The workload's name.
    pub workload: String,
    /// The method.
    pub method: String,
    /// cpu or gpu.
    pub backend: String,
    /// Readings.
    pub readings: u64,
    /// Cell updates.
    pub updates: u64,
    /// Seconds of each run, without the first, which compiles and allocates.
    pub seconds: Vec<f64>,
    /// The median of `seconds`.
    pub median: f64,
    /// Median seconds of binning on the host.
    pub binning: f64,
    /// Seconds of each kind of pass in one further run, by the processor's own clock.
    pub passes: Vec<(String, f64)>,
    /// Cell updates a second, by the median.
    pub updates_per_second: f64,
    /// Readings a second, by the median.
    pub readings_per_second: f64,
    /// Floating-point operations of a cell update ([`crate::method::Cost`]).
    pub flop: u32,
    /// Integer operations of a cell update.
    pub int: u32,
    /// Bytes moved for a cell update if nothing is cached: each pass reads its tile's cells and its lists, and writes cells back.
    pub bytes: f64,
    /// The most used resource of the backend, flop, int or bytes, and the used share of its peak rate.
    pub ceiling: Option<(f64, &'static str)>,
    /// The same of the passes alone, by their own time, without the host's work.
    pub kernels: Option<(f64, &'static str)>,
}

impl Measurement {
    /// Compares the figures with the peak rates of the backend.
    pub fn against(mut self, ceilings: Option<Peaks>) -> Measurement {
        let most = |rate: f64, c: Peaks| {
            let used = [
                (f64::from(self.flop) * rate / c.flop, "flop"),
                (f64::from(self.int) * rate / c.int, "int"),
                (self.bytes * rate / c.bytes, "bytes"),
            ];
            used.into_iter().fold((0.0, "flop"), |most, one| if one.0 > most.0 { one } else { most })
        };
        let passes: f64 = self.passes.iter().map(|p| p.1).sum();
        let (whole, alone) = (self.updates_per_second, self.updates as f64 / passes);
        (self.ceiling, self.kernels) =
            (ceilings.map(|c| most(whole, c)), ceilings.filter(|_| passes > 0.0).map(|c| most(alone, c)));
        self
    }
}

/// Runs a workload `runs` times after a first run that warms up.
///
/// # Errors
/// The backend's.
pub fn measure(
    workload: &Workload,
    method: &dyn Method,
    backend: &mut dyn Backend,
    runs: usize,
) -> Result<Measurement> {
    // In the pool: from outside each parallel step would have to wake one thread more.
    rayon::scope(|_| measure_here(workload, method, backend, runs))
}

fn measure_here(
    workload: &Workload,
    method: &dyn Method,
    backend: &mut dyn Backend,
    runs: usize,
) -> Result<Measurement> {
    let updates = if method.unit() == Unit::Update { walls(workload) } else { Vec::new() };
    let (mut seconds, mut binning, mut passes, last) = (Vec::new(), Vec::new(), Vec::new(), runs.max(1) + 1);
    let (mut cell_updates, mut batches) = (0, BatchStatistics::default());
    for run in 0..=last {
        // The last run is timed from within.
        if run == last {
            backend.time_passes();
        }
        let started = Instant::now();
        batches = apply(workload, method, backend, &updates)?;
        backend.wait()?;
        let taken = started.elapsed();
        cell_updates = take_map_and_recycle(&workload.grid, method, backend)?.map.updates;
        if run == last {
            passes = backend.pass_times().into_iter().map(|(name, s)| (name.to_string(), s)).collect();
        } else if run > 0 {
            seconds.push(taken.as_secs_f64());
            binning.push(batches.binning_us as f64 * 1e-6);
        }
    }
    // A backend that lists tiles itself does not report the size of its lists.
    if backend.limits().bins_tiles && method.unit() == Unit::Reading {
        batches = apply(workload, method, &mut Dry::default(), &updates)?;
    }
    let (median, readings) = (median(&seconds), workload.readings.len() as u64);
    let cost = crate::method::entry(crate::method::name(method))?.cost;
    Ok(Measurement {
        flop: cost.flop,
        int: cost.int,
        bytes: bytes_moved(method, &batches, cell_updates) as f64 / (cell_updates as f64).max(1.0),
        ceiling: None,
        kernels: None,
        workload: workload.name.clone(),
        method: crate::method::name(method).into(),
        backend: backend.name().into(),
        readings,
        updates: cell_updates,
        updates_per_second: cell_updates as f64 / median,
        readings_per_second: readings as f64 / median,
        binning: self::median(&binning),
        passes,
        seconds,
        median,
    })
}

/// Applies a workload from memory to the cells of a backend. `updates` are those of the workload, for a method that takes them.
fn apply(
    workload: &Workload,
    method: &dyn Method,
    backend: &mut dyn Backend,
    updates: &[Update],
) -> Result<BatchStatistics> {
    let (grid, sensors) = (&workload.grid, &workload.sensors);
    match method.input(grid.resolution) {
        Input::Readings => {
            let mut mapper = Mapper::new(*grid, sensors, method, backend, BATCH)?.without_counts();
            for sweep in 0..method.sweeps().len() {
                mapper.sweep(sweep, workload.readings.iter().map(|r| Ok((*r, None))))?;
            }
            Ok(mapper.statistics)
        }
        Input::Scans { selection, labels } => {
            let records = workload.readings.iter().map(|r| Ok(r.record));
            let scans = Scans::new(records, sensors, labels, u64::MAX, Path::new(&workload.name));
            let scans = ChunkedScans::read(grid, selection, scans, &Spill::never(), &|_| {})?;
            scans.apply(method, backend, BATCH, &|_| {})
        }
        Input::Updates(_) => {
            let mut updater = Updater::new(grid, sensors, method, backend, BATCH);
            updater.apply(updates.iter().map(Ok), &|_| {})?;
            Ok(updater.statistics)
        }
    }
}

/// The bytes that a run moves if nothing is cached.
fn bytes_moved(method: &dyn Method, batches: &BatchStatistics, cell_updates: u64) -> u64 {
    let passes = method.sweeps().iter().copied().flatten().filter(|s| matches!(s, Step::Pass(..))).count() as u64;
    let per_sweep = passes.div_ceil(method.sweeps().len() as u64);
    // An entry names a cone; or a scan, of which each update takes a beam.
    let (named, beams) = match method.unit() {
        Unit::Reading => (size_of::<Cone>(), 0),
        Unit::Update => (size_of::<Cone>() + size_of::<Shapes>(), 0),
        Unit::Scan => (size_of::<Scan>(), cell_updates * size_of::<Beam>() as u64),
    };
    let (listed, cells) = (size_of::<Entry>() + named, 8 * tile_words(method));
    per_sweep * (batches.entries * listed as u64 + batches.tiles * cells as u64) + beams
}

/// The median: the middle value, or the mean of the two in the middle.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let k = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[k],
        _ => (sorted[k - 1] + sorted[k]) / 2.0,
    }
}
