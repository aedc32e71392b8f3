//! Opening a session: the checks of the request, the log and the grid that come before the long run.

use super::{Request, Session};
use crate::binning::update;
use crate::grid::GridSpec;
use crate::log::{self, Log};
use crate::method::{self, LogFacts, Method, RequiredSensor, Unit};
use crate::pipeline::survey::{Survey, SurveyOptions, survey};
use crate::sensor::Kind;
use crate::{Error, Result};
use std::path::Path;

impl Session {
    /// Opens a log and surveys it in one pass.
    ///
    /// # Errors
    /// The log's and the parameters' errors; [`Error::Input`] for a log without a usable reading, and for the first bad
    /// line where the request is strict.
    pub fn open(path: &Path, request: &Request) -> Result<Session> {
        let (mut options, resolution) = (request.log.clone(), request.resolution);
        let method = method::make(request.settings);
        if let Some(required) = method.required_sensor() {
            options.kind = Some(required_kind(required, method.as_ref(), options.kind)?);
        }
        let log = Log::open(path, &options).map_err(|e| explain_open(path, request, method.as_ref(), e))?;
        let mut sensors = log.header().sensors.clone();
        sensors.iter_mut().for_each(|sensor| method.limit_sensor(sensor, &options.overrides));
        if method.unit() == Unit::Update {
            update::check(&sensors, resolution)?;
        }
        // Given bounds are checked before the log is read through.
        let given = request.bounds.map(|b| GridSpec::from_bounds(b, resolution)).transpose()?;
        let until = request.until.unwrap_or(u64::MAX);
        let r_max_set = options.overrides.r_max.is_some();
        let survey = survey(&log, &sensors, &SurveyOptions { resolution, until, r_max_set, spread: method.spread() })?;
        if request.strict {
            refuse_bad_lines(path, &survey)?;
        }
        if survey.counts.used == 0 {
            return Err(Error::input(path, nothing_to_map(&survey)));
        }
        let grid = match given {
            Some(grid) => grid,
            None => GridSpec::around(survey.covered, resolution).map_err(|e| survey.explain(e, path))?,
        };
        let completed = method.complete(&LogFacts {
            path: log.path(),
            sensors: &sensors,
            class_names: &log.header().classes,
            class_file: request.log.classes.as_deref(),
            hits: survey.hits,
            labelled: survey.labelled,
            grid: &grid,
        })?;
        let (method, classes) = (method::make(completed.settings), completed.classes);
        Ok(Session { log, sensors, method, grid, survey, classes, until, bounded: given.is_some() })
    }
}

/// The kind of sensor that a method maps.
///
/// # Errors
/// [`Error::Usage`] where the user wants the other kind.
fn required_kind(required: RequiredSensor, method: &dyn Method, wanted: Option<Kind>) -> Result<Kind> {
    match wanted {
        Some(kind) if kind != required.kind => Err(Error::Usage(format!(
            "method {} {}: leave out `sensor {}`",
            method::name(method),
            required.reason,
            word(kind)
        ))),
        _ => Ok(required.kind),
    }
}

/// A kind of sensor as `--sensor` takes it.
fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Sonar => "sonar",
        Kind::Laser => "laser",
    }
}

/// The error of a log that can't be opened, or, where the log has only sensors of the kind that the method itself excludes, that.
fn explain_open(path: &Path, request: &Request, method: &dyn Method, error: Error) -> Error {
    let Some(RequiredSensor { kind, instead: Some(instead), .. }) = method.required_sensor() else { return error };
    let other = if kind == Kind::Sonar { Kind::Laser } else { Kind::Sonar };
    let excluded = log::Options { kind: Some(other), ..request.log.clone() };
    match request.log.kind.is_none() && Log::open(path, &excluded).is_ok() {
        true => {
            let (other, name) = (word(other), method::name(method));
            Error::input(path, format!("it holds {other} readings alone, and method {name} {instead}"))
        }
        false => error,
    }
}

/// An error for the first bad line of a log, if it has one.
fn refuse_bad_lines(path: &Path, survey: &Survey) -> Result<()> {
    let Some(first) = survey.bad_lines.first.first() else { return Ok(()) };
    let more = match survey.bad_lines.count - 1 {
        0 => String::new(),
        more => format!(", the first of {} bad lines", more + 1),
    };
    Err(Error::input(path, format!("{first}{more}; mend it, or leave out `strict`")))
}

/// The message about a log none of whose readings can be mapped.
fn nothing_to_map(survey: &Survey) -> String {
    let Survey { counts, bad_lines: bad, ignored, .. } = survey;
    let r = counts.rejected;
    let reasons = [
        (counts.no_echo, "without echo (no_echo_range is 0)"),
        (r.below_r_min, "nearer than r_min"),
        (r.beyond_hit_range, "beyond hit_range"),
        (r.negative, "negative"),
        (r.not_a_number, "not a number"),
    ];
    let reasons: Vec<String> = reasons.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
    let mut text = match counts.read {
        0 if *ignored > 0 => format!("holds no reading, but {ignored} lines (or scans) without one"),
        0 => "holds no reading".into(),
        read => format!(
            "none of its {read} readings can be mapped: {}; check `sensor` and the sensors' ranges (`r_min=…`, \
             hit_range=…, no_echo_range=…)",
            reasons.join(", ")
        ),
    };
    for note in &survey.notes {
        text += &format!("; {note}");
    }
    if let Some(first) = bad.first.first() {
        text += &format!("; {} bad lines, the first: {first}", bad.count);
    }
    text
}
