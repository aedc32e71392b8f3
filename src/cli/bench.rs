//! `echogrid bench`.

mod table;

use super::log_arguments::LogArguments;
use super::suggested_values::{SuggestedValues, methods};
use super::values::{parse_threads, use_threads};
use super::warnings::{warn_of_jump, warn_of_log};
use super::{print_line, print_note};
use crate::bench::throughput::{Measurement, measure};
use crate::bench::workload::{RandomCones, Workload, cones, scans, standard, standard_scans};
use crate::kernels::{Choice, choose, gpu_required};
use crate::method::{self, REGISTRY, Unit, settings::Settings};
use crate::{Error, Result};
use clap::ValueHint;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use table::{Style, Table};

/// A backend to measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum BenchBackend {
    /// The CPU's kernels
    Cpu,
    /// The GPU's kernels, on the best adapter; a software one counts
    Gpu,
}

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub struct BenchArguments {
    /// Also measure on this log, at 0.05 m
    #[arg(value_hint = ValueHint::AnyPath)]
    log: Option<PathBuf>,
    /// The methods, separated by commas [default: every one but truth]
    #[arg(short, long, value_delimiter = ',', value_parser = SuggestedValues(methods), hide_possible_values = true)]
    methods: Vec<String>,
    /// The backends
    #[arg(long, value_delimiter = ',', default_value = "cpu,gpu")]
    backends: Vec<BenchBackend>,
    /// Readings of each synthetic workload
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..10_000_000))]
    readings: u64,
    /// Timed runs of each; the median is reported
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..1000))]
    runs: u64,
    /// Threads of the CPU's kernels and of the host's work; 0: one a core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads)]
    threads: usize,
    /// Show how time grows over 1, 4, 16 and 64 times the readings, and over as many times the cells
    #[arg(long)]
    growth: bool,
    /// Hold the figures against those of an earlier run, kept as JSON
    #[arg(long, value_name = "OLD.json", value_hint = ValueHint::FilePath)]
    compare: Option<PathBuf>,
    /// Print the table as Markdown
    #[arg(long)]
    markdown: bool,
    /// Print the figures as JSON
    #[arg(long, conflicts_with = "markdown")]
    json: bool,
}

impl BenchArguments {
    /// Measures, and prints a table.
    pub fn run(self) -> Result<u8> {
        use_threads(self.threads)?;
        let methods: Vec<&str> = if self.methods.is_empty() {
            REGISTRY.iter().map(|e| e.name).filter(|n| *n != "truth").collect()
        } else {
            self.methods.iter().map(|n| method::entry(n).map(|e| e.name)).collect::<Result<_>>()?
        };
        if methods.contains(&"truth") {
            let what = "truth needs the wedges of laser scans; bench measures the other methods";
            return Err(Error::Usage(what.into()));
        }
        let old = self.compare.as_deref().map(read_earlier).transpose()?;
        let count = self.readings as usize;
        let (mut workloads, mut scan_workloads) = (standard(count), standard_scans(count));
        if let Some(log) = &self.log {
            let workload = from_log(log)?;
            scan_workloads.push(workload.clone());
            workloads.push(workload);
        }
        if self.growth {
            let width = 30f64.to_radians();
            workloads = growth_workloads(&|times, cells| {
                cones(RandomCones { count: count * times, width, range: 2.0, resolution: 0.05, cells, seed: 1 })
            });
            // Smaller cells of the same area: no scan reaches cells far away.
            scan_workloads = growth_workloads(&|times, cells| scans(count * times, 25.6 / cells as f64, cells, 1));
        }
        let style = Style { markdown: self.markdown, silent: self.json, compared: old.is_some() };
        let mut table = Table::new(workloads.iter().chain(&scan_workloads), style);
        let mut all: Vec<Measurement> = Vec::new();
        let mut backends = Vec::new();
        for (kind, choice) in [(BenchBackend::Cpu, Choice::Cpu), (BenchBackend::Gpu, Choice::Gpu)] {
            if !self.backends.contains(&kind) {
                continue;
            }
            let mut ceilings = None;
            for name in &methods {
                let Some(settings) = Settings::of(name) else { continue };
                let method = method::make(settings);
                let mut chosen = match choose(choice, method.as_ref(), self.threads) {
                    Ok(chosen) => chosen,
                    Err(Error::NoAdapter(why)) if !gpu_required() => {
                        print_note!("SKIPPED gpu: {why}");
                        break;
                    }
                    Err(e) => return Err(e),
                };
                if ceilings.is_none() {
                    ceilings = chosen.backend.peaks()?;
                    table.begin(&format!("{}: {}", chosen.backend.name(), chosen.backend.adapter()), ceilings);
                    backends.push(json!({
                        "backend": chosen.backend.name(), "adapter": chosen.backend.adapter(), "ceilings": ceilings,
                    }));
                }
                let suited = if method.unit() == Unit::Scan { &scan_workloads } else { &workloads };
                for workload in suited {
                    let m = measure(workload, method.as_ref(), chosen.backend.as_mut(), self.runs as usize)?;
                    let m = m.against(ceilings);
                    table.row(&m, old.as_ref().map(|old| rate_before(old, &m)));
                    all.push(m);
                }
            }
        }
        table.end();
        if self.json {
            let figures = json!({"version": env!("CARGO_PKG_VERSION"), "backends": backends, "measured": all});
            print_line!("{}", serde_json::to_string_pretty(&figures).unwrap_or_default());
        }
        Ok(0)
    }
}

/// Reads the JSON of an earlier run.
fn read_earlier(path: &Path) -> Result<Value> {
    let wrong = |what: String| Error::input(path, format!("{what}: give what bench --json printed"));
    let text = std::fs::read(path).map_err(|e| wrong(e.to_string()))?;
    let figures: Value = serde_json::from_slice(&text).map_err(|e| wrong(format!("it is not JSON ({e})")))?;
    if figures["measured"].is_array() { Ok(figures) } else { Err(wrong("it has no figures".into())) }
}

/// The updates a second of the same method, backend and workload in an earlier run.
fn rate_before(old: &Value, m: &Measurement) -> Option<f64> {
    let same = |v: &&Value| v["method"] == m.method && v["backend"] == m.backend && v["workload"] == m.workload;
    old["measured"].as_array()?.iter().find(same)?["updates_per_second"].as_f64()
}

/// Workloads of 1, 4, 16 and 64 times the readings over the same cells, and of as many times the cells with the same readings. `make`
/// takes the factor of readings and the cells along an edge.
fn growth_workloads(make: &dyn Fn(usize, usize) -> Workload) -> Vec<Workload> {
    let one = |times: usize, cells: usize, what: &str| {
        let workload = make(times, cells);
        Workload {
            name: format!("{what} x {}", if what == "cells" { (cells / 512) * (cells / 512) } else { times }),
            ..workload
        }
    };
    let more = [1, 4, 16, 64].map(|times| one(times, 512, "readings"));
    more.into_iter().chain([512, 1024, 2048, 4096].map(|cells| one(1, cells, "cells"))).collect()
}

/// The readings of a log as a workload, on cells of 5 cm.
fn from_log(path: &Path) -> Result<Workload> {
    let arguments = LogArguments::defaults(path);
    let session = arguments.session()?;
    warn_of_log(&arguments, &session);
    warn_of_jump(&arguments, &session);
    let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
    let (readings, _) = session.all_readings()?;
    Ok(Workload { name: format!("{name}, 5 cm"), grid: session.grid, sensors: session.sensors().to_vec(), readings })
}
