//! What is told of a log being stepped through.

use crate::common::Place;
use crate::pictures::{ask, decode, json, level, tile};
use echogrid::method::settings::Settings;
use echogrid::pipeline::session;
use echogrid::sensor::Overrides;
use echogrid::view::log::{LogView, Options};
use echogrid::view::protocol::LaneSpec;
use echogrid::view::{Request, Response, View};
use echogrid::{Error, Result, method};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A bent corridor, heard by eight sonars.
fn corridor(place: &Place) -> PathBuf {
    let world = format!("{}/worlds/bend.toml", env!("CARGO_MANIFEST_DIR"));
    place.does(&["simulate", &world, "--rig", "ring8", "--scans", "60", "--quiet", "-o", "bend.jsonl"]);
    place.path("bend.jsonl")
}

fn wanted(method: &str, set: &[(&str, &str)]) -> LaneSpec {
    let set = set.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect();
    LaneSpec { method: method.into(), set }
}

/// What the command makes of a lane, in brief.
fn ready(lane: &LaneSpec) -> Result<session::Request> {
    method::entry(&lane.method)?;
    let (mut settings, mut overrides) = (Settings::of(&lane.method).unwrap(), Overrides::default());
    for (key, value) in &lane.set {
        if !overrides.set(key, value)? && !settings.set(key, value)? {
            return Err(Error::Usage(format!("no parameter {key}")));
        }
    }
    let log = echogrid::log::Options { overrides, ..Default::default() };
    Ok(session::Request { log, settings, resolution: 0.05, bounds: None, until: None, strict: false })
}

fn open(log: &Path, lanes: &[LaneSpec]) -> LogView {
    let options = Options { path: log.into(), request: Box::new(ready), threads: 0, memory: None };
    LogView::open(options, lanes).unwrap()
}

fn post(view: &LogView, path: &str, query: &str, body: &[u8]) -> Result<Response> {
    let pairs = query.split('&').filter_map(|p| p.split_once('=')).map(|(k, v)| (k.to_string(), v.to_string()));
    let query: BTreeMap<String, String> = pairs.collect();
    view.respond(&Request { post: true, path, query: &query, body })
}

#[track_caller]
fn told(answer: Result<Response>) -> Value {
    match answer {
        Ok(Response::Json(value)) => value,
        other => panic!("{other:?}"),
    }
}

#[track_caller]
fn go(view: &LogView, body: Value) -> Value {
    told(post(view, "api/go", "", body.to_string().as_bytes()))
}

#[track_caller]
fn refused(answer: Result<Response>, says: &str) {
    match answer {
        Err(Error::Usage(what)) => assert!(what.contains(says), "{what}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn at_the_end_each_view_is_the_picture_that_map_writes() {
    let place = Place::new();
    let log = corridor(&place);
    for name in ["certainty", "dempster-shafer", "bayes", "himm", "csm-continuous", "features"] {
        place.does(&["map", "bend.jsonl", "-m", name, "-o", name, "--backend", "cpu", "--quiet"]);
        let view = open(&log, &[wanted(name, &[])]);
        let total = json(&view, "api/session", "")["state"]["total"].as_u64().unwrap();
        assert_eq!(go(&view, json!({"to": total}))["position"], total);
        let session = json(&view, "api/session", "");
        let mut compared = 0;
        for shown in session["sources"][0]["views"].as_array().unwrap() {
            let shown = shown["name"].as_str().unwrap();
            let file = match (name, shown) {
                (_, "combined") => "map",
                ("certainty", "empty") => "emp",
                ("certainty", "full") => "occ",
                ("bayes" | "features", "empty") => "p_emp",
                ("bayes" | "features", "full") => "p_occ",
                ("dempster-shafer", _) => shown,
                _ if place.path(name).join(format!("{shown}.png")).exists() && shown != "map" => shown,
                _ => continue,
            };
            let path = place.path(name).join(format!("{file}.png"));
            let Ok(bytes) = std::fs::read(path) else { continue };
            let wanted = decode(&bytes);
            let (extent, entries) = level(&view, "0", shown, 0);
            assert_eq!(extent, wanted.extent, "{name} {shown}");
            for (k, entry) in entries.iter().enumerate() {
                let (column, row) = (k % extent[0], k / extent[0]);
                assert_eq!(*entry, wanted.at(column, row), "{name} {shown} at {column}, {row}");
            }
            compared += 1;
        }
        assert!(compared >= 2, "{name}: {compared}");
    }
}

#[test]
fn a_step_says_where_it_is_and_what_changed() {
    let place = Place::new();
    let view = open(&corridor(&place), &[wanted("certainty", &[])]);
    let start = json(&view, "api/session", "");
    let (total, scans) = (start["state"]["total"].as_u64().unwrap(), start["state"]["scans"].as_u64().unwrap());
    assert!(total > 60 && scans == 60, "{total} {scans}");
    assert_eq!(start["state"]["lanes"][0]["current"], Value::Null);
    assert_eq!(json(&view, "api/working", "lane=0")["column"], json!([]));
    let one = go(&view, json!({"by": "reading"}));
    assert_eq!((&one["position"], &one["scan"], &one["done"]), (&json!(1), &json!(1), &json!(true)));
    let current = &one["lanes"][0]["current"];
    assert_eq!((&current["kind"], &current["number"], &current["scan"]), (&json!("reading"), &json!(1), &json!(0)));
    assert!(current["outline"]["lines"].as_array().unwrap().len() >= 3, "{current}");
    assert!(!one["lanes"][0]["changed"].as_array().unwrap().is_empty());
    let working = json(&view, "api/working", "lane=0");
    let cells = working["column"].as_array().unwrap().len();
    assert_eq!(working["interior"].as_u64().unwrap() + working["arc"].as_u64().unwrap(), cells as u64);
    assert_eq!(working["steps"], json!(["own", "cancelled", "normalised"]));
    for key in ["row", "region", "d", "theta", "own", "cancelled", "normalised", "strength"] {
        assert_eq!(working[key].as_array().unwrap().len(), cells, "{key}");
    }
    let sum: f64 = working["normalised"]
        .as_array()
        .unwrap()
        .iter()
        .zip(working["region"].as_array().unwrap())
        .filter(|(_, region)| **region == 1)
        .map(|(v, _)| v.as_f64().unwrap())
        .sum();
    assert!((sum - 1.0).abs() < 1e-9 || working["arc"] == 0, "{sum}");
    // by scans: to their end, back to their beginning
    let scan = go(&view, json!({"by": "scan"}))["position"].as_u64().unwrap();
    assert_eq!(go(&view, json!({"by": "scan"}))["scan"], 2);
    assert_eq!(go(&view, json!({"by": "scan", "count": -1}))["position"], scan);
    assert_eq!(go(&view, json!({"by": "scan", "count": 10}))["scan"], 11);
    let rest = go(&view, json!({"to": u32::MAX}));
    assert_eq!((&rest["position"], &rest["scan"]), (&json!(total), &json!(60)));
    assert_eq!(go(&view, json!({"by": "reading", "count": -1000000}))["position"], 0);
    assert_eq!(tile(&view, "0", "combined", [0, 0, 0]), None);
    // a budget of nothing still gets on
    let stopped = go(&view, json!({"to": total, "budget_ms": 0}));
    assert!(stopped["position"].as_u64().unwrap() > 0 && stopped["target"] == total, "{stopped}");
}

#[test]
fn a_cell_and_its_history() {
    let place = Place::new();
    let view = open(&corridor(&place), &[wanted("bayes", &[]), wanted("csm-continuous", &[])]);
    go(&view, json!({"to": 100000}));
    let (extent, entries) = level(&view, "0", "updates", 0);
    let busiest = (0..entries.len()).max_by_key(|k| entries[*k]).unwrap();
    let at = format!("column={}&row={}", busiest % extent[0], busiest / extent[0]);
    let cell = json(&view, "api/cell", &at);
    let [bayes, csm] = [0, 1].map(|k| &cell["sources"][k]);
    assert_eq!((&bayes["touched"], &csm["touched"]), (&json!(true), &json!(true)));
    let count = bayes["interior"].as_u64().unwrap() + bayes["arc"].as_u64().unwrap();
    let history = json(&view, "api/history", &format!("lane=0&{at}&count=3"));
    assert_eq!((&history["total"], history["events"].as_array().unwrap().len()), (&json!(count), 3));
    let values: Vec<&Value> = bayes["values"].as_array().unwrap().iter().map(|v| &v[1]).collect();
    let after: Vec<&Value> = history["events"][0]["after"].as_array().unwrap().iter().collect();
    assert_eq!(after, values[..after.len()]);
    let chosen = csm["chosen"].as_array().unwrap();
    assert!(!chosen.is_empty() && chosen.len() <= 16, "{}", chosen.len());
    let beams = json(&view, "api/history", &format!("lane=1&{at}"));
    assert_eq!(beams["total"], chosen.len());
    assert!(beams["note"].is_string());
    refused(ask(&view, "api/cell", "column=100000&row=0"), "the grid has");
    refused(ask(&view, "api/history", &format!("lane=2&{at}")), "there is no lane 2");
}

#[test]
fn two_lanes_keep_step_and_differ_by_their_difference() {
    let place = Place::new();
    let log = corridor(&place);
    for second in ["certainty", "csm-discrete", "features", "himm"] {
        let view = open(&log, &[wanted("bayes", &[]), wanted(second, &[])]);
        let lines = |state: &Value| {
            let line = |k: usize| state["lanes"][k]["current"]["line"].as_u64().unwrap();
            [line(0), line(1)]
        };
        for _ in 0..3 {
            let [first, other] = lines(&go(&view, json!({"by": "scan", "count": 3})));
            // A scan, or an update of a missing echo, may end a little later in one of them.
            assert!(first.abs_diff(other) <= 8, "{second}: lines {first} and {other}");
        }
        if second == "certainty" {
            let exact = lines(&go(&view, json!({"by": "reading"})));
            assert_eq!(exact[0], exact[1]);
        }
        let (extent, first) = level(&view, "0", "combined", 0);
        let (_, other) = level(&view, "1", "combined", 0);
        let (same, both) = level(&view, "difference", "combined", 0);
        assert_eq!(extent, same);
        let mut differ = 0;
        for k in 0..both.len() {
            // Palette entries: 0 not reached, 128 nothing, a step 1/127.
            let value = |entry: u8| if entry == 0 { 0 } else { i32::from(entry) - 128 };
            match (first[k], other[k]) {
                (0, 0) => assert_eq!(both[k], 0),
                (a, b) => {
                    let wanted = (value(b) - value(a)).clamp(-127, 127);
                    assert!((value(both[k]) - wanted).abs() <= 1, "{second}: {a} {b} {}", both[k]);
                    differ += usize::from(both[k] != 128);
                }
            }
        }
        // So short a walk shows no wall: features maps it as bayes does.
        assert!(differ > 50 || second == "features", "{second}");
    }
}

#[test]
fn parameters_change_at_the_same_place_or_not_at_all() {
    let place = Place::new();
    let log = corridor(&place);
    let view = open(&log, &[wanted("bayes", &[])]);
    let at = go(&view, json!({"by": "scan", "count": 20}));
    let before = level(&view, "0", "combined", 0);
    let lanes = |body: Value| post(&view, "api/lanes", "", body.to_string().as_bytes());
    for (body, says) in [
        (json!({"lanes": [{"method": "bayes", "set": {"epsilon": "-1"}}]}), "epsilon"),
        (json!({"lanes": [{"method": "bayes", "set": {"rho": "0.1"}}]}), "rho"),
        (json!({"lanes": [{"method": "baies"}]}), "did you mean \"bayes\""),
        (json!({"lanes": []}), "one method or two"),
        (json!({"lanes": [{"method": "bayes"}, {"method": "bayes"}, {"method": "bayes"}]}), "not 3"),
        (json!({"lane": 1}), "the body is not what is wanted"),
    ] {
        refused(lanes(body), says);
        assert_eq!(level(&view, "0", "combined", 0), before);
    }
    let session = told(lanes(json!({"lanes": [{"method": "bayes", "set": {"epsilon": "0.2"}}]})));
    assert_eq!(session["sources"][0]["parameters"]["epsilon"], "0.2");
    assert_eq!(session["state"]["lanes"][0]["current"]["line"], at["lanes"][0]["current"]["line"]);
    assert_ne!(level(&view, "0", "combined", 0), before);
    // The same as if it had been asked for at first.
    let other = open(&log, &[wanted("bayes", &[("epsilon", "0.2")])]);
    go(&other, json!({"by": "scan", "count": 20}));
    assert_eq!(level(&view, "0", "combined", 0), level(&other, "0", "combined", 0));
    told(lanes(json!({"lanes": [{"method": "bayes"}]})));
    assert_eq!(level(&view, "0", "combined", 0), before);
}

#[test]
fn a_page_learns_what_another_did() {
    let place = Place::new();
    let view = open(&corridor(&place), &[wanted("bayes", &[])]);
    let first = go(&view, json!({"to": 10}));
    let version = first["version"].as_u64().unwrap();
    // nothing changes, nothing is new
    let same = go(&view, json!({"by": "reading", "count": 0, "since": version}));
    assert_eq!((&same["version"], &same["lanes"][0]["changed"]), (&json!(version), &json!([])));
    // another page goes elsewhere
    go(&view, json!({"to": 300}));
    let missed = go(&view, json!({"by": "reading", "count": -1, "since": version}));
    assert_eq!((&missed["position"], &missed["lanes"][0]["changed"]), (&json!(299), &json!("all")));
    assert_eq!(missed["version"], version + 2);
    for (path, query) in
        [("api/working", "lane=0"), ("api/cell", "column=0&row=0"), ("api/history", "lane=0&column=0&row=0")]
    {
        let told = json(&view, path, query);
        assert_eq!((&told["version"], &told["generation"]), (&json!(version + 2), &missed["generation"]), "{path}");
    }
    let other = told(post(&view, "api/lanes", "", b"{\"lanes\": [{\"method\": \"himm\"}]}"));
    assert_eq!(other["generation"], missed["generation"].as_u64().unwrap() + 1);
    assert_eq!(other["state"]["generation"], other["generation"]);
}

#[test]
fn scans_are_counted_whatever_the_log_calls_them() {
    let place = Place::new();
    let mut log = String::from(crate::common::HEADER);
    for (k, scan) in [900, 900, 7, 7, 900, 3].into_iter().enumerate() {
        log += &format!("{{\"scan\":{scan},\"px\":0.{k},\"py\":0,\"ph\":0,\"z\":1}}\n");
    }
    place.write("odd.jsonl", log);
    let view = open(&place.path("odd.jsonl"), &[wanted("bayes", &[])]);
    let seen = |body: Value| {
        let state = go(&view, body);
        [&state["position"], &state["scan"], &state["scans"]].map(|v| v.as_u64().unwrap())
    };
    assert_eq!(seen(json!({"by": "scan"})), [2, 1, 4]);
    assert_eq!(seen(json!({"by": "reading"})), [3, 2, 4]);
    assert_eq!(seen(json!({"by": "scan"})), [4, 2, 4]);
    assert_eq!(seen(json!({"by": "scan", "count": 10})), [6, 4, 4]);
    assert_eq!(seen(json!({"by": "scan", "count": -1})), [5, 3, 4]);
    assert_eq!(seen(json!({"by": "reading", "count": -2})), [3, 2, 4]);
    assert_eq!(seen(json!({"by": "scan", "count": -1})), [2, 1, 4]);
    assert_eq!(seen(json!({"by": "scan", "count": i64::MIN})), [0, 0, 4]);
    assert_eq!(seen(json!({"by": "scan", "count": i64::MAX})), [6, 4, 4]);
}

#[test]
fn what_is_wrong_is_refused() {
    let place = Place::new();
    let view = open(&corridor(&place), &[wanted("bayes", &[])]);
    let body = |text: &str| post(&view, "api/go", "", text.as_bytes());
    refused(body("{"), "the body is not what is wanted");
    refused(body("{\"by\": \"mile\"}"), "expected `reading` or `scan`");
    refused(body("{\"by\": \"scan\", \"to\": 3}"), "go by");
    refused(body("{\"to\": -1}"), "the body is not what is wanted");
    refused(body("{\"to\": 1, \"more\": 2}"), "more");
    refused(ask(&view, "api/tile", "source=0&view=nothing&level=0&column=0&row=0"), "there is no view nothing");
    refused(ask(&view, "api/tile", "source=1&view=combined&level=0&column=0&row=0"), "there is no source 1");
    refused(ask(&view, "api/tile", "source=difference&view=combined&level=0&column=0&row=0"), "two methods");
    refused(ask(&view, "api/tile", "source=0&view=combined&level=60&column=0&row=0"), "there is no level 60");
    assert_eq!(ask(&view, "api/nothing", "").unwrap(), Response::NotFound);
    assert_eq!(ask(&view, "api/go", "").unwrap(), Response::NotFound);
}

/// A packed batch: what is said of it, and its buffers.
fn batch(view: &LogView, query: &str) -> (Value, Vec<u8>) {
    let Ok(Response::Bytes("application/octet-stream", bytes)) = ask(view, "api/gpu/batch", query) else {
        panic!("{query}")
    };
    let n = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    assert_eq!((4 + n) % 16, 0);
    (serde_json::from_slice(&bytes[4..4 + n]).unwrap(), bytes[4 + n..].to_vec())
}

#[test]
fn a_pages_own_words_are_held_against_the_cpus() {
    let place = Place::new();
    let log = corridor(&place);
    for name in ["certainty", "dempster-shafer", "bayes", "himm", "features"] {
        let view = open(&log, &[wanted(name, &[])]);
        let plan = json(&view, "api/gpu/plan", "lane=0");
        assert_eq!(plan["supported"], true, "{plan}");
        let words = plan["tile_words"].as_u64().unwrap() as usize;
        go(&view, json!({"to": 50}));
        let (head, bytes) = batch(&view, "lane=0&from=0&to=50");
        let frame = head["frame"]["at"].as_u64().unwrap() as usize;
        assert_eq!(bytes[frame + 8..frame + 12], [0; 4], "the mode is the page's to set");
        for shader in head["shaders"].as_object().unwrap().values() {
            let (path, query) = shader["path"].as_str().unwrap().split_once('?').unwrap();
            let Ok(Response::Bytes(_, source)) = ask(&view, path, query) else { panic!("{shader}") };
            let source = String::from_utf8(source).unwrap();
            assert!(source.contains(&format!("fn {}(", shader["entry"].as_str().unwrap())), "{name}");
            for constant in shader["constants"].as_object().unwrap().keys() {
                assert!(source.contains(&format!("override {constant}")), "{name} {constant}");
            }
        }
        // Words of nothing: every cell that was touched differs.
        let mut tiles = Vec::new();
        for chunk in head["chunks"].as_array().unwrap() {
            let place = [0, 1].map(|k| chunk["place"][k].as_u64().unwrap() as u32);
            let slots = chunk["slots"].as_array().unwrap();
            tiles.extend(slots.iter().map(|s| [place[0], place[1], s.as_u64().unwrap() as u32]));
        }
        let mut body: Vec<u32> = vec![tiles.len() as u32];
        body.extend(tiles.iter().flatten());
        body.resize(body.len() + words * tiles.len(), 0);
        let send = |to: usize, body: &[u32]| {
            let bytes: Vec<u8> = body.iter().flat_map(|w| w.to_le_bytes()).collect();
            post(&view, "api/gpu/words", &format!("lane=0&to={to}"), &bytes)
        };
        let check = told(send(50, &body));
        assert_eq!(check["tiles"], tiles.len());
        // A page that leaves out a tile is found out, once it says that this was the last.
        assert_eq!(told(post(&view, "api/gpu/reset", "lane=0", &[])), json!({}));
        let none = 0u32.to_le_bytes();
        let missing = |query: &str| told(post(&view, "api/gpu/words", query, &none))["membership_differences"].clone();
        assert_eq!(missing("lane=0&to=50&more=1"), 0);
        assert_eq!(missing("lane=0&to=50"), check["membership_differences"], "{name}");
        told(send(50, &body));
        assert!(check["membership_differences"].as_u64().unwrap() > 100, "{name}: {check}");
        let shown = "source=0&view=combined&level=0&column=0&row=0";
        assert_eq!(ask(&view, "api/tile", &format!("{shown}&backend=webgpu")).unwrap(), Response::NoContent);
        // One reading's update of one cell.
        body[1 + 3 * tiles.len()] += 1;
        assert!(told(send(50, &body))["membership_differences"].as_u64().unwrap() > 100);
        assert!(matches!(
            ask(&view, "api/tile", &format!("{shown}&backend=webgpu")).unwrap(),
            Response::Bytes(..) | Response::NoContent
        ));
        assert_eq!(told(post(&view, "api/gpu/reset", "lane=0", &[])), json!({}));
        let cpus = ask(&view, "api/tile", shown).unwrap();
        assert_eq!(
            ask(&view, "api/tile", &format!("{shown}&backend=webgpu")).unwrap(),
            cpus,
            "nothing of the page's is left"
        );
        told(send(50, &body));
        assert_ne!(ask(&view, "api/tile", &format!("{shown}&backend=webgpu")).unwrap(), cpus);
        refused(send(49, &body), "the log stands at 50");
        refused(send(50, &body[..body.len() - 1]), "words were sent");
        refused(send(50, &[u32::MAX]), "words were sent");
        refused(send(50, &[[1, 70000, 0, 0].as_slice(), &vec![0; words]].concat()), "no reading reached tile");
        assert_eq!(told(post(&view, "api/gpu/reset", "lane=0", &[])), json!({}));
        assert!(matches!(ask(&view, "api/tile", &format!("{shown}&backend=webgpu")).unwrap(), Response::Bytes(..)));
        refused(ask(&view, "api/gpu/batch", "lane=0&from=0&to=100000"), "items 0 to 100000");
    }
    let view = open(&log, &[wanted("csm-continuous", &[])]);
    let plan = json(&view, "api/gpu/plan", "lane=0");
    assert_eq!(plan["supported"], false);
    assert!(plan["why"].as_str().unwrap().contains("nearest poses"), "{plan}");
}
