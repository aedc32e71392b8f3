//! Class labels: where they come from, what the maps make of them, what is refused.

use crate::common::{HEADER, Place};
use serde_json::json;

/// Two scans of five labelled beams each, 10 cm a step.
fn labelled(classes: &str) -> String {
    let mut text = format!(
        "{{\"echogrid_log\":1,\"sensors\":[{{\"id\":\"top\",\"kind\":\"laser\",\"half_width\":\"1deg\"}}]{classes}}}\n"
    );
    for scan in 0..2 {
        for beam in 0..5 {
            let label = if beam < 3 { ",\"label\":1" } else { ",\"label\":2" };
            text += &format!(
                "{{\"scan\":{scan},\"px\":0.{scan},\"py\":0,\"ph\":0,\"x\":0.{scan},\"y\":0,\"h\":{},\"z\":1.5{label}}}\n",
                f64::from(beam) * 0.02 - 0.04
            );
        }
    }
    text
}

const NAMES: &str = ",\"classes\":[\"wall\",\"door\"]";
const FILE: &str =
    "[[class]]\nname = \"stone\"\ncolour = \"#ff0000\"\n[[class]]\nname = \"wood\"\n[free]\nname = \"air\"\n";

fn map<'a>(log: &'a str, method: &'a str) -> Vec<&'a str> {
    vec!["map", log, "-o", "out", "--method", method, "--backend", "cpu", "--json"]
}

#[test]
fn the_logs_own_names_and_those_of_a_file() {
    let place = Place::new();
    place.write("own.jsonl", labelled(NAMES));
    place.write("bare.jsonl", labelled(""));
    place.write("classes.toml", FILE);
    for (log, more, names) in [
        ("own.jsonl", &[][..], json!(["wall", "door", "free"])),
        ("own.jsonl", &["--classes", "classes.toml"], json!(["stone", "wood", "air"])),
        ("bare.jsonl", &["--classes", "classes.toml"], json!(["stone", "wood", "air"])),
    ] {
        for method in ["csm-semantic-discrete", "csm-semantic-continuous"] {
            let report = place.does(&[&map(log, method), more].concat()).json();
            assert_eq!(report["classes"], names);
            let gains = report["increments"].as_array().unwrap();
            assert!(gains.len() == 3 && gains.iter().all(|g| g.as_f64().unwrap() > 0.0), "{gains:?}");
            assert!(report["layers"]["alpha_3"].is_object() && report["layers"]["alpha_4"].is_null());
            let figure = std::fs::read_to_string(place.path("out/figure.svg")).unwrap();
            for name in names.as_array().unwrap() {
                assert!(figure.contains(&format!(">{}<", name.as_str().unwrap())), "{name}");
            }
            assert!(figure.contains("0.2500") && figure.matches("data:image/png;base64,").count() == 3);
        }
    }
    let attributes = std::fs::read_to_string(place.path("out/map.zarr/zarr.json")).unwrap();
    assert!(attributes.contains("stone"), "{attributes}");
    let colours = place.report("out")["layers"]["label"]["scale"]["classes"].clone();
    assert_eq!(colours[0], json!([255, 0, 0]));
    assert_eq!(colours.as_array().unwrap().len(), 3);
    // A plain model needs no label, and has one class of hits.
    let report = place.does(&map("bare.jsonl", "csm-continuous")).json();
    assert!(report["classes"].is_null() && report["increments"].as_array().unwrap().len() == 2);
}

#[test]
fn what_the_map_is_can_be_read_back() {
    let place = Place::new();
    place.write("own.jsonl", labelled(NAMES));
    place.does(&map("own.jsonl", "csm-semantic-discrete"));
    place.does(&[
        "map",
        "own.jsonl",
        "-o",
        "again",
        "--method",
        "csm-semantic-discrete",
        "--backend",
        "cpu",
        "--batch",
        "1",
    ]);
    place.does(&["compare", "out", "again"]);
    place.does(&["check", "out"]);
    let plan = place.does(&["plan", "own.jsonl", "--method", "csm-semantic-discrete", "--json"]).json();
    assert_eq!((&plan["fits"], &plan["rounds"]), (&json!(true), &json!(["fuse"])));
    assert!(plan["expected"][0]["readings_per_second"].as_f64().unwrap() > 0.0, "{plan}");
}

#[test]
fn logs_without_labels_or_with_others() {
    let place = Place::new();
    let semantic = map("log.jsonl", "csm-semantic-continuous");
    let plain = "map it with csm-discrete or csm-continuous, which need none";
    place.refuses(&semantic, 3, &format!("echogrid: log.jsonl: none of its 2 hits carries a class label: {plain}"));
    place.write("bare.jsonl", labelled(""));
    place.refuses(
        &map("bare.jsonl", "csm-semantic-discrete"),
        3,
        &format!(
            "echogrid: bare.jsonl: 10 hits carry class labels, but nothing says what they are: name the classes with \
             --classes, or {plain}"
        ),
    );
    place.write("one.toml", "[[class]]\nname = \"wall\"\n");
    place.refuses(
        &[&map("bare.jsonl", "csm-semantic-discrete")[..], &["--classes", "one.toml"]].concat(),
        3,
        "echogrid: bare.jsonl:5: label 2: there are classes 1 to 1; name more with --classes, or mend the log",
    );
    let many: Vec<String> = (0..33).map(|k| format!("\"c{k}\"")).collect();
    place.write("many.jsonl", labelled(&format!(",\"classes\":[{}]", many.join(","))));
    place.refuses(
        &map("many.jsonl", "csm-semantic-discrete"),
        3,
        &format!("echogrid: many.jsonl: 33 classes, more than 32: {plain}"),
    );
}

#[test]
fn class_files() {
    let place = Place::new();
    place.write("own.jsonl", labelled(NAMES));
    let refuses = |text: &str, message: &str| {
        place.write("c.toml", text);
        let run = [&map("own.jsonl", "csm-semantic-discrete")[..], &["--classes", "c.toml"]].concat();
        place.refuses(&run, 3, &format!("echogrid: c.toml{message}"));
    };
    refuses("", ": has 0 [[class]] tables: 1 to 32 are wanted");
    refuses(
        "[[class]]\nname = \"a\"\ncolour = \"red\"\n",
        ": class \"a\": \"red\" is no colour: write red, green and blue as #rrggbb",
    );
    refuses("[[class]]\nname = \"a\"\ncolor = \"#ff0000\"\n", ":3: unknown field `color`, expected `name` or `colour`");
    let run = [&map("own.jsonl", "csm-semantic-discrete")[..], &["--classes", "no.toml"]].concat();
    place.refuses(&run, 3, "echogrid: no.toml: classes file: No such file or directory (os error 2)");
}

#[test]
fn parameters_out_of_range() {
    let place = Place::new();
    for (set, message) in [
        ("neighbours=0", "neighbours takes 1..64|all"),
        ("neighbours=65", "neighbours takes 1..64|all"),
        ("z_max=91", "z_max takes 0.001..90 m"),
        ("w_beam=180deg", "w_beam takes 0.000001..3.14 rad"),
        ("prior=0", "prior takes 0.000001..1000"),
        ("w_obstacle=-1", "w_obstacle takes 0.000001..10 m"),
    ] {
        let run = [&map("log.jsonl", "csm-discrete")[..], &["--set", set]].concat();
        place.refuses(&run, 2, &format!("echogrid: --set {set}: {message}"));
    }
    let run = [&map("log.jsonl", "csm-continuous")[..], &["--set", "free=never"]].concat();
    place.refuses(&run, 2, "echogrid: --set free=never: free takes projection|sample|clamp");
    let run = [&map("log.jsonl", "csm-discrete")[..], &["--resolution", "3"]].concat();
    place.refuses(&run, 2, "echogrid: the counting sensor models take cells of at most 2 m, not 3 m");
    let run = [&map("log.jsonl", "csm-discrete")[..], &["--working", "1"]].concat();
    place.refuses(
        &run,
        2,
        "echogrid: --working 1: it draws one reading's cone, and csm-discrete takes a beam of each of a cell's nearest poses: \
         leave it out",
    );
    let far = [&map("log.jsonl", "csm-discrete")[..], &["--bounds=-1e15,0,-0.9999999999e15,1e5", "--resolution", "2"]]
        .concat();
    place.refuses(
        &far,
        2,
        "echogrid: --bounds begin at -1000000000000000 m: the counting sensor models map up to 2e6 m from the origin",
    );
    // What has no effect is said.
    let run = [&map("log.jsonl", "csm-discrete")[..], &["--classes", "no.toml"]].concat();
    assert_eq!(place.run(&run).err, "echogrid: --classes has no effect with csm-discrete: it knows no class labels\n");
    let run = [&map("log.jsonl", "csm-continuous")[..], &["--set", "step=0.2"]].concat();
    assert_eq!(place.run(&run).err, "echogrid: --set step has no effect with free=projection\n");
}

#[test]
fn odd_scans_do_no_harm() {
    let place = Place::new();
    let reading = |scan: u32, x: f64, h: f64, z: &str| {
        format!("{{\"scan\":{scan},\"px\":{x},\"py\":0,\"ph\":0,\"x\":{x},\"y\":0,\"h\":{h},\"z\":{z}}}\n")
    };
    let one = HEADER.to_string() + &reading(0, 0.0, 0.0, "1");
    let nowhere = HEADER.to_string() + &reading(0, 0.0, 0.0, "null") + &reading(1, 1.0, 0.0, "2");
    let same = HEADER.to_string() + &(0..40).map(|k| reading(k, 0.0, 0.1 * f64::from(k), "1.5")).collect::<String>();
    let twice = HEADER.to_string() + &reading(0, 0.0, 0.0, "1") + &reading(0, 0.0, 0.0, "2");
    let interleaved =
        HEADER.to_string() + &(0..6).map(|k| reading(k % 2, f64::from(k % 2), 0.1, "1")).collect::<String>();
    for (name, text) in
        [("one", one), ("nowhere", nowhere), ("same", same), ("twice", twice), ("interleaved", interleaved)]
    {
        let log = format!("{name}.jsonl");
        place.write(&log, text);
        for method in ["csm-discrete", "csm-continuous"] {
            let ran = place.does(&["verify", &log, "--method", method, "--set", "r_min=0", "--json"]);
            assert_eq!(ran.json()["passed"], true, "{name} {method}");
        }
    }
}
