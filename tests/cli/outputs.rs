//! Where a map can't be written, what may be replaced, and that an error leaves everything as it was.

use crate::common::{Place, SMALL};

#[test]
fn more_memory_than_allowed_or_there_is() {
    let place = Place::new();
    let need = |command: &[&str], start: &str, end: &str| -> f64 {
        let ran = place.run(command);
        assert_eq!(ran.code, 5, "{ran:?}");
        let number = ran.err.strip_prefix(start).and_then(|rest| rest.strip_suffix(end));
        number.unwrap_or_else(|| panic!("{}", ran.err)).parse().unwrap()
    };
    let small = need(
        &["map", "log.jsonl", "-o", "out", "--memory", "1MB"],
        "echogrid: a map of 50 × 38 cells of 0.05 m needs ",
        " MiB, but --memory allows 977 KiB: give smaller --bounds or a coarser --resolution\n",
    );
    // Three chunks of 1024 × 1024 cells on their way and a spare one, of five words a cell each; and not a whole batch where
    // there are four readings.
    assert!((80.0..110.0).contains(&small), "{small}");
    // A map of any size is mapped in little memory; but its files must fit: 3.6e13 cells, a byte a cell and more.
    let far = ["--bounds", "0,0,300000,300000"];
    let ran = place.run(&[&["map", "log.jsonl", "-o", "out"][..], &far].concat());
    assert_eq!(ran.code, 5);
    let start =
        "echogrid: the files of a map of 6000000 × 6000000 cells of 0.05 m take 44 TiB and more, but there are ";
    assert!(
        ran.err.starts_with(start) && ran.err.ends_with(" free: give smaller --bounds or a coarser --resolution\n")
    );
    // Where all of a map is held, the machine's own memory is asked where the system tells it.
    #[cfg(target_os = "linux")]
    for command in [&["map", "-o", "out", "--backend", "oracle"][..], &["verify"]] {
        let ran = place.run(&[command, &["log.jsonl"], &far].concat());
        assert_eq!(ran.code, 5);
        assert!(
            ran.err.contains(" TiB, but this machine has ") && ran.err.contains(" free: give smaller"),
            "{}",
            ran.err
        );
    }
    assert_eq!(place.names(""), ["log.jsonl", "run"]);
}

#[test]
fn a_folder_that_can_not_be_written() {
    let place = Place::new();
    place.refuses(
        &["map", "log.jsonl", "-o", "log.jsonl/out"],
        5,
        "echogrid: log.jsonl/out can't be the output: HERE/log.jsonl is a file; give another folder with -o",
    );
    place.refuses(
        &["map", "log.jsonl", "-o", "log.jsonl"],
        5,
        "echogrid: HERE/log.jsonl can't be the output: it is a file; give another folder with -o",
    );
    #[cfg(target_os = "linux")]
    place.refuses(
        &["map", "log.jsonl", "-o", "/proc/echogrid/out"],
        5,
        "echogrid: /proc/echogrid/out can't be the output: its parent can't be made: No such file or directory (os error \
         2); give another folder with -o",
    );
    place.refuses(
        &["map", "log.jsonl", "-o", "/"],
        5,
        "echogrid: / can't be the output: it has no name, as out/map has; give another folder with -o",
    );
    assert_eq!(std::fs::read_to_string(place.path("log.jsonl")).unwrap(), SMALL);
    #[cfg(unix)]
    place.refuses(
        &["demo", "-o", "log.jsonl"],
        5,
        "echogrid: log.jsonl can't be written: File exists (os error 17); give another folder with -o",
    );
    #[cfg(unix)]
    place.refuses(
        &["man", "log.jsonl"],
        5,
        "echogrid: log.jsonl can't be written: File exists (os error 17); give another folder",
    );
}

#[test]
fn a_folder_with_something_else_in_it() {
    let place = Place::new();
    std::fs::create_dir(place.path("photos")).unwrap();
    place.write("photos/cat.png", "cat");
    place.refuses(
        &["map", "log.jsonl", "-o", "photos"],
        5,
        "echogrid: HERE/photos can't be the output: it holds files and is no echogrid map, so it is left as it is; give \
         another folder with -o",
    );
    assert_eq!(place.names("photos"), ["cat.png"]);
    // Nor is anything removed that only looks like a leftover.
    std::fs::create_dir(place.path("out.partial")).unwrap();
    place.write("out.partial/mine", "");
    place.refuses(
        &["map", "log.jsonl", "-o", "out"],
        5,
        "echogrid: HERE/out.partial can't be the output: it is in the way and echogrid didn't write it; move it, or give \
         another folder with -o",
    );
    assert_eq!(place.names("out.partial"), ["mine"]);
}

#[test]
fn an_empty_folder_or_a_map_is_replaced() {
    let place = Place::new();
    std::fs::create_dir(place.path("out")).unwrap();
    place.map("out", &["--npy"]);
    assert!(place.path("out/class.npy").exists());
    place.map("out", &["--method", "himm"]);
    assert_eq!(place.report("out")["method"], "himm");
    assert!(
        !place.path("out/class.npy").exists() && !place.path("out/p_occ.png").exists(),
        "the old map's files are gone"
    );
    assert_eq!(place.names(""), ["log.jsonl", "out", "run"]);
}

#[test]
fn an_error_leaves_the_old_map() {
    let place = Place::new();
    place.map("out", &[]);
    let (names, report) = (place.names("out"), std::fs::read(place.path("out/report.json")).unwrap());
    place.write("bad.jsonl", format!("{SMALL}garbage\n"));
    for (more, code) in [
        (&["nosuch.log"][..], 3),
        (&["bad.jsonl", "--strict"], 3),
        (&["log.jsonl", "--memory", "1kB"], 5),
        (&["log.jsonl", "--working", "99"], 2),
        (&["log.jsonl", "--method", "himm", "--set", "gro=true", "--backend", "gpu"], 4),
    ] {
        let ran = place.run(&[&["map", "-o", "out"], more].concat());
        assert_eq!(ran.code, code, "{ran:?}");
        assert_eq!(place.names("out"), names, "{more:?}");
        assert_eq!(std::fs::read(place.path("out/report.json")).unwrap(), report, "{more:?}");
        assert_eq!(place.names(""), ["bad.jsonl", "log.jsonl", "out", "run"], "{more:?}");
    }
}

#[test]
fn folders_above_are_made_and_go_again_after_an_error() {
    let place = Place::new();
    std::fs::create_dir(place.path("a")).unwrap();
    assert_eq!(place.run(&["map", "nosuch.log", "-o", "a/b/c/out"]).code, 3);
    assert_eq!(place.names("a"), [""; 0]);
    place.map("a/b/c/out", &[]);
    assert_eq!(place.names("a/b/c"), ["out"]);
}

#[test]
fn a_second_run_is_refused_and_a_killed_one_cleaned_up() {
    let place = Place::new();
    place.map("out", &[]);
    let before = std::fs::read(place.path("out/report.json")).unwrap();
    // A run that waits for its standard input has opened its folder.
    let mut waiting = std::process::Command::new(place.command(&[]).get_program())
        .args(["map", "-", "-o", "out", "--backend", "cpu"])
        .current_dir(place.path(""))
        .stdin(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let partial = place.path("out.partial/.echogrid-partial");
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(20);
    while !partial.exists() && std::time::Instant::now() < deadline {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    // The marker is locked a moment after it is made.
    std::thread::sleep(std::time::Duration::from_millis(100));
    let ran = place.run(&["map", "log.jsonl", "-o", "out"]);
    assert_eq!(
        (ran.code, ran.err.as_str()),
        (
            5,
            "echogrid: HERE/out.partial can't be the output: another run is writing it; wait for that run, or give \
             another folder with -o\n"
        )
    );
    waiting.kill().unwrap();
    waiting.wait().unwrap();
    assert_eq!(place.names(""), ["log.jsonl", "out", "out.partial", "run"]);
    assert_eq!(std::fs::read(place.path("out/report.json")).unwrap(), before);
    place.map("out", &["--method", "himm"]);
    assert_eq!(place.names(""), ["log.jsonl", "out", "run"]);
}
