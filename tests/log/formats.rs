//! Every example of `docs/formats.md` is read, and gives what the text around it says.

use echogrid::log::reading::{Record, Unused, classify};
use echogrid::log::{Log, Options, Problem};
use echogrid::sensor::{Kind, Mounts, SensorFile};
use std::io::Write;
use std::path::Path;

/// The fenced blocks of one kind.
fn examples(kind: &str) -> Vec<String> {
    let text = include_str!("../../docs/formats.md");
    let fence = format!("```{kind}\n");
    let blocks: Vec<String> = text.split(&fence).skip(1).map(|b| b.split("```").next().unwrap().to_string()).collect();
    assert!(!blocks.is_empty(), "no example of {kind}");
    blocks
}

fn open(text: &str) -> Log {
    Log::read(text.as_bytes(), &Options::default()).unwrap()
}

fn read(log: &Log) -> Vec<Record> {
    log.records().unwrap().map(|r| r.unwrap()).collect()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-12
}

#[test]
fn json_lines() {
    let log = open(&examples("jsonl")[0]);
    let header = log.header();
    assert_eq!((header.format, header.sensors.len(), header.classes.len()), ("echogrid-jsonl", 2, 2));
    let left = &header.sensors[0];
    assert_eq!((left.id.as_str(), left.half_width, left.hit_range), ("left", 15_f64.to_radians(), 4.0));
    assert_eq!((header.sensors[1].kind, header.sensors[1].r_max), (Kind::Laser, 80.0));
    let records = read(&log);
    assert_eq!(records.len(), 4);
    let first = records[0];
    assert!(near(first.pose.x, 1.1) && near(first.pose.y, 2.05) && near(first.pose.heading, 90_f64.to_radians()));
    assert_eq!((first.line, first.range, first.label), (2, 1.25, None));
    assert_eq!((records[1].pose.heading, records[1].label, records[1].sensor), (0.7, Some(2), 1));
    assert_eq!(records[2].range, f64::INFINITY);
    assert_eq!(classify(records[3], left), Err(Unused::NotANumber));
    // Again, from the start; and with a byte-order mark and CRLF.
    assert_eq!(read(&log).len(), 4);
    let windows = format!("\u{feff}{}", examples("jsonl")[0].replace('\n', "\r\n"));
    assert_eq!(read(&open(&windows)).len(), 4);
}

#[test]
fn one_kind_of_sensor() {
    let text = &examples("jsonl")[0];
    let laser = Options { kind: Some(Kind::Laser), ..Options::default() };
    let log = Log::read(text.as_bytes(), &laser).unwrap();
    let mut pass = log.records().unwrap();
    assert_eq!(pass.by_ref().map(|r| r.unwrap().sensor).collect::<Vec<_>>(), [1]);
    assert_eq!(pass.ignored(), 3);
    let sonars = text.replace("laser", "sonar");
    let error = Log::read(sonars.as_bytes(), &laser).unwrap_err();
    assert!(error.to_string().contains("no laser sensor"), "{error}");
}

#[test]
fn csv() {
    let blocks = examples("csv");
    let log = open(&blocks[0]);
    assert_eq!((log.header().format, log.header().sensors[0].half_width), ("echogrid-csv", 12.5_f64.to_radians()));
    let records = read(&log);
    assert_eq!(records.iter().map(|r| (r.line, r.scan)).collect::<Vec<_>>(), [(3, 0), (4, 1), (5, 2)]);
    assert_eq!((records[0].t, records[1].range), (0.0, f64::INFINITY));
    assert!(records[2].range.is_nan());

    let log = open(&blocks[1]);
    let ids: Vec<_> = log.header().sensors.iter().map(|s| s.id.as_str()).collect();
    assert_eq!(ids, ["0", "1", "2"]);
    let s = &log.header().sensors[2];
    assert_eq!((s.kind, s.r_min, s.r_max, s.no_echo_range), (Kind::Sonar, 0.15, 5.0, 0.0));
    assert_eq!((read(&log)[1].pose.heading, read(&log)[1].range), (1.57, f64::INFINITY));
    let laser = Options { kind: Some(Kind::Laser), ..Options::default() };
    assert_eq!(Log::read(blocks[1].as_bytes(), &laser).unwrap().header().sensors[0].kind, Kind::Laser);
}

#[test]
fn carmen() {
    let text = &examples("carmen")[0];
    let log = open(text);
    let sensors = &log.header().sensors;
    let ids: Vec<_> = sensors.iter().map(|s| (s.id.as_str(), s.r_max)).collect();
    assert_eq!(ids, [("FLASER/4", 50.0), ("RLASER/3", 80.0), ("ROBOTLASER1/3", 20.0)]);
    assert!(near(sensors[0].half_width.to_degrees(), 22.5) && near(sensors[1].half_width.to_degrees(), 45.0));
    let mut pass = log.records().unwrap();
    let records: Vec<Record> = pass.by_ref().map(|r| r.unwrap()).collect();
    assert_eq!((records.len(), pass.ignored()), (10, 2));
    let ranges: Vec<f64> = records[..4].iter().map(|r| r.range).collect();
    assert_eq!(ranges, [1.5, 2.5, 50.0, 81.91]);
    let silent = |r: &Record| classify(*r, &sensors[r.sensor as usize]) == Err(Unused::NoEcho);
    assert_eq!(records[..4].iter().map(silent).collect::<Vec<_>>(), [false, false, true, true]);
    let degrees = |r: &Record| (r.pose.heading - r.robot.heading).to_degrees();
    for (record, bearing) in records.iter().zip([-90.0, -45.0, 0.0, 45.0, 90.0, 180.0, 270.0]) {
        assert!((degrees(record) - bearing).abs() < 1e-9, "{record:?}");
    }
    assert_eq!((records[0].robot.x, records[0].pose.y, records[0].t, records[0].line), (0.1, 0.2, 12.5, 3));
    assert_eq!((records[7].pose.x, records[7].robot.x, records[7].t), (1.3, 1.0, 13.5));
    assert!(near(sensors[2].x, 0.3) && (records[8].range, records[9].range) == (20.0, 3.0));
    assert!(silent(&records[8]) && !silent(&records[9]));
    // Every sensor at the robot's centre, also where the log says otherwise.
    let mut options = Options::default();
    options.overrides.mounts = Some(Mounts::None);
    let centred = read(&Log::read(text.as_bytes(), &options).unwrap());
    assert_eq!((centred[7].pose.x, centred[7].pose.heading), (1.0, records[7].pose.heading));
    let sonar = Options { kind: Some(Kind::Sonar), ..Options::default() };
    assert!(Log::read(text.as_bytes(), &sonar).unwrap_err().to_string().contains("laser readings only"));
}

#[test]
fn sonar_ring_8_folder_and_sensor_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["sonar.txt", "od.txt"] {
        std::fs::write(folder.path().join(name), &examples(name)[0]).unwrap();
    }
    let log = Log::open(folder.path(), &Options::default()).unwrap();
    let records = read(&log);
    assert_eq!((log.header().format, records.len()), ("sonar_ring_8", 16));
    assert_eq!((records[0].range, records[2].range, records[15].range), (f64::INFINITY, 2.32, 1.18));
    assert!(near(records[8].robot.heading, 1.5_f64.to_radians()) && near(records[8].robot.x, 0.12));
    let both = examples("sonar.txt")[0].clone() + &examples("od.txt")[0];
    use sha2::Digest;
    let sum: String = sha2::Sha256::digest(both.as_bytes()).iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(log.sha256().unwrap(), sum);

    let toml = examples("toml").remove(0);
    let file = SensorFile::parse(Path::new("ring.toml"), &toml).unwrap();
    let left = file.sensors[1].complete(1).unwrap();
    assert_eq!((left.y, left.hit_range, left.half_width), (0.18, 3.0, 12.5_f64.to_radians()));
    let mut ring = tempfile::NamedTempFile::new().unwrap();
    ring.write_all(toml.as_bytes()).unwrap();
    let options = Options { sensor_file: Some(ring.path().into()), ..Options::default() };
    let error = Log::open(folder.path(), &options).unwrap_err().to_string();
    assert!(error.contains("describes 2 sensors, but the log has 8 (sonar0, "), "{error}");
}

#[test]
fn the_later_layer_wins() {
    let text = examples("jsonl").remove(0);
    let mut ring = tempfile::NamedTempFile::new().unwrap();
    ring.write_all(b"[[sensor]]\nr_max = 3\nx = 1\n[[sensor]]\n").unwrap();
    let mut options = Options { sensor_file: Some(ring.path().into()), ..Options::default() };
    options.overrides.set("hit_range", "2m").unwrap();
    let log = Log::read(text.as_bytes(), &options).unwrap();
    let (left, top) = (&log.header().sensors[0], &log.header().sensors[1]);
    assert_eq!((left.r_max, left.hit_range, left.x, left.y, left.id.as_str()), (3.0, 2.0, 1.0, 0.05, "left"));
    assert_eq!((top.r_max, top.hit_range), (80.0, 2.0));
    // The sensor file places the first sensor, not the second, whose poses the log gives.
    let records = read(&log);
    assert!(near(records[0].pose.x, 2.0));
    assert_eq!((records[1].pose.x, records[1].pose.heading), (1.0, 0.7));
    options.overrides.set("hit_range", "4m").unwrap();
    let error = Log::read(text.as_bytes(), &options).unwrap_err();
    assert_eq!(error.kind(), echogrid::ErrorKind::Usage);
    assert!(error.to_string().contains("sensor left: hit_range 4 m must not exceed r_max 3 m"), "{error}");
    // Only r_max is lowered: hit_range follows.
    let mut options = Options::default();
    options.overrides.set("r_max", "2").unwrap();
    let log = Log::read(text.as_bytes(), &options).unwrap();
    assert_eq!((log.header().sensors[0].hit_range, log.header().sensors[1].hit_range), (2.0, 2.0));
}

#[test]
fn a_gzip_stream_and_its_checksum() {
    let text = examples("jsonl").remove(0);
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gz.write_all(text.as_bytes()).unwrap();
    let log = Log::read(&gz.finish().unwrap()[..], &Options::default()).unwrap();
    assert_eq!((read(&log).len(), log.path()), (4, Path::new("<stdin>")));
    fn travels<T: Send>(_: &T) {}
    travels(&log);
    travels(&log.records().unwrap());
    // Two passes at once don't disturb each other.
    let (mut a, mut b) = (log.records().unwrap(), log.records().unwrap());
    assert_eq!(a.next().unwrap().unwrap(), b.next().unwrap().unwrap());
    assert_eq!(a.next().unwrap().unwrap(), b.next().unwrap().unwrap());
    assert!(!log.records().unwrap().any(|r| matches!(r, Err(Problem::Fatal(_)))));
}

#[test]
fn a_sensor_file_says_what_an_undescribed_csv_holds() {
    let text = examples("csv").remove(1);
    let mut ring = tempfile::NamedTempFile::new().unwrap();
    ring.write_all(b"[all]\nkind = 'laser'\n[[sensor]]\n[[sensor]]\n[[sensor]]\n").unwrap();
    let options = Options { sensor_file: Some(ring.path().into()), ..Options::default() };
    let log = Log::read(text.as_bytes(), &options).unwrap();
    assert!(log.header().sensors.iter().all(|s| s.kind == Kind::Laser && s.r_max == 80.0));
}

#[cfg(unix)]
#[test]
fn a_pipe_can_be_passed_twice() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let text = examples("carmen").remove(0);
    let writer = std::thread::spawn({
        let (pipe, text) = (pipe.clone(), text.clone());
        move || std::fs::write(pipe, text).unwrap()
    });
    let log = Log::open(&pipe, &Options::default()).unwrap();
    writer.join().unwrap();
    assert_eq!((read(&log).len(), read(&log).len()), (10, 10));
    assert_eq!(log.sha256().unwrap(), open(&text).sha256().unwrap());
}
