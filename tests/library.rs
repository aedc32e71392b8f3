//! The library alone, without the command: a simulated log to a map in memory and to a folder. It is built with every set of cargo
//! features (`scripts/test`); with `gpu` both backends must give the same bytes.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use echogrid::binning::batch::BATCH;
use echogrid::kernels::{Backend, Choice, choose};
use echogrid::log;
use echogrid::method::settings::Settings;
use echogrid::output::{Folder, RunInfo, Unfinished, read_map, write_map};
use echogrid::pipeline::session::{MappedLog, Request, Session};
use echogrid::world::{Shipped, Simulation, World, simulate};
use std::path::Path;

fn request(method: &str) -> Request {
    let settings = Settings::of(method).unwrap();
    Request { log: log::Options::default(), settings, resolution: 0.1, bounds: None, until: None, strict: true }
}

fn map(path: &Path, method: &str, choice: Choice) -> (Session, MappedLog) {
    let session = Session::open(path, &request(method)).unwrap();
    let mut chosen = choose(choice, session.method.as_ref(), 0).unwrap();
    let mapped = session.map(chosen.backend.as_mut(), BATCH, &|_| {}).unwrap();
    (session, mapped)
}

/// The corridor's log.
fn log_of_bend(folder: &Path) -> std::path::PathBuf {
    let path = folder.join("bend.jsonl");
    let shipped = Shipped::named(Path::new("bend")).unwrap();
    let world = World::parse(Path::new("bend.toml"), shipped.text).unwrap();
    let file = std::fs::File::create(&path).unwrap();
    let simulation = Simulation { world: &world, rig: &world.rig, seed: 1, scans: Some(40) };
    simulate(&simulation, file, &|_| {}).unwrap();
    path
}

/// A number of a layer's bits, so that maps can be compared.
fn bits(mapped: &MappedLog) -> Vec<Vec<u64>> {
    let layers = &mapped.finished.map.layers;
    layers.iter().map(|l| (0..l.data.len()).map(|k| l.data.get(k).to_bits()).collect()).collect()
}

#[test]
fn a_log_becomes_a_map_and_a_folder() {
    let place = tempfile::tempdir().unwrap();
    let log = log_of_bend(place.path());
    let (session, mapped) = map(&log, "bayes", Choice::Cpu);
    assert_eq!(mapped.counts.used, session.survey.counts.used);
    let class = mapped.finished.map.layer("class").unwrap();
    let count = |of: f64| (0..class.data.len()).filter(|k| class.data.get(*k) == of).count();
    // The corridor is 1.5 m wide and some 20 m long: cells of 0.01 m².
    assert!(count(-1.0) > 1000 && count(1.0) > 50, "{} empty, {} occupied", count(-1.0), count(1.0));

    let out = place.path().join("out");
    let folder = Folder::open(&out, Unfinished::Refuse).unwrap();
    let report =
        write_map(&folder, &mapped.finished.map, &mapped.finished.combined, &RunInfo::default(), false).unwrap();
    assert_eq!(report.updates, mapped.finished.map.updates);
    folder.finish().unwrap();
    assert_eq!(read_map(&out).unwrap().map.layer("class").unwrap().data, class.data);
}

#[test]
fn auto_takes_what_there_is_and_without_the_gpu_feature_the_gpu_is_an_error() {
    let settings = Settings::of("himm").unwrap();
    let method = echogrid::method::make(settings);
    let chosen = choose(Choice::Auto, method.as_ref(), 0).unwrap();
    assert!(["cpu", "gpu"].contains(&Backend::name(chosen.backend.as_ref())) && !chosen.why.is_empty());
    if cfg!(not(feature = "gpu")) {
        let error = choose(Choice::Gpu, method.as_ref(), 0).err().map(|e| e.to_string()).unwrap();
        assert!(error.contains("feature gpu"), "{error}");
    }
}

#[cfg(feature = "gpu")]
#[test]
fn both_backends_give_the_same_bytes() {
    if !echogrid::kernels::gpu_required() && choose_gpu().is_none() {
        eprintln!("SKIPPED: no GPU adapter");
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let log = log_of_bend(place.path());
    for method in ["certainty", "bayes", "features"] {
        let [cpu, gpu] = [Choice::Cpu, Choice::Gpu].map(|choice| bits(&map(&log, method, choice).1));
        assert!(cpu == gpu, "{method}: the backends' maps differ");
    }
}

#[cfg(feature = "gpu")]
fn choose_gpu() -> Option<()> {
    let method = echogrid::method::make(Settings::of("bayes")?);
    choose(Choice::Gpu, method.as_ref(), 0).ok().map(|_| ())
}
