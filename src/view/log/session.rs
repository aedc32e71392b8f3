//! The session of a log and the position in it, as the page is told.

use super::current_item::{current_item, sensor_kind};
use super::lane::Lane;
use super::views::{DIFFERENCE, LaneView, level0_tiles, views};
use super::{Lanes, Options};
use crate::method::REGISTRY;
use crate::method::settings::Settings;
use crate::sensor::{OVERRIDE_KEYS, ParameterDoc};
use crate::view::legend::legend;
use crate::view::protocol::{
    AllTiles, BadLines, ChangedTiles, Grid, Json, LaneState, LogReport, LogSession, LogSource, MethodInfo,
    ParameterInfo, SensorInfo, Session, Stamp, State, ViewGroup, ViewInfo, finite,
};
use crate::view::tile::levels;
use crate::{Error, Result};

/// The whole session.
///
/// # Errors
/// [`Error::Resources`] where a count can't be represented in JSON.
pub fn session(options: &Options, lanes: &Lanes) -> Result<Session> {
    let first = &lanes.all[0].stepper;
    let grid = first.grid();
    let methods = REGISTRY.iter().filter_map(|entry| {
        let settings = Settings::of(entry.name)?;
        let keys = settings.keys().iter().map(parameter_info).collect();
        Some(MethodInfo { name: entry.name, about: entry.about, source: entry.source, keys })
    });
    let sensors = first.sensors().iter().map(|s| SensorInfo {
        id: s.id.clone(),
        kind: sensor_kind(s.kind),
        half_width: finite(s.half_width),
        r_min: finite(s.r_min),
        r_max: finite(s.r_max),
        hit_range: finite(s.hit_range),
        no_echo_range: finite(s.no_echo_range),
        epsilon: finite(s.epsilon(grid.resolution)),
    });
    let survey = &first.session().survey;
    let readings = serde_json::to_value(survey.counts)
        .map_err(|e| Error::Resources(format!("the counts of readings can't be written as JSON: {e}")))?;
    let name = options.path.file_name().unwrap_or(options.path.as_os_str());
    Ok(Session::Log(Box::new(LogSession {
        name: name.to_string_lossy().into_owned(),
        version: env!("CARGO_PKG_VERSION").into(),
        grid: Grid {
            x0: grid.x0(),
            y0: grid.y0(),
            resolution: grid.resolution,
            width: grid.width,
            height: grid.height,
        },
        levels: levels([grid.width, grid.height]),
        sources: lanes.all.iter().map(source).collect(),
        methods: methods.collect(),
        sensor_keys: OVERRIDE_KEYS.iter().map(parameter_info).collect(),
        sensors: sensors.collect(),
        difference: (lanes.all.len() > 1).then(|| view_info(&DIFFERENCE, &[])),
        generation: lanes.generation,
        report: LogReport {
            readings: Json(readings),
            bad_lines: BadLines { count: survey.bad_lines.count, first: survey.bad_lines.first.clone() },
        },
        state: state(lanes, first.position(), false),
    })))
}

fn parameter_info(key: &ParameterDoc) -> ParameterInfo {
    ParameterInfo { name: key.name, values: key.values, default: key.default, about: key.about }
}

fn source(lane: &Lane) -> LogSource {
    let session = lane.stepper.session();
    let classes = session.classes.as_ref().map_or(&[][..], |c| &c.names);
    LogSource {
        name: lane.name().into(),
        method: lane.name().into(),
        set: lane.spec.set.clone(),
        parameters: session.parameters().into_iter().collect(),
        views: views(lane.stepper.method()).iter().map(|v| view_info(v, classes)).collect(),
    }
}

fn view_info(view: &LaneView, classes: &[String]) -> ViewInfo {
    let group = if view.main { ViewGroup::Main } else { ViewGroup::Layer };
    ViewInfo { name: view.name.into(), about: view.about.into(), group, legend: legend(view.scale, classes) }
}

/// The lanes' positions, and the tiles that changed on the way to a position of the first. Where the page `missed` a state all may have
/// changed.
pub fn state(lanes: &Lanes, target: usize, missed: bool) -> State {
    let first = &lanes.all[0].stepper;
    let lane = |lane: &Lane| LaneState {
        position: lane.stepper.position(),
        total: lane.stepper.items().len(),
        changed: match missed {
            true => ChangedTiles::All(AllTiles::All),
            false => ChangedTiles::Some(level0_tiles(&lane.changed)),
        },
        current: current_item(lane),
    };
    State {
        stamp: Stamp { version: lanes.version, generation: lanes.generation },
        position: first.position(),
        total: first.items().len(),
        scan: first.scans(first.position()),
        scans: first.scans(first.items().len()),
        done: first.position() == target,
        target,
        lanes: lanes.all.iter().map(lane).collect(),
    }
}
