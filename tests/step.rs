//! Stepping through a log: wherever a stepper comes from, it holds the bytes that `map` gives.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking; here are the tests' helpers too")]

#[path = "cli/common.rs"]
#[allow(dead_code, reason = "the command's tests use all of it")]
mod common;

use common::data;
use echogrid::kernels::cpu::Cpu;
use echogrid::method::settings::Settings;
use echogrid::oracle::{self, Region};
use echogrid::pipeline::finished::FinishedMap;
use echogrid::pipeline::session::{Request, Session};
use echogrid::pipeline::step::{By, Cell, Stepper, explain};
use echogrid::world::{Rig, Simulation, World, simulate};
use std::path::{Path, PathBuf};

/// A log of so many scans of a small campus.
fn log(folder: &Path, rig: &str, scans: u64) -> PathBuf {
    let world = World::parse(Path::new("c.toml"), "[campus]\nseed = 4\nwidth = 40\nheight = 35\n").unwrap();
    let path = folder.join(format!("{rig}.jsonl"));
    let file = std::fs::File::create(&path).unwrap();
    simulate(&Simulation { world: &world, rig: &Rig::named(rig).unwrap(), seed: 2, scans: Some(scans) }, file, &|_| {})
        .unwrap();
    path
}

fn set(method: &str, pairs: &[(&str, &str)]) -> Settings {
    let mut settings = Settings::of(method).unwrap();
    pairs.iter().for_each(|(k, v)| assert!(settings.set(k, v).unwrap()));
    settings
}

fn every_settings() -> Vec<(&'static str, Settings)> {
    vec![
        ("certainty", set("certainty", &[])),
        ("certainty, batch order", set("certainty", &[("order", "batch")])),
        ("dempster-shafer", set("dempster-shafer", &[])),
        ("dempster-shafer, murphy", set("dempster-shafer", &[("model", "murphy")])),
        ("bayes", set("bayes", &[])),
        ("bayes, constant", set("bayes", &[("model", "constant")])),
        ("himm", set("himm", &[])),
        ("himm, growing", set("himm", &[("gro", "true")])),
        ("csm-discrete", set("csm-discrete", &[("w_beam", "20deg")])),
        ("csm-continuous", set("csm-continuous", &[("z_max", "6")])),
        ("csm-continuous, all", set("csm-continuous", &[("neighbours", "all"), ("z_max", "6")])),
        ("features", set("features", &[])),
    ]
}

fn session(log: &Path, settings: Settings, until: Option<u64>, resolution: f64) -> Session {
    let bounds = Some([0.0, 0.0, 40.0, 35.0]);
    let request = Request { log: Default::default(), settings, resolution, bounds, until, strict: true };
    Session::open(log, &request).unwrap()
}

fn stepper(log: &Path, settings: Settings, snapshots: u64) -> Stepper {
    Stepper::open(session(log, settings, None, 0.1), 0, None, snapshots).unwrap()
}

fn go(stepper: &mut Stepper, by: By) {
    let to = stepper.target(by);
    stepper.go(to, &mut || true).unwrap();
    assert_eq!(stepper.position(), to);
}

fn same(name: &str, found: &FinishedMap, wanted: &FinishedMap) {
    assert!(found.map == wanted.map && found.combined == wanted.combined && found.visits == wanted.visits, "{name}");
}

/// Small numbers from a seed, for walks to and fro.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    *state >> 33
}

#[test]
fn by_any_way_it_ends_with_the_bytes_of_map() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring24", 120);
    for (name, settings) in every_settings() {
        let wanted =
            session(&log, settings, None, 0.1).map(&mut Cpu::new(0).unwrap(), 1 << 16, &|_| {}).unwrap().finished;
        // Snapshots as many as it likes, and hardly any, where there are some.
        let anew = name.starts_with("csm") || name == "certainty, batch order";
        for snapshots in if anew { vec![1 << 28] } else { vec![1 << 28, 200_000] } {
            let mut stepper = stepper(&log, settings, snapshots);
            let total = stepper.items().len();
            go(&mut stepper, By::To(total));
            same(name, &stepper.finished(), &wanted);
            let mut seed = 7;
            for _ in 0..5 {
                let to = random(&mut seed) as usize % (total + 1);
                go(&mut stepper, By::To(to));
                go(&mut stepper, By::Items(random(&mut seed) as i64 % 5 - 2));
                go(&mut stepper, By::Scans(random(&mut seed) as i64 % 5 - 2));
                let mut other = self::stepper(&log, settings, 1 << 20);
                go(&mut other, By::To(stepper.position()));
                assert_eq!(stepper.touched(), other.touched(), "{name} at {to}");
                same(&format!("{name} at {to}"), &stepper.finished(), &other.finished());
            }
            go(&mut stepper, By::To(0));
            assert!(
                stepper.finished().visits.interior.iter().all(|n| *n == 0) && stepper.touched().is_empty(),
                "{name}"
            );
            while stepper.position() < total {
                go(&mut stepper, By::Scans(1));
            }
            same(name, &stepper.finished(), &wanted);
        }
    }
}

#[test]
fn a_position_is_the_map_until_it() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring8", 700);
    for (name, settings) in every_settings() {
        // Features of the whole log are known to the stepper, those until there to map; a scan is cut where --until falls into one.
        if matches!(settings, Settings::Features(_) | Settings::Csm(_)) {
            continue;
        }
        let mut stepper = stepper(&log, settings, 1 << 28);
        for until in [333, 41] {
            let session = session(&log, settings, Some(until), 0.1);
            let wanted = session.map(&mut Cpu::new(0).unwrap(), 100, &|_| {}).unwrap().finished;
            go(&mut stepper, By::To(until as usize));
            same(name, &stepper.finished(), &wanted);
        }
    }
}

#[test]
fn what_a_reading_did_is_the_difference_that_it_made() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring8", 700);
    for (name, settings) in every_settings() {
        let mut stepper = stepper(&log, settings, 1 << 28);
        let mut changed = 0;
        for at in [9, 10, 60] {
            go(&mut stepper, By::To(at - 1));
            let before = stepper.finished();
            let tiles = stepper.go(at, &mut || true).unwrap();
            let after = stepper.finished();
            changed += stepper.touched().len();
            let width = stepper.grid().width;
            for layer in &after.map.layers {
                let old = before.map.layer(&layer.name).unwrap();
                for k in (0..layer.data.len()).filter(|k| layer.data.get(*k) != old.data.get(*k)) {
                    let [row, column] = [k / width, k % width];
                    assert!(tiles.contains(&[row as u32 / 16, column as u32 / 16]), "{name}: tile of {column}, {row}");
                    if name != "certainty, batch order" {
                        let noted = stepper.touched().iter().any(|t| (t.column, t.row) == (column, row));
                        assert!(noted, "{name}: {} of {column}, {row} changed", layer.name);
                    }
                }
            }
            for touched in stepper.touched() {
                let words = stepper.words(touched.column, touched.row).unwrap();
                assert_eq!(words, touched.after, "{name}");
            }
        }
        assert!(changed > 0, "{name}");
    }
}

#[test]
fn a_cells_history_leads_to_its_state() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring24", 700);
    for (name, settings) in every_settings() {
        let mut stepper = stepper(&log, settings, 1 << 28);
        let total = stepper.items().len();
        go(&mut stepper, By::To(total));
        go(&mut stepper, By::To(total * 3 / 4));
        let (visits, width) = (stepper.finished().visits, stepper.grid().width);
        let busy = |k: &usize| visits.interior[*k] > 2 && visits.arc[*k] > 1;
        let cells: Vec<usize> = (0..visits.interior.len()).filter(busy).step_by(37).take(9).collect();
        assert!(!cells.is_empty(), "{name}");
        for k in cells {
            let (column, row) = (k % width, k / width);
            let cell = Cell::of(stepper.method(), stepper.words(column, row).as_deref());
            let history = stepper.history(column, row, usize::MAX).unwrap();
            assert_eq!(history.total, history.events.len());
            if let Settings::Csm(csm) = settings {
                let counted = |which: usize| {
                    history.events.iter().filter(|e| e.given.as_ref().unwrap().counted[which]).count() as u32
                };
                let all = csm.free != echogrid::method::settings::FreeRule::Projection && csm.continuous;
                assert!(all || counted(0) == cell.interior, "{name}");
                assert_eq!(counted(1), cell.arc, "{name}");
                continue;
            }
            assert_eq!(history.events[0].after.as_ref(), Some(&cell), "{name}");
            assert!(history.events.iter().all(|e| e.own.is_some_and(f64::is_finite)), "{name}");
            let count = |arc: bool| history.events.iter().filter(|e| e.arc == arc).count() as u32;
            assert_eq!((count(false), count(true)), (cell.interior, cell.arc), "{name} at {column}, {row}");
            for pair in history.events.windows(2) {
                assert_eq!(pair[0].before, pair[1].after, "{name}");
            }
            let short = stepper.history(column, row, 2).unwrap();
            assert_eq!((short.total, &short.events[..]), (history.total, &history.events[..2]), "{name}");
        }
    }
}

#[test]
fn a_reading_is_explained_as_by_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring8", 700);
    for (name, settings) in every_settings() {
        if matches!(settings, Settings::Features(_) | Settings::Csm(_)) {
            continue;
        }
        let mut stepper = stepper(&log, settings, 1 << 28);
        let (readings, _) = stepper.session().all_readings().unwrap();
        let mut arcs = 0;
        for at in [1usize, 57, 300] {
            go(&mut stepper, By::To(at));
            let found = explain(&stepper).unwrap().unwrap();
            let until = at;
            let (grid, sensors) = (*stepper.grid(), stepper.sensors());
            let wanted = oracle::trace(
                &oracle::Setup { grid: &grid, sensors, settings: &settings },
                &readings[..until],
                None,
                at - 1,
            )
            .unwrap();
            assert_eq!(found.n, wanted.arc_cells, "{name}");
            let mut cells = found.cells.clone();
            cells.sort_by_key(|c| (c.row, c.column));
            let reached: Vec<_> = wanted
                .cells
                .iter()
                .filter(|c| cells.binary_search_by_key(&(c.update.row, c.update.column), |c| (c.row, c.column)).is_ok())
                .collect();
            assert_eq!(reached.len(), cells.len(), "{name}");
            // Each cell of the cone is touched, but for one that stays what it was: surely free, or a count at its end.
            let kept = matches!(settings, Settings::Certainty(_) | Settings::Himm(_));
            assert!(reached.len() == wanted.cells.len() || (kept && name.contains("batch")), "{name}");
            if let Some(cell) = cells.get(cells.len() / 2).filter(|_| !name.contains("batch")) {
                let last = &stepper.history(cell.column, cell.row, 1).unwrap().events[0];
                assert_eq!((last.item, last.own), (at - 1, cell.evidence.map(|e| e[0])), "{name}");
            }
            for (cell, own) in cells.iter().zip(reached) {
                assert_eq!(cell.arc, own.update.region == Region::Arc, "{name}");
                let [a, b, c] = cell.evidence.unwrap();
                assert_eq!(a, own.own, "{name}");
                assert!(
                    (b - own.cancelled).abs() < 1e-5 && (c - own.normalised).abs() < 1e-4,
                    "{name}: {cell:?} {own:?}"
                );
                arcs += usize::from(cell.arc);
            }
        }
        assert!(arcs > 0, "{name}");
    }
}

#[test]
fn a_walk_that_is_stopped_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring24", 700);
    let settings = set("certainty", &[]);
    let (mut stopped, mut other) = (stepper(&log, settings, 1 << 28), stepper(&log, settings, 1 << 28));
    let total = stopped.items().len();
    let mut calls = 0;
    while stopped.position() < total {
        stopped.go(total, &mut || false).unwrap();
        assert!(stopped.touched().len() > 1, "each stop shows what its last reading did");
        calls += 1;
        go(&mut other, By::To(stopped.position()));
        assert_eq!(stopped.touched(), other.touched());
    }
    assert!(calls > 1);
    same("stopped", &stopped.finished(), &other.finished());
}

#[test]
fn what_does_not_fit_into_memory_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring8", 700);
    let refused = Stepper::open(session(&log, set("bayes", &[]), None, 0.1), 0, Some(1 << 20), 1 << 28);
    let error = refused.err().unwrap().to_string();
    assert!(error.contains("1 MiB"), "{error}");
}

#[test]
fn a_real_log_reading_by_reading_ends_with_the_bytes_of_map() {
    let Some(path) = data("sonar_ring_8/test1") else { return };
    for (name, settings) in every_settings() {
        let open = || {
            let request = Request {
                log: Default::default(),
                settings,
                resolution: 0.05,
                bounds: None,
                until: None,
                strict: true,
            };
            Session::open(&path, &request).unwrap()
        };
        let wanted = open().map(&mut Cpu::new(0).unwrap(), 1 << 16, &|_| {}).unwrap().finished;
        let mut stepper = Stepper::open(open(), 0, None, 1 << 28).unwrap();
        let anew = name == "certainty, batch order";
        while stepper.position() < stepper.items().len() {
            go(&mut stepper, if anew { By::Scans(40) } else { By::Items(1) });
        }
        same(name, &stepper.finished(), &wanted);
    }
}
