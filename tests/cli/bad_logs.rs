//! Logs that can't be mapped, or only in part.

use crate::common::{HEADER, Place, SMALL, line};
use std::io::Write;

const KNOWN: &str = "Known are: a sonar_ring_8 folder (sonar.txt or measurement.txt or laser.txt, with od.txt or \
                     poses.txt); echogrid's JSON Lines (first line {\"echogrid_log\":1,\"sensors\":[…]}); echogrid's CSV \
                     (a row of names: t,scan,sensor,px,py,ph,z); a ROS topic as CSV (rostopic echo -p, ros2 topic echo \
                     --csv: LaserScan or Range, with --poses); an ARIA laser log (.2d, LaserOdometryLog); a Player log \
                     (writelog: time host robot interface index …); a robotdata log of CMU's course 16-833 (L and O lines, \
                     centimetres); a CARMEN text log (FLASER, RLASER, ROBOTLASER1 or other laser lines), plain or gzip; a MATLAB .mat \
                     file (version 5 to 7) of poses and scans; an Octave text file (save -text) of poses and scans";

fn gz(text: &str) -> Vec<u8> {
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(text.as_bytes()).unwrap();
    gz.finish().unwrap()
}

/// Every command that takes a log gives the same message and code.
#[track_caller]
fn refused(place: &Place, log: &str, code: i32, message: &str) {
    place.refuses(&["map", log, "-o", "deep/down/out"], code, message);
    place.refuses(&["plan", log], code, message);
    place.refuses(&["verify", log, "--backends", "cpu"], code, message);
}

#[test]
fn no_log() {
    let place = Place::new();
    place.write("empty.log", "");
    place.write("empty.gz", gz(""));
    std::fs::create_dir(place.path("folder")).unwrap();
    refused(&place, "nosuch.log", 3, "echogrid: nosuch.log: no such file or folder");
    refused(&place, "empty.log", 3, "echogrid: empty.log: is empty");
    refused(&place, "empty.gz", 3, "echogrid: empty.gz: is empty once unpacked");
    refused(&place, "-", 3, "echogrid: <stdin>: is empty");
    refused(&place, "folder", 3, &format!("echogrid: folder: no log in this folder: it holds no file. {KNOWN}"));
}

#[test]
fn noise_and_prose() {
    let place = Place::new();
    let noise: Vec<u8> = (0..5000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    place.write("noise.log", noise);
    place.write("prose.log", "Dear diary,\n");
    refused(&place, "noise.log", 3, &format!("echogrid: noise.log: is binary, not a log. {KNOWN}"));
    let what = "is of no known format; line 1 is 'Dear diary,'. A table is read with its columns named, --columns \
                t,x,y,heading,range (docs/formats.md)";
    refused(&place, "prose.log", 3, &format!("echogrid: prose.log: {what}. {KNOWN}"));
}

#[test]
fn a_truncated_gzip_names_its_line() {
    let place = Place::new();
    let text: String = (0..20_000).map(|i| line(&format!("0.{}", i * 7919 % 10_007), "1.5")).collect();
    let packed = gz(&format!("{HEADER}{text}"));
    place.write("cut.gz", &packed[..packed.len() / 2]);
    let before = place.names("");
    let ran = place.run(&["map", "cut.gz", "-o", "out"]);
    assert_eq!(ran.code, 3);
    let rest = ran.err.strip_prefix("echogrid: cut.gz:").unwrap();
    let (number, what) = rest.split_once(": ").unwrap();
    assert!((5_000..15_000).contains(&number.parse::<u32>().unwrap()), "{number}");
    assert_eq!(
        what,
        "the compressed log is truncated here: fetch it again, or save its whole lines with `gzip -dc FILE > part.log` \
         and map those\n"
    );
    assert_eq!(place.names(""), before);
    place.write("stub.gz", &packed[..5]);
    refused(
        &place,
        "stub.gz",
        3,
        "echogrid: stub.gz: the compressed log is truncated here: fetch it again, or save its whole lines with \
         `gzip -dc FILE > part.log` and map those",
    );
}

#[test]
fn a_log_without_a_reading() {
    let place = Place::new();
    place.write("header.jsonl", HEADER);
    refused(&place, "header.jsonl", 3, "echogrid: header.jsonl: holds no reading");
    place.write("bad.jsonl", format!("{HEADER}{}one\ntwo\n", line("1e7", "1")));
    refused(
        &place,
        "bad.jsonl",
        3,
        "echogrid: bad.jsonl: holds no reading; 3 bad lines, the first: line 2: the robot's x is 10000000 m, farther \
         than 1e6 m from the origin",
    );
}

#[test]
fn a_log_whose_readings_are_all_rejected() {
    let place = Place::new();
    let lines: String = ["-1", "0.01", "\"NaN\"", "null", "\"inf\"", "9"].map(|z| line("0", z)).concat();
    place.write("all.jsonl", format!("{HEADER}{lines}"));
    refused(
        &place,
        "all.jsonl",
        3,
        "echogrid: all.jsonl: none of its 6 readings can be mapped: 3 without echo (no_echo_range is 0), 1 nearer than \
         r_min, 1 negative, 1 not a number; check --sensor and the sensors' ranges (--set r_min=…, hit_range=…, \
         no_echo_range=…)",
    );
    // What the message says helps.
    place.does(&["map", "all.jsonl", "-o", "out", "--set", "no_echo_range=1", "--backend", "cpu"]);
    assert_eq!(place.report("out")["readings"]["used"], 3);
}

#[test]
fn readings_that_are_no_ranges_are_counted_and_the_map_is_whole() {
    let place = Place::new();
    let ran = place.map("out", &[]);
    let said: Vec<&str> = ran.out.lines().take(6).collect();
    let why = [
        "4 of 8 readings mapped, from 4 scans",
        "  2 without echo (each frees up to no_echo_range, 1 m)",
        "  1 beyond hit_range (3 m): echoes from so far are not trusted; --set hit_range=4 takes all",
        "  1 nearer than r_min (20 cm)",
        "  1 not a number",
        "  1 negative",
    ];
    assert_eq!(said, why);
    let rejected = &place.report("out")["readings"]["rejected"];
    for reason in ["below_r_min", "not_a_number", "negative", "beyond_hit_range"] {
        assert_eq!(rejected[reason], 1, "{reason}");
    }
}

fn with_bad_lines() -> String {
    let good = line("0", "1");
    format!("{HEADER}{good}{}{}{}garbage\n{good}", line("1e7", "1"), line("\"NaN\"", "1"), line("0", "NaN"))
}

const BAD_LINES: &str = "echogrid: bad.jsonl: 4 bad lines were left out; the first:
  line 3: the robot's x is 10000000 m, farther than 1e6 m from the origin
  line 4: the robot's x is NaN
  line 5: expected value (column 36); JSON has no bare NaN or Infinity: write \"NaN\", or null for no echo
  (mend them, or give --strict to write nothing then; the exit code is 6)
";

#[test]
fn bad_lines_are_told_once_and_change_the_exit_code() {
    let place = Place::new();
    place.write("bad.jsonl", with_bad_lines());
    for quiet in [&["--quiet"][..], &["--json"], &[]] {
        let ran = place.run(&[&["map", "bad.jsonl", "-o", "out", "--backend", "cpu"], quiet].concat());
        assert_eq!((ran.code, ran.err.as_str()), (6, BAD_LINES));
    }
    let report = place.report("out");
    assert_eq!(report["readings"]["used"], 2);
    assert_eq!(report["bad_lines"]["count"], 4);
    assert_eq!(report["bad_lines"]["first"].as_array().unwrap().len(), 3);
    assert_eq!(report["bad_lines"]["first"][1], "line 4: the robot's x is NaN");
    for command in [&["plan", "bad.jsonl"][..], &["verify", "bad.jsonl", "--backends", "cpu"]] {
        let ran = place.run(command);
        assert_eq!((ran.code, ran.err.as_str()), (6, BAD_LINES), "{command:?}");
    }
    // Lines after the last reading that is wanted are not read.
    let ran = place.run(&["map", "bad.jsonl", "-o", "out", "--backend", "cpu", "--until", "1"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
}

#[test]
fn strict_takes_no_bad_line() {
    let place = Place::new();
    place.write("bad.jsonl", with_bad_lines());
    let message = "echogrid: bad.jsonl: line 3: the robot's x is 10000000 m, farther than 1e6 m from the origin, the \
                   first of 4 bad lines; mend it, or leave out --strict";
    place.refuses(&["map", "bad.jsonl", "-o", "out", "--strict"], 3, message);
    place.refuses(&["plan", "bad.jsonl", "--strict"], 3, message);
    place.refuses(&["verify", "bad.jsonl", "--strict"], 3, message);
    place.map("out", &["--strict"]);
}

#[test]
fn a_line_of_ten_megabytes() {
    let place = Place::new();
    let long = "x".repeat(10_000_000);
    place.write("long.jsonl", format!("{SMALL}{long}\n{}", line("0", "1")));
    let ran = place.run(&["map", "long.jsonl", "-o", "out", "--backend", "cpu", "--json"]);
    assert_eq!(
        (ran.code, ran.err.as_str()),
        (
            6,
            "echogrid: long.jsonl: 1 bad line was left out:\n  line 10: longer than 1 MiB\n  (mend them, or give \
             --strict to write nothing then; the exit code is 6)\n"
        )
    );
    assert_eq!(ran.json()["readings"]["used"], 5);
    place.refuses(
        &["map", "long.jsonl", "-o", "other", "--strict"],
        3,
        "echogrid: long.jsonl: line 10: longer than 1 MiB; mend it, or leave out --strict",
    );
    place.write("first.jsonl", format!("{{{long}"));
    refused(&place, "first.jsonl", 3, "echogrid: first.jsonl:1: longer than 1 MiB");
}

#[test]
fn a_pose_that_jumps_is_named_where_it_makes_the_grid_too_large() {
    let place = Place::new();
    let far = "{\"scan\":1,\"px\":9e5,\"py\":9e5,\"ph\":0,\"z\":1}\n";
    place.write("jump.jsonl", format!("{HEADER}{}{far}{}", line("0", "1"), line("0", "1")));
    refused(
        &place,
        "jump.jsonl",
        3,
        "echogrid: jump.jsonl:3: the robot's pose jumps 1272792 m, to (900000, 900000); if that is wrong, give --bounds. \
         a grid of 18000021 × 18000012 cells of 0.05 m, starting 6 cells from its anchor, is more than 16777216 cells an \
         axis: give --bounds nearer the robot or a coarser --resolution",
    );
    // Within the integers, but not within memory.
    let far = "{\"scan\":1,\"px\":5e5,\"py\":5e5,\"ph\":0,\"z\":1}\n";
    place.write("jump.jsonl", format!("{HEADER}{}{far}{}", line("0", "1"), line("0", "1")));
    for (command, what) in [
        (&["map", "jump.jsonl", "-o", "out"][..], "the files of a map of 10000021 × 10000012 cells of 0.05 m take "),
        (&["verify", "jump.jsonl"], "a map of 10000021 × 10000012 cells of 0.05 m needs "),
    ] {
        let ran = place.run(command);
        assert_eq!(ran.code, 3);
        let start = "echogrid: jump.jsonl:3: the robot's pose jumps 707107 m, to (500000, 500000); if that is wrong, give \
                     --bounds. ";
        assert!(ran.err.starts_with(&format!("{start}{what}")), "{}", ran.err);
        assert!(ran.err.contains(" TiB"), "{}", ran.err);
        assert!(ran.err.ends_with(": give smaller --bounds or a coarser --resolution\n"), "{}", ran.err);
    }
    assert!(!place.path("out").exists() && !place.path("out.partial").exists());
    // What the message says helps, at any resolution: the far reading lies outside and is decided nowhere.
    for resolution in ["0.05", "1mm"] {
        let bounds = ["--bounds", "-1,-1,3,1", "--resolution", resolution];
        let ran = place.does(&[&["map", "jump.jsonl", "-o", "out", "--backend", "cpu"], &bounds[..]].concat());
        assert!(ran.out.starts_with("3 of 3 readings mapped, from 3 scans\n  1 outside --bounds\n"), "{}", ran.out);
        let ran = place.does(&[&["verify", "jump.jsonl", "--json"], &bounds[..]].concat());
        assert!(ran.json()["backends"].as_array().unwrap().iter().all(|b| b["counts"] == 0), "{ran:?}");
    }
}

#[test]
fn a_pose_that_jumps_is_told_where_the_grid_still_fits() {
    let place = Place::new();
    let far = "{\"scan\":1,\"px\":0,\"py\":150,\"ph\":0,\"z\":1}\n";
    place.write("jump.jsonl", format!("{HEADER}{}{far}{}", line("0", "1"), line("0", "1")));
    let warning = "echogrid: jump.jsonl:3: the robot's pose jumps 150 m, to (0, 150), and the grid follows it; if that is \
                   wrong, mend the line or give --bounds\n";
    let coarse = ["--resolution", "0.5"];
    for command in [
        &["map", "jump.jsonl", "-o", "out", "--backend", "cpu", "--quiet"][..],
        &["plan", "jump.jsonl"],
        &["verify", "jump.jsonl", "--backends", "cpu"],
    ] {
        assert_eq!(place.does(&[command, &coarse].concat()).err, warning, "{command:?}");
        assert_eq!(place.does(&[command, &coarse, &["--bounds", "-1,-1,3,1"]].concat()).err, "", "{command:?}");
    }
    let near = "{\"scan\":1,\"px\":0,\"py\":99,\"ph\":0,\"z\":1}\n";
    place.write("near.jsonl", format!("{HEADER}{}{near}", line("0", "1")));
    assert_eq!(place.does(&["plan", "near.jsonl", "--resolution", "0.5"]).err, "");
}

#[test]
fn sensors_that_do_not_fit() {
    let place = Place::new();
    let no_laser = "echogrid: log.jsonl:1: the log has no laser sensor, only sonars: leave out --sensor laser (method truth needs \
                    a laser log)";
    place.refuses(&["map", "log.jsonl", "-o", "out", "--sensor", "laser"], 3, no_laser);
    place.refuses(&["map", "log.jsonl", "-o", "out", "--method", "truth"], 3, no_laser);
    place.refuses(
        &["map", "log.jsonl", "-o", "out", "--method", "truth", "--sensor", "sonar"],
        2,
        "echogrid: method truth takes the nearest beam of each laser scan: leave out --sensor sonar",
    );
    place.write("two.toml", "[[sensor]]\nid = \"a\"\n[[sensor]]\nid = \"b\"\n");
    place.write("key.toml", "[[sensor]]\nr_mxa = 3\n");
    place.write("none.toml", "[all]\nr_max = 3\n");
    place.write("range.toml", "[[sensor]]\nr_max = \"10cm\"\n");
    for (file, message) in [
        ("two.toml", "two.toml: describes 2 sensors, but the log has 1 (front)"),
        ("key.toml", "key.toml:2: unknown key \"r_mxa\"; did you mean \"r_max\"?"),
        ("none.toml", "none.toml: no [[sensor]] table: a sensor file has one for each sensor of the log"),
        ("range.toml", "range.toml: sensor front: r_min 0.2 m must be below r_max 0.1 m"),
        #[cfg(unix)]
        ("nosuch.toml", "nosuch.toml: sensor file: No such file or directory (os error 2)"),
    ] {
        place.refuses(&["map", "log.jsonl", "-o", "out", "--sensor-file", file], 3, &format!("echogrid: {message}"));
    }
}
