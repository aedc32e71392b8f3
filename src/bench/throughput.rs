//! Measuring kernel throughput: the same readings through a backend several times, the median reported.
//!
//! What is timed is a run from readings in memory to cells in the backend's memory: snapping, binning, upload, every pass.
//! The memory of the cells is there from the run before, on the CPU zeroed between the runs.
//! A cell update is one (reading, cell) pair with the cell's centre inside the cone, counted by the kernels themselves.

use crate::Result;
use crate::bench::workload::{Workload, walls};
use crate::binning::batch::BATCH;
use crate::binning::scan::Scans;
use crate::geometry::layout::{Beam, Cone, Entry, Scan, Shapes};
use crate::kernels::Backend;
use crate::kernels::dry::Dry;
use crate::kernels::peak::Peaks;
use crate::method::settings::{Csm, Settings};
use crate::method::{Method, Step, Unit, tile_words};
use crate::pipeline::mapper::{self, Mapper, Work};
use crate::pipeline::out_of_core::Scanned;
use crate::pipeline::updates;
use serde::Serialize;
use std::time::Instant;

/// One method on one backend over one workload.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measured {
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
    /// Seconds of each run, the first (which compiles and allocates) left out.
    pub seconds: Vec<f64>,
    /// Their median.
    pub median: f64,
    /// Of which binning on the host, seconds.
    pub binning: f64,
    /// Seconds that each kind of pass took in one run more, by the processor's own clock.
    pub passes: Vec<(String, f64)>,
    /// Cell updates a second, by the median.
    pub updates_per_second: f64,
    /// Readings a second, by the median.
    pub readings_per_second: f64,
    /// Floating-point operations of an update ([`crate::method::Cost`]).
    pub flop: u32,
    /// Integer operations of an update.
    pub int: u32,
    /// Bytes moved for an update if nothing is cached: each pass reads its tile's cells and its lists, and writes cells back.
    pub bytes: f64,
    /// Of the backend's ceilings, the share of that resource of which most is used, and which it is: flop, int or bytes.
    pub ceiling: Option<(f64, &'static str)>,
    /// The same of the passes alone, by their own time: what the host does beside them left out.
    pub kernels: Option<(f64, &'static str)>,
}

impl Measured {
    /// Holds the figures against what the backend can do at most.
    pub fn against(mut self, ceilings: Option<Peaks>) -> Measured {
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

/// Runs a workload `runs` times after one for warming up.
pub fn measure(workload: &Workload, method: &dyn Method, backend: &mut dyn Backend, runs: usize) -> Result<Measured> {
    // In the pool: from outside each parallel step would have to wake one thread more.
    rayon::scope(|_| measure_here(workload, method, backend, runs))
}

fn measure_here(workload: &Workload, method: &dyn Method, backend: &mut dyn Backend, runs: usize) -> Result<Measured> {
    let (mut seconds, mut binning, mut updates, mut done) = (Vec::new(), Vec::new(), 0, Work::default());
    let passes = method.sweeps().iter().copied().flatten().filter(|s| matches!(s, Step::Pass(..))).count() as u64;
    let per_sweep = passes.div_ceil(method.sweeps().len() as u64);
    let (mut passes, last) = (Vec::new(), runs.max(1) + 1);
    let given = if method.unit() == Unit::Update { walls(workload) } else { Vec::new() };
    for run in 0..=last {
        // The last run is timed from within.
        if run == last {
            backend.time_passes();
        }
        let started = Instant::now();
        let (work, taken, finished) = match method.settings() {
            Settings::Csm(csm) => {
                let work = count_scans(workload, csm, method, backend)?;
                backend.wait()?;
                let taken = started.elapsed();
                (work, taken, mapper::finish(&workload.grid, method, backend, true)?)
            }
            Settings::Features(_) => {
                let (grid, sensors, all) = (&workload.grid, &workload.sensors, given.iter().map(Ok));
                let (_, work) = updates::apply(grid, sensors, method, backend, BATCH, all, &|_| {})?;
                backend.wait()?;
                let taken = started.elapsed();
                (work, taken, mapper::finish(&workload.grid, method, backend, true)?)
            }
            _ => {
                let mut mapper =
                    Mapper::new(workload.grid, &workload.sensors, method, backend, BATCH)?.without_counts();
                for sweep in 0..method.sweeps().len() {
                    mapper.sweep(sweep, workload.readings.iter().map(|r| Ok((*r, None))))?;
                }
                mapper.wait()?;
                (mapper.work, started.elapsed(), mapper.finish()?)
            }
        };
        updates = finished.map.updates;
        done = work;
        if run == last {
            passes = backend.pass_times().into_iter().map(|(name, s)| (name.to_string(), s)).collect();
        } else if run > 0 {
            seconds.push(taken.as_secs_f64());
            binning.push(work.binning_us as f64 * 1e-6);
        }
    }
    // A backend that lists tiles itself doesn't say what its lists hold.
    if backend.limits().bins_tiles && method.unit() == Unit::Reading {
        done = listed(workload, method)?;
    }
    // An entry names a cone; or a scan, of which each update takes a beam.
    let (named, taken_up) = match method.unit() {
        Unit::Reading => (size_of::<Cone>(), 0),
        Unit::Update => (size_of::<Cone>() + size_of::<Shapes>(), 0),
        Unit::Scan => (size_of::<Scan>(), updates * size_of::<Beam>() as u64),
    };
    let (listed, cells) = (size_of::<Entry>() + named, 8 * tile_words(method));
    let moved = per_sweep * (done.entries * listed as u64 + done.tiles * cells as u64) + taken_up;
    let (median, readings) = (median(&seconds), workload.readings.len() as u64);
    let cost = crate::method::entry(crate::method::name(method))?.cost;
    Ok(Measured {
        flop: cost.flop,
        int: cost.int,
        bytes: moved as f64 / (updates as f64).max(1.0),
        ceiling: None,
        kernels: None,
        workload: workload.name.clone(),
        method: crate::method::name(method).into(),
        backend: backend.name().into(),
        readings,
        updates,
        updates_per_second: updates as f64 / median,
        readings_per_second: readings as f64 / median,
        binning: self::median(&binning),
        passes,
        seconds,
        median,
    })
}

/// What the lists of a workload's readings hold, whoever makes them.
fn listed(workload: &Workload, method: &dyn Method) -> Result<Work> {
    let mut dry = Dry::default();
    let mut mapper = Mapper::new(workload.grid, &workload.sensors, method, &mut dry, BATCH)?.without_counts();
    for sweep in 0..method.sweeps().len() {
        mapper.sweep(sweep, workload.readings.iter().map(|r| Ok((*r, None))))?;
    }
    Ok(mapper.work)
}

/// A workload's scans from memory to cells.
fn count_scans(workload: &Workload, csm: Csm, method: &dyn Method, backend: &mut dyn Backend) -> Result<Work> {
    let records = workload.readings.iter().map(|r| Ok(r.record));
    let labels = if csm.semantic { csm.labels() } else { 0 };
    let scans = Scans::new(records, &workload.sensors, labels, u64::MAX, std::path::Path::new(&workload.name));
    let here = (std::env::temp_dir(), u64::MAX);
    let scanned =
        Scanned::read(&workload.grid, csm.selection(workload.grid.resolution), scans, (&here.0, here.1), &|_| {})?;
    scanned.apply(method, backend, BATCH, &|_| {})
}

/// The middle of the values, or of the two in the middle the mean.
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
