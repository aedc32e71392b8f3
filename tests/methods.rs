//! docs/methods.md tells what is: its tables of scores are measured again, to the last digit.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking; here are the tests' helpers too")]

#[path = "data/mod.rs"]
mod data;

use data::data;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// The columns after the method.
const SHOWN: [&str; 9] =
    ["accuracy", "danger", "recall_tolerant", "precision_tolerant", "unknown", "zones", "brier", "auc", "ece"];

fn echogrid(folder: &Path, arguments: &[&str]) -> String {
    let ran = Command::new(env!("CARGO_BIN_EXE_echogrid")).current_dir(folder).args(arguments).output().unwrap();
    assert!(ran.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).unwrap()
}

/// A map's row as the document prints it; `case` is `bend, dense`, `bend, no mirrors`, `bend, ring8` or `test1`.
fn row(folder: &Path, case: &str, method: &str, near: bool) -> Option<Vec<String>> {
    let (name, kind) = case.split_once(", ").unwrap_or((case, "real"));
    let (log, truth, resolution) = if kind == "real" {
        let log = data(&format!("sonar_ring_8/{name}"))?.display().to_string();
        let truth = format!("{name}-truth");
        if !folder.join(&truth).exists() {
            let laser = ["-m", "truth", "--sensor", "laser", "-r", "0.1", "--backend", "cpu", "--quiet"];
            echogrid(folder, &[&["map", &log, "-o", &truth], &laser[..]].concat());
        }
        (log, truth, "0.1")
    } else {
        let (log, truth) = (format!("{name} {kind}.jsonl"), format!("{ROOT}/worlds/{name}.toml"));
        if !folder.join(&log).exists() {
            let more: &[&str] = match kind {
                "dense" => &[],
                "no mirrors" => &["--no-specular"],
                rig => &["--rig", rig],
            };
            echogrid(folder, &[&["simulate", &truth, "-o", &log, "--quiet"], more].concat());
        }
        (log, truth, "0.05")
    };
    let fixed =
        ["map", &log, "-o", "map", "-m", method, "-r", resolution, "--sensor", "sonar", "--backend", "cpu", "-q"];
    let more: &[&str] = if near { &["--set", "hit_range=2"] } else { &[] };
    echogrid(folder, &[&fixed[..], more].concat());
    let scored: Value =
        serde_json::from_str(&echogrid(folder, &["score", "map", "--truth", &truth, "--json"])).unwrap();
    let cell = |name: &&str| match &scored["maps"][0][*name] {
        Value::Object(zones) => zones["z5"].to_string(),
        number => format!("{:.3}", number.as_f64().unwrap()),
    };
    Some(SHOWN.iter().map(cell).collect())
}

/// The part of a document that says which method to take, for one kind of log.
fn which(document: &str, kind: &str) -> String {
    let text = std::fs::read_to_string(Path::new(ROOT).join(document)).unwrap();
    let part = text.split("# Which method?").nth(1).and_then(|t| t.split(&format!("- **{kind}")).nth(1));
    part.and_then(|t| t.split("\n- **").next()).unwrap().to_string()
}

#[test]
fn the_figures_of_which_to_take_are_measured() {
    let folder = tempfile::tempdir().unwrap();
    let fixed = ["--backend", "cpu", "-q"];
    let dangers = |log: &str, truth: &[&str], each: &[&str], methods: &[&[&str]]| {
        echogrid(folder.path(), &[&["map", log, "-o", "truth", "-m", "truth"][..], truth, &fixed].concat());
        let danger = |method: &&[&str]| {
            echogrid(folder.path(), &[&["map", log, "-o", "map", "-m"][..], *method, each, &fixed].concat());
            let text = echogrid(folder.path(), &["score", "map", "--truth", "truth", "--json"]);
            let scored: Value = serde_json::from_str(&text).unwrap();
            format!("{:.3}", scored["maps"][0]["danger"].as_f64().unwrap())[1..].to_string()
        };
        methods.iter().map(danger).collect::<Vec<_>>()
    };
    let mut found = Vec::new();
    if let Some(log) = data("sonar_ring_8/test1") {
        let (log, truth) = (log.display().to_string(), ["--sensor", "laser", "-r", "0.1"]);
        let methods: &[&[&str]] = &[&["bayes"], &["features"], &["himm"]];
        found.push(("A sparse ring", dangers(&log, &truth, &["--sensor", "sonar", "-r", "0.1"], methods)));
    }
    if let Some(log) = data("carmen_corrected/intel-corrected.log.gz") {
        let (log, each) = (log.display().to_string(), ["-r", "0.05", "-b=-20,-20,25,25"]);
        let methods: &[&[&str]] = &[&["bayes", "--set", "model=constant"], &["csm-discrete"], &["bayes"]];
        found.push(("A laser", dangers(&log, &each, &each, methods)));
    }
    for (kind, dangers) in found {
        for document in ["README.md", "docs/methods.md"] {
            let text = which(document, kind);
            for danger in &dangers {
                assert!(text.contains(danger), "{document}, {kind}: {dangers:?}: {text}");
            }
        }
    }
}

#[test]
fn its_tables_are_measured() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/methods.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (mut section, mut checked, mut skipped) = (String::new(), 0, 0);
    for line in text.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            section = heading.into();
        }
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        if cells.len() != 2 + SHOWN.len() || cells[2].parse::<f64>().is_err() {
            continue;
        }
        match row(folder.path(), cells[0], cells[1], section.starts_with("5.")) {
            Some(found) => assert_eq!(cells[2..], found, "{section}: {line}: run scripts/methods again"),
            None => {
                skipped += 1;
                continue;
            }
        }
        checked += 1;
    }
    assert_eq!((checked + skipped, skipped % 8), (72, 0), "tables of docs/methods.md were not found");
}
