//! The page of `echogrid view`: what is built in is what its source gives, and it works in a browser. That takes Node.js,
//! npm and Chromium (`ECHOGRID_CHROMIUM`, else that on the path); without them the tests say so on standard error, and
//! `ECHOGRID_REQUIRE_CHROMIUM=1` makes that an error.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking; here are the tests' helpers too")]

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Bytes of the built page at most.
const LARGEST: usize = 300_000;

fn web() -> PathBuf {
    Path::new(ROOT).join("web")
}

/// Runs a command; its standard output, or all that it said where it fails.
fn run(program: &str, args: &[&str], folder: &Path) -> Result<String, String> {
    let told = format!("{program} {}", args.join(" "));
    let run = Command::new(program).args(args).current_dir(folder).output().map_err(|e| format!("{told}: {e}"))?;
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    if run.status.success() { Ok(out.into_owned()) } else { Err(format!("{told}: {}\n{out}\n{err}", run.status)) }
}

/// Node.js, npm, and what the page is built with, fetched once if it is missing.
fn tools() -> Result<(), String> {
    static TOOLS: OnceLock<Result<(), String>> = OnceLock::new();
    let ready = || {
        run("node", &["--version"], &web())?;
        run("npm", &["--version"], &web())?;
        if !web().join("node_modules").is_dir() {
            run("npm", &["ci", "--no-audit", "--no-fund"], &web())?;
        }
        Ok(())
    };
    TOOLS.get_or_init(ready).clone()
}

/// Not eprintln, which a passing test keeps to itself.
fn say(text: &str) {
    std::io::stderr().write_all(format!("{text}\n").as_bytes()).unwrap();
}

/// Whether a test can run: what it lacks is said aloud, or an error.
fn can_run(test: &str, needs: Result<(), String>) -> bool {
    let Err(why) = needs else { return true };
    if std::env::var_os("ECHOGRID_REQUIRE_CHROMIUM").is_some_and(|v| v == "1") {
        panic!("ECHOGRID_REQUIRE_CHROMIUM=1, but {why}");
    }
    say(&format!("SKIPPED {test}: {why}"));
    false
}

/// The browser that is named, or that on the path.
fn chromium() -> PathBuf {
    if let Some(named) = std::env::var_os("ECHOGRID_CHROMIUM") {
        return named.into();
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path).map(|folder| folder.join("chromium")).find(|p| p.is_file());
    found.unwrap_or_else(|| "/usr/bin/chromium".into())
}

/// A folder's files and their bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(Result::unwrap);
    entries.map(|e| (e.file_name().to_string_lossy().into_owned(), std::fs::read(e.path()).unwrap())).collect()
}

#[test]
fn the_page_is_what_its_source_gives() {
    if !can_run("the_page_is_what_its_source_gives", tools()) {
        return;
    }
    run("npm", &["run", "check"], &web()).unwrap();
    let built = tempfile::tempdir().unwrap();
    run("node", &["build.mjs", built.path().to_str().unwrap()], &web()).unwrap();
    let (anew, held) = (files(built.path()), files(&web().join("dist")));
    assert_eq!(anew.keys().collect::<Vec<_>>(), held.keys().collect::<Vec<_>>(), "the files of web/dist");
    for (name, bytes) in &anew {
        assert!(held[name] == *bytes, "web/dist/{name} is not what web/src gives: run `npm run build` in web/");
    }
    let size: usize = anew.values().map(Vec::len).sum();
    assert!(size < LARGEST, "{size} bytes");
}

#[test]
fn the_page_works_in_a_browser() {
    let chromium = chromium();
    let browser = || {
        tools()?;
        let why = format!("there is no {} (set ECHOGRID_CHROMIUM to the browser)", chromium.display());
        if chromium.is_file() { Ok(()) } else { Err(why) }
    };
    if !can_run("the_page_works_in_a_browser", browser()) {
        return;
    }
    let run = Command::new("node")
        .args(["--test-reporter=tap", "tests/browser/all.mjs"])
        .current_dir(ROOT)
        .env("ECHOGRID_BIN", env!("CARGO_BIN_EXE_echogrid"))
        .env("ECHOGRID_CHROMIUM", &chromium)
        .output()
        .unwrap();
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    for line in out.lines().chain(err.lines()).filter(|l| l.contains("SKIP") || l.starts_with("measured: ")) {
        say(line);
    }
    assert!(run.status.success(), "{out}\n{err}");
    assert!(out.contains("\n# fail 0"), "{out}");
}
