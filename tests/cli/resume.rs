//! A killed run goes on where it was, and ends with the bytes of one that wasn't killed.

use crate::common::Place;
use std::collections::BTreeMap;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn map(place: &Place, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_echogrid"));
    let fixed = ["map", "campus.jsonl", "-o", "out", "-m", "certainty", "-r", "0.02", "--backend", "cpu", "--quiet"];
    command.current_dir(place.path("")).args(fixed).args(more).stderr(Stdio::null());
    command
}

/// Every file of a folder but the report, by its path.
fn files(place: &Place, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let mut all = place.files(folder);
    all.remove("report.json");
    all
}

#[test]
fn killed_three_times_it_ends_with_the_same_bytes() {
    let place = Place::new();
    place.write("campus.toml", "[campus]\nseed = 2\nwidth = 110\nheight = 90\n[rig]\nkind = \"ring24\"\n");
    place.does(&["simulate", "campus.toml", "-o", "campus.jsonl", "--scans", "3000", "--quiet"]);
    assert!(map(&place, &[]).status().unwrap().success());
    std::fs::rename(place.path("out"), place.path("unbroken")).unwrap();

    let done = || {
        let text = std::fs::read_to_string(place.path("out.partial/progress.jsonl")).unwrap_or_default();
        text.lines().count()
    };
    for kill in 0..3 {
        let mut child = map(&place, &["--resume"]).spawn().unwrap();
        let (before, started) = (done(), Instant::now());
        // killed when it has done two chunks more, at whatever it is at then
        while done() < before + 2 && child.try_wait().unwrap().is_none() {
            assert!(started.elapsed() < Duration::from_secs(60), "nothing is done");
            std::thread::sleep(Duration::from_millis(3 + 4 * kill));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!place.path("out").exists() && done() > before, "killed too late, {} chunks done", done());
    }
    // Without --resume the unfinished map is in the way; another run can't go on with it.
    let refused = place.run(&["map", "campus.jsonl", "-o", "out", "-m", "certainty", "-r", "0.02", "--backend", "cpu"]);
    assert_eq!(refused.code, 5);
    assert_eq!(
        refused.err,
        "echogrid: HERE/out.partial can't be the output: it holds an unfinished map; go on with it by `echogrid map \
         --resume`, discard it by `echogrid map --overwrite`, or give another folder with -o\n"
    );
    let fixed = ["map", "campus.jsonl", "-o", "out", "--backend", "cpu", "--resume"];
    for (more, what) in [
        (&["-m", "bayes", "-r", "0.02"][..], "its method is \"certainty\", now it is \"bayes\""),
        (&["-m", "certainty", "-r", "0.02", "--set", "r_min=0.2"], "its r_min is 0.15, now it is 0.2"),
        (&["-m", "certainty", "-r", "0.03"], "now it is "),
        (&["-m", "certainty", "-r", "0.02", "--npy"], "its npy is false, now it is true"),
    ] {
        let refused = place.run(&[&fixed[..], more].concat());
        assert!(refused.code == 2 && refused.err.contains(what), "{more:?}: {refused:?}");
        assert!(place.path("out.partial/progress.jsonl").exists(), "{more:?}");
    }
    let log = std::fs::read(place.path("campus.jsonl")).unwrap();
    std::fs::write(place.path("campus.jsonl"), &log[..log.len() * 9 / 10]).unwrap();
    let refused = place.run(&[&fixed[..], &["-m", "certainty", "-r", "0.02"]].concat());
    assert!(refused.code != 0 && refused.code != 6 && place.path("out.partial").exists(), "{refused:?}");
    std::fs::write(place.path("campus.jsonl"), &log).unwrap();

    assert!(map(&place, &["--resume"]).status().unwrap().success());
    let (a, b) = (files(&place, "unbroken"), files(&place, "out"));
    assert!(a.len() > 100 && a.keys().eq(b.keys()), "{:?} and {:?}", a.keys().count(), b.keys().count());
    for (name, bytes) in &a {
        assert!(b[name] == *bytes, "{name} differs");
    }
    assert!(!place.path("out.partial").exists());
    // And its report counts all of it.
    let (a, b) = (place.report("unbroken"), place.report("out"));
    for key in ["cells", "layers", "updates", "readings"] {
        assert_eq!(a[key], b[key], "{key}");
    }
}

#[test]
fn an_unfinished_map_is_discarded_where_that_is_asked_for() {
    let place = Place::new();
    place.map("out", &["--method", "himm", "--quiet"]);
    // What a run leaves that was killed after its first chunk.
    std::fs::create_dir_all(place.path("out.partial/map.zarr/p_occ/c/0")).unwrap();
    for (file, text) in [
        (".echogrid-partial", ""),
        ("run.json", "{\"layers\": [\"p_occ\"]}"),
        ("progress.jsonl", "[]\n"),
        ("p_occ.canvas", ""),
        ("map.zarr/p_occ/c/0/0", ""),
    ] {
        place.write(&format!("out.partial/{file}"), text);
    }
    for command in [&["map", "log.jsonl", "-o", "out"][..], &["truth", "nosuch.toml", "-o", "out"]] {
        let ran = place.run(command);
        assert!(ran.code == 5 || ran.err.contains("nosuch.toml"), "{ran:?}");
        assert!(place.path("out.partial/progress.jsonl").exists());
    }
    let both = place.run(&["map", "log.jsonl", "-o", "out", "--resume", "--overwrite"]);
    assert!(both.code == 2 && both.err.contains("cannot be used with"), "{both:?}");
    // Nothing of the user's goes with it.
    place.write("out.partial/notes.txt", "mine");
    place.refuses(
        &["map", "log.jsonl", "-o", "out", "--overwrite"],
        5,
        "echogrid: HERE/out.partial can't be the output: a killed run left it, and it holds notes.txt, which is no file of a \
         map; move what is yours out of it, or give another folder with -o",
    );
    assert_eq!(place.files("out.partial").len(), 6);
    std::fs::remove_file(place.path("out.partial/notes.txt")).unwrap();
    place.map("out", &["--overwrite", "--quiet"]);
    assert_eq!(place.report("out")["method"], "bayes");
    assert_eq!(place.names(""), ["log.jsonl", "out", "run"]);
    place.map("out", &["--overwrite", "--quiet"]);
}

#[test]
fn a_damaged_store_is_found() {
    let place = Place::new();
    place.does(&["map", "log.jsonl", "-o", "out", "--backend", "cpu", "--quiet"]);
    let whole = place.does(&["check", "out", "--json"]).json();
    assert_eq!((&whole["whole"], &whole["layers"]), (&true.into(), &5.into()), "{whole}");
    let shard = place.path("out/map.zarr/p_occ/c/0/0");
    let bytes = std::fs::read(&shard).unwrap();
    let mut bad = bytes.clone();
    bad[bytes.len() / 3] ^= 4;
    std::fs::write(&shard, &bad).unwrap();
    let ran = place.run(&["check", "out"]);
    assert!(ran.code == 1 && ran.err.starts_with("echogrid: out: p_occ, shard row 0 column 0: "), "{ran:?}");
    std::fs::remove_file(&shard).unwrap();
    let ran = place.run(&["check", "out"]);
    assert!(ran.code == 1 && ran.err.contains("p_occ: its sum is ") && ran.out.ends_with("damaged\n"), "{ran:?}");
    std::fs::write(&shard, &bytes).unwrap();
    assert_eq!(place.run(&["check", "out"]).code, 0);
    assert_eq!(place.run(&["check", "run"]).code, 3);
}
