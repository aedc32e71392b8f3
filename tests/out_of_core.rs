//! The out-of-core pipeline: chunk by chunk it gives the bytes that all chunks together give, however it is batched or spilled.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking; here are the tests' helpers too")]

use echogrid::grid::{Data, Map};
use echogrid::kernels::{Backend, cpu::Cpu, gpu};
use echogrid::log::reading::Counts;
use echogrid::method::settings::Settings;
use echogrid::output::{MapSchema, MapWriter, RunInfo, check, read_map};
use echogrid::pipeline::layers;
use echogrid::pipeline::out_of_core::{self, MapOutput, ResourcePlan};
use echogrid::pipeline::session::{Request, Session};
use echogrid::world::{Rig, Simulation, World, simulate};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A log of a small campus that lies across six chunks at 3 cm.
fn log(folder: &Path, rig: &str) -> PathBuf {
    let world = World::parse(Path::new("c.toml"), "[campus]\nseed = 4\nwidth = 75\nheight = 70\n").unwrap();
    let path = folder.join("campus.jsonl");
    let file = std::fs::File::create(&path).unwrap();
    simulate(&Simulation { world: &world, rig: &Rig::named(rig).unwrap(), seed: 2, scans: Some(2600) }, file, &|_| {})
        .unwrap();
    path
}

fn session(log: &Path, settings: Settings) -> Session {
    let request =
        Request { log: Default::default(), settings, resolution: 0.03, bounds: None, until: None, strict: true };
    Session::open(log, &request).unwrap()
}

/// Maps chunk by chunk into a folder, and reads the map back.
fn mapped(session: &Session, backend: &mut dyn Backend, batch: usize, bins: u64, folder: &Path) -> (Map, Counts) {
    std::fs::create_dir(folder).unwrap();
    let (layers, combined) = layers::schemas(session.method.as_ref());
    let method = echogrid::method::name(session.method.as_ref()).to_string();
    let schema = MapSchema { grid: session.grid, method, layers, combined, npy: false };
    let mut writer = MapWriter::open(folder, schema, &RunInfo::default(), false).unwrap();
    let plan = ResourcePlan { batch, bins, ..ResourcePlan::of(session, batch, None).unwrap() };
    let silent = |_: &str, _: u64| -> Box<dyn Fn(u64)> { Box::new(|_| {}) };
    let output = MapOutput { folder, progress: &silent, sink: &mut writer };
    let counts = out_of_core::map(session, backend, &plan, output).unwrap().counts;
    writer.finish(&RunInfo::default()).unwrap();
    assert!(check(folder, &|| {}).unwrap().problems.is_empty());
    (read_map(folder).unwrap().map, counts)
}

fn bits(map: &Map) -> Vec<(String, Vec<u64>)> {
    let of = |d: &Data| (0..d.len()).map(|k| d.get(k).to_bits()).collect();
    map.layers.iter().map(|l| (l.name.clone(), of(&l.data))).collect()
}

fn every_settings() -> Vec<(&'static str, Settings)> {
    let set = |method: &str, pairs: &[(&str, &str)]| {
        let mut settings = Settings::of(method).unwrap();
        pairs.iter().for_each(|(k, v)| assert!(settings.set(k, v).unwrap()));
        settings
    };
    vec![
        ("certainty", set("certainty", &[])),
        ("certainty, batch order", set("certainty", &[("order", "batch")])),
        ("dempster-shafer", set("dempster-shafer", &[])),
        ("dempster-shafer, murphy", set("dempster-shafer", &[("model", "murphy")])),
        ("bayes", set("bayes", &[])),
        ("himm", set("himm", &[])),
        ("csm-discrete", set("csm-discrete", &[("w_beam", "20deg")])),
        ("csm-continuous, all", set("csm-continuous", &[("neighbours", "all"), ("z_max", "6")])),
    ]
}

#[test]
fn chunk_by_chunk_gives_the_bytes_of_all_chunks_together() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring24");
    for (name, settings) in every_settings() {
        let session = session(&log, settings);
        assert!(echogrid::grid::chunks(&session.grid).count() >= 6, "{:?}", session.grid);
        let together = session.map(&mut Cpu::new(0).unwrap(), 3000, &|_| {}).unwrap();
        let want = bits(&together.finished.map);
        // large batches in memory; small ones, spilled
        for (batch, bins) in [(1 << 16, 1 << 30), (513, 0)] {
            let place = folder.path().join("map");
            let (map, counts) = mapped(&session, &mut Cpu::new(0).unwrap(), batch, bins, &place);
            assert_eq!(counts, together.counts, "{name}");
            assert_eq!((map.grid, map.updates), (session.grid, together.finished.map.updates), "{name}");
            for ((layer, found), (_, wanted)) in bits(&map).iter().zip(&want) {
                let differ = found.iter().zip(wanted).filter(|(a, b)| a != b).count();
                assert_eq!(differ, 0, "{name}, {layer}: {differ} cells differ by {batch} readings at a time");
            }
            std::fs::remove_dir_all(&place).unwrap();
        }
    }
}

#[test]
fn on_the_gpu_too() {
    gpu_too(gpu::Options::default(), 700, &every_settings());
}

/// As on hardware: the GPU lists tiles itself.
#[test]
fn on_a_gpu_that_lists_tiles() {
    let all = every_settings();
    let named = |name: &str| all.iter().copied().find(|s| s.0 == name).unwrap();
    let settings = ["certainty", "dempster-shafer", "bayes"].map(named);
    gpu_too(gpu::Options { staged: Some(true), bins_tiles: Some(true), ..gpu::Options::default() }, 4000, &settings);
}

fn gpu_too(options: gpu::Options, batch: usize, settings: &[(&'static str, Settings)]) {
    let mut gpu = match gpu::Gpu::new(&options) {
        Ok(gpu) => gpu,
        Err(e) => {
            assert!(!echogrid::kernels::gpu_required(), "{e}");
            std::io::stderr().write_all(format!("SKIPPED on_the_gpu_too: {e}\n").as_bytes()).unwrap();
            return;
        }
    };
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring8");
    for (name, settings) in settings.iter().copied() {
        let session = session(&log, settings);
        let together = session.map(&mut gpu, 3000, &|_| {}).unwrap();
        let place = folder.path().join("map");
        let (map, counts) = mapped(&session, &mut gpu, batch, 0, &place);
        assert_eq!(counts, together.counts, "{name}");
        assert!(bits(&map) == bits(&together.finished.map), "{name}: the bytes differ");
        std::fs::remove_dir_all(&place).unwrap();
    }
}

#[test]
fn the_overview_is_a_pyramid_of_the_strongest() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring8");
    let session = session(&log, Settings::of("bayes").unwrap());
    let place = folder.path().join("map");
    let (map, _) = mapped(&session, &mut Cpu::new(0).unwrap(), 1 << 16, 1 << 30, &place);
    let text = std::fs::read(place.join("map.zarr/overview/zarr.json")).unwrap();
    let about: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let levels = about["attributes"]["ome"]["multiscales"][0]["datasets"].as_array().unwrap().clone();
    // 2,178 cells: halved until no side is longer than 256
    assert_eq!(levels.len(), 5, "{about}");
    let scale = |k: usize| levels[k]["coordinateTransformations"][0]["scale"][0].as_f64().unwrap();
    assert_eq!([scale(0), scale(3)], [0.03, 0.24]);
    let shape = |k: usize| -> Vec<u64> {
        let text = std::fs::read(place.join(format!("map.zarr/overview/{k}/zarr.json"))).unwrap();
        let about: serde_json::Value = serde_json::from_slice(&text).unwrap();
        about["shape"].as_array().unwrap().iter().map(|v| v.as_u64().unwrap()).collect()
    };
    let size = |k: u32| vec![map.grid.height.div_ceil(1 << k) as u64, map.grid.width.div_ceil(1 << k) as u64];
    assert_eq!([shape(0), shape(1), shape(3)], [size(0), size(1), size(3)]);
    // map.png is its first level
    let picture = image::open(place.join("map.png")).unwrap();
    assert_eq!((picture.width() as usize, picture.height() as usize), (map.grid.width, map.grid.height));
}

/// What a card needs is held against the cap, too.
#[test]
fn a_card_that_would_take_more_than_the_cap() {
    let folder = tempfile::tempdir().unwrap();
    let log = log(folder.path(), "ring8");
    let session = session(&log, Settings::of("bayes").unwrap());
    let plan = ResourcePlan::of(&session, 1 << 16, None).unwrap();
    // Four chunks of 20 bytes a cell at least.
    assert!(plan.card > (4 * 20) << 20, "{plan:?}");
    assert!(plan.check_card(&session, None).is_ok() && plan.check_card(&session, Some(plan.card)).is_ok());
    let why = plan.check_card(&session, Some(plan.card - (1 << 20))).unwrap_err().to_string();
    assert!(why.contains(" on the card, but `memory` allows ") && why.contains("`backend cpu`"), "{why}");
}
