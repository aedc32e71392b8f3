//! The session and its state, as the page is told.

use super::current::current;
use super::lane::Lane;
use super::shown::{DIFFERENCE, View, blocks, views};
use super::{Lanes, Options};
use crate::method::REGISTRY;
use crate::method::settings::Settings;
use crate::sensor::{Kind, OVERRIDE_KEYS, ParameterDoc};
use crate::view::legend::legend;
use crate::view::tile::levels;
use serde_json::{Map, Value, json};

/// The whole session.
pub fn session(options: &Options, lanes: &Lanes) -> Value {
    let first = &lanes.all[0].stepper;
    let grid = first.grid();
    let methods = REGISTRY.iter().filter_map(|entry| {
        let settings = Settings::of(entry.name)?;
        let keys: Vec<Value> = settings.keys().iter().map(key).collect();
        Some(json!({"name": entry.name, "about": entry.about, "source": entry.source, "keys": keys}))
    });
    let sensors = first.sensors().iter().map(|s| {
        json!({
            "id": s.id,
            "kind": if s.kind == Kind::Sonar { "sonar" } else { "laser" },
            "half_width": s.half_width,
            "r_min": s.r_min,
            "r_max": s.r_max,
            "hit_range": s.hit_range,
            "no_echo_range": s.no_echo_range,
            "epsilon": s.epsilon(grid.resolution),
        })
    });
    let name = options.path.file_name().unwrap_or(options.path.as_os_str());
    json!({
        "mode": "log",
        "name": name.to_string_lossy(),
        "version": env!("CARGO_PKG_VERSION"),
        "grid": {
            "x0": grid.x0(), "y0": grid.y0(), "resolution": grid.resolution, "width": grid.width, "height": grid.height,
        },
        "levels": levels([grid.width, grid.height]),
        "sources": lanes.all.iter().map(source).collect::<Vec<_>>(),
        "methods": methods.collect::<Vec<_>>(),
        "sensor_keys": OVERRIDE_KEYS.iter().map(key).collect::<Vec<_>>(),
        "sensors": sensors.collect::<Vec<_>>(),
        "difference": if lanes.all.len() > 1 { view(&DIFFERENCE, &[]) } else { Value::Null },
        "generation": lanes.generation,
        "report": {"readings": first.session().survey.counts, "bad_lines": first.session().survey.bad_lines},
        "state": state(lanes, first.position(), false),
    })
}

fn key(key: &ParameterDoc) -> Value {
    json!({"name": key.name, "values": key.values, "default": key.default, "about": key.about})
}

fn source(lane: &Lane) -> Value {
    let session = lane.stepper.session();
    let classes = session.classes.as_ref().map_or(&[][..], |c| &c.names);
    let parameters: Map<String, Value> =
        session.parameters().into_iter().map(|(key, value)| (key, json!(value))).collect();
    json!({
        "name": lane.name(),
        "method": lane.name(),
        "set": lane.wanted.set,
        "parameters": parameters,
        "views": views(lane.stepper.method()).iter().map(|v| view(v, classes)).collect::<Vec<_>>(),
    })
}

fn view(view: &View, classes: &[String]) -> Value {
    let group = if view.main { "main" } else { "layer" };
    json!({"name": view.name, "about": view.about, "group": group, "legend": legend(view.scale, classes)})
}

/// Where the lanes are, and which of their tiles changed on the way to a position of the first; all may have where a page `missed`
/// something.
pub fn state(lanes: &Lanes, to: usize, missed: bool) -> Value {
    let first = &lanes.all[0].stepper;
    let lane = |lane: &Lane| {
        json!({
            "position": lane.stepper.position(),
            "total": lane.stepper.items().len(),
            "changed": if missed { json!("all") } else { json!(blocks(&lane.changed)) },
            "current": current(lane),
        })
    };
    json!({
        "version": lanes.version,
        "generation": lanes.generation,
        "position": first.position(),
        "total": first.items().len(),
        "scan": first.scans(first.position()),
        "scans": first.scans(first.items().len()),
        "done": first.position() == to,
        "target": to,
        "lanes": lanes.all.iter().map(lane).collect::<Vec<_>>(),
    })
}
