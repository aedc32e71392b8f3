//! `echogrid plan`.

mod estimate;
mod report;

use super::exit::done;
use super::flags::with_flags;
use super::log_arguments::LogArguments;
use super::progress::{bar, spinner};
use super::values::BackendArgument;
use super::warnings::{warn_of_jump, warn_of_log};
use crate::kernels::{Chosen, choose};
use crate::method::{self, Step, Steps};
use crate::pipeline::out_of_core::{self, Calibration, OutOfCoreRun};
use crate::pipeline::session::Session;
use crate::support::memory;
use crate::{Error, Result};
use estimate::{OracleTrial, TRIAL_SECONDS, TimeEstimate, of_oracle, time_of_writing};
use report::PlanReport;
use std::time::Instant;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
pub struct PlanArguments {
    #[command(flatten)]
    log: LogArguments,
    /// What would compute: it is tried, and told how long it would take
    #[arg(long, default_value = "auto")]
    backend: BackendArgument,
    /// Memory that the run may use, such as 4GiB [default: what the machine has free]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse_size)]
    memory: Option<u64>,
    /// Print the plan as JSON
    #[arg(long)]
    json: bool,
}

impl PlanArguments {
    /// Reads and bins the log, tries the backend for a second, and prints the plan of a run.
    pub fn run(self) -> Result<u8> {
        let started = Instant::now();
        let progress = spinner("reading", self.json);
        let session = self.log.session()?;
        drop(progress);
        let surveyed = started.elapsed().as_secs_f64();
        warn_of_log(&self.log, &session);
        warn_of_jump(&self.log, &session);
        let Some(choice) = self.backend.choice() else {
            let trial = OracleTrial { batch: self.log.batch, memory: self.memory, before: surveyed, quiet: self.json };
            return self.resident(&session, of_oracle(&session, &trial)?);
        };
        let chosen = choose(choice, session.method.as_ref(), self.log.threads)?;
        let Some(rounds) = session.method.rounds() else { return self.resident(&session, None) };
        let started = Instant::now();
        let folder = std::env::temp_dir();
        let plan = out_of_core::ResourcePlan::of(&session, self.log.batch, self.memory);
        let fit = plan.as_ref().map_err(Error::to_string).and_then(|p| {
            p.check_space(&session, &std::env::current_dir().unwrap_or_default(), false).map_err(|e| e.to_string())
        });
        let why_not = fit.err().map(|why| with_flags(&why));
        let (batch, bins) = plan.as_ref().map_or((1 << 14, 1 << 28), |p| (p.batch, p.bins));
        let bar = bar(session.survey.counts.used, "sorting", self.json);
        let run = OutOfCoreRun::begin(&session, batch, &folder, bins, &|n| bar.inc(n))?;
        drop(bar);
        let before = surveyed + started.elapsed().as_secs_f64();
        let chunks = run.chunks();
        let binned: u64 = chunks.iter().map(|p| p.1).sum();
        let passes = binned * rounds.iter().map(|r| r.len() as u64).sum::<u64>();
        let Chosen { mut backend, why } = chosen;
        let progress = spinner("trying", self.json);
        // The first batch compiles the kernels.
        run.calibrate(backend.as_mut(), 0.0)?;
        let Calibration { readings, seconds, chunk } = run.calibrate(backend.as_mut(), TRIAL_SECONDS)?;
        let chunk_seconds = chunk.map_or(Ok(0.0), |chunk| time_of_writing(&session, &chunk))?;
        drop(progress);
        let rate = readings as f64 / seconds.max(1e-9);
        let estimate = Some(TimeEstimate {
            backend: backend.name(),
            adapter: backend.adapter(),
            why,
            readings_per_second: rate,
            chunk_seconds,
            seconds: before + passes as f64 / rate.max(1.0) + chunks.len() as f64 * chunk_seconds,
        });
        let rounds = rounds.iter().map(|r| round_passes(r)).collect();
        let (memory, card, disk) = plan.as_ref().map_or((0, 0, 0), |p| (p.needed, p.card, p.disk));
        let report =
            PlanReport { rounds, chunks, binned, card, estimate, batch, memory, disk, spilled: run.spilled(), why_not };
        Ok(self.print(&session, &report))
    }

    /// Plans a run with all cells in memory: of the oracle, or of a method that needs it.
    fn resident(&self, session: &Session, estimate: Option<TimeEstimate>) -> Result<u8> {
        let need = session.memory(self.log.batch);
        let why_not = session.check_memory(need, self.memory).map_err(|e| with_flags(&e.to_string())).err();
        let rounds = session.method.sweeps().iter().map(|s| step_names(s)).collect();
        let batch = self.log.batch;
        let report = PlanReport { rounds, batch, estimate, memory: need, why_not, ..PlanReport::default() };
        Ok(self.print(session, &report))
    }

    /// Prints the plan; the exit code.
    fn print(&self, session: &Session, report: &PlanReport) -> u8 {
        if self.json {
            report.print_json(session);
        } else {
            report.print(session);
        }
        done(session)
    }
}

/// The passes of a round, as text.
fn round_passes(traversals: &[Steps]) -> String {
    traversals.iter().map(|steps| step_names(steps)).collect::<Vec<_>>().join("; again ")
}

/// The names of steps, as text.
fn step_names(steps: &[Step]) -> String {
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
