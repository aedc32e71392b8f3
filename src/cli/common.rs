//! Arguments that several commands share, and what they come to.

use super::offered::{Offered, methods, settings};
use super::{interrupt, note, say};
use crate::grid::GridSpec;
use crate::kernels::Choice;
use crate::log;
use crate::log::reading::Counts;
use crate::method::settings::{FreeRule, Likelihood, MassModel, Settings};
use crate::method::{self, REGISTRY};
use crate::pipeline::session::{Request, Session};
use crate::sensor::{Kind, OVERRIDE_KEYS, Overrides, length};
use crate::support::wrapped::wrapped;
use crate::{Error, Result};
use clap::{Args, ValueEnum, ValueHint};
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::path::PathBuf;
use std::time::Duration;

/// Kind of sensor to take from the log.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum KindArgument {
    /// Sonar cones
    Sonar,
    /// Laser beams
    Laser,
}

/// Which backend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BackendArgument {
    /// The best hardware GPU adapter, else the CPU
    Auto,
    /// A GPU adapter; a software one counts
    Gpu,
    /// The CPU: all cores, SIMD
    Cpu,
    /// The f64 reference, one reading at a time
    Oracle,
}

impl BackendArgument {
    /// The kernels' choice; `None` for the oracle.
    pub fn choice(self) -> Option<Choice> {
        match self {
            BackendArgument::Auto => Some(Choice::Auto),
            BackendArgument::Gpu => Some(Choice::Gpu),
            BackendArgument::Cpu => Some(Choice::Cpu),
            BackendArgument::Oracle => None,
        }
    }
}

/// A log and how to map it.
#[derive(Debug, Clone, Args)]
pub struct LogArguments {
    /// The log: a file, a sonar_ring_8 folder, or - for standard input; its format is found by content
    #[arg(value_hint = ValueHint::AnyPath)]
    pub log: PathBuf,
    /// The method
    #[arg(short, long, default_value = "bayes", help = method_help(), value_parser = Offered(methods),
        hide_possible_values = true)]
    pub method: String,
    /// Edge of a cell: metres, or with mm, cm, m
    #[arg(short, long, value_name = "LENGTH", default_value = "0.05", value_parser = metres, allow_hyphen_values = true)]
    pub resolution: f64,
    /// Bounds in metres [default: around all that the readings reach]
    #[arg(short, long, value_name = "X0,Y0,X1,Y1", value_delimiter = ',', num_args = 1, value_parser = number, allow_hyphen_values = true)]
    pub bounds: Option<Vec<f64>>,
    /// Take this kind of sensor from a log that has both
    #[arg(long)]
    pub sensor: Option<KindArgument>,
    /// A TOML file that describes the sensors
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub sensor_file: Option<PathBuf>,
    /// Read the log as a table with these columns, such as t,x,y,heading:deg,range:cm; - skips one, range*180 is a scan
    #[arg(long, value_name = "NAMES", allow_hyphen_values = true)]
    pub columns: Option<String>,
    /// Which variables of a MATLAB or Octave file are what, such as pose=P,ranges=R,angles=A,t=T
    #[arg(long, value_name = "KEY=NAME,…")]
    pub fields: Option<String>,
    /// A file with the robot's poses by time (a ROS topic as CSV, TUM, t x y heading), for a log without them or in place of its own
    #[arg(long, value_name = "FILE")]
    pub poses: Option<PathBuf>,
    /// What the columns of --poses hold, such as t:ms,x,y,heading:deg
    #[arg(long, value_name = "NAMES", allow_hyphen_values = true)]
    pub pose_columns: Option<String>,
    /// A TOML file with the class labels' names and colours, for the semantic methods
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub classes: Option<PathBuf>,
    /// Set a parameter, as often as needed; lengths in metres or with mm, cm, m, angles in radians or with deg
    #[arg(short, long = "set", value_name = "KEY=VALUE", long_help = set_help(), value_parser = Offered(settings),
        hide_possible_values = true, value_hint = ValueHint::Other)]
    pub set: Vec<String>,
    /// Map only the first N used readings
    #[arg(long, value_name = "N", value_parser = from_one, allow_negative_numbers = true)]
    pub until: Option<u64>,
    /// Take no bad line: exit code 3, and nothing is written
    #[arg(long)]
    pub strict: bool,
    /// Readings at a time; the result does not depend on it
    #[arg(long, value_name = "N", default_value_t = crate::binning::batch::BATCH, hide_short_help = true)]
    pub batch: usize,
    /// Threads of the CPU's kernels and of the host's work; 0: one a core; the result does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = threads, hide_short_help = true)]
    pub threads: usize,
}

/// A length on the command line, metres.
pub fn metres(text: &str) -> std::result::Result<f64, String> {
    // Not a number is refused with the other impossible cell sizes.
    text.parse().or_else(|_| length(text).map_err(|what| format!("it {what}")))
}

/// A number on the command line.
pub fn number(text: &str) -> std::result::Result<f64, String> {
    text.parse().map_err(|_| "it is not a number".into())
}

/// The four numbers of `--bounds`, checked, with the resolution, before anything is read.
pub fn bounds(given: Option<&[f64]>, resolution: f64) -> Result<Option<[f64; 4]>> {
    let bounds = match given {
        None => None,
        Some(&[x0, y0, x1, y1]) => Some([x0, y0, x1, y1]),
        Some(other) => {
            let what = format!("--bounds takes x0,y0,x1,y1, four numbers; here are {}", other.len());
            return Err(Error::Usage(what));
        }
    };
    GridSpec::from_bounds(bounds.unwrap_or([0.0, 0.0, 1.0, 1.0]), resolution)?;
    Ok(bounds)
}

/// A count on the command line that can't be 0.
pub fn from_one(text: &str) -> std::result::Result<u64, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "give a whole number from 1".into())
}

/// Threads on the command line: more than a machine has only cost.
pub fn threads(text: &str) -> std::result::Result<usize, String> {
    text.parse().ok().filter(|n| *n <= 1024).ok_or_else(|| "give 0 (one a core) to 1024".into())
}

/// Bounds the host's work, binning say, to so many threads too; 0 leaves one a core. Once a program.
pub fn use_threads(count: usize) -> Result<()> {
    if count == 0 {
        return Ok(());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
    pool.build_global().map_err(|e| Error::Resources(format!("{count} threads can't be started: {e}")))
}

/// Every method.
fn method_help() -> String {
    let names: Vec<&str> = REGISTRY.iter().map(|e| e.name).collect();
    format!("The method: {}", names.join(", "))
}

/// Every key of `--set`.
fn set_help() -> String {
    let keys = |keys: &[crate::sensor::ParameterDoc]| -> String {
        keys.iter().map(|k| format!("\n    {}={} [{}]  {}", k.name, k.values, k.default, k.about)).collect()
    };
    let mut help = String::from("Set a parameter, as often as needed.\n\n  every method:");
    help += &keys(OVERRIDE_KEYS);
    for entry in REGISTRY {
        if let Some(settings) = Settings::of(entry.name)
            && !settings.keys().is_empty()
        {
            help += &format!("\n  {}:{}", entry.name, keys(settings.keys()));
        }
    }
    help
}

/// What to say of a key that the method doesn't have.
fn unknown_key(method: &str, settings: &Settings, key: &str) -> String {
    let has = |name: &&str| Settings::of(name).is_some_and(|s| s.keys().iter().any(|k| k.name == key));
    let others: Vec<&str> = REGISTRY.iter().map(|e| e.name).filter(has).collect();
    let known: Vec<&str> = settings.keys().iter().chain(OVERRIDE_KEYS).map(|k| k.name).collect();
    let hint = match others.is_empty() {
        true => method::nearest(key, &known),
        false => format!(
            ", {} {}; there are {}",
            others.join(" and "),
            if others.len() > 1 { "have" } else { "has" },
            known.join(", ")
        ),
    };
    format!("{method} has no parameter \"{key}\"{hint}")
}

/// Of the parameters that are set, those that change nothing, each with what makes it so.
fn idle(settings: &Settings, set: &[String]) -> Vec<(&'static str, &'static str)> {
    const SCANS: &str = "a counting sensor model: it takes the nearest beam";
    let keys: &[(&'static str, &'static str)] = match settings {
        Settings::Bayes(b) if b.likelihood() == Likelihood::Murphy => {
            &[("p_hit", "model=murphy"), ("p_miss", "model=murphy")]
        }
        Settings::Bayes(_) => &[
            ("max_occ", "model=constant"),
            ("region_one_floor", "model=constant"),
            ("region_two_floor", "model=constant"),
        ],
        Settings::DempsterShafer(d) if d.model == MassModel::Murphy => &[("rho", "model=murphy")],
        Settings::DempsterShafer(_) => &[("max_occ", "model=pagac")],
        Settings::Himm(_) => &[("beta", "method himm: it takes the cells on the axis")],
        Settings::Truth => &[("epsilon", "method truth: a hit is ¾ cell deep")],
        Settings::Csm(c) if c.continuous && c.free == FreeRule::Projection => {
            &[("beta", SCANS), ("step", "free=projection")]
        }
        Settings::Csm(c) if c.continuous && c.free == FreeRule::Clamp => &[("beta", SCANS), ("step", "free=clamp")],
        Settings::Csm(_) => &[("beta", SCANS)],
        Settings::Certainty(_) | Settings::Features(_) => &[],
    };
    let given = |key: &str| set.iter().any(|text| text.split_once('=').is_some_and(|(k, _)| k == key));
    keys.iter().filter(|(key, _)| given(key)).copied().collect()
}

impl LogArguments {
    /// What they ask for.
    pub fn request(&self) -> Result<Request> {
        use_threads(self.threads)?;
        let request = self.request_of(&self.method, &self.pairs()?)?;
        if self.classes.is_some() && !matches!(request.settings, Settings::Csm(c) if c.semantic) {
            note!("--classes has no effect with {}: it knows no class labels", self.method);
        }
        Ok(request)
    }

    /// The keys and values of `--set`.
    pub fn pairs(&self) -> Result<Vec<(String, String)>> {
        let pair = |text: &String| match text.split_once('=') {
            Some((key, value)) => Ok((key.to_string(), value.to_string())),
            None => Err(Error::Usage(format!("--set {text} has no value: write --set key=value"))),
        };
        self.set.iter().map(pair).collect()
    }

    /// The same of another method with other parameters.
    pub fn request_of(&self, name: &str, set: &[(String, String)]) -> Result<Request> {
        method::entry(name)?;
        let mut settings = Settings::of(name).ok_or_else(|| Error::Usage(format!("no method {name}")))?;
        let mut overrides = Overrides::default();
        for (key, value) in set {
            if !overrides.set(key, value)? && !settings.set(key, value)? {
                return Err(Error::Usage(format!("--set {key}={value}: {}", unknown_key(name, &settings, key))));
            }
        }
        let bounds = bounds(self.bounds.as_deref(), self.resolution)?;
        let kind = self.sensor.map(|k| match k {
            KindArgument::Sonar => Kind::Sonar,
            KindArgument::Laser => Kind::Laser,
        });
        Ok(Request {
            log: log::Options {
                kind,
                sensor_file: self.sensor_file.clone(),
                overrides,
                columns: self.columns.clone(),
                fields: self.fields.clone(),
                poses: self.poses.clone(),
                pose_columns: self.pose_columns.clone(),
                classes: self.classes.clone(),
                spool: None,
            },
            settings,
            resolution: self.resolution,
            bounds,
            until: self.until,
            strict: self.strict,
        })
    }

    /// Opens the log.
    pub fn session(&self) -> Result<Session> {
        Session::open(&self.log, &self.request()?)
    }
}

/// A line of a list, with what it is about, broken where a terminal ends.
pub fn item(about: &str, text: &str) {
    say!("{}", wrapped(&format!("{about:<10}{text}"), 10));
}

/// A count of something; its plural is made with an s.
pub fn count(n: u64, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Columns of a terminal that has room for a bar beside its stage's name and the share that is done.
const ROOM: u16 = 36;

/// A progress bar of a stage of so many steps, on a terminal only; it goes away at the end. It tells a share, not the steps: they
/// aren't the same in each stage, since a reading is taken by every chunk that it reaches.
pub fn bar(steps: u64, stage: &'static str, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let (_, columns) = console::Term::stderr().size();
    let template = match columns < ROOM {
        true => "{msg} {percent} %",
        false => "{msg:9} {wide_bar} {percent:>3} %, {eta} left",
    };
    let bar = ProgressBar::new(steps).with_finish(ProgressFinish::AndClear);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.set_message(stage);
    interrupt::shows(&bar);
    bar
}

/// A sign of life where nothing counts how far a run is, on a terminal only; it goes away at the end.
pub fn spinner(stage: &'static str, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner().with_finish(ProgressFinish::AndClear);
    if let Ok(style) = ProgressStyle::with_template("{msg:9} {spinner} {elapsed}") {
        bar.set_style(style);
    }
    bar.set_message(stage);
    interrupt::shows(&bar);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Says once what a user should know of a log: bad lines, with the first few, how it was read, and which parameters change nothing.
pub fn warn_of_log(arguments: &LogArguments, session: &Session) {
    tell_idle(arguments, session);
    note_bad_lines(session, "mend them, or give --strict to write nothing then; the exit code is 6");
    tell_notes(session);
}

/// Says which of the parameters that are set change nothing.
pub fn tell_idle(arguments: &LogArguments, session: &Session) {
    for (key, why) in idle(&session.method.settings(), &arguments.set) {
        note!("--set {key} has no effect with {why}");
    }
}

/// Says how a log was read, where a user should know.
pub fn tell_notes(session: &Session) {
    let path = session.log.path().display();
    for text in session.notes() {
        note!("{path}: {text}");
    }
}

/// The same, with what to do about them.
pub fn note_bad_lines(session: &Session, remedy: &str) {
    let bad = &session.survey.bad_lines;
    let path = session.log.path().display();
    let what = match bad.count {
        0 => return,
        1 => "1 bad line was left out".into(),
        n if n > bad.first.len() as u64 => format!("{n} bad lines were left out; the first"),
        n => format!("{n} bad lines were left out"),
    };
    let quoted: String = bad.first.iter().map(|line| format!("  {line}\n")).collect();
    note!("{path}: {what}:\n{quoted}  ({remedy})");
}

/// Warns of a pose that jumps, where the grid follows it.
pub fn warn_of_jump(arguments: &LogArguments, session: &Session) {
    if let (None, Some((line, what))) = (&arguments.bounds, session.survey.jump()) {
        let path = session.log.path().display();
        note!("{path}:{line}: {what}, and the grid follows it; if that is wrong, mend the line or give --bounds");
    }
}

/// Warns where bounds were given that no reading reaches.
pub fn warn_of_empty_map(counts: &Counts, session: &Session) {
    if counts.outside == counts.used {
        let [x0, y0, x1, y1] = session.survey.covered;
        note!("no reading reaches these --bounds: the log covers {x0:.2},{y0:.2},{x1:.2},{y1:.2}");
    }
}

/// The exit code of a run that did its work.
pub fn done(session: &Session) -> u8 {
    if session.survey.bad_lines.count > 0 { 6 } else { 0 }
}

impl LogArguments {
    /// An option that was given and says how a log is mapped, if there is one. One that says what is so anyhow isn't found.
    pub fn changed(&self) -> Option<&'static str> {
        let plain = LogArguments::plain(&self.log);
        let given = [
            ("--method", self.method != plain.method),
            ("--resolution", self.resolution != plain.resolution),
            ("--bounds", self.bounds.is_some()),
            ("--sensor", self.sensor.is_some()),
            ("--sensor-file", self.sensor_file.is_some()),
            ("--columns", self.columns.is_some()),
            ("--fields", self.fields.is_some()),
            ("--poses", self.poses.is_some()),
            ("--pose-columns", self.pose_columns.is_some()),
            ("--classes", self.classes.is_some()),
            ("--set", !self.set.is_empty()),
            ("--until", self.until.is_some()),
            ("--strict", self.strict),
            ("--batch", self.batch != plain.batch),
        ];
        given.iter().find(|(_, given)| *given).map(|(option, _)| *option)
    }

    /// A log with every default.
    pub fn plain(log: &std::path::Path) -> LogArguments {
        LogArguments {
            log: log.into(),
            method: "bayes".into(),
            resolution: 0.05,
            bounds: None,
            sensor: None,
            sensor_file: None,
            columns: None,
            fields: None,
            poses: None,
            pose_columns: None,
            classes: None,
            set: Vec::new(),
            until: None,
            strict: false,
            batch: crate::binning::batch::BATCH,
            threads: 0,
        }
    }
}
