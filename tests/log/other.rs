//! Logs of courses, old robots and other programs, made here in a room whose walls are known: every hit must lie on one of them, so that a
//! mirrored bearing, a shifted pose or another unit shows.

use echogrid::log::reading::{Pose, Record};
use echogrid::log::{Log, Options, Problem};
use echogrid::sensor::Kind;
use proptest::prelude::*;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// A room without any symmetry: x0, y0, x1, y1.
const ROOM: [f64; 4] = [-2.0, -1.5, 3.0, 2.5];
/// A robot's way through it, headings from −π to π, turning both ways.
const WAY: [(f64, f64, f64); 4] = [(0.0, 0.0, 0.0), (0.5, 0.2, 0.7), (0.9, -0.4, -2.2), (1.5, 1.0, 3.0)];

fn pose(k: usize) -> Pose {
    let (x, y, heading) = WAY[k];
    Pose { x, y, heading }
}

/// The distance to the wall.
fn cast(at: &Pose, bearing: f64) -> f64 {
    let (s, c) = (at.heading + bearing).sin_cos();
    let [x0, y0, x1, y1] = ROOM;
    // Along a wall it is never met.
    let to = |low: f64, high: f64, at: f64, along: f64| match along {
        0.0 => f64::INFINITY,
        along => (if along > 0.0 { high - at } else { low - at }) / along,
    };
    to(x0, x1, at.x, c).min(to(y0, y1, at.y, s))
}

fn bearings(n: usize, first: f64, step: f64) -> Vec<f64> {
    (0..n).map(|k| (first + k as f64 * step).to_radians()).collect()
}

fn ranges(at: &Pose, bearings: &[f64]) -> Vec<f64> {
    bearings.iter().map(|b| cast(at, *b)).collect()
}

fn joined(values: &[f64], scale: f64, digits: usize, between: &str) -> String {
    values.iter().map(|v| format!("{:.digits$}", v * scale)).collect::<Vec<_>>().join(between)
}

fn read(log: &Log) -> Vec<Record> {
    log.records().unwrap().map(|r| r.unwrap()).collect()
}

/// Good records, and what is said of the others.
fn pass(log: &Log) -> (usize, Vec<String>) {
    let (good, bad): (Vec<_>, Vec<_>) = log.records().unwrap().partition(Result::is_ok);
    (good.len(), bad.into_iter().map(|p: Result<Record, Problem>| p.unwrap_err().to_string()).collect())
}

fn open(text: &str, options: &Options) -> Log {
    Log::read(text.as_bytes(), options).unwrap()
}

fn plain(text: &str) -> Log {
    open(text, &Options::default())
}

fn refused(bytes: &[u8], options: &Options) -> String {
    Log::read(bytes, options).unwrap_err().to_string()
}

fn columns(names: &str) -> Options {
    Options { columns: Some(names.into()), ..Options::default() }
}

/// Every finite range ends on a wall; there are so many of them, at so many poses.
fn on_walls(records: &[Record], hits: usize, poses: usize, tolerance: f64) {
    let found: Vec<&Record> = records.iter().filter(|r| r.range.is_finite()).collect();
    assert_eq!(found.len(), hits);
    let mut scans: Vec<u64> = found.iter().map(|r| r.scan).collect();
    scans.dedup();
    assert_eq!(scans.len(), poses, "scans");
    for record in found {
        let (s, c) = record.pose.heading.sin_cos();
        let (x, y) = (record.pose.x + record.range * c, record.pose.y + record.range * s);
        let [x0, y0, x1, y1] = ROOM;
        let inside = x > x0 - tolerance && x < x1 + tolerance && y > y0 - tolerance && y < y1 + tolerance;
        let wall = [x - x0, x - x1, y - y0, y - y1].iter().map(|d| d.abs()).fold(f64::INFINITY, f64::min);
        assert!(inside && wall < tolerance, "({x}, {y}) of {record:?}");
    }
}

/// A file in a folder of its own.
fn file(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

// ---- CMU

fn cmu() -> String {
    let beams = bearings(180, -90.0, 1.0);
    let mut text = String::from("O 1 2 0.1 0.06\n");
    for k in 0..WAY.len() {
        let robot = pose(k);
        let laser = robot.compose(0.25, 0.0, 0.0);
        let mut r = ranges(&laser, &beams);
        r[3] = 81.83;
        let p = |p: &Pose| format!("{:.4} {:.4} {:.6}", 100.0 * p.x, 100.0 * p.y, p.heading);
        writeln!(text, "L {} {} {} {k}.5", p(&robot), p(&laser), joined(&r, 100.0, 0, " ")).unwrap();
        writeln!(text, "O {} {k}.6", p(&robot)).unwrap();
    }
    text
}

#[test]
fn cmu_logs() {
    let log = plain(&cmu());
    assert_eq!((log.header().format, log.header().sensors.len()), ("cmu", 1));
    assert!((log.header().sensors[0].x, log.header().sensors[0].kind) == (0.25, Kind::Laser));
    let mut records = log.records().unwrap();
    let all: Vec<Record> = records.by_ref().map(|r| r.unwrap()).collect();
    assert_eq!((all.len(), records.ignored()), (720, 5));
    on_walls(&all, 4 * 179, 4, 0.011);
    assert_eq!((all[3].range, all[180].t, all[180].line), (f64::INFINITY, 1.5, 4));
    assert!((all[0].pose.x - all[0].robot.x - 0.25).abs() < 1e-9);
    // Bad lines one by one.
    let good = cmu();
    let first = good.lines().nth(1).unwrap();
    let fields = |n: usize| first.split(' ').take(n).collect::<Vec<_>>().join(" ");
    for (line, what) in [
        (fields(100), "expected 188 fields in an L line, found 100"),
        (first.replacen("L 0.0000", "L nan", 1), "the robot's x is NaN"),
        (first.replacen("L 0.0000", "L far", 1), "field 2 is 'far', not a number"),
        ("X 1 2".into(), "'X' is neither L nor O"),
        (format!("{} never", fields(187)), "field 188 is 'never'"),
    ] {
        let (found, bad) = pass(&plain(&format!("{good}{line}\n{first}\n")));
        assert_eq!((found, bad.len()), (900, 1), "{bad:?}");
        assert!(bad[0].starts_with("line 10: ") && bad[0].contains(what), "{}", bad[0]);
    }
    let sonar = Options { kind: Some(Kind::Sonar), ..Options::default() };
    assert!(refused(good.as_bytes(), &sonar).contains("leave out --sensor sonar"));
}

// ---- ARIA

fn aria(points: bool) -> String {
    let beams = bearings(181, -90.0, 1.0);
    let mut text = String::from(
        "LaserOdometryLog\n#Created by hand\nversion: 3\nsick1pose: 160 -70 0.00\nsick1conf: -90 90 181\n",
    );
    for k in 0..WAY.len() {
        let robot = pose(k);
        let r = ranges(&robot.compose(0.16, -0.07, 0.0), &beams);
        let (x, y, turn) = (1000.0 * robot.x, 1000.0 * robot.y, robot.heading.to_degrees());
        writeln!(text, "scan1Id: {k}\ntime: {k}.25\nvelocities: 0 0 0\nrobot: {x:.0} {y:.0} {turn:.4}").unwrap();
        if points {
            let pair = |(b, r): (&f64, &f64)| {
                format!("{:.0} {:.0}", 160.0 + 1000.0 * r * b.cos(), -70.0 + 1000.0 * r * b.sin())
            };
            let pairs: Vec<String> = beams.iter().zip(&r).map(pair).collect();
            writeln!(text, "scan1: {}  0 0", pairs.join("  ")).unwrap();
        } else {
            writeln!(text, "sick1: {}", joined(&r, 1000.0, 0, " ")).unwrap();
        }
    }
    text + "# End of log\n"
}

#[test]
fn aria_logs() {
    for points in [false, true] {
        let log = plain(&aria(points));
        assert_eq!(log.header().format, "aria");
        let laser = &log.header().sensors[0];
        assert!((laser.x - 0.16).abs() < 1e-9 && (laser.y + 0.07).abs() < 1e-9);
        assert!((laser.half_width.to_degrees() - 0.5).abs() < 1e-9, "{laser:?}");
        let all = read(&log);
        on_walls(&all, 4 * 181, 4, 0.003);
        assert_eq!(all[181].t, 1.25);
    }
    // Corrected poses hold where there are some, and that is said.
    let mut moved = aria(false).replace("robot: ", "robotGlobal: ");
    moved = moved.replace("robotGlobal: ", "robot: 9000 9000 90\nrobotGlobal: ");
    let log = plain(&moved);
    on_walls(&read(&log), 4 * 181, 4, 0.003);
    assert!(log.notes()[0].contains("robotGlobal"), "{:?}", log.notes());
    // No returns: SICK's codes.
    let far = aria(false).replacen("sick1: ", "sick1: 8191 ", 1);
    let cut = far.replacen("sick1conf: -90 90 181", "sick1conf: -90 90 182", 1);
    assert_eq!(plain(&cut).header().sensors[0].r_max, 8.183);
    let (good, bad) = pass(&plain(&far));
    assert_eq!((good, bad.len()), (3 * 181, 1));
    assert!(bad[0].ends_with("expected 181 ranges, as sick1conf says, found 182"), "{}", bad[0]);
    for (from, to, what) in [
        ("robot: 0 0 ", "robot: 0 here ", "field 3 is 'here', not a number"),
        ("robot: 0 0 ", "rob: 0 0 ", "a scan without the robot's pose before it"),
        ("robot: 0 0 ", "robot: 9e12 0 ", "farther than 1e6 m"),
    ] {
        let (_, bad) = pass(&plain(&aria(false).replacen(from, to, 1)));
        assert!(bad.iter().any(|bad| bad.contains(what)), "{bad:?}");
    }
    let bare = refused(aria(false).replace("sick1conf", "#").as_bytes(), &Options::default());
    assert!(bare.contains("no sick1conf: line"), "{bare}");
    assert!(refused(b"LaserOdometryLog\nversion: 1\n", &Options::default()).contains("nothing to map"));
}

// ---- Player

fn player(old: bool) -> String {
    let beams = bearings(181, -90.0, 1.0);
    let mut text = String::from("## Player version 2.1.1\n## File version 0.3.0\n");
    if !old {
        text += "10.000 16777343 6665 laser 00 004 001 +0.200 +0.100 0.500 0.156 0.155\n";
        text += "10.000 16777343 6665 sonar 00 004 001 2 0.1 0.2 1.570796 0.15 -0.1 -0.785398\n";
    }
    // The robot stands still at each scan, a second between; positions come before and after it.
    for k in 0..WAY.len() {
        let robot = pose(k);
        let place = if old { Pose::default() } else { Pose { x: 0.2, y: 0.1, heading: 0.5 } };
        let r = ranges(&robot.compose(place.x, place.y, place.heading), &beams);
        let t = 100.0 + k as f64;
        let readings: String = r.iter().map(|z| format!("{z:.4} 0 ")).collect();
        let position = |t: f64, text: &mut String| {
            let p = format!("{:+.4} {:+.4} {:+.5} 0 0 0", robot.x, robot.y, robot.heading);
            match old {
                true => writeln!(text, "{t:.3} fly 6665 position 00 {t:.3} {p}").unwrap(),
                false => writeln!(text, "{t:.3} 16777343 6665 position2d 00 001 001 {p} 0").unwrap(),
            }
        };
        position(t - 0.1, &mut text);
        match old {
            true => {
                writeln!(text, "{t:.3} fly 6665 laser 00 {t:.3} -1.5708 +1.5708 0.017453 181 {readings}").unwrap();
            }
            false => {
                let head = format!("{k:04} -1.5708 +1.5708 +0.01745329 +8.0000 0181");
                writeln!(text, "{t:.3} 16777343 6665 laser 00 001 001 {head} {readings}").unwrap();
                let ring = [(0.1, 0.2, PI / 2.0), (0.15, -0.1, -PI / 4.0)];
                let z: Vec<f64> = ring.iter().map(|(x, y, a)| cast(&robot.compose(*x, *y, *a), 0.0)).collect();
                writeln!(text, "{t:.3} 16777343 6665 sonar 00 001 001 2 {}", joined(&z, 1.0, 4, " ")).unwrap();
            }
        }
        position(t + 0.1, &mut text);
    }
    text
}

#[test]
fn player_logs() {
    let log = plain(&player(false));
    let ids: Vec<&str> = log.header().sensors.iter().map(|s| s.id.as_str()).collect();
    assert_eq!((log.header().format, ids), ("player", vec!["laser:0", "sonar:0/0", "sonar:0/1"]));
    assert_eq!((log.header().sensors[0].r_max, log.header().sensors[1].kind), (8.0, Kind::Sonar));
    on_walls(&read(&log), 4 * 183, 8, 0.002);
    let laser = Options { kind: Some(Kind::Laser), ..Options::default() };
    on_walls(&read(&open(&player(false), &laser)), 4 * 181, 4, 0.002);
    let old = plain(&player(true));
    on_walls(&read(&old), 4 * 181, 4, 0.002);
    assert!(old.notes().is_empty(), "{:?}", old.notes());
    // Without its first lines it is known all the same.
    let bare: String = player(false).lines().skip(2).map(|line| format!("{line}\n")).collect();
    assert_eq!(read(&plain(&bare)).len(), 4 * 183);
}

#[test]
fn player_poses_are_those_of_the_scans_times() {
    // Between two positions the robot has gone half of the way.
    let line = |t: f64, what: &str| format!("{t} 1 6665 {what}\n");
    let scan = |t: f64| line(t, "laser 0 1 1 0 -0.1 0.1 0.2 8 2 1.0 0 2.0 0");
    let at = |t: f64, x: f64, h: f64| line(t, &format!("position2d 0 1 1 {x} 0 {h} 0 0 0 0"));
    let text = at(1.0, 0.0, 3.1) + &scan(1.5) + &at(2.0, 1.0, -3.1) + &scan(9.0) + &scan(0.5);
    let log = plain(&text);
    let all = read(&log);
    assert_eq!(all.len(), 2);
    assert!((all[0].robot.x - 0.5).abs() < 1e-9 && (all[0].robot.heading.abs() - PI).abs() < 1e-9);
    assert!(log.notes()[0].starts_with("2 scans were left out: at their times there is no pose"), "{:?}", log.notes());
    // Scans that carry the pose, and Player 3's rangers.
    let carried = line(1.0, "laser 0 1 2 0 1.5 -0.5 0.25 -0.1 0.1 0.2 8 2 1.0 0 2.0 0");
    let all = read(&plain(&carried));
    assert_eq!((all[1].robot.x, all[1].robot.heading, all[1].range), (1.5, 0.25, 2.0));
    let geometry = line(0.0, "ranger 0 4 1 0.1 0 0 0 0 0 0.1 0.1 0.1 2 0 0.2 0 0 0 1.5 0 -0.2 0 0 0 -1.5 0");
    let ranger = geometry + &at(1.0, 0.0, 0.0) + &line(1.0, "ranger 0 1 1 2 1.0 2.0");
    let all = read(&plain(&ranger));
    assert!(
        (all[0].pose.x - 0.1).abs() < 1e-9
            && (all[0].pose.y - 0.2).abs() < 1e-9
            && (all[1].pose.heading + 1.5).abs() < 1e-9
    );
    let config = line(0.0, "ranger 0 4 5 -1.0 1.0 0.5 0.1 6.0 0.01 10");
    let ranger = config + &at(1.0, 0.0, 0.0) + &line(1.0, "ranger 0 1 1 5 1 2 3 4 7");
    let log = plain(&ranger);
    let all = read(&log);
    assert_eq!((log.header().sensors[0].r_max, log.header().sensors[0].r_min), (6.0, 0.1));
    assert!(all.len() == 5 && (all[4].pose.heading - 1.0).abs() < 1e-9);
}

#[test]
fn player_logs_that_lack_something() {
    let sonar = "1.0 1 6665 sonar 0 1 1 2 1.0 2.0\n1.0 1 6665 position2d 0 1 1 0 0 0 0 0 0 0\n";
    assert!(refused(sonar.as_bytes(), &Options::default()).contains("that say where their beams look"));
    let scan = "1.0 1 6665 laser 0 1 1 0 -0.1 0.1 0.2 8 2 1.0 0 2.0 0\n";
    assert!(refused(scan.as_bytes(), &Options::default()).contains("no poses of the robot"));
    let pose = "1.0 1 6665 position2d 0 1 1 0 0 0 0 0 0 0\n";
    for (line, what) in [
        ("1.0 1 6665 laser 0 1 1 0 -0.1 0.1 0.2 8 3 1.0 0 2.0 0", "don't fit the count"),
        ("1.0 1 6665 laser zero 1 1 0", "field 5 is 'zero', not an index"),
        ("never 1 6665 laser 0 1 1 0", "field 1 is 'never', not a number"),
        ("1.0 1 6665 position2d 0 1 1 0 0", "a position2d message with only 2 numbers"),
        ("1.0 1 6665", "expected time, host"),
    ] {
        let (good, bad) = pass(&plain(&format!("{pose}{scan}{line}\n")));
        assert_eq!((good, bad.len()), (2, 1), "{line}");
        assert!(bad[0].starts_with("line 3: ") && bad[0].contains(what), "{}", bad[0]);
    }
    let two = format!("{pose}{scan}{}", scan.replace("6665", "6666"));
    let log = plain(&two);
    assert_eq!(read(&log).len(), 2);
    assert!(log.notes()[0].contains("1 messages of other robots"), "{:?}", log.notes());
}

// ---- ROS topics

fn scans_csv() -> String {
    let beams = bearings(90, -120.0, 2.5);
    let names: Vec<String> = (0..90).map(|k| format!("field.ranges{k}")).collect();
    let mut text = format!(
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.angle_min,field.angle_max,field.angle_increment,\
         field.time_increment,field.scan_time,field.range_min,field.range_max,{},field.intensities0\n",
        names.join(",")
    );
    for k in 0..WAY.len() {
        let r = joined(&ranges(&pose(k), &beams), 1.0, 5, ",");
        let stamp = 1_500_000_000_000_000_000u64 + k as u64 * 1_000_000_000;
        let head = "-2.094395102,1.789528,0.0436332313,0.0,0.1,0.12,10.0";
        writeln!(text, "{stamp},{k},{stamp},base_scan,{head},{r},0").unwrap();
    }
    text
}

/// Odometry half a second before and after each scan, where the robot stands still.
fn odom_csv() -> String {
    let mut text = String::from(
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.child_frame_id,field.pose.pose.position.x,\
         field.pose.pose.position.y,field.pose.pose.position.z,field.pose.pose.orientation.x,field.pose.pose.orientation.y,\
         field.pose.pose.orientation.z,field.pose.pose.orientation.w,field.twist.twist.linear.x\n",
    );
    for k in 0..WAY.len() {
        let Pose { x, y, heading } = pose(k);
        for half in [-400_000_000i64, 400_000_000] {
            let stamp = 1_500_000_000_000_000_000i64 + k as i64 * 1_000_000_000 + half;
            let (s, c) = (heading / 2.0).sin_cos();
            writeln!(text, "{stamp},0,{stamp},odom,base,{x},{y},0.0,0.0,0.0,{s},{c},0.5").unwrap();
        }
    }
    text
}

fn posed(path: &Path) -> Options {
    Options { poses: Some(path.into()), ..Options::default() }
}

#[test]
fn topics_with_poses_of_another_file() {
    let (_folder, path) = file("odom.csv", &odom_csv());
    let log = open(&scans_csv(), &posed(&path));
    let sensor = &log.header().sensors[0];
    assert_eq!(
        (log.header().format, sensor.id.as_str(), sensor.r_min, sensor.r_max),
        ("rostopic", "base_scan", 0.12, 10.0)
    );
    let all = read(&log);
    on_walls(&all, 4 * 90, 4, 0.001);
    assert_eq!((all[0].t, all[90].line), (1_500_000_000.0, 3));
    assert!(log.notes()[0].contains("doesn't say where its sensors sit (base_scan)"), "{:?}", log.notes());
    // The same from ros2 topic echo --csv, which writes no names.
    let bare = |text: &str, drop: &[usize]| -> String {
        let row = |line: &str| {
            let cells = line.split(',').enumerate().filter(|(i, _)| !drop.contains(i)).map(|(_, cell)| cell);
            let cells: Vec<&str> = cells.collect();
            let stamp: u64 = cells[0].parse().unwrap();
            format!("{},{},{}\n", stamp / 1_000_000_000, stamp % 1_000_000_000, cells[1..].join(","))
        };
        text.lines().skip(1).map(row).collect()
    };
    let (scans, odom) = (bare(&scans_csv(), &[1, 2, 101]), bare(&odom_csv(), &[1, 2]));
    let (_folder, path) = file("odom.csv", &odom);
    let log = open(&scans, &posed(&path));
    on_walls(&read(&log), 4 * 90, 4, 0.001);
    // A bag converter's names.
    let bagpy = scans_csv().replace("%time", "Time").replace("field.ranges", "ranges_").replace("field.", "");
    on_walls(&read(&open(&bagpy, &posed(&path))), 4 * 90, 4, 0.001);
    // The checksum runs over both files.
    let alone = Options { poses: None, ..posed(&path) };
    assert!(refused(scans.as_bytes(), &alone).contains("no poses of the robot"));
    use sha2::Digest;
    let sum: String = sha2::Sha256::digest((scans + &odom).as_bytes()).iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(log.sha256().unwrap(), sum);
}

#[test]
fn a_range_topic() {
    let text = "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.radiation_type,field.field_of_view,field.min_range,\
                field.max_range,field.range\n\
                1000000000,0,1000000000,left,0,0.5,0.1,4.0,1.5\n\
                2000000000,0,2000000000,front,1,0.02,0.2,2.0,inf\n\
                3000000000,0,3000000000,left,0,0.5,0.1,4.0,-inf\n\
                4000000000,0,4000000000,left,0,0.5,0.1,4.0,nan\n";
    let (_folder, path) = file("tum.txt", "# a trajectory\n0 0 0 0 0 0 0 1\n4 2 0 0 0 0 0 1\n");
    let log = open(text, &posed(&path));
    let found: Vec<_> = log.header().sensors.iter().map(|s| (s.id.as_str(), s.kind, s.half_width, s.r_max)).collect();
    assert_eq!(found, [("left", Kind::Sonar, 0.25, 4.0), ("front", Kind::Laser, 0.01, 2.0)]);
    let all = read(&log);
    assert_eq!((all[0].robot.x, all[0].range, all[1].sensor, all[1].range), (0.5, 1.5, 1, f64::INFINITY));
    assert!(all[2].range == f64::NEG_INFINITY && all[3].range.is_nan());
    let two = text.lines().take(3).map(|l| format!("{l}\n")).collect::<String>();
    let (_, bad) = pass(&open(&format!("{two}5,6,7\n"), &posed(&path)));
    assert_eq!(bad, ["line 4: expected 9 cells, found 3"]);
    let (_folder, odom) = file("odom.csv", &odom_csv());
    let text = refused(text.as_bytes(), &posed(&odom));
    assert!(
        text.contains("don't meet: poses from 1499999999.600") && text.contains("readings from 1.000 to 4.000"),
        "{text}"
    );
    assert!(refused(odom_csv().as_bytes(), &Options::default()).contains("holds poses, no ranges"));
}

#[test]
fn poses_in_whatever_form() {
    let scan = "t,range\n1,2\n3,2\n";
    let log_of = |poses: &str, named: Option<&str>| {
        let (_folder, path) = file("poses", poses);
        let pose_columns = named.map(str::to_string);
        Log::read(
            scan.as_bytes(),
            &Options { pose_columns, ..Options { columns: Some("t,range".into()), ..posed(&path) } },
        )
    };
    for (poses, named) in [
        ("0 0 10 0\n4 4 10 1.5707963267948966\n", None),
        ("0,0,10,0\n4,4,10,1.5707963267948966\n", None),
        ("time;x;y;yaw_deg\n0;0,0;10,0;0\n4;4,0;10,0;90,0\n", None),
        ("0 0 10 0 0 0 0 1\n4 4 10 0 0 0 0.7071067811865476 0.7071067811865476\n", None),
        ("0,9,90,0,1000\n4000,9,0,4000,1000\n", Some("t:ms,-,heading:deg,x:mm,y:cm")),
    ] {
        let log = log_of(poses, named).unwrap();
        let all = read(&log);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        // The last one's headings go down.
        let turn = if named.is_some() { 67.5 } else { 22.5f64 };
        assert!(near(all[0].robot.x, 1.0) && near(all[0].robot.y, 10.0), "{poses}: {:?}", all[0]);
        assert!(near(all[0].pose.heading, turn.to_radians()), "{poses}: {:?}", all[0]);
    }
    for (poses, named, what) in [
        ("1 2 3\n", None, "3 columns: what they are isn't known; name them with --pose-columns"),
        ("stamp,a,b\n1,2,3\n", None, "name its columns: --pose-columns t,-*2"),
        ("", None, "is empty"),
        ("a b c d\n", Some("t,x,y,heading"), "holds no pose"),
        ("0 0 0 nan\n", None, "heading is NaN"),
        ("0 0 0 0\n", Some("x,y,heading"), "poses are t, x, y and heading"),
    ] {
        let error = log_of(poses, named).unwrap_err().to_string();
        assert!(error.contains(what), "{poses}: {error}");
    }
    let lone = Options { pose_columns: Some("t,x,y,heading".into()), ..Options::default() };
    assert!(refused(cmu().as_bytes(), &lone).contains("give it with --poses FILE"));
    // In place of a log's own poses, with the sensor where it was on the robot.
    let (_folder, path) = file("poses", "0 0 0 0\n9 0 0 0\n");
    let log = open(&cmu(), &posed(&path));
    let all = read(&log);
    assert!(
        (all[200].robot.x, all[200].robot.heading) == (0.0, 0.0) && (all[200].pose.x - 0.25).abs() < 1e-5,
        "{:?}",
        all[200]
    );
    assert!(log.notes().iter().any(|note| note.contains("the log's own poses are not used")), "{:?}", log.notes());
}

// ---- tables

#[test]
fn columns_of_a_table() {
    let beams = bearings(36, 0.0, 10.0);
    // A reading a row, with its bearing clockwise in degrees; other columns between.
    let mut one = String::from("id;time_ms;px;py;yaw;bat;bearing;dist\n");
    // A scan a row, blanks between.
    let mut rows = String::new();
    for k in 0..WAY.len() {
        let Pose { x, y, heading } = pose(k);
        let all = ranges(&pose(k), &beams);
        for (beam, z) in beams.iter().zip(&all) {
            let line = format!(
                "7;{k}000;{x:.2};{y:.2};{:.3};12.1;{:.2};{:.2}",
                heading.to_degrees(),
                -beam.to_degrees(),
                100.0 * z
            );
            writeln!(one, "{}", line.replace('.', ",")).unwrap();
        }
        writeln!(rows, "{k} {x} {y} {heading} 0 {}", joined(&all, 1000.0, 0, " ")).unwrap();
    }
    let laser = |names: &str| Options { kind: Some(Kind::Laser), ..columns(names) };
    let log = open(&one, &laser("-,t:ms,x,y,heading:deg,-,angle:-deg,range:cm"));
    let all = read(&log);
    on_walls(&all, 144, 4, 0.002);
    assert_eq!((log.header().format, all[40].t, all[40].line), ("table", 1.0, 42));
    assert!(log.notes()[0].contains("decimal commas"), "{:?}", log.notes());
    for names in [
        "t,x,y,heading,-,range:mm*36",
        "t,px,py,ph,_,range*36:mm",
        "t,x,y,theta,-,range:mm…",
        "t,x,y,yaw,-,ranges:mm...",
    ] {
        let mut options = laser(names);
        // From the right, the axis in the middle: the first beam looks ahead, so the sensor looks back.
        options.overrides.set("fov", "360deg").unwrap();
        let log = open(&rows, &options);
        let sensor = log.header().sensors[0].clone();
        assert!((sensor.half_width.to_degrees() - 5.0).abs() < 1e-9, "{sensor:?}");
        let turned: Vec<Record> = read(&log)
            .into_iter()
            .map(|mut r| {
                r.pose.heading += PI;
                r
            })
            .collect();
        on_walls(&turned, 144, 4, 0.002);
    }
    // A plain sonar, no header, tabs; empty and "inf" are no echo.
    let log = open("0\t1\t2\t0.5\t3\n1\t1\t2\t0.5\t\n2\t1\t2\t0.5\tinf\n", &columns("t,x,y,heading,range"));
    let all = read(&log);
    assert_eq!(all.iter().map(|r| r.range).collect::<Vec<_>>(), [3.0, f64::INFINITY, f64::INFINITY]);
    assert_eq!(
        (all[0].pose.x, all[0].pose.heading, all[2].scan, log.header().sensors[0].kind),
        (1.0, 0.5, 2, Kind::Sonar)
    );
    assert!(log.notes()[0].contains("taken to be a sonar's"), "{:?}", log.notes());
    // Sensors by name, scans and labels, and the sensor's own pose.
    let log = open(
        "s,px,py,ph,x,y,h,z,l\nleft,0,0,0,1,2,3,4,2\nright,0,0,0,-1,2,3,4,\n",
        &columns("sensor,px,py,ph,x,y,h,range,label"),
    );
    let all = read(&log);
    assert_eq!(
        (all[0].pose, all[0].label, all[1].sensor, all[1].label),
        (Pose { x: 1.0, y: 2.0, heading: 3.0 }, Some(2), 1, None)
    );
    assert_eq!((log.header().sensors[1].id.as_str(), all[1].scan), ("right", 0));
}

#[test]
fn a_ring_of_sonars_in_a_row_wants_a_sensor_file() {
    let text = "0 0 0 0 1 2\n1 0 0 0 1 2\n";
    let ring = Options { kind: Some(Kind::Sonar), ..columns("t,x,y,heading,range*2") };
    assert!(refused(text.as_bytes(), &ring).contains("describe them in a --sensor-file"));
    let (_folder, path) = file("ring.toml", "[[sensor]]\naxis = '90deg'\nx = 0.1\n[[sensor]]\naxis = '-90deg'\n");
    let all = read(&open(text, &Options { sensor_file: Some(path), ..ring }));
    assert!(
        (all[0].pose.heading - 90f64.to_radians()).abs() < 1e-9
            && (all[1].pose.heading + 90f64.to_radians()).abs() < 1e-9
    );
    assert_eq!((all[0].pose.x, all[1].range, all[2].scan), (0.1, 2.0, 1));
    let laser = Options { kind: Some(Kind::Laser), ..columns("t,x,y,heading,range*2") };
    assert!(refused(text.as_bytes(), &laser).contains("give --set fov=180deg"));
    assert!(refused(text.as_bytes(), &columns("t,x,y,heading,range*2")).contains("say --sensor laser"));
    // The beams as a sensor file lays them out.
    let (_folder, path) = file("laser.toml", "[[sensor]]\nkind = 'laser'\nfirst = '-45deg'\nstep = '90deg'\n");
    let all = read(&open(text, &Options { sensor_file: Some(path), ..laser }));
    assert!((all[1].pose.heading - 45f64.to_radians()).abs() < 1e-9);
}

#[test]
fn what_is_wrong_with_columns_is_said() {
    let text = "1 2 3 4 5\n";
    for (names, what) in [
        ("t,x,y,heading", "no column is called range"),
        ("t,x,y,range", "the robot's pose is x, y and heading"),
        ("range", "without x, y and heading it needs t"),
        ("t,x,y,heading,rnge", "'rnge': no such column; did you mean \"range\"?"),
        ("t,t,x,y,heading,range", "two columns are t"),
        ("t:min,x,y,heading,range", "its unit is one of s, ms, us, ns"),
        ("t,x,y,heading:mm,range", "its unit is one of rad, deg, -rad, -deg"),
        ("t,x,y,heading,range*0", "a count is a whole number"),
        ("t,x,y,heading,range...,-...", "… can be given once"),
        ("t,x,y,heading,range,-", "expected 6 cells, as --columns says, found 5"),
        ("t,x,y,heading,range,angle*2", "expected 7 cells, as --columns says, found 5"),
    ] {
        let error = refused(text.as_bytes(), &columns(names));
        assert!(error.contains(what), "{names}: {error}");
    }
    let (good, bad) = pass(&open(
        "t,x,y,h,r\n0,0,0,0,1\n1,0,0,1\n2,0,zero,0,1\n3,0,0,0,1\nnan,0,0,0,1\n",
        &columns("t,x,y,heading,range"),
    ));
    assert_eq!(good, 2);
    assert_eq!(bad, ["line 3: expected 5 cells, found 4", "line 4: y is 'zero', not a number", "line 6: t is NaN"]);
    // A header that nobody named shows the line that fits it; so do numbers.
    for (text, what) in [
        ("timestamp,pos_x,pos_y,yaw,distance_cm\n1,2,3,4,5\n", "--columns t,x,y,heading,range:cm; - skips one"),
        ("a;b;c\n1;2;3\n", "--columns -*3 (no column is called range)"),
        ("t,scan,sensor,px,py,ph,range\n", "unknown column 'range'"),
        ("t,scan,sensor,px,py,ph,range\n", "--columns t,scan,sensor,px,py,ph,range"),
        ("1.5 2.5 3.5 4.5 5.5\n", "say what its 5 columns hold, such as --columns t,x,y,heading,range"),
    ] {
        let error = refused(text.as_bytes(), &Options::default());
        assert!(error.contains(what), "{text}: {error}");
    }
}

// ---- MATLAB and Octave

fn matrix(name: &str, rows: &[Vec<f64>]) -> String {
    let lines: String = rows.iter().map(|row| format!(" {}\n", joined(row, 1.0, 6, " "))).collect();
    format!(
        "# name: {name}\n# type: matrix\n# rows: {}\n# columns: {}\n{lines}\n\n",
        rows.len(),
        rows.first().map_or(0, Vec::len)
    )
}

fn turned(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..rows[0].len()).map(|j| rows.iter().map(|row| row[j]).collect()).collect()
}

#[test]
fn octave_matrices() {
    let beams = bearings(31, -75.0, 5.0);
    let poses: Vec<Vec<f64>> = (0..4).map(|k| vec![WAY[k].0, WAY[k].1, WAY[k].2]).collect();
    let scans: Vec<Vec<f64>> = (0..4).map(|k| ranges(&pose(k), &beams)).collect();
    let row = std::slice::from_ref(&beams);
    let head = "# Created by Octave 6.4.0, Mon Jan 01 00:00:00 2024 GMT <me@here>\n".to_string();
    for (p, r, a) in [
        (poses.clone(), scans.clone(), row.to_vec()),
        (turned(&poses), turned(&scans), turned(row)),
        (poses.clone(), turned(&scans), row.to_vec()),
    ] {
        let text = head.clone() + &matrix("poses", &p) + &matrix("scans", &r) + &matrix("bearings", &a);
        let log = plain(&text);
        assert_eq!(log.header().format, "octave");
        assert!((log.header().sensors[0].half_width.to_degrees() - 2.5).abs() < 1e-3);
        on_walls(&read(&log), 4 * 31, 4, 1e-4);
        assert!(log.notes()[0].contains("--fields pose=poses,ranges=scans,angles=bearings"), "{:?}", log.notes());
    }
    // Penn's course: clockwise.
    let mirrored = |rows: &[Vec<f64>], at: usize| -> Vec<Vec<f64>> {
        rows.iter().enumerate().map(|(i, row)| row.iter().map(|v| if i >= at { -v } else { *v }).collect()).collect()
    };
    let text = head.clone()
        + &matrix("t", &[vec![5.0, 6.0, 7.0, 8.0]])
        + &matrix("pose", &mirrored(&turned(&poses), 2))
        + &matrix("ranges", &turned(&scans))
        + &matrix("scanAngles", &mirrored(&turned(row), 0));
    let log = plain(&text);
    let all = read(&log);
    on_walls(&all, 4 * 31, 4, 1e-4);
    assert!(all[31].t == 6.0 && log.notes()[1].contains("clockwise"), "{:?}", log.notes());
    // Named by hand: parts of a matrix, units, a field of view, a struct.
    let deg: Vec<Vec<f64>> = poses.iter().map(|p| vec![100.0 * p[0], 100.0 * p[1], p[2].to_degrees()]).collect();
    let fields = Options {
        fields: Some("x=P(:,1):cm,y=P(:,2):cm,heading=P(:,3):deg,ranges=d.R:m,fov=150deg".into()),
        ..Options::default()
    };
    let inner = matrix("R", &scans);
    let text = format!(
        "{head}{}# name: d\n# type: scalar struct\n# ndims: 2\n 1 1\n# length: 1\n{inner}\n",
        matrix("P", &deg)
    );
    on_walls(&read(&open(&text, &fields)), 4 * 31, 4, 1e-4);
    // Unnamed, it says what there is.
    let error = refused(text.as_bytes(), &Options::default());
    assert!(
        error.contains("it holds 'P', 4 × 3 numbers; 'd.R', 4 × 31 numbers. Name them, such as --fields pose="),
        "{error}"
    );
}

/// An array of structs as Octave writes it: a cell for each field.
#[test]
fn freiburgs_array_of_structs() {
    let beams = bearings(31, -75.0, 5.0);
    let cell = |name: &str, each: &dyn Fn(usize) -> String| {
        let all: String = (0..4).map(each).collect();
        format!("# name: {name}\n# type: cell\n# rows: 1\n# columns: 4\n{all}\n\n")
    };
    let scalar = |v: f64| format!("# name: <cell-element>\n# type: scalar\n{v:.6}\n\n\n");
    let column = |v: Vec<f64>| matrix("<cell-element>", &v.iter().map(|v| vec![*v]).collect::<Vec<_>>());
    let text = "# name: laser\n# type: struct\n# ndims: 2\n 1 4\n# length: 6\n".to_string()
        + &cell("start_angle", &|_| scalar(beams[0]))
        + &cell("angular_resolution", &|_| scalar(5f64.to_radians()))
        + &cell("maximum_range", &|_| scalar(30.0))
        + &cell("ranges", &|k| matrix("<cell-element>", &[ranges(&pose(k).compose(0.1, 0.05, 0.2), &beams)]))
        + &cell("pose", &|k| column(vec![WAY[k].0, WAY[k].1, WAY[k].2]))
        + &cell("laser_offset", &|_| column(vec![0.1, 0.05, 0.2]));
    let log = plain(&text);
    assert_eq!(log.header().sensors[0].r_max, 30.0);
    on_walls(&read(&log), 4 * 31, 4, 1e-4);
}

#[test]
fn what_is_wrong_with_fields_is_said() {
    let text = matrix("P", &[vec![0.0, 0.0, 0.0]]) + &matrix("R", &[vec![1.0, 2.0]]) + &matrix("A", &[vec![0.1]]);
    for (fields, what) in [
        ("pose=P,ranges=R", "ranges need the beams' bearings"),
        ("ranges=R,fov=90deg", "name the robot's poses"),
        ("pose=P,fov=90deg", "name the readings"),
        ("pose=Q,ranges=R,fov=90deg", "pose: there is no variable 'Q'"),
        ("pose=P,ranges=R,angles=A", "2 ranges, but 1 angles"),
        ("pose=P,range=R,fov=1", "'range' is no key; did you mean \"ranges\""),
        ("pose=P,ranges=R(:,5),fov=1", "has no (:,5)"),
        ("pose=P,ranges=R.z,fov=1", "has no field 'z'"),
        ("pose=R,ranges=R,fov=1", "pose is 1 × 2 numbers, not 3 × N or N × 3"),
        ("pose=P,ranges=R,fov=90deg,t=R", "2 times in t for 1 poses"),
        ("pose", "write key=variable"),
    ] {
        let options = Options { fields: Some(fields.into()), ..Options::default() };
        let error = match Log::read(text.as_bytes(), &options) {
            Err(error) => error.to_string(),
            Ok(log) => pass(&log).1.join(" "),
        };
        assert!(error.contains(what), "{fields}: {error}");
    }
    let fields = Options { fields: Some("pose=P,ranges=R,fov=1".into()), ..Options::default() };
    assert!(refused(b"1 2 3\n", &fields).contains("is no MATLAB or Octave file"));
    assert!(refused(b"1 2 3\n", &Options { columns: Some("t".into()), ..fields }).contains("give one of them"));
    let cut = text.rsplit_once("# columns").unwrap().0.to_string();
    assert!(refused(cut.as_bytes(), &Options::default()).contains("A, near line"), "cut");
}

// ---- what is no log

#[test]
fn files_that_are_no_logs_are_named() {
    let zip = b"PK\x03\x04\x14\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x08\0\0\0data.npy";
    let mut tar = vec![0u8; 512];
    tar[257..262].copy_from_slice(b"ustar");
    let utf16: Vec<u8> = "t,x,y\n1,2,3\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let rawlog = b"\x91CObservation2DRangeScan\0\x07\0\0\0";
    for (bytes, name, remedy) in [
        (&b"#ROSBAG V2.0\nE\0\0\0"[..], "is a ROS 1 bag", "rostopic echo -p -b FILE /scan"),
        (b"\x89MCAP0\r\n\x01\0", "is an MCAP file", "ros2 topic echo --csv"),
        (b"SQLite format 3\0\x10\0", "is an SQLite database", "ros2 bag play"),
        (b"\x89HDF\r\n\x1a\n", "is an HDF5 file", "save(name, '-v7')"),
        (b"\xd4\xc3\xb2\xa1\x02\0", "capture of network packets", "CSV"),
        (b"# .PCD v.7 - Point Cloud\n", "is a PCD file", "no sensor poses"),
        (b"ply\nformat ascii 1.0\n", "is a PLY file", "no sensor poses"),
        (b"LASF\0\0", "is a LAS or LAZ file", "no sensor poses"),
        (b"PAR1\x15\x04", "is a Parquet file", "--columns"),
        (b"\x93NUMPY\x01\0", "is a NumPy array", "numpy.savetxt"),
        (zip, "is NumPy arrays (.npz)", "numpy.savetxt"),
        (b"PK\x03\x04\x14\0", "is packed with zip", "unpack it"),
        (b"\x89PNG\r\n\x1a\n", "is a PNG picture", "no log"),
        (b"\xff\xd8\xff\xe0", "is a JPEG picture", "no log"),
        (b"%PDF-1.7\n", "is a PDF document", "no log"),
        (b"\x7fELF\x02\x01", "is a program", "no log"),
        (b"\xfd7zXZ\0\0", "is packed with xz", "unpack it"),
        (b"\x28\xb5\x2f\xfd\x04", "is packed with zstd", "unpack it"),
        (b"7z\xbc\xaf\x27\x1c\0", "is packed with 7z", "unpack it"),
        (&tar, "is packed with tar", "unpack it"),
        (rawlog, "is an MRPT rawlog", "JSON Lines"),
        (&utf16, "is UTF-16 text", "iconv -f UTF-16 -t UTF-8"),
        (b"\xff\xfet\0,\0x\0", "is UTF-16 text", "save it as UTF-8"),
        (b"Octave-1-L\0", "Octave's binary form", "save -text"),
    ] {
        let text = refused(bytes, &Options::default());
        assert!(text.contains(name) && text.contains(remedy), "{text}");
        // The same within gzip.
        let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut gz, bytes).unwrap();
        assert!(refused(&gz.finish().unwrap(), &Options::default()).contains(name), "{name} in gzip");
    }
    let prose = refused(b"Dear diary,\ntoday\n", &Options::default());
    assert!(prose.contains("line 1 is 'Dear diary,'") && prose.contains("--columns"), "{prose}");
}

#[test]
fn a_folder_says_what_it_holds() {
    let folder = tempfile::tempdir().unwrap();
    let open = || Log::open(folder.path(), &Options::default()).unwrap_err().to_string();
    assert!(open().contains("it holds no file"));
    std::fs::write(folder.path().join("notes.txt"), "hello\n").unwrap();
    assert!(open().contains("none of its 1 files is one"));
    std::fs::write(folder.path().join("run.log"), cmu()).unwrap();
    assert!(open().contains("one file is a log: give run.log (cmu)"), "{}", open());
    std::fs::write(folder.path().join("a.2d"), aria(true)).unwrap();
    assert!(open().contains("2 files are logs: give one of them, a.2d (aria), run.log (cmu)"), "{}", open());
    std::fs::write(folder.path().join("metadata.yaml"), "rosbag2_bagfile_information:\n").unwrap();
    assert!(open().contains("it is a ROS 2 bag"), "{}", open());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn damage_never_panics(
        seed in 0usize..7,
        at in proptest::collection::vec((0.0..1.0f64, any::<u8>()), 0..8),
        cut in 0.0..1.0f64,
    ) {
        let octave = matrix("poses", &[vec![0.0, 0.0, 0.0]]) + &matrix("ranges", &[vec![1.0, 2.0]]) + &matrix("angles", &[vec![0.1, 0.2]])
            + "# name: r\n# type: range\n# base, limit, increment\n1 5 1\n# name: s\n# type: string\n# elements: 1\n# length: 2\nhi\n";
        let table = "t,x,y,h,r\n0,0,0,0,1\n1,0,0,0,2\n";
        let texts = [cmu(), aria(true), aria(false), player(false), scans_csv(), octave, table.to_string()];
        let mut bytes = texts[seed].clone().into_bytes();
        for (place, byte) in at {
            let i = (place * bytes.len() as f64) as usize;
            bytes[i] = byte;
        }
        bytes.truncate((bytes.len() as f64 * (1.0 - cut * cut)) as usize);
        let (_folder, path) = file("odom.csv", &odom_csv());
        let mut options = if seed == 4 { posed(&path) } else { Options::default() };
        if seed == 6 {
            options.columns = Some("t,x,y,heading,range".into());
        }
        if let Ok(log) = Log::read(&bytes[..], &options) {
            prop_assert!(log.records().unwrap().count() < 5000);
            log.notes();
        }
    }
}

#[test]
fn a_trajectory_in_nanoseconds_and_one_with_w_first() {
    let text = "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.radiation_type,field.field_of_view,field.min_range,\
                field.max_range,field.range\n\
                1500000000000000000,0,1500000000000000000,left,0,0.5,0.1,4.0,1.5\n";
    let around = |k: u32| (0.05 * f64::from(k)).sin_cos();
    let rows = |row: fn(f64, (f64, f64)) -> String| -> String {
        (0..40).map(|k| row(1.5e9 - 2.0 + 0.1 * f64::from(k), around(k))).collect()
    };
    let ns = rows(|t, (s, c)| format!("{}000000000 1 2 0 0 0 {s} {c}\n", t as u64));
    let (_folder, path) = file("ns.txt", &ns);
    let log = open(text, &posed(&path));
    assert_eq!((read(&log)[0].robot.x, log.notes().iter().any(|n| n.contains("tip the robot"))), (1.0, false));
    let first = rows(|t, (s, c)| format!("{t} 1 2 0 {c} 0 0 {s}\n"));
    let (_folder, path) = file("w.txt", &first);
    let notes = open(text, &posed(&path)).notes();
    assert!(
        notes.iter().any(|n| n.contains("quaternions tip the robot over") && n.contains("qx qy qz qw")),
        "{notes:?}"
    );
}
