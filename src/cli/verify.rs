//! `echogrid verify`.

use super::exit::{DIFFERS, done};
use super::log_arguments::LogArguments;
use super::progress::{bar, spinner};
use super::warnings::{warn_of_jump, warn_of_log};
use super::{print_line, print_note};
use crate::evaluate::compare::{Options, compare, write_pictures};
use crate::evaluate::verify::{BackendRun, Verification, check_backend, same_bytes};
use crate::kernels::{Choice, Chosen, choose, gpu_required};
use crate::method;
use crate::oracle::OracleMap;
use crate::pipeline::finished::FinishedMap;
use crate::pipeline::layers;
use crate::pipeline::session::Session;
use crate::support::memory;
use crate::{Error, Result};
use clap::ValueHint;
use std::path::PathBuf;
use std::time::Instant;

/// A backend that `verify` can run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum VerifyBackend {
    /// The f64 reference; always run
    Oracle,
    /// The CPU's kernels
    Cpu,
    /// The GPU's kernels, on the best adapter; a software one counts
    Gpu,
}

/// Arguments of `verify`.
#[derive(Debug, clap::Args)]
pub struct VerifyArguments {
    #[command(flatten)]
    log: LogArguments,
    /// The backends to compare with the oracle
    #[arg(long, value_delimiter = ',', default_value = "oracle,cpu,gpu")]
    backends: Vec<VerifyBackend>,
    /// If a backend is not equal, write its pictures, the oracle's and their difference here
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pictures: Option<PathBuf>,
    /// Memory that may be used, such as 4GiB [default: what the machine has free]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse_size)]
    memory: Option<u64>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing but warnings and errors
    #[arg(short, long)]
    quiet: bool,
}

/// The backends to compare with the oracle.
#[derive(Default)]
struct OpenedBackends {
    backends: Vec<Chosen>,
    /// Backends that were asked for and can't run, and why.
    skipped: Vec<String>,
    /// Backends that the method can't run on, and why.
    absent: Vec<String>,
}

/// Why backends are missing, and the option that compares the others.
fn without(missing: &[String]) -> String {
    format!("{}; `--backends oracle,cpu` compares without it", missing.join("; "))
}

impl VerifyArguments {
    /// Compares the backends; exit code 1 if one is not equal.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] where a backend that was asked for couldn't run.
    pub fn run(self) -> Result<u8> {
        let progress = spinner("reading", self.quiet || self.json);
        let session = self.log.session()?;
        drop(progress);
        warn_of_log(&self.log, &session);
        // The oracle keeps values and bounds in f64, and two maps are held beside it.
        let oracle_cells = session.grid.cells() as u64 * 16 * (session.method.layers().len() as u64 + 2);
        let readings = session.survey.counts.used * 200;
        session.check_memory(2 * session.memory(self.log.batch) + oracle_cells + readings, self.memory)?;
        warn_of_jump(&self.log, &session);
        let OpenedBackends { backends, skipped, absent } = self.open(&session)?;
        let started = Instant::now();
        let hidden = self.quiet || self.json;
        let progress = spinner("reference", hidden);
        let oracle = session.oracle()?;
        drop(progress);
        let mut result = Verification {
            method: method::name(session.method.as_ref()).into(),
            readings: session.survey.counts.used,
            size: [session.grid.width, session.grid.height],
            updates: oracle.updates,
            oracle_seconds: started.elapsed().as_secs_f64(),
            backends: Vec::new(),
            same_bytes: None,
            skipped,
            absent,
            passed: true,
        };
        let mut maps: Vec<FinishedMap> = Vec::new();
        for mut chosen in backends {
            let started = Instant::now();
            let readings = session.survey.counts.used * session.method.sweeps().len() as u64;
            let bar = bar(readings, chosen.backend.name(), hidden);
            let mapped = session.map(chosen.backend.as_mut(), self.log.batch, &|n| bar.inc(n))?;
            drop(bar);
            let seconds = started.elapsed().as_secs_f64();
            let counts = &mapped.counts;
            let wrong =
                [(counts.outside, oracle.outside), (counts.empty_arc, oracle.empty_arc), (counts.wide, oracle.wide)]
                    .iter()
                    .map(|(a, b)| a.abs_diff(*b))
                    .sum();
            let run = BackendRun {
                name: chosen.backend.name(),
                adapter: chosen.backend.adapter(),
                finished: &mapped.finished,
                wrong_counts: wrong,
                seconds,
            };
            let progress = spinner("comparing", hidden);
            result.backends.push(check_backend(&session, &oracle, run)?);
            drop(progress);
            self.draw(&session, &oracle, &result, &mapped.finished)?;
            maps.push(mapped.finished);
        }
        result.passed = !result.differs() && result.skipped.is_empty();
        if let [a, b] = &maps[..] {
            result.same_bytes = Some(same_bytes(a, b));
        }
        if self.json {
            print_line!("{}", serde_json::to_string_pretty(&result).unwrap_or_default());
        } else if !self.quiet {
            print_line!("{result}");
        }
        if hidden {
            result.absent.iter().for_each(|why| print_note!("{why}"));
        }
        if self.quiet {
            for b in result.backends.iter().filter(|b| !b.passed) {
                print_note!("{} and the oracle are NOT EQUAL", b.backend);
            }
        }
        match result.skipped.as_slice() {
            _ if result.differs() => Ok(DIFFERS),
            [] => Ok(done(&session)),
            skipped => Err(Error::NoAdapter(format!("not verified: {}", without(skipped)))),
        }
    }

    /// Opens the backends to compare, before the long run.
    fn open(&self, session: &Session) -> Result<OpenedBackends> {
        let mut opened = OpenedBackends::default();
        for (kind, choice) in [(VerifyBackend::Cpu, Choice::Cpu), (VerifyBackend::Gpu, Choice::Gpu)] {
            if !self.backends.contains(&kind) {
                continue;
            }
            match (choose(choice, session.method.as_ref(), self.log.threads), session.method.cpu_only()) {
                (Ok(chosen), _) => opened.backends.push(chosen),
                // The method runs on no adapter: none is missing.
                (Err(Error::NoAdapter(_)), Some(why)) => {
                    opened
                        .absent
                        .push(format!("gpu: there is none for this method: {why}; oracle and cpu are all there is"));
                }
                (Err(Error::NoAdapter(why)), None) if !gpu_required() => opened.skipped.push(format!("gpu: {why}")),
                (Err(e), _) => return Err(e),
            }
        }
        if !opened.backends.is_empty() {
            return Ok(opened);
        }
        let missing = [opened.skipped, opened.absent].concat();
        Err(match missing.is_empty() {
            true => Error::Usage("the oracle alone proves nothing: give --backends cpu, gpu or both".into()),
            false => Error::NoAdapter(format!("there is nothing to verify: {}", without(&missing))),
        })
    }

    /// Writes pictures of the last backend, if it is not equal and they were asked for.
    fn draw(&self, session: &Session, oracle: &OracleMap, result: &Verification, map: &FinishedMap) -> Result<()> {
        let (Some(folder), Some(last)) = (&self.pictures, result.backends.last().filter(|b| !b.passed)) else {
            return Ok(());
        };
        let reference = layers::from_oracle(oracle, session.method.as_ref());
        let differences = compare(&reference.map, &map.map, &Options::default())?;
        for path in write_pictures(&reference.map, &map.map, &differences, &folder.join(&last.backend))? {
            print_note!("see {}", path.display());
        }
        Ok(())
    }
}
