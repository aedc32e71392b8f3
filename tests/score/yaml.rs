//! map.yaml in YAML's styles, its values as nav2's map_server takes them, and what is refused by file, line, key and value.

use crate::ros::{CLASSES, YAML, classes, open, place};
use echogrid::ErrorKind;

#[test]
fn every_style_is_the_same_map() {
    let place = place();
    let flow = format!("{{{}}}\n", YAML.trim().replace('\n', ", "));
    let indented: String = YAML.lines().map(|l| format!("  {l}\n")).collect();
    let styles = [
        YAML.to_string(),
        flow.clone(),
        flow.replace(", ", ",\n  "),
        format!("\u{feff}{YAML}"),
        format!("\u{feff}{flow}"),
        indented.clone(),
        format!("---\n{YAML}"),
        format!("---\n{indented}...\n"),
        format!("%YAML 1.2\n---\n{YAML}"),
        format!("# a map\n\n{YAML}\n# its end"),
        YAML.replace('\n', "\r\n"),
        format!("\u{feff}{}", indented.replace('\n', "\r\n")),
        YAML.trim_end().to_string(),
        YAML.replace("[-1.0, -2.0, 0.0]", "[-1.0,\n  -2.0, 0.0]"),
        YAML.replace("[-1.0, -2.0, 0.0]", "[\n  -1.0,\n  -2.0,\n  0.0,\n  ]"),
        YAML.replace("[-1.0, -2.0, 0.0]", "\n  - -1.0\n  - -2.0\n  - 0.0"),
        YAML.replace("[-1.0, -2.0, 0.0]", "\n- -1.0 # x\n- -2.0\n- 0"),
        YAML.replace("[-1.0, -2.0, 0.0]", "['-1', \"-2.00\", 0e0]"),
        YAML.replace("a.pgm", "\"a.pgm\" # the picture"),
        YAML.replace("a.pgm", "'a.pgm'"),
        YAML.replace("a.pgm", "\n  a.pgm"),
        YAML.replace("a.pgm", ">-\n  a.pgm"),
        YAML.replace("image: ", "\"image\":   "),
        YAML.replace("0.05", "5e-2"),
        YAML.replace("0.05", "+.05"),
        YAML.replace("0.05", "!!float \"0.05\""),
        YAML.lines().rev().map(|l| format!("{l}\n")).collect(),
    ];
    for text in styles {
        let ros = open(place.path(), &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!((classes(&ros.map), ros.notes), (CLASSES.to_vec(), vec![]), "{text}");
        let grid = ros.map.grid;
        assert_eq!((grid.x0(), grid.y0(), grid.resolution), (-1.0, -2.0, 0.05), "{text}");
        assert_eq!((grid.width, grid.height), (4, 3));
    }
}

#[test]
fn negate_takes_every_boolean() {
    let place = place();
    // light is occupied, 205 too; the dark greys lie between the thresholds
    let negated = [1, 1, 1, 0, 1, 1, -1, 0, -1, 1, 1, 0];
    let with = |value: &str| {
        let text = YAML.replace("negate: 0", &format!("negate: {value}"));
        classes(&open(place.path(), text).unwrap().map)
    };
    for yes in [
        "1",
        "yes",
        "Yes",
        "YES",
        "true",
        "True",
        "TRUE",
        "on",
        "On",
        "ON",
        "y",
        "Y",
        "\"yes\"",
        "'1'",
        "2",
        "!!bool yes",
    ] {
        assert_eq!(with(yes), negated, "{yes}");
    }
    for no in ["0", "no", "No", "NO", "false", "False", "FALSE", "off", "Off", "OFF", "n", "N", "\"no\"", "'0'", "00"] {
        assert_eq!(with(no), CLASSES, "{no}");
    }
}

#[test]
fn what_is_not_understood_is_refused_by_file_line_key_and_value() {
    let place = place();
    let refused = |text: &str, says: &[&str]| {
        let error = open(place.path(), text).err().unwrap_or_else(|| panic!("taken:\n{text}"));
        let said = error.to_string();
        assert_eq!(error.kind(), ErrorKind::Input, "{said}");
        for word in says {
            assert!(said.contains(word), "{word} isn't in: {said}\n{text}");
        }
        assert!(said.contains("m.yaml"), "{said}");
    };
    let numbers = [
        "0.05m", "5cm", "0,05", "abc", "", "~", ".nan", "nan", ".inf", "inf", "-0.05", "0", "[0.05]", "{a: 1}", "1e400",
    ];
    for value in numbers {
        refused(&YAML.replace("0.05", value), &["m.yaml:2: resolution: ", "metres a pixel, such as 0.05"]);
    }
    refused(&YAML.replace("0.05", "0.05m"), &["\"0.05m\" isn't understood"]);
    refused(&YAML.replace("0.05", "[0.05]"), &["is a list of 1"]);
    refused(&YAML.replace("0.05", ""), &["has no value"]);
    for (origin, says) in [
        ("[-1.0, -2.0m, 0.0]", "\"-2.0m\""),
        ("[-1.0, -2.0, 90deg]", "\"90deg\""),
        ("[1 m, -2.0, 0]", "\"1 m\""),
        ("[-1.0, .nan, 0.0]", "\".nan\""),
        ("[-1.0, -2.0, inf]", "\"inf\""),
        ("[-1.0, ~, 0.0]", "has no value"),
        ("[-1.0, -2.0]", "is a list of 2"),
        ("[]", "is a list of 0"),
        ("[-1.0, -2.0, 0.0, 0.0]", "is a list of 4"),
        ("[[-1.0, -2.0, 0.0]]", "is a list of 3"),
        ("-1.0 -2.0 0.0", "\"-1.0 -2.0 0.0\""),
        ("\"[-1.0, -2.0, 0.0]\"", "isn't understood"),
        ("", "has no value"),
        ("{x: -1.0, y: -2.0}", "is a table"),
    ] {
        let text = YAML.replace("[-1.0, -2.0, 0.0]", origin);
        refused(&text, &["m.yaml:3: origin: ", says, "write [x, y, yaw]"]);
    }
    // the line is the item's
    refused(&YAML.replace("[-1.0, -2.0, 0.0]", "\n  - -1.0\n  - -2.0\n  - 0deg"), &["m.yaml:6: origin: \"0deg\""]);
    for mode in ["bogus", "trinary2", "0", "", "[raw]", "tri nary"] {
        refused(&format!("{YAML}mode: {mode}\n"), &["m.yaml:7: mode: ", "write trinary, scale or raw"]);
    }
    for negate in ["maybe", "1.0", "tru", "", "[1]", "yes no"] {
        refused(
            &YAML.replace("negate: 0", &format!("negate: {negate}")),
            &["m.yaml:4: negate: ", "true, false, yes, no"],
        );
    }
    for threshold in ["65", "65%", "-0.1", "1.1", ".nan", "high", ""] {
        let with = |old: &str| YAML.replace(old, threshold);
        refused(&with("0.65"), &["m.yaml:5: occupied_thresh: ", "from 0 to 1"]);
        refused(&with("0.196"), &["m.yaml:6: free_thresh: ", "from 0 to 1"]);
    }
    refused(&YAML.replace("0.196", "0.7"), &["m.yaml:6: free_thresh 0.7 is above occupied_thresh 0.65"]);
    refused(&YAML.replace("0.65", "0.1"), &["free_thresh 0.196 is above occupied_thresh 0.1"]);
    for image in ["", "~", "''", "[a.pgm]", "{a: b}"] {
        refused(&YAML.replace("a.pgm", image), &["m.yaml:1: image: ", "the picture's file"]);
    }
    for key in ["image", "resolution", "origin"] {
        let without: String = YAML.lines().filter(|l| !l.starts_with(key)).map(|l| format!("{l}\n")).collect();
        refused(&without, &[&format!("it has no \"{key}\"")]);
        let renamed = YAML.replace(key, &key.to_uppercase());
        refused(&renamed, &[&format!("it has no \"{key}\": write that in place of \"{}\"", key.to_uppercase())]);
    }
    for line in YAML.lines() {
        let key = line.split(':').next().unwrap();
        refused(&format!("{YAML}{line}\n"), &["m.yaml:7: ", key, "stands twice, first in line "]);
    }
    for (text, says) in [
        ("", "it has no key"),
        ("# nothing\n", "it has no key"),
        ("---\n...\n", "it has no key"),
        ("- image: a.pgm\n", "m.yaml:1: it is no map_server map.yaml"),
        ("a map\n", "m.yaml:1: it is no map_server map.yaml"),
        ("image: a.pgm\nresolution: [0.05\n", "not YAML"),
        ("image: a.pgm\n\tresolution: 0.05\n", "not YAML"),
        ("image: \"a.pgm\nresolution: 0.05\n", "not YAML"),
        ("image: &a a.pgm\nresolution: *a\n", "m.yaml:2: an alias"),
        ("[a, b]: c\n", "m.yaml:1: a key is no plain word"),
    ] {
        refused(text, &[says]);
    }
    refused(&format!("{}{}", "image: ", "[".repeat(50_000)), &["m.yaml"]);
    refused(&"# long\n".repeat(200_000), &["longer than 1 MiB"]);
    let error = open(place.path(), b"image: a.pgm\nresolution: 0.05 # \xb5\n").unwrap_err().to_string();
    assert!(error.contains("m.yaml:2: is not UTF-8"), "{error}");
}

#[test]
fn what_is_not_read_is_noted() {
    let place = place();
    let notes = |more: &str| open(place.path(), format!("{YAML}{more}")).unwrap().notes.join("\n");
    assert!(
        notes("occupied_threshold: 0.5\n")
            .contains("m.yaml:7: the key \"occupied_threshold\" isn't read; did you mean \"occupied_thresh\"?")
    );
    assert!(notes("Mode: raw\n").contains("did you mean \"mode\"?"));
    assert!(notes("type: {a: [1, {b: 2}]}\n").contains("\"type\" isn't read; the keys are image"));
    assert!(notes("---\nimage: b.pgm\n").contains("m.yaml:7: only the first document"));
}
