//! The summary of `map`: the readings used and rejected, the map's cells, the backend, and a hint where another method suits the log
//! better.

use super::print_line;
use super::text::count;
use crate::feature::{Summary, Times};
use crate::log::reading::Counts;
use crate::method;
use crate::method::settings::{Likelihood, Settings};
use crate::output::Report;
use crate::pipeline::session::Session;
use crate::sensor::{Kind, Sensor};
use indicatif::HumanCount;
use std::path::Path;

/// Prints the summary of a map.
pub(super) fn print_summary(session: &Session, counts: &Counts, report: &Report, why: &str, place: &Path) {
    for line in readings(counts, session) {
        print_line!("{line}");
    }
    let c = &report.cells;
    let name = match session.method.settings() {
        Settings::Bayes(b) if b.likelihood() == Likelihood::Constant => "bayes (model constant)".into(),
        _ => report.method.clone(),
    };
    let edge = |first: f64, cells: usize| first + cells as f64 * c.resolution;
    print_line!(
        "{name}: {} × {} cells of {}, x {:.2} to {:.2} m, y {:.2} to {:.2} m",
        c.width,
        c.height,
        length(c.resolution),
        c.x0,
        edge(c.x0, c.width),
        c.y0,
        edge(c.y0, c.height)
    );
    print_line!(
        "{} cells seen: {} occupied, {} empty, {} undecided; {} cell updates",
        HumanCount(c.touched),
        HumanCount(c.occupied),
        HumanCount(c.empty),
        HumanCount(c.touched.saturating_sub(c.occupied + c.empty)),
        HumanCount(report.updates)
    );
    if let Some(found) = &report.features {
        print_features(found);
    }
    let seconds: f64 = report.seconds.iter().map(|s| s.1).sum();
    let why = if why.is_empty() { String::new() } else { format!(", because {why}") };
    let adapter = report.adapter.as_deref().map(|a| format!(" ({a})")).unwrap_or_default();
    print_line!("{}{adapter}{why}; {seconds:.2} s", report.backend);
    if let Some(hint) = hint(session) {
        print_line!("{hint}");
    }
    print_line!("{}", place.join("map.png").display());
}

fn print_features(f: &Summary) {
    let Times { stage, kernels, .. } = f.seconds;
    print_line!(
        "found {}, {} and {}; echoes: {} from one of these, {} mirrored (from behind a wall), {} from behind the line between two, \
         {} from none",
        count(f.walls, "wall"),
        count(f.corners, "corner"),
        count(f.points, "point"),
        HumanCount(f.associated),
        HumanCount(f.outliers),
        HumanCount(f.behind),
        HumanCount(f.routine)
    );
    print_line!("finding them took {stage:.2} s, updating cells {kernels:.2} s, side by side");
}

/// The lines about the log's readings: how many were mapped, and why others were not, with the parameter that changes it.
fn readings(c: &Counts, session: &Session) -> Vec<String> {
    let sensors = session.sensors();
    let mut lines = vec![format!(
        "{} of {} mapped, from {}",
        HumanCount(c.used),
        counted(c.read, "reading"),
        counted(session.survey.scans, "scan")
    )];
    let r = c.rejected;
    let free = sensors.iter().map(|s| s.no_echo_range).fold(0.0, f64::max);
    let silence = match free {
        0.0 => "without echo (they free nothing: no_echo_range is 0)".into(),
        _ => format!("without echo (each frees up to no_echo_range, {})", length(free)),
    };
    let limit = |value: fn(&Sensor) -> f64| shared_value(sensors, value).map_or_else(|| "the sensor's".into(), length);
    let beyond = format!(
        "beyond hit_range ({}): echoes from so far are not trusted; --set hit_range={} takes all",
        limit(|s| s.hit_range),
        session.sensors().iter().map(|s| s.r_max).fold(0.0, f64::max)
    );
    let outside = if session.bounded() { "outside --bounds" } else { "that reach no cell's centre" };
    for (count, what) in [
        (c.no_echo, silence),
        (r.beyond_hit_range, beyond),
        (r.below_r_min, format!("nearer than r_min ({})", limit(|s| s.r_min))),
        (r.not_a_number, "not a number".into()),
        (r.negative, "negative".into()),
        (c.outside, outside.into()),
        (c.empty_arc, "whose echo lies in no cell's centre: they free only".into()),
    ] {
        if count > 0 {
            lines.push(format!("  {} {what}", HumanCount(count)));
        }
    }
    lines
}

/// A large count with its noun, its digits in groups of three.
fn counted(n: u64, what: &str) -> String {
    format!("{} {what}{}", HumanCount(n), if n == 1 { "" } else { "s" })
}

/// A value that all sensors share.
fn shared_value(sensors: &[Sensor], value: fn(&Sensor) -> f64) -> Option<f64> {
    let first = sensors.first().map(value)?;
    sensors.iter().all(|s| value(s) == first).then_some(first)
}

/// A length with its unit: centimetres below a metre.
fn length(metres: f64) -> String {
    let (value, unit) = if metres.abs() < 1.0 { (100.0 * metres, "cm") } else { (metres, "m") };
    let text = format!("{value:.2}");
    format!("{} {unit}", text.trim_end_matches('0').trim_end_matches('.'))
}

/// The fewest readings of a sonar in a scan of a full circle.
const MIN_CIRCLE: u64 = 100;
/// The fewest sonars of a ring.
const MIN_RING: usize = 8;

/// The hint where another method, or another parameter, suits the log better.
fn hint(session: &Session) -> Option<String> {
    let (sensors, settings) = (session.sensors(), session.method.settings());
    let name = method::name(session.method.as_ref());
    let general = matches!(
        settings,
        Settings::Certainty(_) | Settings::DempsterShafer(_) | Settings::Bayes(_) | Settings::Himm(_)
    );
    if !general {
        return None;
    }
    if sensors.iter().all(|s| s.kind == Kind::Laser) {
        return match settings {
            Settings::Bayes(b) if b.likelihood() == Likelihood::Constant => None,
            Settings::Bayes(_) => {
                Some("hint: these are laser readings; --set model=constant, their default, keeps walls that murphy thins out".into())
            }
            _ => Some(format!("hint: these are laser readings, and {name} is made for sonars; --method bayes or csm-continuous fits")),
        };
    }
    if sensors.iter().any(|s| s.kind == Kind::Laser) {
        return Some(
            "hint: this log holds sonars and lasers; --sensor laser, or --sensor sonar, maps one kind by what fits it"
                .into(),
        );
    }
    let a_scan = session.survey.counts.read / session.survey.scans.max(1);
    if a_scan >= MIN_CIRCLE * sensors.len() as u64 {
        return Some(
            "hint: these are circular scans; --method features finds the walls first, and far fewer of them are shown as empty (README, Which method?)"
                .into(),
        );
    }
    // On real rings features is the more accurate, and bayes shows fewer walls as empty: docs/features.md.
    let ring = "hint: this is a ring of sonars; --method features finds the walls first, and is more accurate on most rings (docs/features.md)";
    (sensors.len() >= MIN_RING).then(|| ring.into())
}
