//! `echogrid view` as a command.

use crate::common::Place;
use crate::web::parts;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};

/// The command, listening; and its first line.
fn start(place: &Place, arguments: &[&str]) -> (Child, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_echogrid"))
        .args(arguments)
        .current_dir(place.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    (child, line.trim_end().to_string())
}

#[cfg(unix)]
#[test]
fn it_says_where_it_listens_and_ends_with_ctrl_c() {
    let place = Place::new();
    place.map("m", &[]);
    let (mut child, line) = start(&place, &["view", "m"]);
    let (at, token) = parts(&line);
    assert!(at.ip().is_loopback());
    let mut stream = std::net::TcpStream::connect(at).unwrap();
    write!(stream, "GET /{token}/api/session HTTP/1.1\r\nHost: {at}\r\n\r\n").unwrap();
    let session = crate::web::reply(&mut stream).unwrap().json();
    assert_eq!((&session["mode"], &session["name"]), (&"map".into(), &"m".into()));
    let process = rustix::process::Pid::from_raw(child.id() as i32).unwrap();
    rustix::process::kill_process(process, rustix::process::Signal::INT).unwrap();
    let code = child.wait().unwrap().code();
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!(code, Some(0), "{err}");
    assert!(err.contains(&format!("ssh -L {0}:127.0.0.1:{0} HOST", at.port())), "{err}");
}

#[cfg(unix)]
#[test]
fn a_log_with_a_bad_line_is_opened_and_the_line_named() {
    let place = Place::new();
    place.write("bad.jsonl", crate::common::SMALL.replacen("\"z\":1.5", "\"z\":tru", 1));
    let (mut child, line) = start(&place, &["view", "bad.jsonl", "-m", "certainty", "--beside", "bayes"]);
    let (at, token) = parts(&line);
    let mut stream = std::net::TcpStream::connect(at).unwrap();
    write!(stream, "GET /{token}/api/session HTTP/1.1\r\nHost: {at}\r\n\r\n").unwrap();
    let session = crate::web::reply(&mut stream).unwrap().json();
    assert_eq!((&session["mode"], &session["name"]), (&"log".into(), &"bad.jsonl".into()));
    let names: Vec<_> = session["sources"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["certainty", "bayes"]);
    let process = rustix::process::Pid::from_raw(child.id() as i32).unwrap();
    rustix::process::kill_process(process, rustix::process::Signal::INT).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert!(err.contains("1 bad line was left out") && err.contains("--strict refuses such a log"), "{err}");
    let strict = place.run(&["view", "bad.jsonl", "--strict"]);
    assert_eq!(strict.code, 3, "{strict:?}");
}

#[test]
fn a_log_that_cant_be_looked_at() {
    let place = Place::new();
    let wanted = "write standard input to a file, and give that";
    assert!(place.run(&["view", "-"]).err.contains(wanted));
    let ran = place.run(&["view", "log.jsonl", "-m", "baies"]);
    assert!(ran.code == 2 && ran.err.contains("did you mean \"bayes\""), "{ran:?}");
    let ran = place.run(&["view", "log.jsonl", "--beside", "certanty"]);
    assert!(ran.code == 2 && ran.err.contains("did you mean \"certainty\""), "{ran:?}");
    let ran = place.run(&["view", "log.jsonl", "--memory", "1MiB"]);
    assert!(ran.code == 5 && ran.err.contains("--memory"), "{ran:?}");
    place.map("m", &[]);
    let ran = place.run(&["view", "m/map.zarr"]);
    assert!(ran.code == 3 && ran.err.contains("a saved map is a folder with report.json and map.zarr"), "{ran:?}");
    let ran = place.run(&["view", "nothing.jsonl"]);
    assert!(ran.code == 3 && ran.err.contains("nothing.jsonl"), "{ran:?}");
}

#[test]
fn a_port_that_is_taken() {
    let place = Place::new();
    place.map("m", &[]);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let ran = place.run(&["view", "m", "--port", &port]);
    assert_eq!(ran.code, 5);
    assert!(ran.err.contains(&format!("127.0.0.1:{port} can't be listened on")), "{ran:?}");
    assert!(ran.err.contains("give another --port"), "{ran:?}");
}

#[test]
fn what_does_not_go_together() {
    let place = Place::new();
    place.map("m", &[]);
    place.map("coarse", &["-r", "0.1"]);
    for (more, option) in [
        (&["-m", "himm"][..], "--method"),
        (&["-r", "0.1"], "--resolution"),
        (&["--bounds", "0,0,1,1"], "--bounds"),
        (&["--set", "epsilon=0.1"], "--set"),
        (&["--until", "3"], "--until"),
    ] {
        let message =
            format!("echogrid: {option} is for logs: m is a map, made already; `echogrid map` makes one anew");
        place.refuses(&[&["view", "m"], more].concat(), 2, &message);
    }
    for option in ["--with", "--truth"] {
        let message =
            format!("echogrid: {option} is for maps: log.jsonl is none, a folder with report.json and map.zarr");
        place.refuses(&["view", "log.jsonl", option, "m"], 2, &message);
    }
    let cells = "coarse has cells of 0.1 m, the map that it is laid on of 0.05 m: make both with one --resolution";
    place.refuses(&["view", "m", "--with", "coarse"], 2, &format!("echogrid: {cells}"));
    let none = "it is no echogrid map: a folder with report.json and map.zarr is wanted";
    place.refuses(&["view", "m", "--with", "run"], 3, &format!("echogrid: run: {none}"));
    let ran = place.run(&["view", "m", "--truth", "m", "--memory", "1kB"]);
    assert_eq!(ran.code, 5);
    assert!(ran.err.contains("--memory allows 1 KiB: look at it without --truth"), "{ran:?}");
}
