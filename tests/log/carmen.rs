//! CARMEN logs of many kinds, made up in a room whose walls are known: each reading that counts as a hit must lie on one.

use echogrid::Error;
use echogrid::log::reading::{Counts, Outcome, Pose, classify};
use echogrid::log::{Log, Options};
use echogrid::sensor::Overrides;
use std::f64::consts::PI;
use std::fmt::Write;

/// The room's walls: x = −4 and 6, y = −3 and 5.
const WALLS: [f64; 4] = [-4.0, 6.0, -3.0, 5.0];

/// How far it is to the wall.
fn range(at: Pose, bearing: f64) -> f64 {
    let (s, c) = (at.heading + bearing).sin_cos();
    let x = (if c > 0.0 { WALLS[1] - at.x } else { WALLS[0] - at.x }) / c;
    let y = (if s > 0.0 { WALLS[3] - at.y } else { WALLS[2] - at.y }) / s;
    x.min(y)
}

/// A scan: so many beams from a bearing on, degrees.
fn scan(at: Pose, count: u32, first: f64, step: f64) -> Vec<f64> {
    (0..count).map(|k| range(at, (first + f64::from(k) * step).to_radians())).collect()
}

fn text(ranges: &[f64]) -> String {
    let mut text = String::new();
    ranges.iter().for_each(|z| write!(text, "{z:.3} ").unwrap());
    text.trim_end().into()
}

fn pose(x: f64, y: f64, heading: f64) -> Pose {
    Pose { x, y, heading }
}

/// x, y and heading.
fn put(p: Pose) -> String {
    format!("{} {} {}", p.x, p.y, p.heading)
}

/// Where a robot goes.
fn way(k: usize) -> Pose {
    pose(0.1 * k as f64, 0.05 * k as f64, 0.1 * k as f64 - 0.4)
}

/// An old message: the pose that it carries, and the odometry's.
fn flat(tag: &str, ranges: &[f64], at: Pose, odometry: Pose, t: f64) -> String {
    format!("{tag} {} {} {} {} {t} host {t}\n", ranges.len(), text(ranges), put(at), put(odometry))
}

/// A new one, of a laser of 1° from −90° on.
fn robot(tag: &str, ranges: &[f64], laser: Pose, at: Pose, t: f64) -> String {
    let n = ranges.len();
    let (ranges, laser, at) = (text(ranges), put(laser), put(at));
    format!(
        "{tag} 0 -1.570796327 3.141592654 0.01745329252 80 0.01 0 {n} {ranges} 0 {laser} {at} 0 0 0.5 0.4 1000 {t} host {t}\n"
    )
}

/// The same without a pose.
fn raw(tag: &str, ranges: &[f64], t: f64) -> String {
    let n = ranges.len();
    format!("{tag} 0 -1.570796327 3.141592654 0.01745329252 80 0.01 0 {n} {} 0 {t} host {t}\n", text(ranges))
}

fn odom(at: Pose, t: f64) -> String {
    format!("ODOM {} 0.5 0 0 {t} host {t}\n", put(at))
}

fn open(text: &str) -> Log {
    Log::read(text.as_bytes(), &Options::default()).unwrap()
}

fn set(text: &str, keys: &[(&str, &str)]) -> Log {
    let mut overrides = Overrides::default();
    for (key, value) in keys {
        assert!(overrides.set(key, value).unwrap());
    }
    Log::read(text.as_bytes(), &Options { overrides, ..Options::default() }).unwrap()
}

/// What the readings are worth, and how far a hit lies off the nearest wall at most; each of the walls listed has one.
#[track_caller]
fn mapped(log: &Log, walls: &[usize]) -> (Counts, f64) {
    let (mut counts, mut off) = (Counts::default(), 0.0_f64);
    let mut met = [false; 4];
    for record in log.records().unwrap() {
        let record = record.unwrap();
        let judged = classify(record, &log.header().sensors[record.sensor as usize]);
        counts.add(&judged);
        if let Ok(reading) = judged
            && reading.outcome == Outcome::Hit
        {
            let p = record.pose.compose(reading.range, 0.0, 0.0);
            let each = [p.x - WALLS[0], p.x - WALLS[1], p.y - WALLS[2], p.y - WALLS[3]].map(f64::abs);
            for (met, off) in met.iter_mut().zip(each) {
                *met |= off < 0.01;
            }
            off = off.max(each.into_iter().fold(f64::INFINITY, f64::min));
        }
    }
    for wall in walls {
        assert!(met[*wall], "no reading of wall {wall}");
    }
    (counts, off)
}

#[track_caller]
fn on_the_walls(log: &Log, readings: u64, walls: &[usize]) -> Counts {
    let (counts, off) = mapped(log, walls);
    assert!(off < 0.005, "a hit lies {off} m off the walls");
    assert_eq!(counts.read, readings);
    counts
}

fn refused(text: &str) -> String {
    let error = Log::read(text.as_bytes(), &Options::default()).unwrap_err();
    assert!(matches!(error, Error::Input { .. }));
    error.to_string()
}

fn noted(log: &Log, what: &str) {
    assert!(log.notes().iter().any(|note| note.contains(what)), "{what}: {:?}", log.notes());
}

#[test]
fn several_codes_of_no_return() {
    let codes = [32.767, 32.763, 32.759];
    let (mut log, mut silent) = (String::new(), 0);
    for k in 0..40 {
        let mut ranges = scan(way(k % 20), 181, -90.0, 1.0);
        for (i, z) in ranges.iter_mut().enumerate() {
            if (i * 7 + k * 13) % 31 == 0 {
                *z = codes[(i + k) % 3];
                silent += 1;
            }
        }
        log += &flat("FLASER", &ranges, way(k % 20), way(k % 20), k as f64);
    }
    let log = open(&log);
    assert_eq!(log.header().sensors[0].r_max, 32.759);
    assert_eq!(on_the_walls(&log, 40 * 181, &[1, 2, 3]).no_echo, silent);
    noted(&log, "taken for no return: 32.767 m (");
    // The records have them as they are.
    let kept = log.records().unwrap().filter(|r| codes.contains(&r.as_ref().unwrap().range)).count();
    assert_eq!(kept as u64, silent);
}

#[test]
fn real_walls_are_no_codes() {
    let mut log = String::new();
    for k in 0..40 {
        log += &flat("FLASER", &scan(way(k % 20), 181, -90.0, 1.0), way(k % 20), way(k % 20), k as f64);
    }
    let log = open(&log);
    assert_eq!((log.header().sensors[0].r_max, on_the_walls(&log, 40 * 181, &[1, 2, 3]).no_echo), (80.0, 0));
}

#[test]
fn the_user_decides_over_the_log() {
    // A round tank of 3 m, and a declared maximum below the ranges.
    let mut tank = String::new();
    for k in 0..20 {
        tank += &flat("FLASER", &[3.0; 180], pose(0.0, 0.0, 0.1 * f64::from(k)), Pose::default(), f64::from(k));
    }
    let (counts, _) = mapped(&open(&tank), &[]);
    assert_eq!((counts.used, counts.no_echo), (3600, 0));
    assert_eq!(mapped(&set(&tank, &[("r_max", "2.5")]), &[]).0.no_echo, 3600);
    assert_eq!(mapped(&set(&tank, &[("r_max", "3.5")]), &[]).0.used, 3600);

    let low = format!(
        "PARAM robot_front_laser_max 4.0 host 0\n{}",
        flat("FLASER", &scan(way(0), 181, -90.0, 1.0), way(0), way(0), 0.0)
    );
    let silent = on_the_walls(&open(&low), 181, &[]).no_echo;
    assert!(silent > 50);
    noted(&open(&low), "declares a maximum of 4 m");
    assert_eq!(on_the_walls(&set(&low, &[("r_max", "20")]), 181, &[1, 2, 3]).no_echo, 0);
    // A message's own declaration too; and beyond 80 m if the user says so.
    let message = |far: f64| robot("ROBOTLASER1", &[1.0, far, 3.0], way(0), way(0), 0.0);
    assert_eq!(mapped(&open(&message(85.0)), &[]).0.no_echo, 1);
    assert_eq!(mapped(&set(&message(85.0), &[("r_max", "100")]), &[]).0.no_echo, 0);
}

#[test]
fn whose_heading_the_rear_laser_carries() {
    let behind = |k: usize| scan(Pose { heading: way(k).heading + PI, ..way(k) }, 181, -90.0, 1.0);
    let turned = |p: Pose, by: f64| Pose { heading: p.heading + by, ..p };
    let log = |carried: f64, correction: f64, front: bool| {
        let mut log = String::new();
        for k in 0..8 {
            let t = k as f64;
            if front {
                log += &flat("FLASER", &scan(way(k), 181, -90.0, 1.0), way(k), turned(way(k), correction), t);
            }
            log += &flat("RLASER", &behind(k), turned(way(k), carried), turned(way(k), correction), t + 0.1);
        }
        open(&log)
    };
    for carried in [0.0, PI, -PI] {
        for correction in [0.0, 0.3, -0.8] {
            on_the_walls(&log(carried, correction, false), 8 * 181, &[0]);
        }
        // Beside a front laser any correction will do.
        for correction in [0.0, 1.5, 3.0] {
            on_the_walls(&log(carried, correction, true), 16 * 181, &[0, 1]);
        }
    }
    noted(&log(PI, 0.0, false), "the rear laser's own: 180° off the robot's, in 8 of 8 messages.");
    noted(&log(0.0, 0.0, false), "the robot's: the laser looks the other way, in 8 of 8 messages.");
    noted(&log(PI, 1.4, false), "The others say otherwise or nothing clear");
    // The robot's heading and the mount are the same whoever wrote it.
    for carried in [0.0, PI] {
        let log = log(carried, 0.0, false);
        let record = log.records().unwrap().next().unwrap().unwrap();
        assert!((record.robot.heading - way(0).heading).abs() < 1e-9);
        assert!((log.header().sensors[0].axis.abs() - PI).abs() < 1e-9);
    }
}

#[test]
fn every_robotlaser_is_a_sensor() {
    let mut log = String::new();
    for k in 0..4 {
        for (i, turn) in [0.0, PI, 1.0, -1.0].into_iter().enumerate() {
            let laser = way(k).compose(0.2, 0.1, turn);
            log += &robot(&format!("ROBOTLASER{}", i + 1), &scan(laser, 181, -90.0, 1.0), laser, way(k), k as f64);
        }
    }
    let log = open(&log);
    let ids: Vec<_> = log.header().sensors.iter().map(|s| s.id.as_str()).collect();
    assert_eq!(ids, ["ROBOTLASER1/181", "ROBOTLASER2/181", "ROBOTLASER3/181", "ROBOTLASER4/181"]);
    on_the_walls(&log, 16 * 181, &[0, 1, 2, 3]);
    assert!((log.header().sensors[2].axis - 1.0).abs() < 1e-9 && (log.header().sensors[2].x - 0.2).abs() < 1e-9);
}

#[test]
fn messages_without_a_pose_take_the_odometrys() {
    // Between two ODOM messages of half a second; the laser in front sits 0.2 m ahead, the rear one 0.3 m behind.
    let at = |t: f64| pose(0.4 * t, 0.2 * t, 0.1);
    let mut log = String::from("PARAM robot_frontlaser_offset 0.2 h 0\nPARAM robot_rearlaser_offset -0.3 h 0\n");
    for k in 0..6 {
        let t = 0.5 * f64::from(k);
        log += &odom(at(t), t);
        let front = at(t + 0.2).compose(0.2, 0.0, 0.0);
        let rear = at(t + 0.3).compose(-0.3, 0.0, PI);
        log += &raw("RAWLASER1", &scan(front, 181, -90.0, 1.0), t + 0.2);
        log += &format!("LASER2 181 {} {} host 1\n", text(&scan(rear, 181, -90.0, 1.0)), t + 0.3);
        log += &format!("FLASER 181 {} {} host 1\n", text(&scan(front, 181, -90.0, 1.0)), t + 0.2);
        log += &raw("RAWLASER3", &[1.0, 2.0], t);
    }
    log += &odom(at(3.0), 3.0);
    let log = open(&log);
    on_the_walls(&log, 18 * 181, &[0, 1, 2, 3]);
    noted(&log, "Left out: 6 RAWLASER3 (where that laser sits on the robot is not in the log");
    noted(&log, "RAWLASER1/181: its messages carry no pose; the robot's is that of the ODOM messages");
    // One ODOM message, before or after, must do.
    let one = |text: String| on_the_walls(&open(&text), 181, &[1]);
    let laser = raw("RAWLASER1", &scan(way(4), 181, -90.0, 1.0), 1.0);
    one(odom(way(4), 0.1) + &laser);
    one(laser.clone() + &odom(way(4), 5.0));
    one(format!("POSITION {} 1.0\n{laser}", put(way(4))));
    // Messages that carry a pose are better.
    let both = open(
        &(odom(way(1), 0.1) + &laser + &robot("ROBOTLASER1", &scan(way(4), 181, -90.0, 1.0), way(4), way(4), 1.0)),
    );
    on_the_walls(&both, 181, &[1]);
    noted(&both, "Left out: 1 RAWLASER1 (they carry no pose, and messages that do are in the log)");
}

#[test]
fn laser_readings_of_gmapping() {
    let mut log = String::new();
    for k in 0..3 {
        log += &format!("ODO_UPDATE 1 0 0 0 1 {k}\n");
        log += &format!("LASER_READING 180 {} {} {k}\n", text(&scan(way(k), 180, -90.0, 1.0)), put(way(k)));
        log += "SM_UPDATE 1 0 0 0 1\n";
    }
    let log = open(&log);
    on_the_walls(&log, 3 * 180, &[1]);
    assert_eq!(log.records().unwrap().last().unwrap().unwrap().t, 2.0);
    noted(&log, "SM_UPDATE");
}

#[test]
fn what_is_not_read_is_named() {
    let only = "LASER3 4 1.5 2.5 3.0 3.5 1.0 h 1.0\nSONAR 2 1 1 1.0 h 1.0\nSONAR 2 1 1 1.0 h 1.0\n";
    let error = refused(only);
    assert!(error.contains("left out: 1 LASER3 (where that laser sits") && error.contains("2 SONAR ("), "{error}");
    assert!(
        refused(&raw("RAWLASER1", &[1.0, 2.0], 0.0))
            .contains("1 RAWLASER1 (they carry no pose, and no ODOM message does)")
    );
    let log = open(&format!("{only}{}", flat("FLASER", &[1.0, 2.0], way(0), way(0), 0.0)));
    noted(&log, "Left out: 1 LASER3 (");
    noted(&log, "2 SONAR (echogrid does not read them)");
}

#[test]
fn how_beams_lie() {
    let log = |params: &str, count: u32, first: f64, step: f64| {
        let mut log = params.to_string();
        for k in 0..5 {
            log += &flat("FLASER", &scan(way(k), count, first, step), way(k), way(k), k as f64);
        }
        log
    };
    for (count, first, step) in [
        (180, -90.0, 1.0),
        (181, -90.0, 1.0),
        (360, -90.0, 0.5),
        (361, -90.0, 0.5),
        (400, -90.0, 0.25),
        (401, -90.0, 0.25),
        (541, -135.0, 0.5),
        (1081, -135.0, 0.25),
        (91, -90.0, 2.0),
    ] {
        on_the_walls(&open(&log("", count, first, step)), 5 * u64::from(count), &[]);
    }
    let param = |fov: &str, step: &str| {
        format!("PARAM laser_front_laser_fov {fov} h 0\nPARAM laser_front_laser_resolution {step} h 0\n")
    };
    on_the_walls(&open(&log(&param("1.745329", "0.25"), 401, -90.0, 0.25)), 5 * 401, &[]);
    on_the_walls(&open(&log(&param("100", "1.0"), 101, -90.0, 1.0)), 5 * 101, &[]);
    on_the_walls(&open(&log(&param("270", "0.5"), 541, -135.0, 0.5)), 5 * 541, &[]);
    // Straight ahead, and as it pleases: the user says so.
    let ahead = log("", 401, -50.0, 0.25);
    noted(
        &open(&ahead),
        "401 beams over 100°, 0.25° apart, the first at -90°, by the number of beams; if the laser looks straight",
    );
    assert!(mapped(&open(&ahead), &[]).1 > 0.5);
    on_the_walls(&set(&ahead, &[("first_beam", "-50deg")]), 5 * 401, &[]);
    on_the_walls(&set(&ahead, &[("fov", "100deg")]), 5 * 401, &[]);
    let odd = set(&log("", 101, -30.0, 0.7), &[("fov", "70deg"), ("first_beam", "-30deg")]);
    on_the_walls(&odd, 5 * 101, &[]);
    noted(&odd, "101 beams over 70°, 0.7° apart, the first at -30°, by --set or the sensor file");
    assert!((odd.header().sensors[0].half_width.to_degrees() - 0.35).abs() < 1e-9);
}

#[test]
fn lines_whose_meaning_is_plain() {
    let ranges = scan(way(3), 181, -90.0, 1.0);
    let short = format!("FLASER 181 {} {} {}", text(&ranges), put(way(3)), put(way(3)));
    for line in [
        format!("{short} 1.0 h 1.0 7 8"),
        format!("{short} 1.0 h"),
        format!("{short} 1.0"),
        short.clone(),
        format!("   {short} 1.0 h 1.0"),
        format!("\t{}", short.replace(' ', "\t")),
        format!("{short} 1.0 h 1.0\r"),
        short.replace("FLASER", "flaser"),
        robot("  ROBOTLASER1", &ranges, way(3), way(3), 1.0).replace(" host 1", ""),
        robot("ROBOTLASER1", &ranges, way(3), way(3), 1.0).replace("host 1", "host 1 2 3"),
        // Without the remission mode, as old loggers wrote it.
        robot("ROBOTLASER1", &ranges, way(3), way(3), 1.0).replace(" 0.01 0 181", " 0.01 181"),
    ] {
        let log = open(&format!("{}\n{}\n", line.trim_end_matches('\n'), line.trim_end_matches('\n')));
        on_the_walls(&log, 362, &[1]);
    }
    noted(&open(&short), "1 messages have no time stamp; 0 is taken.");
}

#[test]
fn bad_lines_say_why() {
    let line = |ranges: &str| format!("FLASER 4 {ranges} 0 0 0 0 0 0 1.0 h 1.0\n");
    let error = refused(&line("1,5 2.5 3.0 3.5").repeat(3));
    assert!(error.contains(":1: field 3 is '1,5': write 1.5 with a point."), "{error}");
    assert!(error.contains("no readable laser message") && error.contains("3 bad lines"), "{error}");
    for (bad, what) in [
        (line("1 2 3"), "expected 15 fields for 4 beams, found 14"),
        (line("1 2 3 4 5"), "the host 'h' is field 15, not 14: are there more than 4 ranges?"),
        ("FLASER 4 1.0 2.0 3.".into(), "expected 15 fields for 4 beams, found 5"),
        ("1.0 2.0 0 0 0 0 0 0 1.0 h 1.0\n".into(), "begins with the number '1.0': is a message broken in two?"),
        ("FLASER 4 1 2 3 4 0 0,1 0 0 0 0 1.0 h 1.0\n".into(), "field 8 is '0,1': write 0.1 with a point"),
    ] {
        let log = open(&format!("{}{bad}", line("1 2 3 4")));
        let said: Vec<String> = log.records().unwrap().filter_map(|r| r.err().map(|e| e.to_string())).collect();
        assert!(said.len() == 1 && said[0].starts_with("line 2: ") && said[0].contains(what), "{what}: {said:?}");
    }
}

#[test]
fn many_zeros_are_told() {
    let mut ranges = scan(way(0), 181, -90.0, 1.0);
    ranges.iter_mut().step_by(10).for_each(|z| *z = 0.0);
    let log = open(&flat("FLASER", &ranges, way(0), way(0), 0.0));
    assert_eq!(on_the_walls(&log, 181, &[1]).rejected.below_r_min, 19);
    noted(&log, "19 of 181 readings are 0 or less");
}

#[test]
fn a_line_that_the_file_ends_within_is_no_reading() {
    let whole = "FLASER 4 1.5 2.5 3.0 3.5 0 0 0 0 0 0 1.0 h 1.0\n".repeat(3);
    // cut behind the odometry's heading, of which a digit may be missing
    let cut = format!("{whole}FLASER 4 1.5 2.5 3.0 3.5 0 0 0 0 0 3.");
    let log = Log::read(cut.as_bytes(), &Options::default()).unwrap();
    let (good, bad): (Vec<_>, Vec<_>) = log.records().unwrap().partition(Result::is_ok);
    assert_eq!(good.len(), 12);
    assert_eq!(bad[0].as_ref().unwrap_err().to_string(), "line 4: the file ends within this line");
    assert!(log.notes().iter().all(|note| !note.contains("time stamp")), "{:?}", log.notes());
    // where no message has a time none is cut for want of it
    let timeless = "FLASER 4 1.5 2.5 3.0 3.5 0 0 0 0 0 0\n".repeat(3);
    let log = Log::read(timeless.trim_end().as_bytes(), &Options::default()).unwrap();
    assert_eq!(log.records().unwrap().filter(Result::is_ok).count(), 12);
}
