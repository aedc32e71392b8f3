//! `map` where all is well: the folder, the report, the options.

use crate::common::{HEADER, Place, SMALL, data, keys, line};
use echogrid::method::REGISTRY;
use echogrid::method::settings::Settings;
use serde_json::{Value, json};
use std::io::Write;

#[test]
fn the_report_holds_all_that_the_documentation_lists() {
    let place = Place::new();
    let ran = place.map("out", &["--json"]);
    assert_eq!(ran.err, "");
    let report = ran.json();
    assert_eq!(report, place.report("out"), "--json prints the report");
    let top = [
        "adapter",
        "backend",
        "bad_lines",
        "busy",
        "cells",
        "files",
        "layers",
        "log",
        "method",
        "parameters",
        "peak_memory",
        "readings",
        "seconds",
        "sensors",
        "updates",
        "version",
    ];
    assert_eq!(keys(&report), top);
    assert_eq!(report["method"], "bayes");
    assert_eq!(report["log"]["path"], "log.jsonl");
    use sha2::{Digest, Sha256};
    let sum: String = Sha256::digest(SMALL).iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(report["log"]["sha256"], sum);
    assert_eq!(
        report["readings"],
        json!({"read": 8, "used": 4, "no_echo": 2, "outside": 0, "empty_arc": 0, "wide": 0,
            "rejected": {"below_r_min": 1, "not_a_number": 1, "negative": 1, "beyond_hit_range": 1}})
    );
    assert_eq!(report["bad_lines"], json!({"count": 0, "first": []}));
    assert_eq!(report["parameters"]["mounts"], "own");
    assert_eq!(
        report["sensors"],
        json!([{"id": "front", "kind": "sonar", "x": 0.0, "y": 0.0, "axis": 0.0, "half_width": 0.261799388, "r_min": 0.2,
            "r_max": 4.0, "at_r_max": "no_echo", "hit_range": 3.0, "no_echo_range": 1.0, "epsilon": 0.05}])
    );
    // Every used cone up to R + 5 cm: from the first sensor, and the first's right edge, −1.55 sin 15°, to the second's right
    // edge, 0.5 + 2.05 cos 13.6°, and its left one, 2.05 sin 43.6°.
    let cells = &report["cells"];
    assert_eq!(keys(cells), ["empty", "height", "occupied", "resolution", "touched", "unknown", "width", "x0", "y0"]);
    let near = |value: &Value, wanted: f64| (value.as_f64().unwrap() - wanted).abs() < 1e-9;
    assert!(near(&cells["x0"], 0.0) && near(&cells["y0"], -0.45), "{cells}");
    assert_eq!((&cells["width"], &cells["height"], &cells["resolution"]), (&json!(50), &json!(38), &json!(0.05)));
    let count = |name: &str| cells[name].as_u64().unwrap();
    assert_eq!(count("occupied") + count("empty") + count("unknown"), 50 * 38);
    assert!(count("touched") > 0 && count("touched") < report["updates"].as_u64().unwrap());
    assert_eq!(report["layers"]["touched"]["sum"], count("touched") as f64);
    assert_eq!(report["layers"]["class"]["sum"], count("occupied") as f64 - count("empty") as f64);
    for layer in ["log_odds", "p_occ", "p_emp", "touched", "class"] {
        assert_eq!(keys(&report["layers"][layer]), ["max", "min", "scale", "sum"], "{layer}");
    }
    assert_eq!(keys(&report["seconds"]), ["bin", "map", "survey", "write"]);
    assert_eq!(keys(&report["busy"]), ["kernels", "read", "take"]);
    assert_eq!(report["backend"], "cpu");
    assert!(report["adapter"].as_str().unwrap().contains("thread"));
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    if cfg!(target_os = "linux") {
        assert!(report["peak_memory"].as_u64().unwrap() > 1 << 20);
    }
}

#[test]
fn the_report_lists_every_parameter_of_every_method() {
    let place = Place::new();
    place.write("laser.jsonl", LASER);
    let labelled = SMALL.replace("\"z\":1.5", "\"z\":1.5,\"label\":1").replace("}]}", "}],\"classes\":[\"wall\"]}");
    place.write("labelled.jsonl", labelled);
    let sensor =
        ["beta", "epsilon", "hit_range", "mounts", "no_echo_range", "r_max", "r_min", "resolution"].map(str::to_string);
    for entry in REGISTRY {
        let log = match entry.name {
            "truth" => "laser.jsonl",
            name if name.contains("semantic") => "labelled.jsonl",
            _ => "log.jsonl",
        };
        let ran = place.does(&["map", log, "-o", "out", "--method", entry.name, "--backend", "cpu", "--json"]);
        let settings = Settings::of(entry.name).unwrap();
        let mut wanted: Vec<String> = settings.keys().iter().map(|k| k.name.to_string()).collect();
        wanted.extend(sensor.clone());
        wanted.sort();
        assert_eq!(keys(&ran.json()["parameters"]), wanted, "{}", entry.name);
        assert_eq!(ran.json()["method"], entry.name);
    }
    let set = ["--set", "beta=15deg", "--set", "r_max=250cm", "--set", "max_occ=0.9", "--resolution", "10cm"];
    let parameters = place.map("out", &[&set[..], &["--json"]].concat()).json()["parameters"].clone();
    assert_eq!(parameters["beta"], 15.0_f64.to_radians());
    assert_eq!(parameters["max_occ"], 0.9);
    assert_eq!(parameters["resolution"], 0.1);
    // A lowered r_max takes hit_range with it.
    assert_eq!((&parameters["r_max"], &parameters["hit_range"]), (&json!(2.5), &json!(2.5)));
}

/// Two scans of a laser with three beams.
const LASER: &str = r#"{"echogrid_log":1,"sensors":[{"id":"top","kind":"laser"}]}
{"scan":0,"px":0,"py":0,"ph":0,"x":0,"y":0,"h":-0.01,"z":2}
{"scan":0,"px":0,"py":0,"ph":0,"x":0,"y":0,"h":0,"z":2}
{"scan":0,"px":0,"py":0,"ph":0,"x":0,"y":0,"h":0.01,"z":2}
{"scan":1,"px":0,"py":0,"ph":0,"x":0,"y":0,"h":-0.01,"z":2}
{"scan":1,"px":0,"py":0,"ph":0,"x":0,"y":0,"h":0,"z":2}
{"scan":1,"px":0,"py":0,"ph":0,"x":0,"y":0,"h":0.01,"z":2}
"#;

#[test]
fn what_is_printed() {
    let place = Place::new();
    let ran = place.map("out", &[]);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert_eq!(lines.len(), 10, "{lines:#?}");
    assert_eq!(lines[0], "4 of 8 readings mapped, from 4 scans");
    assert_eq!(lines[6], "bayes: 50 × 38 cells of 5 cm, x 0.00 to 2.50 m, y -0.45 to 1.45 m");
    assert_eq!(lines[7], "643 cells seen: 25 occupied, 329 empty, 289 undecided; 881 cell updates");
    assert!(lines[8].starts_with("cpu (") && lines[8].ends_with(" s"), "{}", lines[8]);
    assert_eq!(lines[9], "HERE/out/map.png");
    let ran = place.map("out", &["--quiet"]);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
}

#[test]
fn the_folder() {
    let place = Place::new();
    let files = [
        "class.png",
        "log_odds.png",
        "map.pgm",
        "map.png",
        "map.yaml",
        "map.zarr",
        "p_emp.png",
        "p_occ.png",
        "report.json",
        "touched.png",
    ];
    place.map("out", &[]);
    assert_eq!(place.names("out"), files);
    place.map("out", &["--npy", "--working", "2"]);
    let mut more: Vec<String> = files.map(str::to_string).to_vec();
    more.extend(["class", "log_odds", "p_emp", "p_occ", "touched"].map(|layer| format!("{layer}.npy")));
    more.extend(["working-2.json", "working-2.png"].map(str::to_string));
    more.sort();
    assert_eq!(place.names("out"), more);
    // The report lists them, but for the store and what was written after it.
    let listed = place.report("out")["files"].clone();
    more.retain(|name| name != "map.zarr" && !name.starts_with("working-"));
    assert_eq!(listed, json!(more));
    let working: Value = serde_json::from_slice(&std::fs::read(place.path("out/working-2.json")).unwrap()).unwrap();
    assert_eq!((&working["reading"]["line"], &working["reading"]["range"]), (&json!(3), &json!(2.0)));
    assert_eq!(working["method"], "bayes");
    assert_eq!(working["own_is"], "P(s|occupied)");
    assert_eq!((working.get("sum"), working["cells"][0].get("cancelled")), (None, None));
    assert!(working["cells"][0]["own"].is_number() && working["cells"][0].get("normalised").is_none());
    place.map("certainty", &["--method", "certainty", "--working", "2"]);
    let path = place.path("certainty/working-2.json");
    let working: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert!(working["own_is"].as_str().unwrap().contains("Occ_k"), "{working}");
    let cell = &working["cells"][0];
    assert!(working["sum"].is_number() && cell["cancelled"].is_number() && cell["normalised"].is_number(), "{cell}");
    let picture = std::fs::read(place.path("out/working-2.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG"));
}

#[test]
fn until_stops_after_so_many_used_readings() {
    let place = Place::new();
    place.map("out", &["--until", "2"]);
    let report = place.report("out");
    assert_eq!((&report["readings"]["read"], &report["readings"]["used"]), (&json!(2), &json!(2)));
    place.map("out", &["--until", "1000"]);
    assert_eq!(place.report("out")["readings"]["read"], 8);
}

#[test]
fn bounds_may_be_negative_and_elsewhere() {
    let place = Place::new();
    for bounds in [&["--bounds", "-1,-1,1,1"][..], &["--bounds=-1,-1,1,1"], &["-b", "-1,-1,1,1"]] {
        place.map("out", bounds);
        let cells = &place.report("out")["cells"];
        assert_eq!((&cells["x0"], &cells["width"], &cells["height"]), (&json!(-1.0), &json!(40), &json!(40)));
    }
    let ran = place.map("out", &["--bounds", "100,100,101,101", "--quiet"]);
    assert_eq!(ran.err, "echogrid: no reading reaches these --bounds: the log covers 0.00,-0.40,2.49,1.41\n");
    let report = place.report("out");
    assert_eq!((&report["readings"]["outside"], &report["cells"]["touched"]), (&json!(4), &json!(0)));
}

const CARMEN: &str = "PARAM robot_front_laser_max 50.0 nohost 0
FLASER 4 1.5 2.5 50.0 81.91 0.1 0.2 0.3 0 0 0 12.5 nohost 12.5
FLASER 4 1.5 2.5 3.0 2.0 0.1 0.2 0.3 0 0 0 12.5 nohost 12.5
";

#[test]
fn standard_input_gives_the_same_map() {
    let place = Place::new();
    let csv = format!("# {HEADER}scan,px,py,ph,z\n0,0,0,0,1.5\n1,0.2,0,0.1,2\n");
    for (name, text) in [("jsonl", SMALL), ("csv", &csv), ("carmen", CARMEN)] {
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gz.write_all(text.as_bytes()).unwrap();
        place.write("file.log", text);
        place.does(&["map", "file.log", "-o", "file", "--backend", "cpu"]);
        for bytes in [text.as_bytes().to_vec(), gz.finish().unwrap()] {
            let mut command = place.command(&["map", "-", "-o", "stream", "--backend", "cpu"]);
            let ran = place.finish(command.write_stdin(bytes));
            // How a CARMEN log is read is told.
            let told = ran.err.lines().all(|line| line.starts_with("echogrid: <stdin>: FLASER/4: "));
            assert!(ran.code == 0 && told && ran.err.is_empty() == (name != "carmen"), "{name}: {ran:?}");
            assert_eq!(place.report("stream")["log"]["path"], "<stdin>");
            assert!(place.report("stream")["cells"]["touched"].as_u64().unwrap() > 0, "{name}");
            assert_eq!(place.does(&["compare", "file", "stream"]).code, 0, "{name}");
        }
    }
}

#[test]
fn the_backends_agree() {
    let place = Place::new();
    place.map("cpu", &[]);
    place.does(&["map", "log.jsonl", "-o", "oracle", "--backend", "oracle"]);
    assert_eq!(place.report("oracle")["backend"], "oracle");
    assert_eq!(place.report("oracle")["updates"], place.report("cpu")["updates"]);
    place.does(&["compare", "cpu", "oracle", "--tol", "1e-4"]);
    let gpu = place.run(&["map", "log.jsonl", "-o", "gpu", "--backend", "gpu"]);
    if gpu.code == 4 && std::env::var("ECHOGRID_REQUIRE_GPU").is_ok_and(|v| v == "1") {
        panic!("{gpu:?}");
    }
    if gpu.code == 4 {
        let _ = std::io::stderr().write_all(format!("SKIPPED: {}", gpu.err).as_bytes());
        return;
    }
    assert_eq!(gpu.code, 0, "{gpu:?}");
    assert_eq!(place.report("gpu")["backend"], "gpu");
    place.does(&["compare", "cpu", "gpu", "--tol", "1e-4"]);
}

#[test]
fn a_real_log_gives_the_known_counts() {
    let Some(log) = data("sonar_ring_8/test1") else { return };
    let place = Place::new();
    let literal = "--resolution 0.1 --set beta=15deg --set mounts=none --set r_min=0.17 --set r_max=5 --set hit_range=5 \
                   --set no_echo_range=5 --method certainty --json -o out";
    let map = |backend: &str| {
        let mut arguments = vec!["map", log.to_str().unwrap(), "--backend", backend];
        arguments.extend(literal.split_whitespace());
        let report = place.does(&arguments).json();
        assert_eq!((&report["updates"], &report["cells"]["touched"]), (&json!(1_101_584), &json!(21_294)), "{backend}");
        let readings = &report["readings"];
        assert_eq!((&readings["used"], &readings["no_echo"]), (&json!(3304), &json!(1091)), "{backend}");
        assert_eq!(report["parameters"]["mounts"], "none");
        let places: Vec<_> = report["sensors"].as_array().unwrap().iter().map(|s| (&s["x"], &s["y"])).collect();
        assert_eq!(places, [(&json!(0.0), &json!(0.0)); 8]);
        let sum = |layer: &str| report["layers"][layer]["sum"].as_f64().unwrap();
        assert!((sum("emp") - 17345.975).abs() < 0.01 && (sum("occ") - 956.243).abs() < 0.01, "{}", report["layers"]);
        report
    };
    map("cpu");
    // A cell where Occ and Emp are all but equal may be either in f32, so the classes are the oracle's.
    let cells = &map("oracle")["cells"];
    assert_eq!((&cells["occupied"], &cells["empty"]), (&json!(566), &json!(20_727)));
}

#[test]
fn numbers_in_a_report_are_round_and_mounts_can_be_set_again() {
    let place = Place::new();
    std::fs::create_dir(place.path("ring")).unwrap();
    place.write("ring/sonar.txt", "1 5110 5110 2320 2360 5110 5110 2160 1190\n");
    place.write("ring/od.txt", "1 0 0 0\n");
    for (more, mounts, y) in [
        (&[][..], "preset", -0.18),
        (&["--set", "mounts=preset"], "preset", -0.18),
        (&["--set", "mounts=none"], "none", 0.0),
    ] {
        let report = place.does(&[&["map", "ring", "-o", "out", "--backend", "cpu", "--json"], more].concat()).json();
        assert_eq!(report["parameters"]["mounts"], mounts);
        let right = &report["sensors"][0];
        assert_eq!(right["axis"].to_string(), "-1.570796327");
        assert_eq!((&right["x"], &right["y"]), (&json!(0.0), &json!(y)));
    }
    place.write("ring.toml", "[all]\nx = 0.1\n".to_string() + &"[[sensor]]\n".repeat(8));
    let own = ["map", "ring", "-o", "out", "--backend", "cpu", "--json", "--sensor-file", "ring.toml"];
    assert_eq!(place.does(&own).json()["parameters"]["mounts"], "own");
    // -56 cells of 0.05 m are -2.8000000000000003 in binary.
    let out = place.map("out", &["--bounds=-2.8,-2.8,1,1", "--json"]).json();
    assert_eq!((&out["cells"]["x0"], &out["cells"]["y0"]), (&json!(-2.8), &json!(-2.8)));
    let yaml = std::fs::read_to_string(place.path("out/map.yaml")).unwrap();
    assert!(yaml.contains("origin: [-2.8, -2.8, 0.0]"), "{yaml}");
}

#[test]
fn a_reading_per_kind_of_sensor() {
    let place = Place::new();
    let both = r#"{"echogrid_log":1,"sensors":[{"id":"s"},{"id":"l","kind":"laser"}]}"#;
    let of = |sensor: &str| line("0", "1").replace("\"px\"", &format!("\"sensor\":\"{sensor}\",\"px\""));
    place.write("both.jsonl", format!("{both}\n{}{}{}", of("s"), of("l"), of("l")));
    for (kind, used) in [("sonar", 1), ("laser", 2)] {
        place.does(&["map", "both.jsonl", "-o", "out", "--sensor", kind, "--backend", "cpu"]);
        assert_eq!(place.report("out")["readings"]["used"], used, "{kind}");
    }
}
