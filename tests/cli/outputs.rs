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
fn what_is_the_user_s_in_a_map_s_folder_is_kept() {
    let place = Place::new();
    place.map("out", &["--npy", "--working", "1"]);
    let kept = |what: &str, named: &str| {
        let before = place.files("out");
        for more in [&[][..], &["--method", "himm"], &["--overwrite"]] {
            place.refuses(
                &[&["map", "log.jsonl", "-o", "out"], more].concat(),
                5,
                &format!(
                    "echogrid: HERE/out can't be the output: beside the files of a map it holds {named}; move what is yours out \
                     of it, or give another folder with -o"
                ),
            );
        }
        assert!(place.files("out") == before, "{what}");
    };
    for (file, named) in [
        ("notes.txt", "notes.txt"),
        (".notes", ".notes"),
        ("survey.png", "survey.png"),
        ("p_occ.npy.bak", "p_occ.npy.bak"),
        ("working-notes.json", "working-notes.json"),
        ("score/score.html", "score/"),
        ("class/class.png", "class/"),
        ("map.zarr/notes.txt", "map.zarr/notes.txt"),
        ("map.zarr/p_occ/c/0/notes.txt", "map.zarr/p_occ/c/0/notes.txt"),
        ("map.zarr/mine/zarr.json", "map.zarr/mine/"),
        ("report.json.bak", "report.json.bak"),
    ] {
        let path = place.path(&format!("out/{file}"));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, "mine").unwrap();
        kept(file, named);
        match named.strip_suffix('/') {
            Some(folder) => std::fs::remove_dir_all(place.path(&format!("out/{folder}"))).unwrap(),
            None => std::fs::remove_file(&path).unwrap(),
        }
    }
    std::fs::create_dir(place.path("out/empty")).unwrap();
    kept("an empty folder", "empty/");
    std::fs::remove_dir(place.path("out/empty")).unwrap();
    for k in 0..5 {
        place.write(&format!("out/{k}.txt"), "");
    }
    kept("many", "0.txt, 1.txt, 2.txt and 2 more");
    for k in 0..5 {
        std::fs::remove_file(place.path(&format!("out/{k}.txt"))).unwrap();
    }
    #[cfg(unix)]
    for link in ["link", "working-2.png", "map.zarr/x/c/1"] {
        std::os::unix::fs::symlink(place.path("log.jsonl"), place.path(&format!("out/{link}"))).unwrap();
        kept("a link", link);
        std::fs::remove_file(place.path(&format!("out/{link}"))).unwrap();
    }
    // A name of the program's that this map hasn't is the user's, too.
    place.map("out", &["--quiet"]);
    place.write("out/class.npy", "mine");
    kept("an array", "class.npy");
    std::fs::remove_file(place.path("out/class.npy")).unwrap();
    place.write("out/features.geojson", "mine");
    kept("features", "features.geojson");
}

#[test]
fn every_method_s_map_is_replaced_whatever_was_written() {
    let place = Place::new();
    // The semantic methods need labels.
    let labelled = SMALL.replacen("\"sensors\"", "\"classes\":[\"wall\"],\"sensors\"", 1);
    place.write("log.jsonl", labelled.replacen("\"z\":1.5", "\"z\":1.5,\"label\":1", 1));
    for entry in echogrid::method::REGISTRY.iter().filter(|e| e.name != "truth") {
        let working = ["certainty", "bayes", "dempster-shafer", "himm"].contains(&entry.name);
        let more = if working { &["--npy", "--working", "1"][..] } else { &["--npy"] };
        place.map("out", &[&["--method", entry.name, "--quiet"], more].concat());
        assert_eq!(place.report("out")["method"], entry.name);
    }
    // A map of a version that listed no files.
    let text = std::fs::read_to_string(place.path("out/report.json")).unwrap();
    let mut report: serde_json::Value = serde_json::from_str(&text).unwrap();
    report.as_object_mut().unwrap().remove("files").unwrap();
    place.write("out/report.json", report.to_string());
    place.write("out/notes.txt", "mine");
    assert_eq!(place.run(&["map", "log.jsonl", "-o", "out"]).code, 5);
    std::fs::remove_file(place.path("out/notes.txt")).unwrap();
    place.map("out", &["--quiet"]);
    assert_eq!(place.names(""), ["log.jsonl", "out", "run"]);
}

#[test]
fn other_commands_leave_what_is_not_theirs() {
    let place = Place::new();
    place.write("world.toml", include_str!("../../worlds/bend.toml"));
    // A true map's folder is a map's.
    place.does(&["truth", "world.toml", "-o", "true", "--quiet"]);
    place.write("true/notes.txt", "mine");
    let ran = place.run(&["truth", "world.toml", "-o", "true"]);
    assert!(ran.code == 5 && ran.err.contains("it holds notes.txt; move"), "{ran:?}");
    std::fs::remove_file(place.path("true/notes.txt")).unwrap();
    place.does(&["truth", "world.toml", "-o", "true", "--quiet"]);
    // A log replaces a log.
    let simulate = |to: &str| place.run(&["simulate", "world.toml", "-o", to, "--scans", "2", "--quiet"]);
    place.write("notes.txt", "mine");
    for file in ["notes.txt", "world.toml"] {
        let before = std::fs::read(place.path(file)).unwrap();
        let ran = simulate(file);
        assert!(ran.code == 5 && ran.err.contains("it is no log of echogrid's, so it is left as it is"), "{ran:?}");
        assert_eq!(std::fs::read(place.path(file)).unwrap(), before);
    }
    assert_eq!((simulate("new.jsonl").code, simulate("new.jsonl").code), (0, 0));
    // A score replaces a score.
    place.map("out", &["--quiet"]);
    let score = || place.run(&["score", "out", "--truth", "true", "-o", "score"]);
    std::fs::create_dir(place.path("score")).unwrap();
    place.write("score/score.html", "mine");
    let ran = score();
    assert_eq!(
        (ran.code, ran.err.as_str(), ran.out.as_str()),
        (5, "echogrid: score holds score.html, which isn't an earlier score's: give another folder with -o\n", "")
    );
    assert_eq!(std::fs::read_to_string(place.path("score/score.html")).unwrap(), "mine");
    std::fs::rename(place.path("score/score.html"), place.path("score/mine.html")).unwrap();
    assert_eq!((score().code, score().code), (0, 0));
    // Pictures replace pictures.
    place.map("other", &["--quiet", "--until", "2", "--bounds=-1,-1,2,1"]);
    place.map("whole", &["--quiet", "--bounds=-1,-1,2,1"]);
    let compare = || place.run(&["compare", "other", "whole", "--pictures", "pictures"]);
    std::fs::create_dir(place.path("pictures")).unwrap();
    place.write("pictures/class.a.png", "mine");
    let ran = compare();
    assert!(ran.code == 5 && ran.err.contains("pictures/class.a.png is there and is no picture"), "{ran:?}");
    assert_eq!(std::fs::read_to_string(place.path("pictures/class.a.png")).unwrap(), "mine");
    std::fs::remove_file(place.path("pictures/class.a.png")).unwrap();
    assert_eq!((compare().code, compare().code), (1, 1));
    // A demo replaces a demo, not a map that has a method's name.
    std::fs::create_dir(place.path("maps")).unwrap();
    place.map("maps/bayes", &["--quiet"]);
    let before = place.files("maps");
    let ran = place.run(&["demo", "-o", "maps"]);
    let what = "echogrid: maps holds bayes, which isn't the demo's: give another folder with -o\n";
    assert_eq!((ran.code, ran.err.as_str(), ran.out.as_str()), (5, what, ""));
    assert!(place.files("maps") == before);
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
