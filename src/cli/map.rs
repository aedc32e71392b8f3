//! `echogrid map`.

use super::common::{BackendArgument, LogArguments, done, parameters, progress, readings, warn_of_bad_lines};
use super::say;
use crate::kernels::choose;
use crate::output::{self, Folder, LogInfo, Report, RunInfo};
use crate::session::{Mapped, Session};
use crate::{Result, memory};
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `map`.
#[derive(Debug, clap::Args)]
pub struct Map {
    #[command(flatten)]
    log: LogArguments,
    /// Folder of the map; an echogrid map there is replaced when the new one is complete
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// What computes
    #[arg(long, default_value = "auto")]
    backend: BackendArgument,
    /// Memory that may be used, such as 4GiB [default: what the machine has free]
    #[arg(long, value_parser = memory::parse)]
    memory: Option<u64>,
    /// Also write a picture and JSON of used reading N alone
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
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
        let folder = Folder::prepare(&self.output)?;
        let started = Instant::now();
        let session = Session::open(&self.log.log, &request)?;
        let surveyed = started.elapsed().as_secs_f64();
        warn_of_bad_lines(&session);
        let need = memory::needed(&session.grid, session.method.as_ref(), self.log.batch);
        memory::check(need, self.memory, &session.grid).map_err(|e| session.survey.explain(e, &self.log.log))?;

        let started = Instant::now();
        let bar = progress(&session, self.quiet || self.json);
        let (mapped, backend, adapter, why) = match self.backend.choice() {
            None => (session.oracle_map()?, "oracle", None, String::new()),
            Some(choice) => {
                let mut chosen = choose(choice, session.method.as_ref(), self.log.threads)?;
                let mapped = session.map(chosen.backend.as_mut(), self.log.batch, &|n| bar.inc(n))?;
                (mapped, chosen.backend.name(), Some(chosen.backend.adapter()), chosen.why)
            }
        };
        bar.finish_and_clear();
        let seconds = vec![("survey".to_string(), surveyed), ("map".to_string(), started.elapsed().as_secs_f64())];
        let info = RunInfo {
            parameters: output::parameters(parameters(&session)),
            log: LogInfo { path: self.log.log.display().to_string(), sha256: session.log.sha256()? },
            readings: mapped.counts,
            seconds,
            backend: backend.into(),
            adapter,
            bad_lines: session.survey.bad_lines.clone(),
            increments: None,
        };
        let finished = &mapped.finished;
        let report = output::write_map(&folder, &finished.map, &finished.combined, &info, self.npy)?;
        if let Some(n) = self.working {
            self.write_working(&folder, &session, &mapped, n)?;
        }
        let place = folder.finish()?;
        if self.json {
            say!("{}", serde_json::to_string_pretty(&report).unwrap_or_default());
        } else if !self.quiet {
            summary(&session, &mapped, &report, &why, &place);
        }
        Ok(done(&session))
    }

    fn write_working(&self, folder: &Folder, session: &Session, mapped: &Mapped, n: u64) -> Result<()> {
        let _ = (folder, session, mapped, n);
        Ok(())
    }
}

fn summary(session: &Session, mapped: &Mapped, report: &Report, why: &str, place: &std::path::Path) {
    let c = &report.cells;
    let seconds: f64 = report.seconds.iter().map(|s| s.1).sum();
    say!("{}", readings(mapped, session));
    say!(
        "{}: {} × {} cells of {} m from ({:.2}, {:.2}) m; {} touched, {} occupied, {} empty; {} cell updates",
        report.method,
        c.width,
        c.height,
        c.resolution,
        c.x0,
        c.y0,
        c.touched,
        c.occupied,
        c.empty,
        report.updates
    );
    let why = if why.is_empty() { String::new() } else { format!(", because {why}") };
    let adapter = report.adapter.as_deref().map(|a| format!(" ({a})")).unwrap_or_default();
    say!("{}{adapter}{why}; {seconds:.2} s", report.backend);
    say!("{}", place.join("map.png").display());
}
