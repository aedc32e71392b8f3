//! What a sensor's limits and its width do to a map: ranges at the maximum, narrow beams, doubts, defaults by kind of sensor.

use crate::common::{Place, Ran, data};
use serde_json::{Value, json};

/// A log of one sensor; `z` for each reading from one place, turned a little from reading to reading.
fn log(sensor: &str, ranges: impl Iterator<Item = f64>) -> String {
    let mut text = format!("{{\"echogrid_log\":1,\"sensors\":[{{\"id\":\"s\",{sensor}}}]}}\n");
    for (k, z) in ranges.enumerate() {
        text += &format!("{{\"scan\":{k},\"px\":0,\"py\":0,\"ph\":{},\"z\":{z}}}\n", 0.01 * k as f64);
    }
    text
}

fn mapped(place: &Place, text: &str, more: &[&str]) -> (Ran, Value) {
    place.write("s.jsonl", text);
    let ran = place.does(&[&["map", "s.jsonl", "-o", "out", "--backend", "cpu"], more].concat());
    (ran, place.report("out"))
}

#[test]
fn a_range_of_just_the_maximum_is_no_echo_unless_the_sensor_says_so() {
    let place = Place::new();
    // A sonar that reports its maximum where it hears nothing, as two in a public log do.
    let ranges = || (0..200).map(|k| if k % 8 == 0 { 0.05 + 0.0004 * f64::from(k) } else { 0.15 });
    let sensor = r#""r_min":0,"r_max":0.15,"no_echo_range":0.15,"half_width":0.5"#;
    let (ran, report) = mapped(&place, &log(sensor, ranges()), &["-r", "0.02"]);
    assert_eq!((&report["readings"]["no_echo"], &report["readings"]["used"]), (&json!(175), &json!(200)));
    assert_eq!(report["sensors"][0]["at_r_max"], "no_echo");
    assert_eq!(ran.err, "");
    let silent = report["cells"]["occupied"].as_u64().unwrap();

    // Told that they are echoes they are, and the heap of equal values is doubted; --set beats the header.
    let hit = format!("{sensor},\"at_r_max\":\"hit\"");
    let (ran, report) = mapped(&place, &log(&hit, ranges()), &["-r", "0.02"]);
    assert_eq!((&report["readings"]["no_echo"], &report["sensors"][0]["at_r_max"]), (&json!(0), &json!("hit")));
    assert!(report["cells"]["occupied"].as_u64().unwrap() > 2 * silent, "{report}");
    let doubt = "s.jsonl: 175 of 200 ranges of sensor s are just 0.15 m, its largest range: most likely they mean that nothing \
                 was heard; if so, say so: --set r_max=0.15 --set at_r_max=no_echo";
    assert_eq!(ran.err.trim_end(), format!("echogrid: {doubt}"));
    assert_eq!(report["log"]["notes"], json!([doubt.trim_start_matches("s.jsonl: ")]));
    let (ran, report) = mapped(&place, &log(&hit, ranges()), &["-r", "0.02", "--set", "at_r_max=no_echo"]);
    assert_eq!((&report["readings"]["no_echo"], ran.err.as_str()), (&json!(175), ""));
}

#[test]
fn a_heap_below_the_maximum_is_doubted_and_walls_are_not() {
    let place = Place::new();
    let sensor = r#""r_min":0,"r_max":6"#;
    let heap = |top: f64| move |k: i32| if k % 3 == 0 { top } else { 0.5 + 0.0131 * f64::from(k) };
    let (ran, _) = mapped(&place, &log(sensor, (0..150).map(heap(2.55))), &[]);
    assert!(ran.err.contains("50 of 150 ranges of sensor s are just 2.55 m"), "{}", ran.err);
    // What the message says helps.
    let remedy = ["--set", "r_max=2.55", "--set", "at_r_max=no_echo"];
    let (ran, report) = mapped(&place, &log(sensor, (0..150).map(heap(2.55))), &remedy);
    assert_eq!((ran.err.as_str(), &report["readings"]["no_echo"]), ("", &json!(50)));
    // A robot that drives along walls hears each range a few times; one that stands before a wall hears one, and nothing else.
    let walls = |k: i32| 1.0 + 0.01 * f64::from(k % 40);
    for ranges in [Box::new(walls) as Box<dyn Fn(i32) -> f64>, Box::new(|_| 1.5)] {
        let (ran, _) = mapped(&place, &log(sensor, (0..200).map(ranges)), &[]);
        assert_eq!(ran.err, "");
    }
    // A log that marks silence itself has no other mark for it.
    let marked = log(sensor, (0..150).map(heap(2.55))) + "{\"scan\":150,\"px\":0,\"py\":0,\"ph\":0,\"z\":null}\n";
    assert_eq!(mapped(&place, &marked, &[]).0.err, "");
}

#[test]
fn a_declared_maximum_that_the_log_exceeds_is_doubted() {
    let place = Place::new();
    let far = || (0..300).map(|k| 2.0 + 0.077 * f64::from(k));
    let sensor = r#""kind":"laser","r_max":10"#;
    let (ran, report) = mapped(&place, &log(sensor, far()), &["-r", "0.2"]);
    assert_eq!(report["readings"]["no_echo"], 196);
    let doubt = "echogrid: s.jsonl: 196 of 300 ranges of sensor s lie beyond its r_max of 10 m, up to 25.0 m, and count as \
                 without echo; if the sensor sees that far, say so: --set r_max=26";
    assert_eq!(ran.err.trim_end(), doubt);
    let (ran, report) = mapped(&place, &log(sensor, far()), &["-r", "0.2", "--set", "r_max=26"]);
    assert_eq!((ran.err.as_str(), &report["readings"]["used"]), ("", &json!(300)));
    // Codes beyond the maximum are a few values, however many readings have them.
    let codes = (0..300).map(|k| if k % 2 == 0 { 81.83 + f64::from(k % 3) } else { 4.0 });
    assert_eq!(mapped(&place, &log(sensor, codes), &["-r", "0.2"]).0.err, "");
    // Where nothing is left to map, the error says why.
    place.write("s.jsonl", log(sensor, (0..40).map(|k| 25.0 + 0.01 * f64::from(k))));
    let ran = place.run(&["map", "s.jsonl", "-o", "none"]);
    assert_eq!(ran.code, 3);
    assert!(ran.err.contains("40 of 40 ranges of sensor s lie beyond its r_max of 10 m"), "{}", ran.err);
}

#[test]
fn narrow_sonars_leave_no_holes() {
    let place = Place::new();
    let one = r#""half_width":"1deg","r_min":0.02,"r_max":4"#;
    let (ran, report) = mapped(&place, &log(one, [1.02].into_iter()), &["-r", "0.1"]);
    let counts = &report["readings"];
    assert_eq!((&counts["outside"], &counts["empty_arc"], ran.err.as_str()), (&json!(0), &json!(0), ""));
    let cells = |name: &str| report["cells"][name].as_u64().unwrap();
    // The axis runs between two rows, both within half a cell of it; R ± ε of one cell holds two columns' centres, 0.95 and 1.05 m.
    assert_eq!((cells("occupied"), cells("empty")), (4, 18), "{report}");
    for half_width in ["0.5deg", "0.8deg", "1.15deg", "2deg", "3deg"] {
        for resolution in ["0.05", "0.1"] {
            let sensor = format!("\"half_width\":\"{half_width}\",\"r_min\":0.1,\"r_max\":6");
            let ranges = (0..600).map(|k| 0.3 + 0.0077 * f64::from(k % 500));
            let (_, report) = mapped(&place, &log(&sensor, ranges), &["-r", resolution]);
            let counts = &report["readings"];
            let lost = [&counts["outside"], &counts["empty_arc"]];
            assert_eq!(lost, [&json!(0), &json!(0)], "{half_width} in {resolution} m");
        }
    }
    // All methods and backends agree on what such a beam reaches.
    for method in ["certainty", "dempster-shafer", "bayes"] {
        place.does(&["verify", "s.jsonl", "-r", "0.1", "-m", method, "--backends", "oracle,cpu"]);
    }
}

#[test]
fn bayes_takes_the_model_that_fits_the_sensor() {
    let place = Place::new();
    let ranges = || (0..60).map(|k| 2.0 + 0.01 * f64::from(k));
    for (kind, set, model) in [
        ("laser", None, "constant"),
        ("sonar", None, "murphy"),
        ("laser", Some("model=murphy"), "murphy"),
        ("sonar", Some("model=constant"), "constant"),
    ] {
        let set: Vec<&str> = set.iter().flat_map(|s| ["--set", s]).collect();
        let (ran, report) = mapped(&place, &log(&format!("\"kind\":\"{kind}\""), ranges()), &set);
        assert_eq!((&report["parameters"]["model"], ran.err.as_str()), (&json!(model), ""), "{kind} {set:?}");
        assert_eq!(ran.out.contains("bayes (model constant)"), model == "constant", "{}", ran.out);
        assert_eq!(ran.out.contains("hint: "), kind == "laser" && model == "murphy", "{}", ran.out);
    }
    // p_hit has an effect where constant is the default, and none where murphy is.
    let (ran, _) = mapped(&place, &log("\"kind\":\"laser\"", ranges()), &["--set", "p_hit=0.8"]);
    assert_eq!(ran.err, "");
    let (ran, _) = mapped(&place, &log("\"kind\":\"sonar\"", ranges()), &["--set", "p_hit=0.8"]);
    assert_eq!(ran.err, "echogrid: --set p_hit has no effect with model=murphy\n");
}

/// What of the grid the readings touch, and whether an ample grid around it shows a cell more.
#[track_caller]
fn fits(place: &Place, arguments: &[&str], least: f64) {
    let map = |out: &str, more: &[&str]| {
        place.does(&[&["map"], arguments, &["-o", out, "--backend", "cpu", "--quiet"], more].concat());
        place.report(out)
    };
    let tight = map("tight", &[]);
    let number = |report: &Value, key: &str| report["cells"][key].as_f64().unwrap();
    let r = number(&tight, "resolution");
    let (x0, y0) = (number(&tight, "x0"), number(&tight, "y0"));
    let (x1, y1) = (x0 + r * number(&tight, "width"), y0 + r * number(&tight, "height"));
    let ample = format!("{},{},{},{}", x0 - 20.0 * r, y0 - 20.0 * r, x1 + 20.0 * r, y1 + 20.0 * r);
    let ample = map("ample", &[&format!("--bounds={ample}")]);
    assert_eq!(tight["updates"], ample["updates"], "{arguments:?}: the default bounds lose cells");
    for key in ["touched", "occupied", "empty"] {
        assert_eq!(tight["cells"][key], ample["cells"][key], "{arguments:?}: {key}");
    }
    let share = number(&tight, "touched") / (number(&tight, "width") * number(&tight, "height"));
    assert!(share > least, "{arguments:?} touches {share} of its grid");
}

#[test]
fn the_default_bounds_hold_what_is_reached_and_little_else() {
    let place = Place::new();
    place.does(&["simulate", "WORLD", "-o", "room.jsonl", "--seed", "1"].map(|a| if a == "WORLD" { ROOM } else { a }));
    // himm takes the cells on the axis alone.
    for (method, least) in [("bayes", 0.4), ("certainty", 0.4), ("himm", 0.1)] {
        fits(&place, &["room.jsonl", "-m", method], least);
    }
    fits(&place, &["room.jsonl", "-m", "features"], 0.15);
    let scans: String = (0..40)
        .map(|k| {
            let ray = |b: i32| {
                format!(
                    "{{\"scan\":{k},\"px\":{},\"py\":0,\"ph\":{},\"z\":{}}}\n",
                    0.05 * f64::from(k),
                    0.02 * f64::from(b),
                    2.0 + 0.1 * f64::from(b % 9)
                )
            };
            (-40..40).map(ray).collect::<String>()
        })
        .collect();
    place.write(
        "laser.jsonl",
        format!("{{\"echogrid_log\":1,\"sensors\":[{{\"id\":\"s\",\"kind\":\"laser\"}}]}}\n{scans}"),
    );
    for method in ["csm-discrete", "csm-continuous", "truth"] {
        fits(&place, &["laser.jsonl", "-m", method, "-r", "0.02"], 0.4);
    }
    // One beam along an axis: no more than a cell on each side of it, and ε beyond its end.
    place.write("s.jsonl", log(r#""kind":"laser""#, [20.0].into_iter()));
    place.does(&["map", "s.jsonl", "-o", "beam", "-r", "0.1", "--backend", "cpu"]);
    let cells = &place.report("beam")["cells"];
    assert_eq!((&cells["height"], cells["width"].as_u64().unwrap() <= 204), (&json!(2), true), "{cells}");
    // One cone that looks up: from the sensor to R + ε, and as wide as its edges are there.
    let text = "{\"echogrid_log\":1,\"sensors\":[{\"id\":\"s\",\"half_width\":\"30deg\"}]}\n\
                {\"scan\":0,\"px\":0,\"py\":0,\"ph\":1.5707963267948966,\"z\":1.9}\n";
    place.write("s.jsonl", text);
    place.does(&["map", "s.jsonl", "-o", "cone", "-r", "0.1", "--backend", "cpu"]);
    let cells = &place.report("cone")["cells"];
    assert_eq!([&cells["x0"], &cells["y0"]], [&json!(-1.0), &json!(0.0)], "{cells}");
    assert_eq!([&cells["width"], &cells["height"]], [&json!(20), &json!(20)], "{cells}");
    if let (Some(intel), Some(test1)) = (data("carmen_corrected/intel-corrected.log.gz"), data("sonar_ring_8/test1")) {
        fits(&place, &[intel.to_str().unwrap(), "-r", "0.1"], 0.25);
        fits(&place, &[test1.to_str().unwrap(), "--sensor", "laser", "-r", "0.1"], 0.2);
        fits(&place, &[test1.to_str().unwrap(), "-r", "0.1"], 0.25);
    }
}

const ROOM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/worlds/room.toml");

#[test]
fn units_and_poses_that_are_most_likely_wrong_are_told() {
    let place = Place::new();
    // A robot that turns while it drives along x, in a room of 3 m; `turn`: its heading's step, `unit`: of the ranges.
    let table = |turn: f64, around: f64, unit: f64, jump: f64| -> String {
        let row = |k: i32| {
            let t = f64::from(k);
            let x = 0.05 * t + if k > 60 { jump } else { 0.0 };
            format!("{t},{x},0,{},{}\n", (turn * t) % around, (1.0 + 0.01 * f64::from(k % 97)) * unit)
        };
        "t,x,y,heading,range\n".to_string() + &(0..120).map(row).collect::<String>()
    };
    let said = |text: String| {
        place.write("t.csv", text);
        let columns = ["--columns", "t,x,y,heading,range", "-r", "0.1", "--backend", "cpu", "-q", "--sensor", "sonar"];
        place.run(&[&["map", "t.csv", "-o", "t"][..], &columns].concat()).err
    };
    let tau = std::f64::consts::TAU;
    assert_eq!(said(table(0.2, tau, 1.0, 0.0)), "");
    assert!(said(table(11.5, 360.0, 1.0, 0.0)).contains("most likely they are degrees"));
    assert!(said(table(0.2, tau, 100.0, 0.0)).contains("most likely they are not metres; say their unit (range:cm"));
    assert!(said(table(0.2, tau, 1.0, 8.0)).contains("t.csv:63: the robot's pose jumps 8 m"));
    // Zeros are silence to many sonars.
    let zeros = |each: usize| -> String {
        let row = |(k, line): (usize, &str)| match k % each == 1 {
            true => format!("{},0\n", line.rsplit_once(',').unwrap().0),
            false => format!("{line}\n"),
        };
        table(0.2, tau, 1.0, 0.0).lines().enumerate().map(row).collect()
    };
    assert_eq!(said(zeros(60)), "");
    assert!(
        said(zeros(4))
            .contains("30 of 120 ranges of sensor sensor are 0, which many sonars write where nothing was heard")
    );
    // A plain 90 in a sensor file is no right angle.
    place.write("s.toml", "[[sensor]]\naxis = 90\n");
    let ran = place.run(&["map", "t.csv", "-o", "t", "--columns", "t,x,y,heading,range", "--sensor-file", "s.toml"]);
    assert_eq!(
        (ran.code, ran.err.contains("s.toml:2: axis = 90: axis is in radians: write \"90deg\"")),
        (3, true),
        "{ran:?}"
    );
}
