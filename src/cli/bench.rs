//! `echogrid bench`.

use super::common::{LogArguments, threads, warn_of_bad_lines, warn_of_jump};
use super::{note, say};
use crate::kernels::{Choice, choose, gpu_required};
use crate::method::{self, REGISTRY, settings::Settings};
use crate::throughput::{Measured, measure};
use crate::workload::{Workload, standard};
use crate::{Error, Result};
use std::path::PathBuf;

/// Characters of a workload's name in the table.
const LONGEST: usize = 40;

/// A backend to measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Measurable {
    /// The CPU's kernels
    Cpu,
    /// The GPU's kernels, on the best adapter; a software one counts
    Gpu,
}

/// Arguments of `bench`.
#[derive(Debug, clap::Args)]
pub struct Bench {
    /// Also measure on this log, at 0.05 m
    log: Option<PathBuf>,
    /// The methods, separated by commas [default: every one but truth]
    #[arg(short, long, value_delimiter = ',')]
    methods: Vec<String>,
    /// The backends
    #[arg(long, value_delimiter = ',', default_value = "cpu,gpu")]
    backends: Vec<Measurable>,
    /// Readings of each synthetic workload
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..10_000_000))]
    readings: u64,
    /// Timed runs of each; the median is reported
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..1000))]
    runs: u64,
    /// Threads of the CPU's kernels; 0: one a core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads)]
    threads: usize,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

impl Bench {
    /// Measures, and prints a table.
    pub fn run(self) -> Result<u8> {
        let methods: Vec<&str> = if self.methods.is_empty() {
            REGISTRY.iter().map(|e| e.name).filter(|n| *n != "truth").collect()
        } else {
            self.methods.iter().map(|n| method::entry(n).map(|e| e.name)).collect::<Result<_>>()?
        };
        if methods.contains(&"truth") {
            let what = "truth needs the wedges of laser scans; bench measures the other methods";
            return Err(Error::Usage(what.into()));
        }
        let mut workloads = standard(self.readings as usize);
        if let Some(log) = &self.log {
            workloads.push(from_log(log)?);
        }
        let widest = workloads.iter().map(|w| w.name.chars().count()).max().unwrap_or(0);
        let width = 2 + widest.clamp(15, LONGEST);
        let mut all: Vec<Measured> = Vec::new();
        let mut adapters = Vec::new();
        for (kind, choice) in [(Measurable::Cpu, Choice::Cpu), (Measurable::Gpu, Choice::Gpu)] {
            if !self.backends.contains(&kind) {
                continue;
            }
            for name in &methods {
                let Some(settings) = Settings::of(name) else { continue };
                let method = method::make(settings);
                let mut chosen = match choose(choice, method.as_ref(), self.threads) {
                    Ok(chosen) => chosen,
                    Err(Error::NoAdapter(why)) if !gpu_required() => {
                        note!("SKIPPED gpu: {why}");
                        break;
                    }
                    Err(e) => return Err(e),
                };
                let adapter = format!("{}: {}", chosen.backend.name(), chosen.backend.adapter());
                if !adapters.contains(&adapter) {
                    if !self.json {
                        say!("{adapter}");
                        say!(
                            "{:<17}{:<width$}{:>12}{:>14}{:>10}{:>10}",
                            "method",
                            "workload",
                            "M updates/s",
                            "k readings/s",
                            "ms",
                            "binning"
                        );
                    }
                    adapters.push(adapter);
                }
                for workload in &workloads {
                    let m = measure(workload, method.as_ref(), chosen.backend.as_mut(), self.runs as usize)?;
                    if !self.json {
                        say!(
                            "{:<17}{:<width$}{:>12.1}{:>14.1}{:>10.1}{:>10.1}",
                            m.method,
                            short(&m.workload),
                            m.updates_per_second / 1e6,
                            m.readings_per_second / 1e3,
                            m.median * 1e3,
                            m.binning * 1e3
                        );
                    }
                    all.push(m);
                }
            }
        }
        if self.json {
            let figures =
                serde_json::json!({"version": env!("CARGO_PKG_VERSION"), "adapters": adapters, "measured": all});
            say!("{}", serde_json::to_string_pretty(&figures).unwrap_or_default());
        }
        Ok(0)
    }
}

/// A name that fits its column.
fn short(name: &str) -> String {
    if name.chars().count() <= LONGEST {
        return name.into();
    }
    let end = name.char_indices().nth(LONGEST - 1).map_or(name.len(), |(at, _)| at);
    format!("{}…", &name[..end])
}

/// A log's readings as a workload.
fn from_log(path: &std::path::Path) -> Result<Workload> {
    let arguments = LogArguments::plain(path);
    let session = arguments.session()?;
    warn_of_bad_lines(&session);
    warn_of_jump(&arguments, &session);
    let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
    let (readings, _) = session.all()?;
    Ok(Workload { name: format!("{name}, 5 cm"), grid: session.grid, sensors: session.sensors().to_vec(), readings })
}
