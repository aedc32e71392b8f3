//! The specification's counts and sums of a real log, by the kernels.

use crate::common::{Run, assert_oracle, place, settings};
use crate::scenes::real;
use echogrid::method::settings::{Bayes, Settings};
use echogrid::oracle::OracleMap;

const LOG: &str = "sonar_ring_8/test1";

/// Every backend's result for one method, held against the oracle, with the backend's name.
fn runs(resolution: f64, name: &str, settings: Settings) -> Option<(OracleMap, Vec<(&'static str, Run)>)> {
    let scene = real(LOG, resolution, true)?;
    assert_eq!(scene.items.len(), 3304);
    let oracle = scene.oracle(settings);
    let mut runs = vec![("cpu", scene.cpu(settings))];
    runs.extend(scene.gpu(settings).map(|run| ("gpu", run)));
    for (backend, run) in &runs {
        assert_oracle(&format!("{LOG} {resolution} {name} {backend}").replace('/', "-"), run, &oracle);
    }
    Some((oracle, runs))
}

fn touched(run: &Run) -> usize {
    run.visits.interior.iter().zip(&run.visits.arc).filter(|(i, a)| *i + *a > 0).count()
}

fn sum(run: &Run, layer: &str) -> f64 {
    let data = &run.map.layer(layer).unwrap().data;
    (0..data.len()).map(|k| data.get(k)).sum()
}

fn near_sum(run: &Run, layer: &str, want: f64) {
    let found = sum(run, layer);
    assert!((found - want).abs() <= 1e-4 * want.abs(), "sum of {layer} is {found}, not {want}");
}

/// Occupied and empty cells, and each cell's class as the oracle decides it.
fn classes(name: &str, run: &Run, oracle: &OracleMap, want: (usize, usize)) {
    let class = &run.map.layer("class").unwrap().data;
    let count = |value: f64| (0..class.len()).filter(|&k| class.get(k) == value).count();
    assert_eq!((count(1.0), count(-1.0)), want, "{name}");
    let differ = (0..class.len()).find(|&k| class.get(k) != f64::from(oracle.class[k]));
    assert!(differ.is_none(), "{name}: {} is decided otherwise", place(&oracle.grid, differ.unwrap()));
}

#[test]
fn certainty() {
    let Some((oracle, all)) = runs(0.1, "certainty", settings("certainty")) else { return };
    for (backend, run) in &all {
        assert_eq!((run.map.updates, touched(run)), (1_101_584, 21_294));
        near_sum(run, "emp", 17345.975);
        near_sum(run, "occ", 956.243);
        classes(&format!("certainty, {backend}"), run, &oracle, (566, 20727));
    }
    let (_, all) = runs(0.1, "certainty-batch", settings("certainty-batch")).unwrap();
    for (_, run) in &all {
        assert_eq!((run.map.updates, touched(run)), (1_101_584, 21_294));
        near_sum(run, "emp", 17345.975);
        near_sum(run, "occ", 752.028);
    }
}

#[test]
fn dempster_shafer() {
    let Some((oracle, all)) = runs(0.1, "dempster-shafer", settings("dempster-shafer")) else { return };
    for (backend, run) in &all {
        assert_eq!((run.map.updates, touched(run)), (1_101_584, 21_294));
        classes(&format!("dempster-shafer, {backend}"), run, &oracle, (1090, 20203));
    }
}

#[test]
fn bayes() {
    let literal = Settings::Bayes(Bayes { region_one_floor: 0.0, ..Bayes::default() });
    let Some((oracle, all)) = runs(0.1, "bayes", literal) else { return };
    for (backend, run) in &all {
        assert_eq!((run.map.updates, touched(run)), (1_101_584, 21_294));
        near_sum(run, "log_odds", -288_424.92);
        classes(&format!("bayes, {backend}"), run, &oracle, (405, 13941));
    }
}

#[test]
fn himm() {
    let Some((oracle, all)) = runs(0.1, "himm", settings("himm")) else { return };
    for (backend, run) in &all {
        assert_eq!(run.map.updates, 97_909);
        assert_eq!(sum(run, "count"), 4508.0);
        classes(&format!("himm, {backend}"), run, &oracle, (764, 11743));
    }
}

#[test]
fn finer_cells() {
    let Some((_, all)) = runs(0.05, "certainty", settings("certainty")) else { return };
    for (_, run) in &all {
        assert_eq!(run.map.updates, 4_407_483);
    }
}
