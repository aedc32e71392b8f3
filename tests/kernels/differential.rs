//! Oracle against cpu against gpu: which cells, to the last one; which values, within the oracle's bound in every cell.

use crate::common::{Scene, assert_oracle, assert_same, cone_settings, every_settings, say, scan_settings, settings};
use crate::scenes;
use echogrid::grid::GridSpec;
use echogrid::method::settings::Settings;
use std::time::Instant;

/// Holds cpu and gpu against the oracle, and against each other where the adapter rounds as the cpu does.
fn agree(scene: &Scene, name: &str, settings: Settings) {
    let at = |backend: &str| format!("{} {name} {backend}", scene.name);
    let oracle = scene.oracle(settings);
    let cpu = scene.cpu(settings);
    assert_oracle(&at("cpu"), &cpu, &oracle);
    let Some(gpu) = scene.gpu(settings) else { return };
    assert_oracle(&at("gpu"), &gpu, &oracle);
    if crate::common::gpu().is_some_and(|g| g.adapter_info().name.contains("llvmpipe")) {
        assert_same(&at("gpu and cpu"), &gpu, &cpu);
    }
}

fn all_agree(scene: &Scene, all: Vec<(&'static str, Settings)>) {
    let started = Instant::now();
    for (name, settings) in all {
        agree(scene, name, settings);
    }
    println!("{}: {} readings, {:.1} s", scene.name, scene.items.len(), started.elapsed().as_secs_f64());
}

fn real(name: &str, resolution: f64) {
    for literal in [true, false] {
        if let Some(scene) = scenes::real(name, resolution, literal) {
            all_agree(&scene, cone_settings());
        }
    }
}

#[test]
fn a_real_log_in_10_cm_cells() {
    real("sonar_ring_8/test1", 0.1);
}

#[test]
fn a_real_log_in_5_cm_cells() {
    real("sonar_ring_8/test1", 0.05);
}

#[test]
fn another_real_log_in_10_cm_cells() {
    real("sonar_ring_8/test2", 0.1);
}

#[test]
fn another_real_log_in_5_cm_cells() {
    real("sonar_ring_8/test2", 0.05);
}

#[test]
fn a_real_laser() {
    let Some(scene) = scenes::real_lasers(20) else { return };
    let names = ["certainty", "dempster-shafer", "bayes", "bayes-constant", "himm", "truth"];
    all_agree(&scene, names.map(|n| (n, settings(n))).to_vec());
}

#[test]
fn twenty_thousand_readings() {
    all_agree(&scenes::crowd(), cone_settings());
}

#[test]
fn ragged_grids_and_sensors_outside() {
    let scene = scenes::ragged();
    let oracle = scene.oracle(settings("bayes"));
    assert!(
        oracle.outside > 50 && oracle.empty_arc > 50,
        "{} outside, {} without arc",
        oracle.outside,
        oracle.empty_arc
    );
    all_agree(&scene, cone_settings());
}

#[test]
fn a_parked_robot() {
    all_agree(&scenes::parked(), cone_settings());
}

#[test]
fn several_chunks() {
    let scene = scenes::chunks();
    assert!(scene.grid.width > 1024 && scene.grid.height > 1024);
    all_agree(&scene, cone_settings());
}

#[test]
fn wide_readings() {
    let scene = scenes::wide();
    let oracle = scene.oracle(settings("bayes"));
    assert!(oracle.wide > 300, "{} wide", oracle.wide);
    let arcs: u32 = oracle.arc.iter().sum();
    assert!(arcs > 10_000, "{arcs} updates on arcs");
    all_agree(&scene, cone_settings());
}

#[test]
fn where_rules_change_hands() {
    all_agree(&scenes::edges(), cone_settings());
}

#[test]
fn readings_that_reach_nothing() {
    let scene = scenes::nowhere();
    let run = scene.cpu(settings("bayes"));
    assert_eq!((run.map.updates, run.counts.outside), (0, scene.items.len() as u64));
    all_agree(&scene, cone_settings());
    let none = Scene { items: Vec::new(), name: "no readings".into(), ..scene };
    all_agree(&none, cone_settings());
}

#[test]
fn the_laser_truth() {
    for scene in [scenes::fans(), scenes::wide_fans()] {
        let oracle = scene.oracle(Settings::Truth);
        assert!(oracle.arc.iter().sum::<u32>() > 500, "{}: hardly any hit", scene.name);
        assert_eq!(oracle.wide > 0, scene.name.starts_with("wide"));
        let all = if oracle.wide > 0 { vec![("truth", Settings::Truth)] } else { every_settings() };
        all_agree(&scene, all);
    }
}

#[test]
fn the_gpu_half_runs_or_says_that_it_does_not() {
    match crate::common::gpu() {
        Some(gpu) => println!("gpu: {}", gpu.adapter_info()),
        None => say("SKIPPED: every comparison with the gpu"),
    }
}

#[test]
fn scans() {
    all_agree(&scenes::scans(), scan_settings());
}

/// Cells so large and so small that other beams, poses and tiles are at stake.
#[test]
fn scans_on_other_cells() {
    for (resolution, i0, width) in [(0.017, -20, 300), (1.5, -2, 6)] {
        let mut scene = scenes::scans();
        scene.grid = GridSpec { resolution, i0, j0: i0, width, height: width - 1, ..scene.grid };
        scene.name = format!("scans in cells of {resolution} m");
        let names = ["csm-discrete", "csm-continuous", "csm-continuous-sample", "csm-semantic-discrete"];
        all_agree(&scene, scan_settings().into_iter().filter(|(name, _)| names.contains(name)).collect());
    }
}
