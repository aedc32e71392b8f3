//! Help, completions, manual pages; and readers that go away.

use crate::common::Place;
use echogrid::method::REGISTRY;
use echogrid::method::settings::Settings;
use echogrid::sensor::OVERRIDE_KEYS;

const LOG: [&str; 13] = [
    "--method",
    "--resolution",
    "--bounds",
    "--sensor",
    "--sensor-file",
    "--columns",
    "--fields",
    "--poses",
    "--pose-columns",
    "--set",
    "--until",
    "--strict",
    "--batch",
];

/// Every subcommand and its options, but `--help`.
fn options() -> Vec<(&'static str, Vec<&'static str>)> {
    let log = |more: &[&'static str]| [&LOG[..], &["--threads"], more].concat();
    vec![
        (
            "map",
            log(&[
                "--output",
                "--backend",
                "--memory",
                "--resume",
                "--overwrite",
                "--working",
                "--npy",
                "--json",
                "--quiet",
            ]),
        ),
        ("verify", log(&["--backends", "--pictures", "--memory", "--json", "--quiet"])),
        (
            "simulate",
            vec!["--output", "--list", "--seed", "--rig", "--scans", "--bounces", "--no-specular", "--threads"],
        ),
        ("truth", vec!["--output", "--resolution", "--bounds", "--r-max", "--quiet"]),
        ("view", log(&["--with", "--truth", "--bind", "--port", "--memory"])),
        ("score", vec!["--truth", "--require", "--tolerance", "--decide", "--output", "--json"]),
        ("plan", log(&["--backend", "--memory", "--json"])),
        ("check", vec!["--json"]),
        ("compare", vec!["--tol", "--common", "--pictures", "--json"]),
        ("doctor", vec!["--json"]),
        ("demo", vec!["--output", "--backend"]),
        (
            "bench",
            vec![
                "--methods",
                "--backends",
                "--readings",
                "--runs",
                "--threads",
                "--growth",
                "--compare",
                "--markdown",
                "--json",
            ],
        ),
        ("completions", vec![]),
        ("man", vec![]),
    ]
}

#[test]
fn every_subcommand_explains_its_options() {
    let place = Place::new();
    let overview = place.does(&["--help"]).out;
    for (command, options) in options() {
        let help = place.does(&[command, "--help"]).out;
        for option in options {
            let at = help.find(&format!("{option} ")).or_else(|| help.find(&format!("{option}\n")));
            let rest = &help[at.unwrap_or_else(|| panic!("{command} {option}: {help}"))..];
            // Something is said of it before the next option.
            let about = rest.lines().skip(1).find(|l| !l.trim().is_empty()).unwrap_or_default();
            let said = rest.lines().next().unwrap().contains("  ") || !about.trim_start().starts_with('-');
            assert!(said, "{command} {option} is not explained: {help}");
        }
        assert!(overview.lines().any(|l| l.trim_start().starts_with(&format!("{command} "))), "{command}: {overview}");
    }
    let overview = overview.split_whitespace().collect::<Vec<_>>().join(" ");
    for code in [
        "0 done",
        "1 differs",
        "2 bad usage",
        "3 bad input",
        "4 no adapter",
        "5 out of memory",
        "6 done, but",
        "130 ended by Ctrl-C",
    ] {
        assert!(overview.contains(code), "{code}: {overview}");
    }
    assert_eq!(place.does(&["--version"]).out, format!("echogrid {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn the_long_help_lists_every_method_and_parameter() {
    let help = Place::new().does(&["map", "--help"]).out;
    for entry in REGISTRY {
        assert!(help.contains(entry.name), "{}", entry.name);
        for key in Settings::of(entry.name).unwrap().keys().iter().chain(OVERRIDE_KEYS) {
            let line = help.lines().find(|l| l.trim_start().starts_with(&format!("{}={}", key.name, key.values)));
            assert!(line.is_some_and(|l| l.contains(&format!("[{}]", key.default))), "{}: {help}", key.name);
        }
    }
}

#[test]
fn completions_for_the_shells() {
    let place = Place::new();
    for (shell, mark) in [
        ("bash", "complete -F _echogrid"),
        ("zsh", "#compdef echogrid"),
        ("fish", "complete -c echogrid"),
        ("powershell", "Register-ArgumentCompleter"),
        ("elvish", "edit:completion:arg-completer[echogrid]"),
    ] {
        let text = place.does(&["completions", shell]).out;
        assert!(text.contains(mark), "{shell}");
        assert!(text.contains("sensor-file"), "{shell} knows the options");
    }
}

/// What bash offers for a command line whose last word is being written.
#[cfg(unix)]
fn offered(script: &std::path::Path, line: &[&str]) -> Vec<String> {
    let (last, before) = (line.len() - 1, line.len() - 2);
    let words: Vec<String> = line.iter().map(|w| format!("'{w}'")).collect();
    // `compopt` works in a completion only.
    let text = format!(
        "source {}; compopt() {{ :; }}; COMP_WORDS=({}); COMP_CWORD={last}; _echogrid echogrid '{}' '{}'; printf '%s\\n' \
         \"${{COMPREPLY[@]}}\"",
        script.display(),
        words.join(" "),
        line[last],
        line[before]
    );
    let ran = std::process::Command::new("bash").args(["--norc", "-c", &text]).output().unwrap();
    assert!(ran.stderr.is_empty(), "{line:?}: {}", String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).unwrap().split_whitespace().map(String::from).collect()
}

#[test]
#[cfg(unix)]
fn bash_completes_methods_keys_and_files() {
    if std::process::Command::new("bash").arg("--version").output().is_err() {
        let _ = std::io::Write::write_all(&mut std::io::stderr(), b"SKIPPED: there is no bash to complete in\n");
        return;
    }
    let place = Place::new();
    place.write("completions", place.does(&["completions", "bash"]).out);
    let script = place.path("completions");
    let offered = |line: &[&str]| offered(&script, line);
    let methods: Vec<&str> = REGISTRY.iter().map(|e| e.name).collect();
    for command in ["map", "verify", "plan", "view"] {
        assert_eq!(offered(&["echogrid", command, "a.log", "--method", ""]), methods, "{command}");
    }
    assert_eq!(offered(&["echogrid", "view", "a.log", "--beside", "csm-d"]), ["csm-discrete"]);
    assert_eq!(offered(&["echogrid", "bench", "-m", "baye"]), ["bayes"]);
    assert_eq!(offered(&["echogrid", "plan", "a.log", "--backend", ""]), ["auto", "gpu", "cpu", "oracle"]);
    let keys = offered(&["echogrid", "map", "a.log", "--set", ""]);
    for entry in REGISTRY {
        for key in Settings::of(entry.name).unwrap().keys().iter().chain(OVERRIDE_KEYS) {
            assert!(keys.iter().any(|k| k.starts_with(&format!("{}=", key.name))), "{}: {keys:?}", key.name);
        }
    }
    assert_eq!(offered(&["echogrid", "map", "a.log", "-s", "order="]), ["order=batch", "order=sequential"]);
    assert_eq!(offered(&["echogrid", "map", "a.log", "-s", "r_m"]), ["r_max=", "r_min="]);
    assert_eq!(offered(&["echogrid", "simulate", "w.toml", "--rig", "ring"]), ["ring8", "ring24"]);
    // What takes a file, or a folder, is left to bash's own completion of files.
    for option in ["--output", "--sensor-file", "--classes"] {
        let found = offered(&["echogrid", "map", "a.log", option, "no_such_name"]);
        assert!(found.is_empty(), "{option}: {found:?}");
    }
    let fish = place.does(&["completions", "fish"]).out;
    let zsh = place.does(&["completions", "zsh"]).out;
    for name in methods {
        assert!(fish.contains(name) && zsh.contains(name), "{name}");
    }
    assert!(zsh.contains(":_files") && zsh.contains("_files -/"), "files, and folders");
}

#[test]
fn manual_pages() {
    let place = Place::new();
    let ran = place.does(&["man", "share/man1"]);
    assert_eq!(ran.out.trim_end(), std::path::Path::new("share/man1").join("echogrid.1").display().to_string());
    let names = place.names("share/man1");
    let page = |command: &str| format!("echogrid-{command}.1");
    for (command, options) in options() {
        assert!(names.contains(&page(command)), "{command}: {names:?}");
        let text = std::fs::read_to_string(place.path("share/man1").join(page(command))).unwrap();
        for option in options {
            let written = option.replace('-', "\\-");
            assert!(text.contains(&written), "{command} {option}");
        }
    }
    assert_eq!(names.len(), 1 + options().len());
}

/// A writer whose reader is gone.
fn closed() -> std::io::PipeWriter {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let place = Place::new();
    let program = place.command(&[]).get_program().to_os_string();
    let run = |arguments: &[&str], quiet: bool| {
        let mut command = std::process::Command::new(&program);
        command.args(arguments).current_dir(place.path("")).env("XDG_RUNTIME_DIR", place.path("run"));
        command.stdout(closed());
        if quiet {
            command.stderr(closed());
        }
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for arguments in [
        &["doctor"][..],
        &["doctor", "--json"],
        &["plan", "log.jsonl"],
        &["map", "log.jsonl", "-o", "out", "--backend", "cpu"],
        &["map", "log.jsonl", "-o", "out", "--backend", "cpu", "--json"],
        &["verify", "log.jsonl", "--backends", "cpu"],
        &["compare", "out", "out"],
        &["completions", "bash"],
        &["man", "pages"],
    ] {
        assert_eq!(run(arguments, false), (Some(0), String::new()), "{arguments:?}");
    }
    // Nor is there a panic where nobody hears the error.
    place.write("bad.jsonl", format!("{}garbage\n", crate::common::SMALL));
    assert_eq!(run(&["map", "nosuch.log", "-o", "out"], true).0, Some(3));
    assert_eq!(run(&["map", "bad.jsonl", "-o", "out", "--backend", "cpu"], true).0, Some(6));
}
