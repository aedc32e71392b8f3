//! Method features: what a run says and leaves, what it falls back to, what is refused, harmless oddities.

use crate::common::{HEADER, Place};
use serde_json::{Value, json};

fn world(name: &str) -> String {
    format!("{}/worlds/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

fn simulated(place: &Place, name: &str) {
    place.does(&["simulate", &world(name), "-o", "log.jsonl", "--seed", "1", "--quiet"]);
}

fn map<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let start = ["map", "log.jsonl", "-o", out, "-m", "features", "-r", "0.05", "--backend", "cpu", "--json"];
    [&start[..], more].concat()
}

/// One circular scan of a sonar at the origin whose k-th range is `z(k)`.
fn circle(z: impl Fn(u32) -> String) -> String {
    let mut text = String::from("{\"echogrid_log\":1,\"sensors\":[{\"id\":\"top\"}]}\n");
    for k in 0..200 {
        let h = f64::from(k) * std::f64::consts::PI / 100.0;
        let (x, y) = (0.14 * h.cos(), 0.14 * h.sin());
        text += &format!("{{\"scan\":0,\"px\":0,\"py\":0,\"ph\":0,\"x\":{x},\"y\":{y},\"h\":{h},\"z\":{}}}\n", z(k));
    }
    text
}

#[test]
fn a_room_its_walls_and_corners_and_what_became_of_each_reading() {
    let place = Place::new();
    simulated(&place, "room");
    let report = place.does(&map("out", &[])).json();
    let f = &report["features"];
    assert_eq!([&f["corners"], &f["points"]], [&json!(4), &json!(0)]);
    let cases = ["associated", "outliers", "behind", "routine"].map(|k| f[k].as_u64().unwrap());
    assert_eq!(cases.iter().sum::<u64>(), 400, "each reading has a case: {cases:?}");
    assert!(f["held"] == 400 && f["held_bytes"].as_u64().unwrap() > 400 * 50 && f["seconds"]["stage"].is_number());
    let text = std::fs::read_to_string(place.path("out/features.geojson")).unwrap();
    let found: Value = serde_json::from_str(&text).unwrap();
    let all = found["features"].as_array().unwrap();
    let corners: Vec<[f64; 2]> = all
        .iter()
        .filter(|f| f["properties"]["kind"] == "corner")
        .map(|f| serde_json::from_value(f["geometry"]["coordinates"].clone()).unwrap())
        .collect();
    for corner in [[0.02, 0.03], [4.62, 0.03], [4.62, 3.43], [0.02, 3.43]] {
        let near = |c: &&[f64; 2]| (c[0] - corner[0]).hypot(c[1] - corner[1]) < 0.1;
        assert_eq!(corners.iter().filter(near).count(), 1, "{corner:?} of {corners:?}");
    }
    assert!(std::fs::read_to_string(place.path("out/features.svg")).unwrap().contains("map.png"));
    let human = place.does(&["map", "log.jsonl", "-o", "out", "-m", "features", "-r", "0.05", "--backend", "cpu"]);
    assert!(human.out.contains("4 corners") && human.out.contains("from behind a wall"), "{}", human.out);
}

#[test]
fn safer_than_the_best_routine_grid_and_than_the_papers_rules() {
    let place = Place::new();
    simulated(&place, "bend");
    place.does(&map("features", &[]));
    place.does(&map("paper", &["--set", "rules=paper"]));
    place.does(&["map", "log.jsonl", "-o", "bayes", "-m", "bayes", "-r", "0.05", "--backend", "cpu", "--quiet"]);
    let truth = world("bend");
    let score = place.does(&["score", "features", "paper", "bayes", "--truth", &truth, "--json"]).json();
    let z5: Vec<f64> = (0..3).map(|k| score["maps"][k]["zones"]["z5"].as_f64().unwrap()).collect();
    assert!(z5[0] < 0.05 * z5[2] && z5[1] < 0.8 * z5[2] && z5[0] < z5[1], "{z5:?}");
    let z1: Vec<f64> = (0..3).map(|k| score["maps"][k]["zones"]["z1"].as_f64().unwrap()).collect();
    assert!(z1[0] > z1[1] && z1[1] > z1[2], "{z1:?}");
}

#[test]
fn verify_finds_no_difference_and_any_window_gives_the_same_bytes() {
    let place = Place::new();
    simulated(&place, "room");
    let verified = place.does(&["verify", "log.jsonl", "-m", "features", "-r", "0.05", "--json"]).json();
    assert_eq!(verified["passed"], true);
    assert!(verified["updates"].as_u64().unwrap() > 50_000);
    place.does(&map("whole", &[]));
    for more in [["--batch", "1"], ["--batch", "7"], ["--threads", "1"]] {
        place.does(&map("parts", &more));
        assert!(place.does(&["compare", "whole", "parts"]).out.contains("to the bit"), "{more:?}");
    }
}

#[test]
fn without_anything_to_go_by_it_is_bayes_and_says_what_it_needs() {
    let place = Place::new();
    place.write("log.jsonl", format!("{HEADER}{}", crate::common::line("0", "1.5")));
    let ran = place.does(&map("features", &[]));
    for needed in ["mapped as method bayes does", "circular scans", "2.5°", "0.25 m of travel"] {
        assert!(ran.err.contains(needed), "{}", ran.err);
    }
    place.does(&["map", "log.jsonl", "-o", "bayes", "-m", "bayes", "-r", "0.05", "--backend", "cpu", "--quiet"]);
    assert!(place.does(&["compare", "bayes", "features"]).out.contains("to the bit"));
}

#[test]
fn degenerate_scans_do_no_harm() {
    let place = Place::new();
    let one = |k: u32| if k == 7 { "1.5".into() } else { "null".to_string() };
    let logs = [
        ("no echo but one", circle(one)),
        ("all equal", circle(|_| "1.5".into())),
        ("a stray each second", circle(|k| if k % 2 == 0 { "1.5".into() } else { "4".into() })),
        ("one place again and again", format!("{HEADER}{}", crate::common::line("0", "1.5").repeat(500))),
        (
            "jumps",
            (0..9).map(|k| crate::common::line(&format!("{}", k * 10), "1.5")).fold(HEADER.into(), |a, b| a + &b),
        ),
    ];
    for (what, log) in logs {
        place.write("log.jsonl", log);
        let report = place.does(&map("out", &[])).json();
        let used = report["readings"]["used"].as_u64().unwrap();
        assert!(used > 0 && report["cells"]["touched"].as_u64().unwrap() > 100, "{what}: {report}");
        place.does(&["map", "log.jsonl", "-o", "bayes", "-m", "bayes", "-r", "0.05", "--backend", "cpu", "--quiet"]);
        let bayes = place.report("bayes")["cells"]["empty"].as_u64().unwrap();
        let empty = report["cells"]["empty"].as_u64().unwrap();
        assert!(empty <= bayes + bayes / 10, "{what}: {empty} cells freed, {bayes} by bayes");
    }
    place.write("log.jsonl", circle(|_| "null".into()));
    assert_eq!(place.run(&map("out", &[])).code, 3, "nothing but missing echoes is nothing to map");
}

#[test]
fn wrong_settings_are_refused() {
    let place = Place::new();
    for (set, said) in [
        ("rules=theirs", "rules takes ours|paper"),
        ("hold=-1", "hold takes 0..1000"),
        ("hold=nan", "hold takes 0..1000"),
        ("corners=1", "corners takes true|false"),
    ] {
        let ran = place.run(&map("out", &["--set", set]));
        assert!(ran.code == 2 && ran.err.contains(said), "{set}: {}", ran.err);
    }
    let fine = place.run(&["map", "log.jsonl", "-o", "out", "-m", "features", "-r", "0.001"]);
    assert!(fine.code == 2 && fine.err.contains("512 cells"), "{}", fine.err);
}
