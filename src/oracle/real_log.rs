//! The specification's counts and sums on a real log. The log isn't part of the repository: without it the tests say so
//! and pass.

use super::vectors::{reading, sonar};
use super::{OracleMap, map};
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Reading};
use crate::method::settings::{Bayes, Certainty, Order, Settings};
use crate::sensor::Sensor;
use std::path::PathBuf;

/// Readings of `sonar_ring_8/test1` with literal values: β 15°, no mounts, `r_min` 0.17, all ranges 5 m.
fn test1() -> Option<(Sensor, Vec<Reading>)> {
    let here = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("ECHOGRID_DATA").map_or_else(here, PathBuf::from).join("sonar_ring_8/test1");
    let table = |name: &str| -> Option<Vec<Vec<f64>>> {
        let text = std::fs::read_to_string(folder.join(name)).ok()?;
        let row = |line: &str| line.split_whitespace().map(|w| w.parse().unwrap()).collect();
        Some(text.lines().map(row).filter(|r: &Vec<f64>| !r.is_empty()).collect())
    };
    let (Some(poses), Some(ranges)) = (table("od.txt"), table("sonar.txt")) else {
        // Straight to the stream: the harness would swallow a print of a test that passes.
        let thread = std::thread::current();
        let (test, folder) = (thread.name().unwrap_or("?"), folder.display());
        let text = format!("SKIPPED {test}: no {folder} (set ECHOGRID_DATA to the folder of real logs)\n");
        let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
        return None;
    };
    let axes = [-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0f64];
    let mut readings = Vec::new();
    for (p, r) in poses.iter().zip(&ranges) {
        for (axis, z) in axes.iter().zip(&r[1..]) {
            let (z, hit) = if *z > 5000.0 { (5.0, Outcome::NoEcho) } else { (z / 1000.0, Outcome::Hit) };
            let heading = (p[3] / 10.0).to_radians() + axis.to_radians();
            readings.push(reading(p[1] / 1000.0, p[2] / 1000.0, heading, z, hit));
        }
    }
    Some((Sensor { r_min: 0.17, r_max: 5.0, hit_range: 5.0, no_echo_range: 5.0, ..sonar(15.0) }, readings))
}

/// The default grid of the readings.
fn grid(sensor: &Sensor, readings: &[Reading], resolution: f64) -> GridSpec {
    let mut b = [f64::MAX, f64::MAX, f64::MIN, f64::MIN];
    for r in readings {
        let (reach, p) = (r.range + sensor.epsilon(resolution), r.record.pose);
        b = [b[0].min(p.x - reach), b[1].min(p.y - reach), b[2].max(p.x + reach), b[3].max(p.y + reach)];
    }
    GridSpec::around(b, resolution).unwrap()
}

/// A scene for the bounds: the hits of the log, or without it a made-up drive; both with hits only.
pub(super) fn test1_or_random() -> (GridSpec, Sensor, Vec<Reading>) {
    let (sensor, mut readings) = test1().unwrap_or_else(|| {
        let drive = |k: u32| {
            let (t, z) = (f64::from(k), f64::from((k * 7919) % 331) / 100.0 + 0.4);
            reading(0.004 * t, (0.003 * t).sin(), 0.61 * t, z, Outcome::Hit)
        };
        (Sensor { r_min: 0.17, r_max: 5.0, hit_range: 5.0, ..sonar(15.0) }, (0..1500).map(drive).collect())
    });
    readings.retain(|r| r.outcome == Outcome::Hit);
    (grid(&sensor, &readings, 0.1), sensor, readings)
}

fn run(resolution: f64, settings: &Settings) -> Option<OracleMap> {
    let (sensor, readings) = test1()?;
    assert_eq!(readings.len(), 3304);
    assert_eq!(readings.iter().filter(|r| r.outcome == Outcome::NoEcho).count(), 1091);
    let grid = grid(&sensor, &readings, resolution);
    let started = std::time::Instant::now();
    let map = map(&grid, &[sensor], &readings, settings, None).unwrap();
    eprintln!("{settings:?} at {resolution} m: {} updates in {:.2} s", map.updates, started.elapsed().as_secs_f64());
    for layer in &map.layers {
        let loose = |b: f64| layer.bound.iter().filter(|v| **v > b).count();
        let most = layer.bound.iter().copied().fold(0.0, f64::max);
        let (a, b, c) = (loose(1e-5), loose(1e-3), loose(0.1));
        eprintln!("  {}: largest bound {most:.3e}; bounds over 1e-5 {a}, 1e-3 {b}, 0.1 {c}", layer.name);
    }
    eprintln!("  {} of {} touched cells are ambiguous", map.ambiguous.iter().filter(|a| **a).count(), map.touched);
    Some(map)
}

fn classes(map: &OracleMap) -> (usize, usize) {
    let count = |class| map.class.iter().filter(|c| **c == class).count();
    (count(1), count(-1))
}

fn near_sum(map: &OracleMap, layer: &str, want: f64) {
    let sum: f64 = map.layer(layer).unwrap().values.iter().sum();
    eprintln!("  sum of {layer}: {sum}");
    assert!((sum - want).abs() <= 1e-5 * want.abs(), "sum of {layer} is {sum}, not {want}");
}

#[test]
fn certainty_on_a_real_log() {
    let Some(map) = run(0.1, &Settings::of("certainty").unwrap()) else { return };
    assert_eq!((map.updates, map.touched), (1_101_584, 21_294));
    near_sum(&map, "emp", 17345.975);
    near_sum(&map, "occ", 956.243);
    assert_eq!(classes(&map), (566, 20727));
    let batch = run(0.1, &Settings::Certainty(Certainty { order: Order::Batch })).unwrap();
    near_sum(&batch, "occ", 752.028);
    let fine = run(0.05, &Settings::of("certainty").unwrap()).unwrap();
    assert_eq!(fine.updates, 4_407_483);
}

#[test]
fn dempster_shafer_on_a_real_log() {
    let Some(map) = run(0.1, &Settings::of("dempster-shafer").unwrap()) else { return };
    assert_eq!((map.updates, map.touched), (1_101_584, 21_294));
    assert_eq!(classes(&map), (1090, 20203));
    let mut murphy = Settings::of("dempster-shafer").unwrap();
    murphy.set("model", "murphy").unwrap();
    run(0.1, &murphy).unwrap();
}

#[test]
fn bayes_on_a_real_log() {
    let literal = Settings::Bayes(Bayes { region_one_floor: 0.0, ..Bayes::default() });
    let Some(map) = run(0.1, &literal) else { return };
    assert_eq!((map.updates, map.touched), (1_101_584, 21_294));
    assert_eq!(classes(&map), (405, 13941));
    near_sum(&map, "log_odds", -288424.92);
    run(0.1, &Settings::of("bayes").unwrap()).unwrap();
}
