//! `scripts/skipped` counts the tests that found no real log, each once, among all that `cargo test` prints.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "data/mod.rs"]
mod data;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// What it says of a text.
fn counted(text: &str) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/skipped");
    let mut child = Command::new(script).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    String::from_utf8(child.wait_with_output().unwrap().stdout).unwrap()
}

#[test]
fn skipped_tests_are_counted_once_each() {
    let no = "no /x/../shared/data/a (set ECHOGRID_DATA to the folder of real logs)";
    assert_eq!(counted(""), "0\n");
    assert_eq!(counted("running 2 tests\ntest a ... ok\nSKIPPED on_the_gpu: no adapter\nSKIPPED gpu: no ICD\n"), "0\n");
    let said = format!(
        "running 4 tests\nSKIPPED cli::map::a: {no}\nSKIPPED cli::map::a: {no}\ntest map::a ... ok\n\
         test map::b ... SKIPPED cli::map::b: {no}\nok\nSKIPPED step::b: {no}\n"
    );
    assert_eq!(counted(&said), "3\n");
}

#[test]
fn a_test_without_its_log_says_so_in_that_form() {
    // this very test as a process of its own, in a place without logs
    if std::env::var_os("ECHOGRID_TEST_SAYS").is_some() {
        assert_eq!(data::data("no such log"), None);
        assert_eq!(data::data("nor this one"), None);
        return;
    }
    let run = Command::new(std::env::current_exe().unwrap())
        .arg("a_test_without_its_log_says_so_in_that_form")
        .env("ECHOGRID_TEST_SAYS", "1")
        .env("ECHOGRID_DATA", "/nowhere")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{said}");
    assert!(
        said.starts_with("SKIPPED scripts::a_test_without_its_log_says_so_in_that_form: no /nowhere/no such log (")
    );
    assert_eq!(counted(&said), "1\n");
}
