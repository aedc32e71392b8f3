//! `echogrid plan`.

use super::common::{BackendArgument, LogArguments, bar, count, done, item, spinner, warn_of_jump, warn_of_log};
use super::{interrupt, parameters, say};
use crate::grid::Place;
use crate::kernels::{Chosen, choose};
use crate::method::{self, Step, Steps, Unit};
use crate::oracle;
use crate::output::{LogInfo, MapWriter, Outline, RunInfo, head, tidy};
use crate::pipeline::out_of_core::{self, Calibration, Chunk, Run};
use crate::pipeline::session::Session;
use crate::support::memory::{self, show};
use crate::support::wrapped::wrapped;
use crate::{Error, Result};
use serde::Serialize;
use serde_json::json;
use std::time::Instant;

/// How long the backend is tried, seconds.
const TRY: f64 = 1.0;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct Plan {
    #[command(flatten)]
    log: LogArguments,
    /// What would compute: it is tried, and told how long it would take
    #[arg(long, default_value = "auto")]
    backend: BackendArgument,
    /// Memory that the run may use, such as 4GiB [default: what the machine has free]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse)]
    memory: Option<u64>,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

/// What the backend would take.
#[derive(Debug, Serialize)]
struct Expected {
    backend: &'static str,
    adapter: String,
    /// Why it was taken; empty where the user chose.
    why: String,
    /// Readings a second on the busiest chunk, binning included.
    readings_per_second: f64,
    /// Seconds to write a chunk like it.
    chunk_seconds: f64,
    /// Seconds of the whole run.
    seconds: f64,
}

impl Plan {
    /// Reads and bins the log, tries the backend for a second, and says what a run would come to.
    pub fn run(self) -> Result<u8> {
        let started = Instant::now();
        let sign = spinner("reading", self.json);
        let session = self.log.session()?;
        drop(sign);
        let surveyed = started.elapsed().as_secs_f64();
        warn_of_log(&self.log, &session);
        warn_of_jump(&self.log, &session);
        let Some(choice) = self.backend.choice() else {
            return self.resident(&session, self.oracle(&session, surveyed)?);
        };
        let chosen = choose(choice, session.method.as_ref(), self.log.threads)?;
        let Some(rounds) = session.method.rounds() else { return self.resident(&session, None) };
        let started = Instant::now();
        let folder = std::env::temp_dir();
        let plan = out_of_core::Plan::of(&session, self.log.batch, self.memory);
        let fit = plan.as_ref().map_err(Error::to_string).and_then(|p| {
            p.check_space(&session, &std::env::current_dir().unwrap_or_default(), false).map_err(|e| e.to_string())
        });
        let why_not = fit.err();
        let (batch, bins) = plan.as_ref().map_or((1 << 14, 1 << 28), |p| (p.batch, p.bins));
        let bar = bar(session.survey.counts.used, "sorting", self.json);
        let run = Run::begin(&session, batch, &folder, bins, &|n| bar.inc(n))?;
        drop(bar);
        let before = surveyed + started.elapsed().as_secs_f64();
        let places = run.places();
        let binned: u64 = places.iter().map(|p| p.1).sum();
        let passes = binned * rounds.iter().map(|r| r.len() as u64).sum::<u64>();
        let Chosen { mut backend, why } = chosen;
        let sign = spinner("trying", self.json);
        // The first batch makes the kernels.
        run.calibrate(backend.as_mut(), 0.0)?;
        let Calibration { readings, seconds, chunk } = run.calibrate(backend.as_mut(), TRY)?;
        let chunk_seconds = chunk.map_or(Ok(0.0), |chunk| write(&session, &chunk))?;
        drop(sign);
        let rate = readings as f64 / seconds.max(1e-9);
        let expected = Some(Expected {
            backend: backend.name(),
            adapter: backend.adapter(),
            why,
            readings_per_second: rate,
            chunk_seconds,
            seconds: before + passes as f64 / rate.max(1.0) + places.len() as f64 * chunk_seconds,
        });
        let rounds = rounds.iter().map(|r| round(r)).collect();
        let (memory, card, disk) = plan.as_ref().map_or((0, 0, 0), |p| (p.needed, p.card, p.disk));
        self.show(
            &session,
            &Shown { rounds, places, binned, expected, batch, memory, card, disk, spilled: run.spilled(), why_not },
        )
    }

    /// What the f64 reference would take, from some of the readings; nothing is told of methods whose cost depends on the others.
    fn oracle(&self, session: &Session, before: f64) -> Result<Option<Expected>> {
        let fits = session.check_memory(session.memory(self.log.batch), self.memory).is_ok();
        if session.method.unit() != Unit::Reading || !fits {
            return Ok(None);
        }
        let _sign = spinner("trying", self.json);
        let time = |count: usize| -> Result<f64> {
            let items = session.items()?.take(count).collect::<Result<Vec<_>>>()?;
            let readings: Vec<_> = items.iter().map(|i| i.0).collect();
            let wedges: Option<Vec<_>> = items.iter().map(|i| i.1).collect();
            let started = Instant::now();
            oracle::map(&session.grid, session.sensors(), &readings, &session.method.settings(), wedges.as_deref())?;
            Ok(started.elapsed().as_secs_f64())
        };
        let (used, cells) = (session.survey.counts.used, time(0)?);
        let (mut count, mut seconds) = (1, 0.0);
        while count < used as usize && seconds < TRY {
            count = (4 * count).min(used as usize);
            seconds = time(count)? - cells;
        }
        let rate = count as f64 / seconds.max(1e-9);
        Ok(Some(Expected {
            backend: "oracle",
            adapter: "f64, one reading at a time".into(),
            why: String::new(),
            readings_per_second: rate,
            chunk_seconds: 0.0,
            seconds: before + cells + used as f64 / rate,
        }))
    }

    /// A method whose cells must be in memory together, or the reference.
    fn resident(&self, session: &Session, expected: Option<Expected>) -> Result<u8> {
        let need = session.memory(self.log.batch);
        let why_not = session.check_memory(need, self.memory).map_err(|e| e.to_string()).err();
        let rounds = session.method.sweeps().iter().map(|s| names(s)).collect();
        let batch = self.log.batch;
        self.show(session, &Shown { rounds, batch, expected, memory: need, why_not, ..Shown::default() })
    }

    fn show(&self, session: &Session, shown: &Shown) -> Result<u8> {
        if self.json {
            self.print_json(session, shown);
        } else {
            self.print(session, shown);
        }
        Ok(done(session))
    }

    fn print_json(&self, session: &Session, shown: &Shown) {
        let grid = &session.grid;
        let chunk =
            |([row, column], readings): &(Place, u64)| json!({"row": row, "column": column, "readings": readings});
        let plan = json!({
            "method": method::name(session.method.as_ref()),
            "format": session.log.header().format,
            "parameters": session.parameters().into_iter().collect::<std::collections::BTreeMap<_, _>>(),
            "readings": session.survey.counts,
            "scans": session.survey.scans,
            "bad_lines": session.survey.bad_lines.count,
            "cells": {"x0": tidy(grid.x0()), "y0": tidy(grid.y0()), "resolution": grid.resolution, "width": grid.width, "height": grid.height},
            "chunks": shown.places.iter().map(chunk).collect::<Vec<_>>(),
            "binned": shown.binned,
            "spilled": shown.spilled,
            "batch": shown.batch,
            "rounds": shown.rounds,
            "memory": shown.memory,
            "card": shown.card,
            "disk": shown.disk,
            "fits": shown.why_not.is_none(),
            "why_not": shown.why_not,
            "available": memory::available(),
            "expected": shown.expected.iter().collect::<Vec<_>>(),
        });
        say!("{}", serde_json::to_string_pretty(&plan).unwrap_or_default());
    }

    fn print(&self, session: &Session, shown: &Shown) {
        let (grid, counts) = (&session.grid, &session.survey.counts);
        let sensors = count(session.sensors().len() as u64, "sensor");
        item("log", &format!("{}, {sensors}", session.log.header().format));
        item(
            "readings",
            &format!(
                "{} used of {} in {}, {}, {}",
                counts.used,
                counts.read,
                count(session.survey.scans, "scan"),
                count(session.survey.bad_lines.count, "bad line"),
                count(session.survey.ignored, "other line")
            ),
        );
        let end = |start: f64, cells: usize| start + cells as f64 * grid.resolution;
        item(
            "grid",
            &format!(
                "{} × {} cells of {} m from ({:.2}, {:.2}) to ({:.2}, {:.2}) m",
                grid.width,
                grid.height,
                grid.resolution,
                grid.x0(),
                grid.y0(),
                end(grid.x0(), grid.width),
                end(grid.y0(), grid.height)
            ),
        );
        if let Some(([row, column], most)) = shown.places.iter().max_by_key(|p| p.1) {
            item(
                "chunks",
                &format!(
                    "{} of {} squares of {} × {} cells have readings; the fullest, column {column} row {row}, has {most}",
                    shown.places.len(),
                    crate::grid::places(grid).count(),
                    crate::grid::EDGE,
                    crate::grid::EDGE,
                ),
            );
            let disk =
                if shown.spilled > 0 { format!("; {} of them on disk", show(shown.spilled)) } else { String::new() };
            item(
                "",
                &format!(
                    "{} if a reading counts in each square that it reaches, {} at a time{disk}",
                    count(shown.binned, "reading"),
                    shown.batch
                ),
            );
        }
        for (k, steps) in shown.rounds.iter().enumerate() {
            item(&format!("round {}", k + 1), steps);
        }
        let free = memory::available().map(|f| format!(", of {} free", show(f))).unwrap_or_default();
        item("memory", &format!("about {}{free}", show(shown.memory)));
        if shown.card > 0 {
            item("card", &format!("about {} of a GPU's memory, where one maps", show(shown.card)));
        }
        if shown.disk > 0 {
            item("disk", &format!("{} and the compressed layers", show(shown.disk)));
        }
        if let Some(e) = &shown.expected {
            let (rate, chunk) = (e.readings_per_second / 1e3, e.chunk_seconds);
            let chunk = if chunk > 0.0 { format!(", {chunk:.3} s to write a chunk") } else { String::new() };
            let why = if e.why.is_empty() { String::new() } else { format!(", because {}", e.why) };
            let about = format!("about {:.1} s: {rate:.1} k readings/s{chunk} ({}{why})", e.seconds, e.adapter);
            item(e.backend, &about);
        }
        if let Some(e) = &shown.why_not {
            say!("{}", wrapped(&format!("does not fit: {e}"), 10));
        }
        for (key, value) in session.parameters() {
            say!("{}", wrapped(&format!("  {key} = {}", parameters::shown(&key, &value)), 10));
        }
    }
}

/// What both kinds of output show.
#[derive(Default)]
struct Shown {
    rounds: Vec<String>,
    places: Vec<(Place, u64)>,
    binned: u64,
    card: u64,
    expected: Option<Expected>,
    batch: usize,
    /// Bytes that the run needs at once.
    memory: u64,
    /// Bytes of the outputs that aren't compressed.
    disk: u64,
    /// Bytes of bins that went to disk.
    spilled: u64,
    /// What the run lacks.
    why_not: Option<String>,
}

/// Seconds to write a chunk.
fn write(session: &Session, chunk: &Chunk) -> Result<f64> {
    let folder = tempfile::tempdir().map_err(|e| Error::Resources(format!("no temporary folder: {e}")))?;
    let map = &chunk.finished.map;
    let heads = map.layers.iter().map(head).collect();
    let method = method::name(session.method.as_ref()).to_string();
    let combined = head(&chunk.finished.combined);
    let outline = Outline { grid: map.grid, method, heads, combined, npy: false };
    let info = RunInfo { log: LogInfo::default(), ..RunInfo::default() };
    let mut writer = MapWriter::open(folder.path(), outline, &info, false)?;
    // A signal waits, so that the folder doesn't stay.
    let _unbroken = interrupt::unbroken();
    let started = Instant::now();
    writer.chunk([0, 0], map, &chunk.finished.combined)?;
    Ok(started.elapsed().as_secs_f64())
}

/// A round's passes.
fn round(traversals: &[Steps]) -> String {
    traversals.iter().map(|steps| names(steps)).collect::<Vec<_>>().join("; again ")
}

fn names(steps: &[Step]) -> String {
    let name = |step: &Step| match step {
        Step::Pass(method::Pass::Weigh, _) => "weigh",
        Step::Pass(method::Pass::Count, _) => "count",
        Step::Pass(method::Pass::Fuse, _) => "fuse",
        Step::Sum => "sum",
        Step::NormalizeByCount => "share",
        Step::ReadBack => "hand over",
        Step::AccumulateCounts => "tally",
    };
    steps.iter().map(name).collect::<Vec<_>>().join(", then ")
}
