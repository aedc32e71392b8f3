//! Broken logs: each with the message it gives, and nothing ever panics.

use echogrid::log::{Log, Options, Problem};
use echogrid::{Error, ErrorKind};
use proptest::prelude::*;
use std::fs::File;
use std::io::Write;
use std::path::Path;

const HEADER: &str = "{\"echogrid_log\":1,\"sensors\":[{\"id\":\"front\"},{\"id\":\"back\"}],\"classes\":[\"wall\"]}\n";
const GOOD: &str = "{\"scan\":0,\"sensor\":0,\"px\":0,\"py\":0,\"ph\":0,\"z\":1}\n";

fn refused(bytes: &[u8]) -> String {
    let error = Log::read(bytes, &Options::default()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Input, "{error}");
    error.to_string()
}

/// Good records, and the messages of bad lines.
fn pass(log: &Log) -> (usize, Vec<String>) {
    let (mut good, mut bad) = (0, Vec::new());
    for record in log.records().unwrap() {
        match record {
            Ok(_) => good += 1,
            Err(problem) => bad.push(problem.to_string()),
        }
    }
    (good, bad)
}

fn read(bytes: &[u8]) -> (usize, Vec<String>) {
    pass(&Log::read(bytes, &Options::default()).unwrap())
}

fn gz(text: &str) -> Vec<u8> {
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
    gz.write_all(text.as_bytes()).unwrap();
    gz.finish().unwrap()
}

#[test]
fn no_log_at_all() {
    let error = Log::open(Path::new("no/such.log"), &Options::default()).unwrap_err();
    assert_eq!((error.to_string().as_str(), error.kind()), ("no/such.log: no such file or folder", ErrorKind::Input));
    assert_eq!(refused(b""), "<stdin>: is empty");
    assert_eq!(refused(&gz("")), "<stdin>: is empty once unpacked");
    let file = tempfile::NamedTempFile::new().unwrap();
    let error = Log::open(file.path(), &Options::default()).unwrap_err().to_string();
    assert!(error.ends_with(": is empty"), "{error}");
    let noise: Vec<u8> = (0..5000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    assert!(refused(&noise).contains("is binary, not a log. Known are: a sonar_ring_8 folder"));
    assert!(refused(b"Dear diary,\n").contains("is of no known format; line 1 is 'Dear diary,'. A table"));
    assert!(refused(b"BZh91AY").contains("packed with bzip2: unpack it first"));
    assert!(refused(b"1686487 0 0 0\n").contains("name the folder"));
    let folder = tempfile::tempdir().unwrap();
    let error = Log::open(folder.path(), &Options::default()).unwrap_err().to_string();
    assert!(error.contains("no log in this folder"), "{error}");
    std::fs::write(folder.path().join("sonar.txt"), "1 2 3 4 5 6 7 8 9\n").unwrap();
    let error = Log::open(folder.path(), &Options::default()).unwrap_err().to_string();
    assert!(error.contains("without its poses: no od.txt or poses.txt"), "{error}");
}

#[test]
fn a_bad_spool_folder() {
    let options = Options { spool: Some("no/such/folder".into()), ..Options::default() };
    let error = Log::read(HEADER.as_bytes(), &options).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Resources);
    assert!(error.to_string().contains("can't be copied to a temporary file in no/such/folder"), "{error}");
}

#[test]
fn truncated_gzip_is_fatal_after_the_whole_lines() {
    let packed = gz(&format!("{HEADER}{}", GOOD.repeat(5000)));
    let log = Log::read(&packed[..packed.len() - 5000], &Options::default()).unwrap();
    let mut last = None;
    let mut good = 0;
    for record in log.records().unwrap() {
        match record {
            Ok(_) => good += 1,
            Err(problem) => last = Some(problem),
        }
    }
    assert!((4500..5000).contains(&good), "{good}");
    let Some(Problem::Fatal(error @ Error::Input { line: Some(_), .. })) = last else { panic!("{last:?}") };
    let text = error.to_string();
    assert!(text.contains("truncated") && text.contains("gzip -dc"), "{text}");
    let mut damaged = packed;
    let end = damaged.len() - 6;
    damaged[end] ^= 0x55;
    let (_, bad) = read(&damaged);
    assert!(bad.len() == 1 && bad[0].contains("damaged"), "{bad:?}");
}

#[test]
fn what_follows_gzip_is_passed_over_and_said() {
    let (one, two) = (gz(&format!("{HEADER}{GOOD}")), gz(&GOOD.repeat(3000)));
    let zeros = |n: usize| vec![0; n];
    let other = |n: usize| {
        format!(
            "what follows its gzip data ({n} B) is no gzip and is passed over: if it belongs to the log, fetch it again"
        )
    };
    let many = 600 << 10;
    for (packed, good, note) in [
        ([&one[..], &two].concat(), 3001, None),
        ([&one[..], &zeros(512), &two].concat(), 3001, None),
        ([&one[..], &two, &zeros(1)].concat(), 3001, Some("zeros after its gzip data are passed over (1 B)".into())),
        ([&one[..], &zeros(many)].concat(), 1, Some(format!("zeros after its gzip data are passed over ({many} B)"))),
        ([&one[..], b"garbage"].concat(), 1, Some(other(7))),
        ([&one[..], b"\x1f"].concat(), 1, Some(other(1))),
        ([&one[..], &zeros(512), b"garbage"].concat(), 1, Some(other(519))),
        ([&one[..], &vec![b'x'; many]].concat(), 1, Some(other(many))),
    ] {
        let log = Log::read(&packed[..], &Options::default()).unwrap();
        for _ in 0..2 {
            assert_eq!(
                (pass(&log), log.notes()),
                ((good, Vec::new()), note.iter().cloned().collect()),
                "{}",
                packed.len()
            );
        }
    }
    // What begins as gzip and isn't, or ends too early, stays an error.
    for packed in [
        [&one[..], b"\x1f\x8bnot gzip at all"].concat(),
        [&one[..], &two[..two.len() - 100]].concat(),
        [&one[..], &two[..4]].concat(),
    ] {
        let (_, bad) = read(&packed);
        assert!(bad.len() == 1 && (bad[0].contains("truncated") || bad[0].contains("damaged")), "{bad:?}");
    }
}

/// A log's readings, bad lines, notes and checksum.
fn whole(log: &Log) -> (usize, Vec<String>, Vec<String>, String) {
    let (good, bad) = pass(log);
    (good, bad, log.notes(), log.sha256().unwrap())
}

fn sha256(bytes: &[u8]) -> String {
    use sha2::{Digest, Sha256};
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn a_log_that_grows_is_read_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.jsonl");
    let append = |text: &str| File::options().append(true).open(&path).unwrap().write_all(text.as_bytes()).unwrap();
    let start = format!("{HEADER}{}", GOOD.repeat(20_000));
    // The last line whole, and half of it written; a CSV log, too.
    for (half, kept) in [("", 20_000), ("{\"scan\":0,\"sensor\":0,\"px\":0,\"py\":0,\"ph\":0,\"z\":1", 20_000)] {
        std::fs::write(&path, format!("{start}{half}")).unwrap();
        let log = Log::open(&path, &Options::default()).unwrap();
        append(&format!("2}}\n{GOOD}"));
        let (good, bad, notes, sum) = whole(&log);
        assert_eq!((good, bad.len()), (kept, 0), "{bad:?}");
        assert_eq!(sum, sha256(start.as_bytes()));
        assert!(
            notes[0].starts_with("another program is writing it: it is read as it was when it was opened"),
            "{notes:?}"
        );
        assert_eq!(notes.iter().any(|n| n.contains("half written")), !half.is_empty(), "{notes:?}");
        append(&GOOD.repeat(5000));
        assert_eq!(whole(&log), (good, bad, notes, sum));
    }
}

#[test]
fn a_log_that_is_changed_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.jsonl");
    let start = format!("{HEADER}{}", GOOD.repeat(20_000));
    std::fs::write(&path, &start).unwrap();
    let log = Log::open(&path, &Options::default()).unwrap();
    assert_eq!(pass(&log), (20_000, Vec::new()));
    let name = path.display();
    std::fs::write(&path, start.replace("\"z\":1}", "\"z\":2}")).unwrap();
    let (_, bad) = pass(&log);
    let what = format!(
        "{name}: was changed while it was read, after byte 0: map it again when nothing writes it, or map a copy"
    );
    assert_eq!(bad, [what.as_str()]);
    assert_eq!(log.sha256().unwrap_err().to_string(), what);
    std::fs::write(&path, &start[..start.len() / 2]).unwrap();
    let (_, bad) = pass(&log);
    let what = format!("{name}: became shorter while it was read: map it again when nothing writes it, or map a copy");
    assert_eq!(bad, [what]);
}

#[test]
fn a_folder_whose_files_grow_is_read_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let [sonar, poses] = ["sonar.txt", "od.txt"].map(|name| folder.path().join(name));
    let rows = |range: std::ops::Range<u32>, of: &str| range.map(|t| format!("{t} {of}\n")).collect::<String>();
    let (ranges, pose) = ("1000 1000 1000 1000 1000 1000 1000 1000", "0 0 0");
    std::fs::write(&sonar, rows(0..500, ranges) + "500 1000 10").unwrap();
    std::fs::write(&poses, rows(0..490, pose)).unwrap();
    let log = Log::open(folder.path(), &Options::default()).unwrap();
    let append =
        |path: &Path, text: &str| File::options().append(true).open(path).unwrap().write_all(text.as_bytes()).unwrap();
    append(&sonar, "00 1000 1000 1000 1000 1000 1000\n");
    append(&poses, &rows(490..600, pose));
    for _ in 0..2 {
        assert_eq!(pass(&log), (490 * 8, Vec::new()));
    }
    let notes = log.notes();
    assert!(notes.iter().any(|n| n.starts_with("rows at the end of one file")), "{notes:?}");
    assert!(notes.iter().any(|n| n.starts_with("sonar.txt: another program is writing it")), "{notes:?}");
    assert_eq!(log.sha256().unwrap(), sha256((rows(0..500, ranges) + &rows(0..490, pose)).as_bytes()));
}

#[test]
fn headers() {
    for (text, what) in [
        ("{\"scan\":0}\n", "the first line must be the header"),
        ("{\"stamp\":0,\"ranges\":[1]}\n", "it has no \"echogrid_log\"; a log of another kind needs this header"),
        ("\n# of a robot\n{\"stamp\":0}\n", ":3: the first line must be the header"),
        ("{\"stamp\":0,\"ranges\":[1]}\n", "; the line is '{\\\"stamp\\\":0,\\\"ranges\\\":[1]}'"),
        ("{\"echogrid_log\":1,\"sensors\":[}\n", "; the line is '{\\\"echogrid_log"),
        ("{\"echogrid_log\":2,\"sensors\":[{}]}\n", "echogrid_log is 2: this program reads version 1"),
        ("{\"echogrid_log\":1,\"sensors\":[]}\n", "lists no sensors"),
        ("{\"echogrid_log\":1,\"sensor\":[]}\n", "unknown key \"sensor\"; did you mean \"sensors\"?"),
        ("{\"echogrid_log\":1,\"sensors\":[{\"r_mxa\":3}]}\n", "unknown key \"r_mxa\"; did you mean \"r_max\"?"),
        ("{\"echogrid_log\":1,\"sensors\":[{\"half_width\":2}]}\n", "half_width takes 0 to 60deg"),
        ("{\"echogrid_log\":1,\"sensors\":[{\"r_min\":9}]}\n", "sensor 0: r_min 9 m must be below r_max 5 m"),
        ("{\"echogrid_log\":1,\"sensors\":[{\"beams\":9}]}\n", "beams has no place here"),
        ("{\"echogrid_log\":1,\"sensors\":[{\"id\":\"a\"},{\"id\":\"a\"}]}\n", "two sensors are called \"a\""),
        ("t,scan,sensor,px,py,ph,range\n", "unknown column 'range'"),
        ("t,scan,sensor,px,py,ph\n", "no column is called z"),
        ("t,scan,scan,px,py,ph,z\n", "two columns are called scan"),
        ("# {\"echogrid_log\":3,\"sensors\":[{}]}\nscan,px,py,ph,z\n", "reads version 1"),
        ("# {\"echogrid_log\":1,\"sensors\":[{}]}\n", "no row of column names"),
        ("ODOM 0 0 0 0 0 0 1 h 1\n", "nothing to map"),
    ] {
        let error = refused(text.as_bytes());
        assert!(error.contains(what), "{text}: {error}");
    }
    // Blank lines and comments may stand before it.
    assert_eq!(read(format!("\n  \n# of a robot\n{HEADER}{GOOD}").as_bytes()), (1, Vec::new()));
    // What the header gets wrong, --set may mend.
    let mut options = Options::default();
    options.overrides.set("r_min", "10cm").unwrap();
    assert!(Log::read(&b"{\"echogrid_log\":1,\"sensors\":[{\"r_min\":9}]}\n"[..], &options).is_ok());
}

#[test]
fn bad_json_lines() {
    for (line, what) in [
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":0}"#, "z is missing"),
        (r#"{"sensor":0,"px":0,"py":0,"ph":0,"z":1}"#, "scan is missing"),
        (r#"{"scan":0,"px":0,"py":0,"ph":0,"z":1}"#, "sensor is missing"),
        (r#"{"scan":0,"sensor":0,"px":0,"ph":0,"z":1}"#, "py is missing"),
        (r#"{"scan":0,"sensor":2,"px":0,"py":0,"ph":0,"z":1}"#, "sensor 2: the log has 2 sensors"),
        (r#"{"scan":0,"sensor":"fornt","px":0,"py":0,"ph":0,"z":1}"#, "did you mean \"front\"?"),
        (r#"{"scan":0,"sensor":-1,"px":0,"py":0,"ph":0,"z":1}"#, "a sensor's id or its index"),
        (r#"{"scan":0,"sensor":0,"px":"inf","py":0,"ph":0,"z":1}"#, "the robot's x is inf"),
        (r#"{"scan":0,"sensor":0,"px":0,"py":2e6,"ph":0,"z":1}"#, "y is 2000000 m, farther than 1e6 m"),
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":-2e4,"z":1}"#, "heading is -20000 rad, more than 1e4 rad"),
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":"NaN","z":1}"#, "the robot's heading is NaN"),
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":0,"x":1,"z":1}"#, "x, y and h go together"),
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":0,"z":"far"}"#, "expected a number, \"NaN\""),
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":0,"z":NaN}"#, "JSON has no bare NaN"),
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":0,"z":1,"lable":1}"#, "did you mean \"label\"?"),
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":0,"z":1,"label":2}"#, "label 2: the log has classes 1 to 1"),
        (r#"{"scan":0,"sensor":0,"px":0,"py":0,"ph":0,"z":1,"label":0}"#, "label 0"),
        (r#"{"scan":0,"sensor":0,"px":0,"#, "EOF"),
        ("plain text", "expected value"),
    ] {
        let (good, bad) = read(format!("{HEADER}{GOOD}{line}\n{GOOD}").as_bytes());
        assert_eq!((good, bad.len()), (2, 1), "{line}");
        assert!(bad[0].starts_with("line 3: ") && bad[0].contains(what), "{line}: {}", bad[0]);
    }
}

#[test]
fn broken_ranges_are_passed_on_to_be_counted() {
    let line = |z: &str| format!("{{\"scan\":0,\"sensor\":0,\"px\":0,\"py\":0,\"ph\":0,\"z\":{z}}}\n");
    let text: String = ["\"NaN\"", "\"inf\"", "\"-inf\"", "-1", "null"].iter().map(|z| line(z)).collect();
    let log = Log::read(format!("{HEADER}{text}").as_bytes(), &Options::default()).unwrap();
    let ranges: Vec<String> = log.records().unwrap().map(|r| r.unwrap().range.to_string()).collect();
    assert_eq!(ranges, ["NaN", "inf", "-inf", "-1", "inf"]);
    // A jump of the robot is no reason to leave a line out.
    let jump = GOOD.replace("\"px\":0", "\"px\":5000");
    assert_eq!(read(format!("{HEADER}{GOOD}{jump}").as_bytes()), (2, Vec::new()));
}

#[test]
fn long_lines_and_other_text() {
    let mut text = format!("{HEADER}{GOOD}").into_bytes();
    text.extend(vec![b'x'; 10 << 20]);
    text.extend(b"\n{\"scan\":\"\xff\"}\n");
    text.extend(GOOD.as_bytes());
    let (good, bad) = read(&text);
    assert_eq!(good, 2);
    assert_eq!(bad, ["line 3: longer than 1 MiB", "line 4: not UTF-8 text: byte 10 is 0xff"]);
}

#[test]
fn bad_carmen_lines() {
    let good = "FLASER 2 1 2 0 0 0 0 0 0 1.0 h 1.0\n";
    let robot = "ROBOTLASER1 0 -1.57 3.14 1.57 20 0.01 0 2 1 2 0 1 2 0 1 2 0 0 0 0 0 0 1.0 h 1.0\n";
    assert_eq!(read(format!("{good}{robot}").as_bytes()), (4, Vec::new()));
    for (line, what) in [
        ("FLASER 3 1 2 0 0 0 0 0 0 1.0 h 1.0", "expected 14 fields for 3 beams, found 13"),
        ("FLASER 2 1 2 nan 0 0 0 0 0 1.0 h 1.0", "the laser's x is NaN"),
        ("FLASER 2 1 2 0 1e7 0 0 0 0 1.0 h 1.0", "the laser's y is 10000000 m, farther"),
        ("FLASER 2 1 two 0 0 0 0 0 0 1.0 h 1.0", "field 4 is 'two', not a number"),
        ("FLASER 2 1 2 0 0 0 0 0 0 nan h 1.0", "the time stamp is NaN"),
        ("FLASER 1 1 0 0 0 0 0 0 1.0 h 1.0", "with 1 beams"),
        ("FLASER many", "field 2 is 'many', not a count"),
        ("FLASER", "with only 1 fields"),
        ("FLASER 4294967295 1", "expected 4294967306 fields"),
        ("ROBOTLASER1 0 -1.57", "with only 3 fields"),
        ("ROBOTLASER1 0 -1.57 3.14 0 20 0.01 0 2 1 2 0 1 2 0 1 2 0 0 0 0 0 0 1.0 h 1.0", "is no angle"),
        ("some \u{7}text", "'some' is no CARMEN message"),
    ] {
        let (ok, bad) = read(format!("{good}{line}\n{good}").as_bytes());
        assert_eq!((ok, bad.len()), (4, 1), "{line}: {bad:?}");
        assert!(bad[0].starts_with("line 2: ") && bad[0].contains(what), "{line}: {}", bad[0]);
    }
    let whole = format!("{good}FLASER 2 nan -1 0 0 0 0 0 0 1.0 h 1.0\nFLASER 2 inf 80 0 0 0 0 0 0 1.0 h 1.0\n");
    let log = Log::read(whole.as_bytes(), &Options::default()).unwrap();
    let ranges: Vec<String> = log.records().unwrap().map(|r| r.unwrap().range.to_string()).collect();
    assert_eq!(ranges, ["1", "2", "NaN", "-1", "inf", "80"]);
}

#[test]
fn bad_csv_lines() {
    let names = "t,scan,sensor,px,py,ph,z\n";
    let (good, bad) = read(format!("{names}0,0,a,0,0,0,1\n0,1,a,0,0,1\n0,x,a,0,0,0,1\n0,2,a,0,0,0,1m\n").as_bytes());
    assert_eq!(good, 1);
    let whats = ["expected 7 cells, found 6", "scan is 'x', not a count", "z is '1m', not a number"];
    for ((bad, what), line) in bad.iter().zip(whats).zip(3..) {
        assert_eq!(*bad, format!("line {line}: {what}"));
    }
}

#[test]
fn rows_that_do_not_match() {
    let folder = tempfile::tempdir().unwrap();
    let row = |t: u32| format!("{t} 1000 1000 1000 1000 1000 1000 1000 1000\n");
    let pose = |t: u32| format!("{t} 0 0 0\n");
    let check = |sonar: &str, od: &str, scans: usize, what: &[&str]| {
        std::fs::write(folder.path().join("sonar.txt"), sonar).unwrap();
        std::fs::write(folder.path().join("od.txt"), od).unwrap();
        let (good, bad) = pass(&Log::open(folder.path(), &Options::default()).unwrap());
        assert_eq!((good, bad.len()), (scans * 8, what.len()), "{bad:?}");
        for (bad, what) in bad.iter().zip(what) {
            assert!(bad.contains(what), "{bad}, not {what}");
        }
    };
    let rows = |ts: &[u32]| ts.iter().map(|t| row(*t)).collect::<String>();
    let poses = |ts: &[u32]| ts.iter().map(|t| pose(*t)).collect::<String>();
    let all = [1, 2, 3, 4, 5];
    check(&rows(&all), &poses(&all), 5, &[]);
    check(&rows(&all), &poses(&[1, 2, 4, 5]), 4, &["line 3: sonar.txt: od.txt has no row of this time stamp (3 ms)"]);
    check(
        &rows(&[1, 5]),
        &poses(&all),
        2,
        &["line 2: od.txt: sonar.txt has no row"; 3].map(|_| "od.txt: sonar.txt has no row"),
    );
    check(&rows(&all), &poses(&[1, 2, 3]), 3, &["(4 ms)", "(5 ms)"]);
    check(
        &rows(&all),
        &poses(&[1, 2, 900, 4, 5]),
        4,
        &["time stamps differ: 3 ms in sonar.txt, 900 ms in line 3 of od.txt"],
    );
    check(
        &format!("{}1 2\n{}", row(1), row(3)),
        &poses(&[1, 2, 3]),
        2,
        &["line 2: sonar.txt: expected 9 fields, found 2"],
    );
    check(&rows(&[3, 4]), &poses(&[900, 3, 4]), 2, &["line 1: od.txt: sonar.txt has no row"]);
    check(&format!("{}?\n{}", row(1), rows(&[2, 3])), &poses(&[1, 2, 3]), 3, &["line 2: sonar.txt: expected 9 fields"]);
    check(&rows(&[1, 2]), "1 0 0 0\n2 nan 0 0\n", 1, &["line 2: od.txt: the robot's x is NaN"]);
    check(&rows(&[1, 2]), "1 0 0 0\n2 0 two 0\n", 1, &["line 2: od.txt: field 3 is 'two', not a number"]);
    check(&rows(&[1, 2]), "1 0 0 0\n2 9e9 0 0\n", 1, &["x is 9000000 m, farther than 1e6 m"]);
}

proptest! {
    #[test]
    fn nothing_panics(seed in 0usize..4, at in proptest::collection::vec((0.0..1.0f64, any::<u8>()), 0..12), cut in 0.0..1.0f64) {
        let jsonl = format!("{HEADER}{GOOD}{GOOD}");
        let csv = "# {\"echogrid_log\":1,\"sensors\":[{}]}\nt,scan,sensor,px,py,ph,z\n0,0,0,0,0,0,1\n";
        let carmen = "PARAM robot_front_laser_max 50 h 1\nFLASER 2 1 2 0 0 0 0 0 0 1.0 h 1.0\n\
            ROBOTLASER1 0 -1.57 3.14 1.57 20 0.01 0 2 1 2 0 1 2 0 1 2 0 0 0 0 0 0 1.0 h 1.0\n";
        let packed = gz(carmen);
        let mut bytes = [jsonl.as_bytes(), csv.as_bytes(), carmen.as_bytes(), &packed][seed].to_vec();
        for (place, byte) in at {
            let i = (place * bytes.len() as f64) as usize;
            bytes[i] = byte;
        }
        bytes.truncate((bytes.len() as f64 * (1.0 - cut * cut)) as usize);
        if let Ok(log) = Log::read(&bytes[..], &Options::default()) {
            prop_assert!(log.records().unwrap().count() < 100);
            prop_assert_eq!(log.sha256().unwrap().len(), 64);
        }
    }
}
