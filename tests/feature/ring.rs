//! Regions of sonars that look one way, from their readings while the robot passes.

use crate::common::{gap, near, ping, way};
use echogrid::feature::Ping;
use echogrid::feature::rcd::{Rcd, Source};
use echogrid::feature::ring::Runs;

/// A robot that goes along x in steps of 0.125 m, its sonar looking at a bearing; what it hears at each x.
fn pass(steps: usize, degrees: f64, range: impl Fn(f64) -> f64) -> Vec<Ping> {
    let one = |k: usize| {
        let x = k as f64 * 0.125;
        let mut ping = ping((x, 0.0), degrees, Some(range(x)));
        (ping.record.scan, ping.record.line) = (k as u64, k as u64 + 1);
        ping
    };
    (0..steps).map(one).collect()
}

fn found(pings: &[Ping]) -> Vec<Rcd> {
    let mut runs = Runs::default();
    let mut found: Vec<Rcd> = pings.iter().filter_map(|p| runs.push(p)).collect();
    found.extend(runs.finish());
    found
}

#[test]
fn a_wall_that_is_passed() {
    let all = found(&pass(8, 90.0, |_| 2.0));
    assert_eq!(all.len(), 1);
    let rcd = &all[0];
    assert!(rcd.source == Source::Wall && rcd.fitted && rcd.clear);
    // from x = 0 to 0.875: its middle, and half of that and 5 cm
    near(rcd.foot, (0.4375, 2.0), 1e-9);
    near(rcd.normal, (0.0, 1.0), 1e-9);
    assert!((rcd.half - 0.4875).abs() < 1e-9 && (rcd.range - 2.0).abs() < 1e-9);
    assert_eq!((rcd.count, rcd.lines, rcd.scan), (8, [1, 8], 4));
}

#[test]
fn a_slanted_wall_is_found_across_the_cone() {
    // its normal is 10° off the axis: z = 2 − n · S
    let normal = way(100.0);
    let all = found(&pass(8, 90.0, |x| 2.0 - normal.x * x));
    assert_eq!(all.len(), 1);
    near(all[0].normal, normal, 1e-9);
    assert!((normal.dot(&all[0].foot.coords) - 2.0).abs() < 1e-9, "the foot is on its line");
}

#[test]
fn a_point_that_is_passed() {
    let at = (0.5, 1.5);
    let all = found(&pass(8, 90.0, |x| gap(at, (x, 0.0))));
    assert_eq!(all.len(), 1);
    assert!(all[0].source == Source::Point && all[0].clear);
    near(all[0].foot, at, 1e-3);
    assert_eq!(all[0].half, 0.05);
}

/// ± 5 mm in turn.
fn noise(x: f64) -> f64 {
    if (x / 0.125) as i64 % 2 == 0 { 0.005 } else { -0.005 }
}

#[test]
fn what_fits_both_is_a_wall_straight_ahead_and_a_point_aside_and_neither_is_clear() {
    let ahead = found(&pass(5, 0.0, |x| 3.0 - x + noise(x)));
    assert_eq!(ahead.len(), 1);
    assert!(ahead[0].source == Source::Wall && !ahead[0].clear && ahead[0].fitted);
    near(ahead[0].foot, (3.0, 0.0), 0.02);
    // 0.375 m at 4 m: the arc rises 4 mm
    let aside = found(&pass(4, 90.0, |x| 4.0 + noise(x)));
    assert_eq!(aside.len(), 1);
    assert!(aside[0].source == Source::Point && !aside[0].clear);
}

#[test]
fn a_robot_that_stands_or_turns_tells_nothing() {
    let still: Vec<Ping> = (0..1000).map(|_| ping((1.0, 1.0), 90.0, Some(2.0))).collect();
    assert_eq!(found(&still), []);
    // 1.5° a step: after four readings it has turned too far; 2.5°: after two
    let turning = |by: f64| {
        let mut pings = pass(4, 90.0, |_| 2.0);
        pings.extend(pass(8, 90.0, |_| 2.0).drain(4..));
        for (k, p) in pings.iter_mut().enumerate() {
            *p = Ping { record: p.record, ..ping(p.at, 90.0 + by * k as f64, p.range) };
        }
        found(&pings).iter().map(|r| r.count).collect::<Vec<_>>()
    };
    assert_eq!(turning(1.5), [4, 4]);
    assert_eq!(turning(2.5), Vec::<u32>::new());
}

#[test]
fn it_takes_four_readings_and_a_quarter_of_a_metre() {
    assert_eq!(found(&pass(3, 90.0, |_| 2.0)).len(), 0);
    assert_eq!(found(&pass(4, 90.0, |_| 2.0)).len(), 1);
    let slow = |step: f64| {
        let pings: Vec<Ping> = (0..6).map(|k| ping((k as f64 * step, 0.0), 90.0, Some(2.0))).collect();
        found(&pings).len()
    };
    assert_eq!([slow(0.045), slow(0.055)], [0, 1]);
}

#[test]
fn a_run_ends_after_a_metre_at_a_missing_echo_and_at_a_jump() {
    let counts = |pings: &[Ping]| found(pings).iter().map(|r| r.count).collect::<Vec<_>>();
    // 9 readings reach from 0 to 1 m
    assert_eq!(counts(&pass(18, 90.0, |_| 2.0)), [9, 9]);
    let mut gone = pass(9, 90.0, |_| 2.0);
    gone[4].range = None;
    assert_eq!(counts(&gone), [4, 4]);
    // a step of 0.125 m changes a wall's range by at most 3.2 cm in a cone of 15°; 3 cm are left for noise
    assert_eq!(counts(&pass(8, 90.0, |x| if x < 0.4 { 2.0 } else { 2.055 })), [8]);
    assert_eq!(counts(&pass(8, 90.0, |x| if x < 0.4 { 2.0 } else { 2.07 })), [4, 4]);
}

#[test]
fn what_fits_neither_is_nothing() {
    // ± 2 cm in turn: 1.5 cm are allowed
    assert_eq!(found(&pass(8, 90.0, |x| 2.0 + 4.0 * noise(x))), []);
    assert_eq!(found(&pass(8, 90.0, |x| 2.0 + 2.0 * noise(x))).len(), 1);
}

#[test]
fn each_sensor_has_its_own_run() {
    let mut both = Vec::new();
    for (a, mut b) in pass(8, 90.0, |_| 2.0).into_iter().zip(pass(8, 270.0, |_| 1.0)) {
        b.record.sensor = 1;
        both.extend([a, b]);
    }
    let all = found(&both);
    assert_eq!(all.len(), 2);
    near(all[0].foot, (0.4375, 2.0), 1e-9);
    near(all[1].foot, (0.4375, -1.0), 1e-9);
}
