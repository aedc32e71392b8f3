//! `echogrid map`.

use super::common::{
    BackendArgument, LogArguments, bar, count, done, from_one, spinner, warn_of_empty_map, warn_of_jump, warn_of_log,
};
use super::interrupt::{self, Unbroken};
use super::summary::summary;
use super::{note, say};
use crate::feature;
use crate::kernels::cpu::Cpu;
use crate::kernels::{Chosen, choose};
use crate::log::reading::Counts;
use crate::method;
use crate::method::Unit;
use crate::output::{self, Folder, LogInfo, MapWriter, Outline, Report, RunInfo, Unfinished};
use crate::pipeline::layers;
use crate::pipeline::out_of_core::{self, ChunkSink};
use crate::pipeline::session::{Mapped, Session};
use crate::support::memory;
use crate::{Error, Result};
use clap::ValueHint;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `map`.
#[derive(Debug, clap::Args)]
pub struct Map {
    #[command(flatten)]
    log: LogArguments,
    /// Folder of the map; an echogrid map there is replaced when the new one is complete
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    output: PathBuf,
    /// What computes
    #[arg(long, default_value = "auto")]
    backend: BackendArgument,
    /// Memory that may be used, such as 4GiB [default: what the machine has free]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse)]
    memory: Option<u64>,
    /// Go on with the unfinished map that a killed run left beside the folder
    #[arg(long)]
    resume: bool,
    /// Discard the unfinished map that a killed run left beside the folder, and begin anew
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
    /// Also write a picture and JSON of used reading N alone
    #[arg(long, value_name = "N", value_parser = from_one, allow_negative_numbers = true)]
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

impl Map {
    /// Maps the log.
    pub fn run(self) -> Result<u8> {
        let request = self.log.request()?;
        let unfinished = match (self.resume, self.overwrite) {
            (true, _) => Unfinished::Resume,
            (false, true) => Unfinished::Discard,
            (false, false) => Unfinished::Refuse,
        };
        let made = interrupt::missing_above(&self.output);
        let folder = Folder::open(&self.output, unfinished)?;
        interrupt::output(folder.path(), made, true);
        let started = Instant::now();
        let sign = spinner("reading", self.hidden());
        let session = Session::open(&self.log.log, &request)?;
        drop(sign);
        let surveyed = started.elapsed().as_secs_f64();
        warn_of_log(&self.log, &session);
        self.check_working(&session)?;
        let whole = session.method.rounds().is_some() && self.backend.choice().is_some();
        if !whole || self.working.is_some() {
            session.check_memory(session.memory(self.log.batch), self.memory)?;
        }
        let seconds = vec![("survey".to_string(), surveyed)];
        let (folder, report, counts, ran, unbroken) = match self.backend.choice() {
            Some(choice) if whole => self.whole(folder, &session, choice, seconds)?,
            choice => self.resident(folder, &session, choice, seconds)?,
        };
        if let Some(n) = self.working {
            self.write_working(&folder, &session, n as usize)?;
        }
        let place = folder.finish()?;
        interrupt::finished(&place, unbroken);
        warn_of_empty_map(&counts, &session);
        if report.features.as_ref().is_some_and(|f| f.regions == 0) {
            note!("{NO_REGIONS}");
        }
        if self.json {
            say!("{}", serde_json::to_string_pretty(&report).unwrap_or_default());
        } else if !self.quiet {
            summary(&session, &counts, &report, &ran.why, &place);
        }
        Ok(done(&session))
    }

    fn hidden(&self) -> bool {
        self.quiet || self.json
    }

    /// The whole-log way: chunk by chunk, each written when it is done.
    fn whole(
        &self,
        folder: Folder,
        session: &Session,
        choice: crate::kernels::Choice,
        seconds: Vec<(String, f64)>,
    ) -> Result<(Folder, Report, Counts, Ran, Unbroken)> {
        let plan = out_of_core::Plan::of(session, self.log.batch, self.memory)?;
        plan.check_space(session, folder.path(), self.npy)?;
        warn_of_jump(&self.log, session);
        let mut chosen = choose(choice, session.method.as_ref(), self.log.threads)?;
        if chosen.backend.name() == "gpu" {
            plan.check_card(session, self.memory)?;
        }
        let ran = Ran::of(&chosen);
        let info = run_info(session, &ran, Counts::default(), seconds)?;
        let (heads, combined) = layers::heads(session.method.as_ref());
        let method = method::name(session.method.as_ref()).to_string();
        let outline = Outline { grid: session.grid, method, heads, combined, npy: self.npy };
        let unbroken = interrupt::unbroken();
        let mut writer = MapWriter::open(folder.path(), outline, &info, self.resume)?;
        drop(unbroken);
        let before = writer.done().len();
        let stage = |what, readings| -> Box<dyn Fn(u64)> {
            if what == out_of_core::MAPPING {
                interrupt::writing();
            }
            let bar = bar(readings, what, self.hidden());
            Box::new(move |n| bar.inc(n))
        };
        let mapped = out_of_core::map(session, chosen.backend.as_mut(), &plan, folder.path(), &stage, &mut writer);
        let out_of_core::Done { counts, seconds, busy } = match mapped {
            Ok(done) => done,
            Err(e) if writer.done().is_empty() => return Err(e),
            Err(e) => return Err(kept(folder, e)),
        };
        if before > 0 {
            note!("resumed: {} had been done", count(before as u64, "chunk"));
        }
        let info =
            RunInfo { readings: counts, seconds: info.seconds.into_iter().chain(seconds).collect(), busy, ..info };
        // The cells are done: what is left is worth waiting for.
        let unbroken = interrupt::unbroken();
        let _sign = spinner("writing", self.hidden());
        match writer.finish(&info) {
            Ok(report) => Ok((folder, report, counts, ran, unbroken)),
            Err(e) => Err(kept(folder, e)),
        }
    }

    /// With all chunks resident: where the method needs it, and for the reference.
    fn resident(
        &self,
        folder: Folder,
        session: &Session,
        choice: Option<crate::kernels::Choice>,
        mut seconds: Vec<(String, f64)>,
    ) -> Result<(Folder, Report, Counts, Ran, Unbroken)> {
        warn_of_jump(&self.log, session);
        let started = Instant::now();
        let (mapped, ran) = match choice {
            None => {
                let _sign = spinner("mapping", self.hidden());
                (session.oracle_map()?, Ran { backend: "oracle", ..Ran::default() })
            }
            Some(choice) => {
                let sweeps = session.method.sweeps().len() as u64;
                let bar = bar(session.survey.counts.used * sweeps, out_of_core::MAPPING, self.hidden());
                let mut chosen = choose(choice, session.method.as_ref(), self.log.threads)?;
                let mapped = session.map(chosen.backend.as_mut(), self.log.batch, &|n| bar.inc(n))?;
                (mapped, Ran::of(&chosen))
            }
        };
        seconds.push(("map".into(), started.elapsed().as_secs_f64()));
        let unbroken = interrupt::unbroken();
        let _sign = spinner("writing", self.hidden());
        let report = save(&folder, session, &mapped, &ran, seconds, self.npy)?;
        Ok((folder, report, mapped.counts, ran, unbroken))
    }

    /// Before the long run: is there such a reading?
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
        let (readings, wedges) = session.all()?;
        let before = session.map_first(n - 1, &mut Cpu::new(self.log.threads)?, self.log.batch, &|_| {})?;
        let settings = session.method.settings();
        let (grid, sensors, map) = (&session.grid, session.sensors(), Some(&before.finished.map));
        output::write_working(folder.path(), grid, sensors, &readings, &settings, wedges.as_deref(), n, map)?;
        Ok(())
    }
}

/// What to say where method features found nothing to go by.
const NO_REGIONS: &str = "no walls or corners were found, so that every echo was mapped as method bayes does: features needs circular \
scans (a sonar that turns, with a reading every 2.5° or less), or sonars that pass a wall (4 echoes of one over 0.25 m of travel)";

/// What is done is not lost: the error, and where to go on from.
fn kept(folder: Folder, error: Error) -> Error {
    let place = folder.path().display().to_string();
    folder.keep();
    error.and(&format!("the finished part stays in {place}: --resume goes on from there, --overwrite begins anew"))
}

/// What a map was made on.
#[derive(Debug, Clone, Default)]
pub struct Ran {
    /// oracle, cpu or gpu.
    pub backend: &'static str,
    /// The adapter or processor.
    pub adapter: Option<String>,
    /// Why it was taken; empty where the user chose.
    pub why: String,
}

impl Ran {
    /// On a chosen backend.
    pub fn of(chosen: &Chosen) -> Ran {
        Ran { backend: chosen.backend.name(), adapter: Some(chosen.backend.adapter()), why: chosen.why.clone() }
    }
}

/// Writes a map's files, and returns its report.
pub fn save(
    folder: &Folder,
    session: &Session,
    mapped: &Mapped,
    ran: &Ran,
    seconds: Vec<(String, f64)>,
    npy: bool,
) -> Result<Report> {
    let features = mapped.found.as_ref().map(feature::StageResult::summary);
    let info = RunInfo { features, ..run_info(session, ran, mapped.counts, seconds)? };
    let report = output::write_map(folder, &mapped.finished.map, &mapped.finished.combined, &info, npy)?;
    if let Some(found) = &mapped.found {
        output::write_features(folder.path(), &found.feature_map, &session.grid)?;
    }
    Ok(report)
}

/// What a report says of a run.
fn run_info(session: &Session, ran: &Ran, counts: Counts, seconds: Vec<(String, f64)>) -> Result<RunInfo> {
    Ok(RunInfo {
        parameters: output::parameters(session.parameters()),
        log: LogInfo {
            path: session.log.path().display().to_string(),
            sha256: session.log.sha256()?,
            beams: session.log.beams(),
            notes: session.notes(),
        },
        sensors: session.sensors().to_vec(),
        readings: counts,
        seconds,
        busy: Vec::new(),
        backend: ran.backend.into(),
        adapter: ran.adapter.clone(),
        bad_lines: session.survey.bad_lines.clone(),
        classes: session.classes.as_ref().map_or_else(Vec::new, |c| c.names.clone()),
        features: None,
    })
}
