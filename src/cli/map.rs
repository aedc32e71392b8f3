//! `echogrid map`.

mod save;

pub use save::{BackendUsed, FinishedRun, save};

use super::exit::done;
use super::interrupt::{self, SignalGuard};
use super::log_arguments::LogArguments;
use super::progress::{bar, spinner};
use super::summary::print_summary;
use super::text::count;
use super::values::{BackendArgument, parse_positive};
use super::warnings::{warn_of_empty_map, warn_of_jump, warn_of_log};
use super::{print_line, print_note};
use crate::kernels::cpu::Cpu;
use crate::kernels::{Choice, choose};
use crate::log::reading::Counts;
use crate::method::{self, Unit};
use crate::output::{self, Folder, MapSchema, MapWriter, Report, RunInfo, Unfinished, WorkingRequest};
use crate::pipeline::layers;
use crate::pipeline::out_of_core::{self, ChunkSink};
use crate::pipeline::session::Session;
use crate::support::memory;
use crate::{Error, Result};
use clap::ValueHint;
use save::run_info;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `map`.
#[derive(Debug, clap::Args)]
pub struct MapArguments {
    #[command(flatten)]
    log: LogArguments,
    /// Folder of the map; an echogrid map there is replaced when the new one is complete
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    output: PathBuf,
    /// What computes
    #[arg(long, default_value = "auto")]
    backend: BackendArgument,
    /// Memory that may be used, such as 4GiB [default: what the machine has free]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse_size)]
    memory: Option<u64>,
    /// Go on with the unfinished map that a killed run left beside the folder
    #[arg(long)]
    resume: bool,
    /// Discard the unfinished map that a killed run left beside the folder, and begin anew
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
    /// Also write a picture and JSON of used reading N alone
    #[arg(long, value_name = "N", value_parser = parse_positive, allow_negative_numbers = true)]
    working: Option<u64>,
    /// Also write every layer as .npy
    #[arg(long)]
    npy: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing but warnings and errors
    #[arg(short, long)]
    quiet: bool,
}

impl MapArguments {
    /// Maps the log.
    pub fn run(self) -> Result<u8> {
        let request = self.log.request()?;
        let unfinished = match (self.resume, self.overwrite) {
            (true, _) => Unfinished::Resume,
            (false, true) => Unfinished::Discard,
            (false, false) => Unfinished::Refuse,
        };
        let created = interrupt::missing_parents(&self.output);
        let folder = Folder::open(&self.output, unfinished)?;
        interrupt::register_output(folder.path(), created, true);
        let started = Instant::now();
        let progress = spinner("reading", self.hidden());
        let session = Session::open(&self.log.log, &request)?;
        drop(progress);
        let surveyed = started.elapsed().as_secs_f64();
        warn_of_log(&self.log, &session);
        self.check_working(&session)?;
        let out_of_core = session.method.rounds().is_some() && self.backend.choice().is_some();
        if !out_of_core || self.working.is_some() {
            session.check_memory(session.memory(self.log.batch), self.memory)?;
        }
        let seconds = vec![("survey".to_string(), surveyed)];
        let WrittenMap { folder, report, counts, backend, guard } = match self.backend.choice() {
            Some(choice) if out_of_core => self.map_out_of_core(folder, &session, choice, seconds)?,
            choice => self.map_in_memory(folder, &session, choice, seconds)?,
        };
        if let Some(n) = self.working {
            self.write_working(&folder, &session, n as usize)?;
        }
        let place = folder.finish()?;
        interrupt::mark_finished(&place, guard);
        warn_of_empty_map(&counts, &session);
        if report.features.as_ref().is_some_and(|f| f.regions == 0) {
            print_note!("{NO_REGIONS}");
        }
        if self.json {
            print_line!("{}", serde_json::to_string_pretty(&report).unwrap_or_default());
        } else if !self.quiet {
            print_summary(&session, &counts, &report, &backend.why, &place);
        }
        Ok(done(&session))
    }

    fn hidden(&self) -> bool {
        self.quiet || self.json
    }

    /// Maps out of core: chunk by chunk, each written when it is done.
    fn map_out_of_core(
        &self,
        folder: Folder,
        session: &Session,
        choice: Choice,
        seconds: Vec<(String, f64)>,
    ) -> Result<WrittenMap> {
        let plan = out_of_core::ResourcePlan::of(session, self.log.batch, self.memory)?;
        plan.check_space(session, folder.path(), self.npy)?;
        warn_of_jump(&self.log, session);
        let mut chosen = choose(choice, session.method.as_ref(), self.log.threads)?;
        if chosen.backend.name() == "gpu" {
            plan.check_card(session, self.memory)?;
        }
        let backend = BackendUsed::of(&chosen);
        let info = run_info(session, &backend, Counts::default(), seconds)?;
        let (layers, combined) = layers::schemas(session.method.as_ref());
        let method = method::name(session.method.as_ref()).to_string();
        let schema = MapSchema { grid: session.grid, method, layers, combined, npy: self.npy };
        let guard = interrupt::defer_signals();
        let mut writer = MapWriter::open(folder.path(), schema, &info, self.resume)?;
        drop(guard);
        let before = writer.done().len();
        let stage = |what, readings| -> Box<dyn Fn(u64)> {
            if what == out_of_core::MAPPING {
                interrupt::mark_writing();
            }
            let bar = bar(readings, what, self.hidden());
            Box::new(move |n| bar.inc(n))
        };
        let output = out_of_core::MapOutput { folder: folder.path(), progress: &stage, sink: &mut writer };
        let mapped = out_of_core::map(session, chosen.backend.as_mut(), &plan, output);
        let out_of_core::MappingStatistics { counts, seconds, busy } = match mapped {
            Ok(done) => done,
            Err(e) if writer.done().is_empty() => return Err(e),
            Err(e) => return Err(keep_unfinished(folder, e)),
        };
        if before > 0 {
            print_note!("resumed: {} had been done", count(before as u64, "chunk"));
        }
        let info =
            RunInfo { readings: counts, seconds: info.seconds.into_iter().chain(seconds).collect(), busy, ..info };
        // The cells are done: a signal waits for what is left.
        let guard = interrupt::defer_signals();
        let _progress = spinner("writing", self.hidden());
        match writer.finish(&info) {
            Ok(report) => Ok(WrittenMap { folder, report, counts, backend, guard }),
            Err(e) => Err(keep_unfinished(folder, e)),
        }
    }

    /// Maps with all chunks in memory: for the oracle, and for methods that need it.
    fn map_in_memory(
        &self,
        folder: Folder,
        session: &Session,
        choice: Option<Choice>,
        mut seconds: Vec<(String, f64)>,
    ) -> Result<WrittenMap> {
        warn_of_jump(&self.log, session);
        let started = Instant::now();
        let (mapped, backend) = match choice {
            None => {
                let _progress = spinner("mapping", self.hidden());
                (session.oracle_map()?, BackendUsed { backend: "oracle", ..BackendUsed::default() })
            }
            Some(choice) => {
                let sweeps = session.method.sweeps().len() as u64;
                let bar = bar(session.survey.counts.used * sweeps, out_of_core::MAPPING, self.hidden());
                let mut chosen = choose(choice, session.method.as_ref(), self.log.threads)?;
                let mapped = session.map(chosen.backend.as_mut(), self.log.batch, &|n| bar.inc(n))?;
                (mapped, BackendUsed::of(&chosen))
            }
        };
        seconds.push(("map".into(), started.elapsed().as_secs_f64()));
        let guard = interrupt::defer_signals();
        let _progress = spinner("writing", self.hidden());
        let report =
            save(&folder, FinishedRun { session, mapped: &mapped, backend: &backend, seconds, npy: self.npy })?;
        Ok(WrittenMap { folder, report, counts: mapped.counts, backend, guard })
    }

    /// Refuses a reading that can't be drawn, before the long run.
    fn check_working(&self, session: &Session) -> Result<()> {
        let used = session.survey.counts.used;
        match self.working {
            Some(n) if session.method.unit() == Unit::Scan => Err(Error::Usage(format!(
                "--working {n}: it draws one reading's cone, and {} takes a beam of each of a cell's nearest poses: leave it out",
                method::name(session.method.as_ref())
            ))),
            Some(n) if session.method.unit() == Unit::Update => Err(Error::Usage(format!(
                "--working {n}: it draws one reading's cone, and {} updates what the feature it came from says: leave it out",
                method::name(session.method.as_ref())
            ))),
            Some(n) if n > used => Err(Error::Usage(format!("--working {n}: there are {used} used readings"))),
            _ => Ok(()),
        }
    }

    /// Draws reading `n` over the map of those before it.
    fn write_working(&self, folder: &Folder, session: &Session, n: usize) -> Result<()> {
        let (readings, wedges) = session.all_readings()?;
        let before = session.map_first(n - 1, &mut Cpu::new(self.log.threads)?, self.log.batch, &|_| {})?;
        let request = WorkingRequest {
            grid: &session.grid,
            sensors: session.sensors(),
            readings: &readings,
            settings: &session.method.settings(),
            wedges: wedges.as_deref(),
            number: n,
            map: Some(&before.finished.map),
        };
        output::write_working(folder.path(), &request)?;
        Ok(())
    }
}

/// A map whose files are written, in a folder that is still the unfinished one.
struct WrittenMap {
    folder: Folder,
    report: Report,
    counts: Counts,
    backend: BackendUsed,
    /// Defers signals until the folder is in its place.
    guard: SignalGuard,
}

/// The note where method features found no walls or corners.
const NO_REGIONS: &str = "no walls or corners were found, so that every echo was mapped as method bayes does: features needs circular \
scans (a sonar that turns, with a reading every 2.5° or less), or sonars that pass a wall (4 echoes of one over 0.25 m of travel)";

/// Keeps the unfinished map; the error, with where it lies and how to go on.
fn keep_unfinished(folder: Folder, error: Error) -> Error {
    let place = folder.path().display().to_string();
    folder.keep();
    error.and(&format!("the finished part stays in {place}: --resume goes on from there, --overwrite begins anew"))
}
