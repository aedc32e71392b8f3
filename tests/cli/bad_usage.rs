//! Methods, parameters and options that don't exist or can't be meant: exit code 2, before anything is touched.

use crate::common::Place;

const BAYES: &str = "model, max_occ, region_one_floor, region_two_floor, p_hit, p_miss, p_occupied, p_empty, beta, r_min, \
                     r_max, at_r_max, hit_range, no_echo_range, epsilon, fov, first_beam, mounts";

#[track_caller]
fn refused(more: &[&str], message: &str) {
    let place = Place::new();
    for command in [&["map", "log.jsonl", "-o", "deep/out"][..], &["plan", "log.jsonl"], &["verify", "log.jsonl"]] {
        place.refuses(&[command, more].concat(), 2, &format!("echogrid: {message}"));
    }
}

/// An option that the parser itself refuses: its own first line, then the way to the help.
#[track_caller]
fn mistyped(more: &[&str], message: &str) {
    let place = Place::new();
    place.refuses(
        &[&["map", "log.jsonl", "-o", "out"], more].concat(),
        2,
        &format!("error: {message}\n\nFor more information, try '--help'."),
    );
}

#[test]
fn methods() {
    let there_are = "there are certainty, dempster-shafer, bayes, himm, truth, csm-discrete, csm-continuous, \
                     csm-semantic-discrete, csm-semantic-continuous, features";
    refused(&["-m", "baye"], &format!("there is no method \"baye\"; did you mean \"bayes\"? {there_are}"));
    refused(
        &["-m", "demster"],
        &format!("there is no method \"demster\"; did you mean \"dempster-shafer\"? {there_are}"),
    );
    refused(&["-m", "elfes"], &format!("there is no method \"elfes\"; did you mean \"certainty\"? {there_are}"));
    refused(&["-m", "log-odds"], &format!("there is no method \"log-odds\"; did you mean \"bayes\"? {there_are}"));
    refused(&["-m", "xyz"], &format!("there is no method \"xyz\"; {there_are}"));
    let place = Place::new();
    place.refuses(
        &["bench", "-m", "himn"],
        2,
        &format!("echogrid: there is no method \"himn\"; did you mean \"himm\"? {there_are}"),
    );
}

#[test]
fn parameters() {
    refused(
        &["--set", "bta=1"],
        &format!("--set bta=1: bayes has no parameter \"bta\"; did you mean \"beta\"? there are {BAYES}"),
    );
    refused(
        &["--set", "max_range=3"],
        &format!("--set max_range=3: bayes has no parameter \"max_range\"; did you mean \"r_max\"? there are {BAYES}"),
    );
    refused(
        &["--set", "rho=1/n"],
        &format!("--set rho=1/n: bayes has no parameter \"rho\", dempster-shafer has; there are {BAYES}"),
    );
    refused(&["--set", "beta"], "--set beta has no value: write --set key=value");
    refused(&["--set", "beta=90deg"], "--set beta=90deg: beta takes 0 to 60deg (1.0472)");
    refused(
        &["--set", "beta=wide"],
        "--set beta=wide: beta takes an angle: a number in radians, or one that ends in deg",
    );
    refused(
        &["--set", "r_max=5ft"],
        "--set r_max=5ft: r_max takes a length: a number in metres, or one that ends in mm, cm or m",
    );
    refused(&["--set", "r_max=-1"], "--set r_max=-1: r_max takes more than 0, up to 1e6 m");
    refused(&["--set", "r_min=9"], "--set: sensor front: r_min 9 m must be below r_max 4 m");
    refused(&["--set", "mounts=some"], "--set mounts=some: mounts takes preset or none");
    refused(&["--set", "p_hit=nan"], "--set p_hit=nan: p_hit takes 0.02..0.98");
    refused(&["-m", "dempster-shafer", "--set", "rho=2"], "--set rho=2: rho takes 1/n|0..1");
    refused(&["-m", "certainty", "--set", "order=sideways"], "--set order=sideways: order takes sequential|batch");
}

#[test]
fn parameters_without_effect_are_told() {
    let place = Place::new();
    let plan = |more: &[&str]| place.does(&[&["plan", "log.jsonl"], more].concat()).err;
    for (method, set, idle) in [
        (
            "bayes",
            &["p_hit=0.7", "p_miss=0.4"][..],
            &["p_hit has no effect with model=murphy", "p_miss has no effect with model=murphy"][..],
        ),
        ("bayes", &["model=constant", "max_occ=0.9", "p_hit=0.7"], &["max_occ has no effect with model=constant"]),
        ("bayes", &["region_one_floor=0", "beta=10deg"], &[]),
        ("dempster-shafer", &["model=murphy", "rho=0.5"], &["rho has no effect with model=murphy"]),
        ("dempster-shafer", &["max_occ=0.5", "rho=0.5"], &["max_occ has no effect with model=pagac"]),
        ("himm", &["beta=10deg"], &["beta has no effect with method himm: it takes the cells on the axis"]),
        ("certainty", &["beta=10deg", "epsilon=0.1"], &[]),
    ] {
        let mut arguments = vec!["-m", method];
        set.iter().for_each(|s| arguments.extend(["--set", s]));
        let wanted: String = idle.iter().map(|text| format!("echogrid: --set {text}\n")).collect();
        assert_eq!(plan(&arguments), wanted, "{arguments:?}");
    }
}

#[test]
fn cells_and_bounds() {
    let advice = "m is not a cell size: give 0.0001 to 10000 metres, such as 0.05";
    for (given, shown) in [("0", "0"), ("-1", "-1"), ("nan", "NaN"), ("inf", "inf"), ("1e-9", "0.000000001")] {
        refused(&["--resolution", given], &format!("resolution {shown} {advice}"));
    }
    mistyped(
        &["--resolution", "wide"],
        "invalid value 'wide' for '--resolution <LENGTH>': it takes a length: a number in metres, or one that ends in mm, \
         cm or m",
    );
    refused(&["--bounds", "1,2,3"], "--bounds takes x0,y0,x1,y1, four numbers; here are 3");
    for (given, shown) in [("1,1,-1,-1", "1,1,-1,-1"), ("0,0,0,1", "0,0,0,1"), ("0,0,nan,1", "0,0,NaN,1")] {
        refused(
            &["--bounds", given],
            &format!("bounds {shown} are empty or inverted: give x0,y0,x1,y1 in metres with x0 < x1 and y0 < y1"),
        );
    }
    mistyped(&["--bounds", "1,2,3,a"], "invalid value 'a' for '--bounds <X0,Y0,X1,Y1>': it is not a number");
    refused(
        &["--bounds", "0,0,1e9,1"],
        "a grid of 20000000000 × 20 cells of 0.05 m, starting 0 cells from its anchor, is more than 16777216 cells an \
         axis: give --bounds nearer the robot or a coarser --resolution",
    );
}

#[test]
fn counts_and_sizes() {
    mistyped(&["--until", "0"], "invalid value '0' for '--until <N>': give a whole number from 1");
    for given in ["1025", "100000", "-1", "many"] {
        let message = format!("invalid value '{given}' for '--threads <N>': give 0 (one a core) to 1024");
        mistyped(&[&format!("--threads={given}")], &message);
    }
    mistyped(&["--working", "-3"], "invalid value '-3' for '--working <N>': give a whole number from 1");
    mistyped(
        &["--memory", "lots"],
        "invalid value 'lots' for '--memory <SIZE>': lots is not a size: give a number with a unit, such as 4GiB or 500MB",
    );
    let place = Place::new();
    place.refuses(
        &["map", "log.jsonl", "-o", "out", "--working", "5"],
        2,
        "echogrid: --working 5: there are 4 used readings",
    );
    place.refuses(
        &["map", "log.jsonl", "-o", "out", "--until", "2", "--working", "3"],
        2,
        "echogrid: --working 3: there are 2 used readings",
    );
}

#[test]
fn what_features_cannot_take() {
    refused(
        &["-m", "features", "-r", "0.005"],
        "sensor front: r_max is 4 m, more than the 512 cells of 0.005 m that method features takes: give a coarser \
         --resolution or a smaller --set r_max",
    );
    refused(
        &["-m", "features", "--sensor", "laser"],
        "method features tells what a sonar's readings came from: leave out --sensor laser",
    );
    Place::new().refuses(
        &["map", "log.jsonl", "-o", "out", "-m", "features", "--working", "1"],
        2,
        "echogrid: --working 1: it draws one reading's cone, and features updates what the feature it came from says: leave \
         it out",
    );
}

#[test]
fn the_command_line_itself() {
    let place = Place::new();
    place.refuses(
        &["map", "log.jsonl"],
        2,
        "error: the following required arguments were not provided:\n  --output <DIR>\n\nUsage: echogrid map --output \
         <DIR> <LOG>\n\nFor more information, try '--help'.",
    );
    place.refuses(
        &["map", "log.jsonl", "-o", "out", "--seet", "beta=1"],
        2,
        "error: unexpected argument '--seet' found\n\n  tip: a similar argument exists: '--set'\n\nUsage: echogrid map \
         --output <DIR> --set <KEY=VALUE> <LOG>\n\nFor more information, try '--help'.",
    );
    place.refuses(
        &["verfy", "log.jsonl"],
        2,
        "error: unrecognized subcommand 'verfy'\n\n  tip: a similar subcommand exists: 'verify'\n\nUsage: echogrid \
         <COMMAND>\n\nFor more information, try '--help'.",
    );
    place.refuses(
        &["verify", "log.jsonl", "--backends", "oracle"],
        2,
        "echogrid: the oracle alone proves nothing: give --backends cpu, gpu or both",
    );
    // Without a subcommand the help itself is the message.
    let ran = place.run(&[]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("Start with `echogrid demo`"), "{}", ran.err);
}
