//! `echogrid score` as a user runs it: exit codes, JSON, files, errors; and the real log's figures.

use crate::data::data;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn echogrid(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_echogrid")).current_dir(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs, and gives the exit code and standard error.
fn refused(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = echogrid(folder, arguments);
    (output.status.code().unwrap(), text(&output.stderr))
}

/// A ROS map of 5 × 5 cells of `resolution`, its top row first: `#` occupied, `.` empty, `?` unknown.
fn ros(folder: &Path, name: &str, resolution: f64, x0: f64, rows: &str) {
    let pixel = |c: char| match c {
        '#' => 0u8,
        '.' => 254,
        _ => 205,
    };
    let mut picture = b"P5\n5 5\n255\n".to_vec();
    picture.extend(rows.split_whitespace().flat_map(str::chars).map(pixel));
    std::fs::write(folder.join(format!("{name}.pgm")), picture).unwrap();
    let about = format!("image: {name}.pgm\nresolution: {resolution}\norigin: [{x0}, 0.0, 0.0]\nnegate: 0\n");
    std::fs::write(folder.join(format!("{name}.yaml")), about).unwrap();
}

/// A truth, the same map, and one that frees the wall's middle.
fn three() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    ros(folder.path(), "truth", 0.1, 0.0, "????? ##### ..... ..... .....");
    ros(folder.path(), "good", 0.1, 0.0, "????? ##### ..... ..... .....");
    ros(folder.path(), "bad", 0.1, 0.0, "????? ##.## ..... ..... ..#..");
    folder
}

#[test]
fn exit_codes_of_require() {
    let folder = three();
    let run = |maps: &[&str], requires: &[&str]| {
        let mut all = vec!["score", "--truth", "truth.yaml"];
        all.extend(maps);
        requires.iter().for_each(|r| all.extend(["--require", r]));
        refused(folder.path(), &all)
    };
    assert_eq!(run(&["good.yaml", "bad.yaml"], &[]), (0, String::new()));
    assert_eq!(run(&["good.yaml"], &["danger<=0.02", "accuracy>=1"]), (0, String::new()));
    let (code, said) = run(&["good.yaml", "bad.yaml"], &["danger<=0.02", "accuracy>=0.5"]);
    assert_eq!((code, said.as_str()), (1, "echogrid: bad.yaml: danger<=0.02 does not hold: it is 0.200000\n"));
    let (code, said) = run(&["good.yaml"], &["dangre<=0.02"]);
    assert!(code == 2 && said.contains("did you mean \"danger\""), "{code} {said}");
    let (code, said) = run(&["good.yaml"], &["danger"]);
    assert!(code == 2 && said.contains("danger<=0.02"), "{code} {said}");
}

#[test]
fn the_json_names_everything() {
    let folder = three();
    let output = echogrid(folder.path(), &["score", "good.yaml", "bad.yaml", "--truth", "truth.yaml", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let bad = &json["maps"][1];
    assert_eq!((&bad["path"], &bad["method"]), (&"bad.yaml".into(), &"ros".into()));
    assert_eq!(bad["levels"], serde_json::json!([18, 0, 0, 0, 0, 0, 1, 0, 1, 0]));
    assert_eq!(bad["zones"], serde_json::json!({"z1": 18, "z2": 19, "z3": 0, "z4": 1, "z5": 1}));
    for (name, value) in [
        ("o_to_e", 1.0),
        ("occupied_found", 4.0),
        ("accuracy", 0.9),
        ("danger", 0.2),
        ("recall_tolerant", 1.0),
        ("precision_tolerant", 0.8),
        ("brier", 0.1),
        ("auc", (0.8 + 14.0 / 15.0) / 2.0),
        ("ece", 0.1),
    ] {
        let found = bad[name].as_f64().unwrap();
        assert!((found - value).abs() < 1e-9, "{name} {found}, not {value}");
    }
    assert!(bad["log_loss"].as_f64().unwrap() > 1.0 && bad["near"].is_null());
}

#[test]
fn the_report_holds_all_in_one_file() {
    let folder = three();
    let arguments =
        ["score", "good.yaml", "bad.yaml", "--truth", "truth.yaml", "-o", "new/report", "--require", "z5<1"];
    let (code, said) = refused(folder.path(), &arguments);
    assert!(code == 1 && said.contains("score.html"), "{code} {said}");
    let place = folder.path().join("new/report");
    let html = std::fs::read_to_string(place.join("score.html")).unwrap();
    assert_eq!(html.matches("data:image/png;base64,").count(), 6);
    assert_eq!((html.matches("<svg").count(), html.matches("does not hold").count()), (2, 1));
    assert!(!html.contains("src=\"http") && !html.contains("href="));
    let picture = image::open(place.join("bad.yaml.errors.png")).unwrap().to_rgb8();
    // The freed wall is the darkest cell, right cells are white, what isn't compared is no grey.
    let dark = picture.pixels().map(|p| p.0.iter().map(|c| u32::from(*c)).sum::<u32>()).min();
    assert_eq!(dark, Some(120 + 10 + 20));
    assert!(picture.pixels().any(|p| p.0 == [255; 3]) && picture.pixels().any(|p| p.0 == [168, 180, 196]));
    let svg = std::fs::read_to_string(place.join("bad.yaml.levels.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains(">18<"));
}

#[test]
fn what_can_not_be_scored_says_why() {
    let folder = three();
    ros(folder.path(), "fine", 0.05, 0.0, "##### ##### ..... ..... .....");
    ros(folder.path(), "off", 0.1, 0.03, "##### ##### ..... ..... .....");
    ros(folder.path(), "far", 0.1, 7.0, "##### ##### ..... ..... .....");
    std::fs::write(folder.path().join("notes.txt"), "no map").unwrap();
    for (map, code, says) in [
        ("fine.yaml", 2, "--resolution"),
        ("off.yaml", 2, "--bounds"),
        ("far.yaml", 2, "same place"),
        ("notes.txt", 3, "no map"),
        ("gone", 3, "gone"),
        (".", 3, "no echogrid map"),
    ] {
        let (found, said) = refused(folder.path(), &["score", map, "--truth", "truth.yaml"]);
        assert!(found == code && said.contains(says) && said.contains(map.trim_matches('.')), "{map}: {found} {said}");
    }
    for bad in ["0.4,0.6", "0.6", "2,1", "a,b"] {
        assert_eq!(refused(folder.path(), &["score", "good.yaml", "--truth", "truth.yaml", "--decide", bad]).0, 2);
    }
    assert_eq!(refused(folder.path(), &["score", "good.yaml"]).0, 2);
    let (code, said) = refused(folder.path(), &["score", "good.yaml", "--truth", "truth.yaml", "-o", "notes.txt/x"]);
    assert!(code == 5 && said.contains("notes.txt"), "{code} {said}");
}

#[test]
fn ros_maps_as_others_write_them() {
    let folder = three();
    let yaml = "image: good.pgm\nmode: trinary\nresolution: 0.10000000149011612\norigin:\n- 0.0\n- 0.0\n- 1.0e-17\nnegate: 0\n";
    std::fs::write(folder.path().join("dumped.yaml"), yaml).unwrap();
    let run = |map: &str| refused(folder.path(), &["score", map, "--truth", "truth.yaml", "--require", "accuracy>=1"]);
    assert_eq!(run("dumped.yaml"), (0, String::new()));
    std::fs::write(folder.path().join("turned.yaml"), yaml.replace("1.0e-17", "0.3")).unwrap();
    let (code, said) = run("turned.yaml");
    assert!(code == 3 && said.contains("turned maps can't be read"), "{code} {said}");
    std::fs::write(folder.path().join("gone.yaml"), yaml.replace("good.pgm", "gone.pgm")).unwrap();
    let (code, said) = run("gone.yaml");
    assert!(code == 3 && said.contains("gone.yaml names it as its image"), "{code} {said}");
    let (code, said) = run("nothing");
    assert!(code == 3 && said.contains("there is no such map"), "{code} {said}");
    // an origin off the truth's cells: what to map with instead
    ros(folder.path(), "off", 0.1, 0.013, "????? ##### ..... ..... .....");
    let (code, said) = run("off.yaml");
    assert!(code == 2 && said.contains("--bounds 0,0,X1,Y1"), "{code} {said}");
}

#[test]
fn the_real_log_against_its_laser_map() {
    let Some(log) = data("sonar_ring_8/test1") else { return };
    let folder = tempfile::tempdir().unwrap();
    let log = log.to_str().unwrap();
    let map = |sensor: &str, method: &str, more: &[&str]| {
        let fixed = ["map", log, "-r", "0.1", "--backend", "cpu", "--quiet", "--sensor", sensor, "-m", method];
        let output = echogrid(folder.path(), &[&fixed[..], &["-o", method], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    };
    map("laser", "truth", &[]);
    // An independent program's figures with echoes trusted up to 3 m and missing ones freeing 1.5 m: accuracy, tolerant
    // recall, danger. Its danger of bayes, .19, is what `freed` counts (of all walls touched); `danger` (of those that the
    // map decides) is .216. For the other methods the two are one.
    let figures = [
        ("bayes", 0.92, 0.88, 0.19),
        ("dempster-shafer", 0.90, 0.93, 0.22),
        ("certainty", 0.91, 0.78, 0.37),
        ("himm", 0.95, 0.93, 0.26),
    ];
    for (method, accuracy, recall, freed) in figures {
        let names = ["accuracy", "recall_tolerant", "freed", "danger"];
        let scored = || {
            let output = echogrid(folder.path(), &["score", method, "--truth", "truth", "--json"]);
            let json: Value = serde_json::from_slice(&output.stdout).unwrap();
            let found = names.map(|name| json["maps"][0][name].as_f64().unwrap());
            eprintln!("{method}: {names:?} {found:?}");
            found
        };
        map("sonar", method, &["--set", "hit_range=3", "--set", "no_echo_range=1.5"]);
        let wide = scored();
        for ((name, found), expected) in names.iter().zip(wide).zip([accuracy, recall, freed]) {
            assert!((found - expected).abs() < 0.01, "{method}: {name} {found}, not {expected}");
        }
        // the defaults are safer by far, find more walls, and are as accurate
        map("sonar", method, &[]);
        let near = scored();
        assert!(near[0] > wide[0] - 1e-3 && near[1] > wide[1] && near[2] < wide[2] && near[3] < wide[3], "{method}");
    }
}
