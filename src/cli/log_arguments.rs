//! The arguments of a log and its mapping, which several commands share.

use super::print_note;
use super::set::{set_help, unknown_key};
use super::suggested_values::{SuggestedValues, methods, settings};
use super::values::{
    KindArgument, check_bounds, parse_length, parse_number, parse_positive, parse_threads, use_threads,
};
use crate::binning::batch::BATCH;
use crate::log;
use crate::method::settings::Settings;
use crate::method::{self, REGISTRY};
use crate::pipeline::session::{Request, Session};
use crate::sensor::{Kind, Overrides};
use crate::{Error, Result};
use clap::{Args, ValueHint};
use std::path::{Path, PathBuf};

/// A log, and the options of its mapping.
#[derive(Debug, Clone, Args)]
pub struct LogArguments {
    /// The log: a file, a sonar_ring_8 folder, or - for standard input; its format is found by content
    #[arg(value_hint = ValueHint::AnyPath)]
    pub log: PathBuf,
    /// The method
    #[arg(short, long, default_value = "bayes", help = method_help(), value_parser = SuggestedValues(methods),
        hide_possible_values = true)]
    pub method: String,
    /// Edge of a cell: metres, or with mm, cm, m
    #[arg(short, long, value_name = "LENGTH", default_value = "0.05", value_parser = parse_length, allow_hyphen_values = true)]
    pub resolution: f64,
    /// Bounds in metres [default: around all that the readings reach]
    #[arg(short, long, value_name = "X0,Y0,X1,Y1", value_delimiter = ',', num_args = 1, value_parser = parse_number, allow_hyphen_values = true)]
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
    #[arg(short, long = "set", value_name = "KEY=VALUE", long_help = set_help(), value_parser = SuggestedValues(settings),
        hide_possible_values = true, value_hint = ValueHint::Other)]
    pub set: Vec<String>,
    /// Map only the first N used readings
    #[arg(long, value_name = "N", value_parser = parse_positive, allow_negative_numbers = true)]
    pub until: Option<u64>,
    /// Take no bad line: exit code 3, and nothing is written
    #[arg(long)]
    pub strict: bool,
    /// Readings at a time; the result does not depend on it
    #[arg(long, value_name = "N", default_value_t = BATCH, hide_short_help = true)]
    pub batch: usize,
    /// Threads of the CPU's kernels and of the host's work; 0: one a core; the result does not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_threads, hide_short_help = true)]
    pub threads: usize,
}

/// The help of `--method`.
fn method_help() -> String {
    let names: Vec<&str> = REGISTRY.iter().map(|e| e.name).collect();
    format!("The method: {}", names.join(", "))
}

impl LogArguments {
    /// The request that they make; limits the threads, and warns of class names without a use.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn request(&self) -> Result<Request> {
        use_threads(self.threads)?;
        let request = self.request_of(&self.method, &self.pairs()?)?;
        if self.classes.is_some() && !matches!(request.settings, Settings::Csm(c) if c.semantic) {
            print_note!("--classes has no effect with {}: it knows no class labels", self.method);
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

    /// The same request for another method with other parameters.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn request_of(&self, name: &str, set: &[(String, String)]) -> Result<Request> {
        method::entry(name)?;
        let mut settings = Settings::of(name).ok_or_else(|| Error::Usage(format!("no method {name}")))?;
        let mut overrides = Overrides::default();
        for (key, value) in set {
            if !overrides.set(key, value)? && !settings.set(key, value)? {
                return Err(Error::Usage(format!("--set {key}={value}: {}", unknown_key(name, &settings, key))));
            }
        }
        let bounds = check_bounds(self.bounds.as_deref(), self.resolution)?;
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

    /// The first option of a log's mapping with another value than its default, if there is one.
    #[cfg(feature = "view")]
    pub fn changed(&self) -> Option<&'static str> {
        let defaults = LogArguments::defaults(&self.log);
        let given = [
            ("--method", self.method != defaults.method),
            ("--resolution", self.resolution != defaults.resolution),
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
            ("--batch", self.batch != defaults.batch),
        ];
        given.iter().find(|(_, given)| *given).map(|(option, _)| *option)
    }

    /// A log with the default of every option.
    pub fn defaults(log: &Path) -> LogArguments {
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
            batch: BATCH,
            threads: 0,
        }
    }
}
