//! What a terminal shows while a map is made: bars that fit it, whatever its width, and nothing of them in what is said at the end.

#![cfg(target_os = "linux")]

use crate::common::Place;
use std::process::{Command, Stdio};

/// What `script` records of a command on a terminal of so many columns, escape sequences but for colours as `\r`; none, loudly, where there is no
/// `script`.
fn on_terminal(place: &Place, columns: usize, command: &str) -> Option<String> {
    let program = env!("CARGO_BIN_EXE_echogrid");
    let line = format!("stty cols {columns} rows 24; {}", command.replace("echogrid", program));
    let mut script = Command::new("script");
    script.args(["-qec", &line, "/dev/null"]).current_dir(place.path("")).stdin(Stdio::null());
    script.env("TERM", "xterm").env("XDG_RUNTIME_DIR", place.path("run")).env_remove("COLUMNS");
    let Ok(ran) = script.output() else {
        let _ =
            std::io::Write::write_all(&mut std::io::stderr(), b"SKIPPED: there is no `script` to make a terminal\n");
        return None;
    };
    let text = String::from_utf8_lossy(&ran.stdout).into_owned();
    let mut shown = String::new();
    let mut pieces = text.split('\x1b');
    shown += pieces.next().unwrap_or_default();
    for piece in pieces {
        let end = piece.find(|c: char| c.is_ascii_alphabetic()).map_or(piece.len(), |at| at + 1);
        shown += if piece[..end].ends_with('m') { "" } else { "\r" };
        shown += &piece[end..];
    }
    Some(shown)
}

/// A log of which a map takes some seconds.
fn campus() -> Place {
    let place = Place::new();
    place.write("campus.toml", "[campus]\nseed = 2\nwidth = 110\nheight = 90\n[rig]\nkind = \"ring24\"\n");
    place.does(&["simulate", "campus.toml", "-o", "campus.jsonl", "--scans", "3000", "--quiet"]);
    place
}

#[test]
fn bars_fit_the_terminal_and_name_their_stages() {
    let place = campus();
    for columns in [100, 40, 20] {
        let map = "echogrid map campus.jsonl -o out -m certainty -r 0.02 --backend cpu";
        let Some(shown) = on_terminal(&place, columns, map) else { return };
        // The summary is printed at the end and may be wrapped; bars have their stage and a share.
        let stages = ["reading", "sorting", "weighing", "mapping", "writing"];
        let bars: Vec<&str> =
            shown.split(['\r', '\n']).filter(|l| stages.iter().any(|s| l.starts_with(s))).map(str::trim_end).collect();
        for line in &bars {
            assert!(line.chars().count() <= columns, "{columns}: {line:?}");
            assert!(!line.contains('/'), "a share is told, not counts: {line:?}");
        }
        for stage in ["reading", "weighing", "mapping"] {
            let shares: Vec<u32> = bars
                .iter()
                .filter(|l| l.starts_with(stage))
                .filter_map(|l| l.split(" %").next()?.rsplit([' ', '█', '░']).next()?.parse().ok())
                .collect();
            assert!(bars.iter().any(|l| l.starts_with(stage)), "{columns}: no {stage}: {shown:?}");
            assert!(shares.is_sorted() && shares.iter().all(|s| *s <= 100), "{columns}, {stage}: {shares:?}");
        }
    }
}

#[test]
fn an_interrupted_bar_does_not_garble_what_is_said() {
    let place = campus();
    let map = "echogrid map campus.jsonl -o out -m certainty -r 0.01 --backend cpu";
    let Some(shown) = on_terminal(&place, 60, &format!("timeout --foreground -s INT 2 {map}; echo code $?")) else {
        return;
    };
    let lines: Vec<&str> = shown.split('\n').map(|l| l.trim_matches('\r')).collect();
    let said = lines.iter().position(|l| l.contains("interrupted: "));
    let said = said.unwrap_or_else(|| panic!("{shown:?}"));
    let message = lines[said].rsplit('\r').next().unwrap();
    assert!(message.starts_with("echogrid: interrupted: "), "{shown:?}");
    // `timeout` gives a code of its own.
    assert_eq!(lines[said + 1..].iter().filter(|l| !l.is_empty()).collect::<Vec<_>>(), [&"code 124"], "{shown:?}");
}
