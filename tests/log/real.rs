//! The logs of real robots, where they are at hand: `$ECHOGRID_DATA`, or `../shared/data` beside the repository.

use crate::data::data;
use echogrid::log::reading::{Counts, Record, Unused, classify};
use echogrid::log::{Log, Options, Problem};
use echogrid::sensor::{Kind, Overrides};

fn read(log: &Log) -> Vec<Record> {
    log.records().unwrap().map(|r| r.unwrap()).collect()
}

fn count(log: &Log) -> Counts {
    let mut counts = Counts::default();
    for record in read(log) {
        counts.add(&classify(record, &log.header().sensors[record.sensor as usize]));
    }
    counts
}

#[test]
fn the_sonar_ring_with_literal_values() {
    let Some(path) = data("sonar_ring_8/test1") else { return };
    let mut options = Options::default();
    for (key, value) in [
        ("beta", "15deg"),
        ("mounts", "none"),
        ("r_min", "0.17"),
        ("r_max", "5"),
        ("hit_range", "5m"),
        ("no_echo_range", "500cm"),
    ] {
        assert!(options.overrides.set(key, value).unwrap());
    }
    let log = Log::open(&path, &options).unwrap();
    assert_eq!((log.header().format, log.header().sensors.len()), ("sonar_ring_8", 8));
    let counts = count(&log);
    assert_eq!((counts.read, counts.used, counts.no_echo), (3304, 3304, 1091));
    assert_eq!(counts.rejected, Default::default());
    let records = read(&log);
    assert_eq!(records.last().unwrap().scan, 412);
    for r in &records {
        let axis = log.header().sensors[r.sensor as usize].axis;
        assert_eq!((r.pose.x, r.pose.y, r.pose.heading), (r.robot.x, r.robot.y, r.robot.heading + axis));
    }
}

#[test]
fn the_sonar_ring_with_its_preset_and_under_its_other_name() {
    let Some(path) = data("sonar_ring_8/test1") else { return };
    let log = Log::open(&path, &Options::default()).unwrap();
    let first = read(&log)[0];
    assert!((first.pose.y + 0.18).abs() < 1e-12 && first.pose.x.abs() < 1e-12, "{first:?}");
    assert_eq!((first.t, first.line, first.range), (1686.487, 1, f64::INFINITY));
    let Some(twin) = data("sonar_ring_8/udacity_mit") else { return };
    let twin = Log::open(&twin, &Options::default()).unwrap();
    assert_eq!(read(&twin), read(&log));
    assert_eq!(twin.sha256().unwrap(), log.sha256().unwrap());
}

#[test]
fn the_rings_laser() {
    let Some(path) = data("sonar_ring_8/test1") else { return };
    let log = Log::open(&path, &Options { kind: Some(Kind::Laser), ..Options::default() }).unwrap();
    let records = read(&log);
    assert_eq!((log.header().sensors.len(), records.len()), (1, 413 * 361));
    let heading = |i: usize| (records[i].pose.heading - records[i].robot.heading).to_degrees();
    assert!((heading(0) + 90.0).abs() < 1e-9 && (heading(360) - 90.0).abs() < 1e-9);
    assert_eq!(records[0].range, 12.24);
}

#[test]
fn carmen_logs() {
    for (name, scans, beams, r_max) in [
        ("carmen_corrected/intel-corrected.log.gz", 910_u64, 180_u32, 80.0),
        ("carmen_corrected/freiburg-079-corrected.log.gz", 4791, 360, 80.0),
        ("carmen_corrected/aces-corrected.log.gz", 440, 180, 50.0),
    ] {
        let Some(path) = data(name) else { return };
        let log = Log::open(&path, &Options::default()).unwrap();
        let sensors = &log.header().sensors;
        assert_eq!((log.header().format, sensors.len()), ("carmen", 1));
        let s = &sensors[0];
        assert_eq!((s.kind, s.r_max, s.hit_range, s.no_echo_range), (Kind::Laser, r_max, r_max, 0.0), "{name}");
        assert!((s.half_width.to_degrees() * f64::from(beams) - 90.0).abs() < 1e-9);
        let mut pass = log.records().unwrap();
        let mut records = 0;
        let mut last = 0;
        let mut none = 0;
        for record in &mut pass {
            let record = record.unwrap();
            records += 1;
            last = record.scan;
            none += u64::from(classify(record, s) == Err(Unused::NoEcho));
        }
        assert_eq!((records, last), (scans * u64::from(beams), scans - 1), "{name}");
        assert!(pass.ignored() > 1000);
        println!("{name}: {records} records, {none} without return, {} lines ignored", pass.ignored());
        // As many as have the code: 50 m, 81.91 m, 81.83 m.
        let silent = match name {
            _ if name.contains("aces") => 620,
            _ if name.contains("freiburg") => 36004,
            _ => 4172,
        };
        assert_eq!(none, silent, "{name}");
        assert!(log.notes().iter().any(|n| n.contains(&format!("({silent})"))), "{:?}", log.notes());
    }
}

#[test]
fn a_log_written_out_reads_back_the_same() {
    let Some(path) = data("sonar_ring_8/test2") else { return };
    let log = Log::open(&path, &Options::default()).unwrap();
    let mut writer = echogrid::log::Writer::new(Vec::new(), &log.header().sensors, &[]).unwrap();
    for record in read(&log) {
        writer.write(&record).unwrap();
    }
    let bytes = writer.finish().unwrap();
    let again = Log::read(&bytes[..], &Options::default()).unwrap();
    assert_eq!(again.header().sensors, log.header().sensors);
    let unlined = |log: &Log| read(log).into_iter().map(|r| Record { line: 0, ..r }).collect::<Vec<_>>();
    assert_eq!(unlined(&again), unlined(&log));
    // A copy carries the sensors' poses; mounts=none still beats them.
    let mut overrides = Overrides::default();
    overrides.set("mounts", "none").unwrap();
    let centred = Log::read(&bytes[..], &Options { overrides, ..Options::default() }).unwrap();
    for r in read(&centred) {
        assert_eq!((r.pose.x, r.pose.y), (r.robot.x, r.robot.y));
    }
}

#[test]
fn a_truncated_gzip_is_an_error_that_says_so() {
    let Some(path) = data("carmen_corrected/intel-corrected.log.gz") else { return };
    let bytes = std::fs::read(path).unwrap();
    let error = Log::read(&bytes[..bytes.len() / 2], &Options::default()).unwrap_err().to_string();
    assert!(error.contains("truncated") && error.contains("gzip -dc"), "{error}");
    let whole = Log::read(&bytes[..], &Options::default()).unwrap();
    assert!(!whole.records().unwrap().any(|r| matches!(r, Err(Problem::Fatal(_)))));
}
