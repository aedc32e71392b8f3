//! Ctrl-C and SIGTERM: the exit code, what is said, and what stays in the folders.

#![cfg(unix)]

use crate::common::Place;
use rustix::process::{Pid, Signal, kill_process};
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

struct Run(Child);

impl Run {
    fn start(place: &Place, arguments: &[&str]) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_echogrid"));
        command.current_dir(place.path("")).args(arguments).env("TMPDIR", place.path("run"));
        command.env_remove("XDG_RUNTIME_DIR");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Run(command.spawn().unwrap())
    }

    /// Waits until something is so.
    #[track_caller]
    fn until(&mut self, what: &str, so: impl Fn() -> bool) {
        let started = Instant::now();
        while !so() {
            assert!(started.elapsed() < Duration::from_secs(60), "never {what}");
            assert!(self.0.try_wait().unwrap().is_none(), "it ended before {what}");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Sends a signal, and gives the exit code, what was printed and what was said.
    fn signal(mut self, signal: Signal) -> (Option<i32>, String, String) {
        kill_process(Pid::from_child(&self.0), signal).unwrap();
        let (mut out, mut err) = (String::new(), String::new());
        self.0.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        self.0.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        (self.0.wait().unwrap().code(), out, err)
    }
}

/// A log of which a map takes some seconds.
fn campus() -> Place {
    let place = Place::new();
    place.write("campus.toml", "[campus]\nseed = 2\nwidth = 110\nheight = 90\n[rig]\nkind = \"ring24\"\n");
    place.does(&["simulate", "campus.toml", "-o", "campus.jsonl", "--scans", "3000", "--quiet"]);
    place
}

const MAP: [&str; 9] = ["map", "campus.jsonl", "-o", "deep/out", "-r", "0.02", "--backend", "cpu", "--quiet"];

#[test]
fn a_map_under_way_stays_to_be_gone_on_with() {
    let place = campus();
    for (signal, code) in [(Signal::INT, 130), (Signal::TERM, 143)] {
        let mut run = Run::start(&place, &[&MAP[..], &["--resume"]].concat());
        let progress = place.path("deep/out.partial/progress.jsonl");
        let done = || std::fs::read_to_string(&progress).unwrap_or_default().lines().count();
        let before = done();
        run.until("a chunk is done", || done() > before);
        let ended = run.signal(signal);
        let partial = place.path("deep/out.partial");
        let said = format!(
            "echogrid: interrupted: the unfinished map stays in {}; give the same command with --resume to go on with it, or \
             with --overwrite to begin anew\n",
            partial.display()
        );
        assert_eq!(ended, (Some(code), String::new(), said));
        assert!(partial.join("run.json").exists() && !place.path("deep/out").exists());
        assert_eq!(place.names("run"), [""; 0], "temporary files stay");
    }
    place.does(&[&MAP[..], &["--resume"]].concat());
    assert_eq!(place.names("deep"), ["out"]);
    assert_eq!(place.run(&["check", "deep/out"]).code, 0);
}

#[test]
fn before_anything_is_mapped_nothing_stays() {
    let place = Place::new();
    let before = place.names("");
    // It waits for a log that never ends.
    let mut run = Run::start(&place, &["map", "-", "-o", "deep/er/out", "--backend", "cpu"]);
    run.until("it waits for the log", || place.path("deep/er/out.partial").exists());
    std::thread::sleep(Duration::from_millis(100));
    let said = "echogrid: interrupted: nothing was mapped yet, and nothing stays\n";
    assert_eq!(run.signal(Signal::INT), (Some(130), String::new(), said.into()));
    assert_eq!((place.names(""), place.names("run")), (before, Vec::<String>::new()));
}

#[test]
fn other_commands_end_quietly() {
    let place = campus();
    place.does(&["simulate", "campus.toml", "-o", "before.jsonl", "--scans", "10", "--quiet"]);
    let before = place.files("");
    let long = ["simulate", "campus.toml", "-o", "before.jsonl", "--scans", "100000000"];
    let mut run = Run::start(&place, &long);
    run.until("the log grows", || place.names("").iter().any(|n| n.ends_with(".partial")));
    assert_eq!(run.signal(Signal::INT), (Some(130), String::new(), String::new()));
    assert!(place.files("") == before, "the old log is as it was, and nothing lies beside it");
    for command in [&["verify", "-"][..], &["plan", "-"]] {
        let mut run = Run::start(&place, command);
        // Its folder for Vulkan shows that it runs.
        run.until("it waits for the log", || !place.names("run").is_empty());
        std::thread::sleep(Duration::from_millis(200));
        assert_eq!(run.signal(Signal::TERM), (Some(143), String::new(), String::new()), "{command:?}");
        assert!(place.files("") == before, "{command:?} left something behind");
    }
}
