//! The same log gives the same bytes: run after run, for any batch and any number of threads.

use crate::common::Place;
use echogrid::method::REGISTRY;
use std::collections::BTreeMap;

/// Every file of a map by its path; the report without what may differ.
fn files(place: &Place, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let mut all = place.files(folder);
    let mut report: serde_json::Value = serde_json::from_slice(&all["report.json"]).unwrap();
    for key in ["seconds", "peak_memory", "adapter"] {
        report.as_object_mut().unwrap().remove(key).unwrap();
    }
    report.as_object_mut().unwrap().remove("busy");
    if let Some(features) = report.get_mut("features") {
        for key in ["seconds", "overlap"] {
            features.as_object_mut().unwrap().remove(key).unwrap();
        }
    }
    report["log"].as_object_mut().unwrap().remove("path").unwrap();
    all.insert("report.json".into(), serde_json::to_vec(&report).unwrap());
    all
}

#[track_caller]
fn same(place: &Place, a: &str, b: &str) {
    let (a, b) = (files(place, a), files(place, b));
    assert!(a.len() > 10 && a.keys().eq(b.keys()), "{:?} and {:?}", a.keys(), b.keys());
    for (name, bytes) in &a {
        assert!(b[name] == *bytes, "{name} differs");
    }
}

#[test]
fn runs_batches_and_threads() {
    let place = Place::new();
    let world = concat!(env!("CARGO_MANIFEST_DIR"), "/worlds/room.toml");
    for log in ["room.jsonl", "same.jsonl"] {
        place.does(&["simulate", world, "-o", log, "--seed", "3", "--quiet"]);
    }
    for entry in REGISTRY.iter().filter(|e| e.name != "truth") {
        let map = |log: &str, folder: &str, more: &[&str]| {
            let fixed = ["map", log, "-o", folder, "-m", entry.name, "--backend", "cpu", "--npy", "--quiet"];
            place.does(&[&fixed, more].concat());
        };
        map("room.jsonl", "once", &[]);
        map("same.jsonl", "twice", &[]);
        same(&place, "once", "twice");
        map("room.jsonl", "twice", &["--batch", "7"]);
        same(&place, "once", "twice");
        map("room.jsonl", "twice", &["--threads", "1"]);
        same(&place, "once", "twice");
    }
    // And what differs is found to differ.
    place.does(&["map", "room.jsonl", "-o", "twice", "-m", "himm", "--until", "99", "--backend", "cpu", "--npy"]);
    let (a, b) = (files(&place, "once"), files(&place, "twice"));
    assert_ne!(a["report.json"], b["report.json"]);
}
