//! `echogrid bench`.

use super::common::{LogArguments, threads, use_threads, warn_of_jump, warn_of_log};
use super::offered::{Offered, methods};
use super::{note, say};
use crate::bench::throughput::{Measured, measure};
use crate::bench::workload::{Workload, cones, scans, standard, standard_scans};
use crate::kernels::peak::Peaks;
use crate::kernels::{Choice, choose, gpu_required};
use crate::method::{self, REGISTRY, Unit, settings::Settings};
use crate::support::wrapped::wrapped;
use crate::{Error, Result};
use clap::ValueHint;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Characters of a workload's name in the table, and where a column tells how fast it was before.
const LONGEST: [usize; 2] = [30, 22];
/// Widths of the columns after it.
const WIDTHS: [usize; 8] = [10, 11, 8, 8, 7, 12, 12, 8];

/// What the columns tell.
const LEGEND: &str = "
M updates: millions of cell updates; one is one reading applied to one cell.
whole: the median of the runs, from readings in memory to cells in memory; binning: what of it is
spent on finding which tiles the readings reach, before the kernels.
per update: bytes that an update moves if nothing is cached.
of the limit: how much of what the processor can do at most, above, is reached in what is used most:
floating-point operations (flop), integer ones (int) or memory traffic (bytes); whole: by the whole
run; in kernels: by the kernels alone, by the processor's own clock.";

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
    #[arg(value_hint = ValueHint::AnyPath)]
    log: Option<PathBuf>,
    /// The methods, separated by commas [default: every one but truth]
    #[arg(short, long, value_delimiter = ',', value_parser = Offered(methods), hide_possible_values = true)]
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
    /// Threads of the CPU's kernels and of the host's work; 0: one a core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads)]
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

impl Bench {
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
        let old = self.compare.as_deref().map(earlier).transpose()?;
        let count = self.readings as usize;
        let (mut workloads, mut of_scans) = (standard(count), standard_scans(count));
        if let Some(log) = &self.log {
            let workload = from_log(log)?;
            of_scans.push(workload.clone());
            workloads.push(workload);
        }
        if self.growth {
            let width = 30f64.to_radians();
            workloads = growing(&|times, cells| cones(count * times, width, 2.0, 0.05, cells, 1));
            // More cells over the same place: scans say nothing of cells far away.
            of_scans = growing(&|times, cells| scans(count * times, 25.6 / cells as f64, cells, 1));
        }
        let mut table = Table::of(workloads.iter().chain(&of_scans), self.markdown, self.json, old.is_some());
        let mut all: Vec<Measured> = Vec::new();
        let mut backends = Vec::new();
        for (kind, choice) in [(Measurable::Cpu, Choice::Cpu), (Measurable::Gpu, Choice::Gpu)] {
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
                        note!("SKIPPED gpu: {why}");
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
                let suited = if method.unit() == Unit::Scan { &of_scans } else { &workloads };
                for workload in suited {
                    let m = measure(workload, method.as_ref(), chosen.backend.as_mut(), self.runs as usize)?;
                    let m = m.against(ceilings);
                    table.row(&m, old.as_ref().map(|old| before(old, &m)));
                    all.push(m);
                }
            }
        }
        table.end();
        if self.json {
            let figures = json!({"version": env!("CARGO_PKG_VERSION"), "backends": backends, "measured": all});
            say!("{}", serde_json::to_string_pretty(&figures).unwrap_or_default());
        }
        Ok(0)
    }
}

/// The table under way.
struct Table {
    width: usize,
    markdown: bool,
    silent: bool,
    compared: bool,
    /// The method whose rows are being printed.
    method: String,
}

impl Table {
    fn of<'a>(workloads: impl Iterator<Item = &'a Workload>, markdown: bool, silent: bool, compared: bool) -> Table {
        let widest = workloads.map(|w| w.name.chars().count()).max().unwrap_or(0);
        let width = widest.clamp(15, LONGEST[usize::from(compared)]);
        Table { width, markdown, silent, compared, method: String::new() }
    }

    /// A backend's title, what it can do at most, and the columns' heads.
    fn begin(&mut self, title: &str, ceilings: Option<Peaks>) {
        if self.silent {
            return;
        }
        let most = ceilings.map(|c| {
            let giga = |v: f64| v / 1e9;
            format!(
                "at most {:.1} GFLOP/s (fused), {:.1} G integer operations/s, {:.1} GB/s copied",
                giga(c.flop),
                giga(c.int),
                giga(c.bytes)
            )
        });
        let gap = if self.markdown { "\n" } else { "" };
        say!("{gap}{}{gap}", wrapped(title, 2));
        most.iter().for_each(|m| say!("{m}{gap}"));
        self.method.clear();
        if self.markdown {
            let mut heads = vec![
                "method",
                "workload",
                "M updates/s",
                "k readings/s",
                "ms",
                "binning",
                "B/update",
                "of ceiling",
                "in kernels",
                "passes, ms",
            ];
            heads.extend(self.compared.then_some("before"));
            say!("| {} |", heads.join(" | "));
            say!("|{}", "---|".repeat(heads.len()));
            return;
        }
        for (first, heads) in [
            ("", ["M updates", "k readings", "whole", "binning", "per", "of the", "limit", "times"]),
            ("workload", ["a second", "a second", "ms", "ms", "update", "whole", "in kernels", "before"]),
        ] {
            self.line(first, &heads.map(String::from)[..WIDTHS.len() - usize::from(!self.compared)]);
        }
    }

    fn row(&mut self, m: &Measured, before: Option<Option<f64>>) {
        if self.silent {
            return;
        }
        let mut cells = vec![
            format!("{:.1}", m.updates_per_second / 1e6),
            format!("{:.1}", m.readings_per_second / 1e3),
            format!("{:.1}", m.median * 1e3),
            format!("{:.1}", m.binning * 1e3),
            format!("{:.1}", m.bytes),
            share(m.ceiling),
            share(m.kernels),
        ];
        // Faster or slower than it was, as a factor.
        let before = before.map(|b| b.map_or("-".into(), |old| format!("{:.2} x", m.updates_per_second / old)));
        if self.markdown {
            cells.push(passes(m, " "));
            cells.extend(before);
            say!("| {} | {} | {} |", m.method, m.workload, cells.join(" | "));
            return;
        }
        cells.extend(before);
        if self.method != m.method {
            say!("{}", m.method);
            self.method = m.method.clone();
        }
        self.line(&m.workload, &cells);
        if m.passes.len() > 1 {
            say!("    of which kernels, ms: {}", passes(m, ", "));
        }
    }

    fn line(&self, workload: &str, cells: &[String]) {
        let cells: String = cells.iter().zip(WIDTHS).map(|(text, width)| format!("{text:>width$}")).collect();
        say!("  {:<1$}{cells}", short(workload, self.width), self.width);
    }

    /// What the columns tell.
    fn end(&self) {
        if !self.silent && !self.markdown {
            say!("{LEGEND}");
        }
    }
}

/// The figures of an earlier run.
fn earlier(path: &std::path::Path) -> Result<Value> {
    let wrong = |what: String| Error::input(path, format!("{what}: give what bench --json printed"));
    let text = std::fs::read(path).map_err(|e| wrong(e.to_string()))?;
    let figures: Value = serde_json::from_slice(&text).map_err(|e| wrong(format!("it is not JSON ({e})")))?;
    if figures["measured"].is_array() { Ok(figures) } else { Err(wrong("it has no figures".into())) }
}

/// Updates a second of the same method on the same backend and workload in an earlier run.
fn before(old: &Value, m: &Measured) -> Option<f64> {
    let same = |v: &&Value| v["method"] == m.method && v["backend"] == m.backend && v["workload"] == m.workload;
    old["measured"].as_array()?.iter().find(same)?["updates_per_second"].as_f64()
}

/// 30° cones of 2 m on 5 cm, or scans: 1, 4, 16 and 64 times the readings over the same cells; and as many cells for the same
/// readings.
fn growing(make: &dyn Fn(usize, usize) -> Workload) -> Vec<Workload> {
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

/// A share of a ceiling.
fn share(share: Option<(f64, &str)>) -> String {
    share.map_or("-".into(), |(share, of)| format!("{:.0} % {of}", 100.0 * share))
}

/// What each kind of pass took, ms.
fn passes(m: &Measured, joint: &str) -> String {
    let each: Vec<String> = m.passes.iter().map(|(name, s)| format!("{name} {:.2}", s * 1e3)).collect();
    if each.is_empty() { "-".into() } else { each.join(joint) }
}

/// A name that fits its column.
fn short(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.into();
    }
    let end = name.char_indices().nth(most - 1).map_or(name.len(), |(at, _)| at);
    format!("{}…", &name[..end])
}

/// A log's readings as a workload.
fn from_log(path: &std::path::Path) -> Result<Workload> {
    let arguments = LogArguments::plain(path);
    let session = arguments.session()?;
    warn_of_log(&arguments, &session);
    warn_of_jump(&arguments, &session);
    let name = path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
    let (readings, _) = session.all()?;
    Ok(Workload { name: format!("{name}, 5 cm"), grid: session.grid, sensors: session.sensors().to_vec(), readings })
}
