//! `echogrid demo`: the main job on whatever the machine has, in a world where the truth is known.

use super::map::{BackendUsed, FinishedRun, save};
use super::values::BackendArgument;
use super::{interrupt, print_line};
use crate::binning::batch::BATCH;
use crate::evaluate::score::{Numbers, Options, Score, Truth, open_map, score, write_report};
use crate::kernels::choose;
use crate::log;
use crate::method::{REGISTRY, settings::Settings};
use crate::output::{Folder, Report, Unfinished};
use crate::pipeline::session::{Request, Session};
use crate::sensor::Overrides;
use crate::world::{Shipped, Simulation, World, simulate};
use crate::{Error, Result};
use clap::ValueHint;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The demo's world, its seed and its cells, metres.
const WORLD: &str = "bend";
const SEED: u64 = 1;
const RESOLUTION: f64 = 0.05;
/// The end of a map's name, and its `hit_range`, metres.
const SHORT_RANGE: (&str, f64) = ("-2m", 2.0);

/// The legend of the table, and what its figures show.
const ABOUT: &str = "\
Recall: true walls' cells with an occupied cell on or beside them; precision: the other way round. Danger: of the walls'
cells that a map decides, those that it calls empty. Smooth walls send echoes by way of other walls, too long by metres:
bayes-2m trusts none from beyond 2 m (--set hit_range=2), and is the safer for it.
";

/// Arguments of `demo`.
#[derive(Debug, clap::Args)]
pub struct DemoArguments {
    /// Folder for the world, the log, the maps and the scores
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath, default_value = "echogrid-demo")]
    output: PathBuf,
    /// What computes
    #[arg(long, default_value = "auto")]
    backend: BackendArgument,
}

impl DemoArguments {
    /// Simulates, maps, scores, and prints a table.
    pub fn run(self) -> Result<u8> {
        let started = Instant::now();
        let unwritable = |e: std::io::Error| {
            Error::Resources(format!("{} can't be written: {e}; give another folder with -o", self.output.display()))
        };
        let [file, log] = ["bend.toml", "bend.jsonl"].map(|name| self.output.join(name));
        self.check(&file)?;
        std::fs::create_dir_all(&self.output).map_err(unwritable)?;
        std::fs::write(&file, world_text()).map_err(unwritable)?;
        let world = World::open(&file)?;
        let out = BufWriter::new(File::create(&log).map_err(unwritable)?);
        let (done, _) =
            simulate(&Simulation { world: &world, rig: &world.rig, seed: SEED, scans: None }, out, &|_| {})?;
        print_line!(
            "A sonar turns in a bent corridor: {} readings in {} scans, {:.0} % without an echo.",
            done.readings,
            done.scans,
            100.0 * done.no_echo as f64 / done.readings as f64
        );
        print_line!("");
        print_line!("map                       backend      ms  M updates  accuracy  recall  precision  danger");
        let truth = Truth::of_world(world, None)?;
        let mut why = String::new();
        let mut scores: Vec<Score> = Vec::new();
        for (name, method, hit_range) in maps() {
            let Some(settings) = Settings::of(method) else { continue };
            let overrides = Overrides { hit_range, ..Overrides::default() };
            let (report, used) = self.map(&log, &name, settings, overrides)?;
            let folder = self.output.join(&name);
            scores.push(score(&folder.display().to_string(), &open_map(&folder)?, &truth, &Options::default())?);
            print_row(&name, &report, scores.last().map(|s| &s.numbers));
            let adapter = used.adapter.map(|a| format!(" ({a})")).unwrap_or_default();
            let reason = if used.why.is_empty() { String::new() } else { format!(", because {}", used.why) };
            why = format!("{}{adapter}{reason}", used.backend);
        }
        let page =
            write_report(&self.output.join("score"), &truth.describe(&file.display().to_string()), &scores, &[])?;
        print_line!("");
        print_line!("Computed on the {why}. In {:.1} s.", started.elapsed().as_secs_f64());
        print_line!("{}", ABOUT.trim_end());
        print_line!("");
        print_line!("{}", method_advice(&scores));
        print_line!("");
        print_line!("Look at {}, then map a log of your own: echogrid map LOG -o DIR", page.display());
        Ok(0)
    }

    /// Refuses a folder with files of the demo's names that no demo wrote: `bayes`, say, may be a map of the user's.
    fn check(&self, world: &Path) -> Result<()> {
        let ours = std::fs::read_to_string(world).is_ok_and(|text| text == world_text());
        let names = ["bend.toml", "bend.jsonl", "score"].map(String::from).into_iter().chain(maps().map(|run| run.0));
        if let Some(name) = names.into_iter().find(|name| !ours && self.output.join(name).exists()) {
            return Err(Error::Resources(format!(
                "{} holds {name}, which isn't the demo's: give another folder with -o",
                self.output.display()
            )));
        }
        maps().try_for_each(|run| Folder::check(&self.output.join(run.0)))
    }

    /// Maps the log; the report, and the backend that made the map.
    fn map(&self, log: &Path, name: &str, settings: Settings, overrides: Overrides) -> Result<(Report, BackendUsed)> {
        let request = Request {
            log: log::Options { overrides, ..log::Options::default() },
            settings,
            resolution: RESOLUTION,
            bounds: None,
            until: None,
            strict: true,
        };
        // An unfinished map of a killed demo is discarded: making it anew takes seconds.
        let folder = Folder::open(&self.output.join(name), Unfinished::Discard)?;
        interrupt::register_output(folder.path(), Vec::new(), false);
        let session = Session::open(log, &request)?;
        let started = Instant::now();
        let (mapped, used) = match self.backend.choice() {
            None => (session.oracle_map()?, BackendUsed { backend: "oracle", ..BackendUsed::default() }),
            Some(choice) => {
                let mut chosen = choose(choice, session.method.as_ref(), 0)?;
                (session.map(chosen.backend.as_mut(), BATCH, &|_| {})?, BackendUsed::of(&chosen))
            }
        };
        let seconds = vec![("map".into(), started.elapsed().as_secs_f64())];
        let guard = interrupt::defer_signals();
        let run = FinishedRun { session: &session, mapped: &mapped, backend: &used, seconds, npy: false };
        let report = save(&folder, run)?;
        interrupt::mark_finished(&folder.finish()?, guard);
        Ok((report, used))
    }
}

/// The demo's world.
fn world_text() -> &'static str {
    Shipped::named(Path::new(WORLD)).map_or("", |shipped| shipped.text)
}

/// The maps: the name, the method, and `hit_range`, metres, where it isn't the sensor's.
fn maps() -> impl Iterator<Item = (String, &'static str, Option<f64>)> {
    let methods = REGISTRY.iter().map(|e| e.name).filter(|n| *n != "truth");
    methods.map(|m| (m.to_string(), m, None)).chain([(format!("bayes{}", SHORT_RANGE.0), "bayes", Some(SHORT_RANGE.1))])
}

/// The advice which method to take, with figures of the table.
fn method_advice(scores: &[Score]) -> String {
    let danger = |name: &str| {
        let score = scores.iter().find(|s| Path::new(&s.path).file_name().is_some_and(|f| f == name));
        score.and_then(|s| s.numbers.danger).map_or("-".into(), |v| format!("{v:.3}"))
    };
    format!(
        "Which method? Dense sonar scans, as here: features (danger {}); the default, bayes, has {}, with hit_range=2 {}.\n\
         A sparse ring of sonars: bayes, the default. A laser: bayes, with model=constant, its default there.\n\
         With figures of real logs: {}/blob/main/docs/methods.md",
        danger("features"),
        danger("bayes"),
        danger(&format!("bayes{}", SHORT_RANGE.0)),
        env!("CARGO_PKG_REPOSITORY")
    )
}

/// Prints the table's row of a map.
fn print_row(name: &str, report: &Report, numbers: Option<&Numbers>) {
    let milliseconds = report.seconds.iter().find(|s| s.0 == "map").map_or(0.0, |s| 1e3 * s.1);
    let share = |of: fn(&Numbers) -> Option<f64>| numbers.and_then(of).map_or("-".into(), |v| format!("{v:.3}"));
    print_line!(
        "{name:<26}{:<8}{milliseconds:>7.1}{:>11.2}{:>10}{:>8}{:>11}{:>8}",
        report.backend,
        report.updates as f64 / 1e6,
        share(|n| n.accuracy),
        share(|n| n.recall_tolerant),
        share(|n| n.precision_tolerant),
        share(|n| n.danger)
    );
}
