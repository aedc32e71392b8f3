//! Standard output that can't be written, and a reader that goes away.

#![cfg(target_os = "linux")]

use crate::common::{Place, Ran};
use std::fs::File;
use std::process::{Command, Stdio};

fn run(place: &Place, arguments: &[&str], out: Stdio) -> Ran {
    let output = Command::new(env!("CARGO_BIN_EXE_echogrid"))
        .args(arguments)
        .current_dir(place.path(""))
        // Without adapters `plan` tries the CPU alone, which is quicker.
        .env("VK_DRIVER_FILES", place.path("no-driver.json"))
        .env("ECHOGRID_REQUIRE_GPU", "0")
        .stdin(Stdio::null())
        .stdout(out)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
        .wait_with_output()
        .unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    Ran { code: output.status.code().unwrap(), out: String::new(), err }
}

fn world(place: &Place) {
    place.write("world.toml", include_str!("../../worlds/bend.toml"));
    place.map("a", &["--quiet"]);
    place.map("b", &["--quiet", "--method", "himm"]);
}

/// Every command with what makes it print.
const PRINTING: &[&[&str]] = &[
    &["--help"],
    &["--version"],
    &["help", "map"],
    &["map", "--help"],
    &["map", "log.jsonl", "-o", "out", "--backend", "cpu"],
    &["map", "log.jsonl", "-o", "out", "--backend", "cpu", "--json"],
    &["verify", "log.jsonl", "--backends", "cpu"],
    &["verify", "log.jsonl", "--backends", "cpu", "--json"],
    &["compare", "a", "a"],
    &["compare", "a", "b", "--json"],
    &["score", "a", "--truth", "b"],
    &["score", "a", "--truth", "b", "--json"],
    &["check", "a"],
    &["check", "a", "--json"],
    &["plan", "log.jsonl"],
    &["plan", "log.jsonl", "--json"],
    &["simulate", "world.toml", "-o", "-", "--scans", "2"],
    &["simulate", "world.toml", "-o", "new.jsonl", "--scans", "2"],
    &["truth", "world.toml", "-o", "true"],
    &["doctor"],
    &["doctor", "--json"],
    &["bench", "--readings", "20", "--runs", "1", "--methods", "himm", "--backends", "cpu"],
    &["bench", "--readings", "20", "--runs", "1", "--methods", "himm", "--backends", "cpu", "--json"],
    &["completions", "bash"],
    &["man", "pages"],
    &["view", "a"],
];

#[test]
fn what_can_not_be_written_is_an_error() {
    let place = Place::new();
    world(&place);
    for command in PRINTING {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let ran = run(&place, command, full.into());
        let last = ran.err.lines().last().unwrap_or_default();
        assert_eq!(ran.code, 5, "{command:?}: {ran:?}");
        assert!(
            last.starts_with("echogrid: ") && last.contains("can't be written: No space left on device"),
            "{command:?}: {ran:?}"
        );
    }
    // What was asked for besides is done.
    assert!(
        place.path("out/map.png").exists()
            && place.path("new.jsonl").exists()
            && place.path("pages/echogrid.1").exists()
    );
    // Where nothing is to be printed, nothing is missing; and a command's own error comes first.
    let full = || File::options().write(true).open("/dev/full").unwrap().into();
    assert_eq!(run(&place, &["map", "log.jsonl", "-o", "out", "--backend", "cpu", "--quiet"], full()).code, 0);
    assert_eq!(run(&place, &["map", "nosuch.log", "-o", "out"], full()).code, 3);
    assert_eq!(run(&place, &["map", "--nosuch"], full()).code, 2);
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let place = Place::new();
    world(&place);
    for command in PRINTING.iter().filter(|c| c[0] != "view") {
        // A pipe whose reading end is closed.
        let mut reader = Command::new("true").stdin(Stdio::piped()).spawn().unwrap();
        let pipe = reader.stdin.take().unwrap();
        reader.wait().unwrap();
        let ran = run(&place, command, pipe.into());
        let differ = command.starts_with(&["compare", "a", "b"]);
        assert_eq!(ran.code, i32::from(differ), "{command:?}: {ran:?}");
        assert!(!ran.err.contains("can't be written"), "{command:?}: {ran:?}");
    }
}
