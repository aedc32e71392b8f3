//! Maps of simulated worlds, scored against the truth: what makes sonar hard is there, and costs what it should.

use echogrid::evaluate::score::{Numbers, Options, Truth, score};
use echogrid::kernels::cpu::Cpu;
use echogrid::log::Options as LogOptions;
use echogrid::method::settings::Settings;
use echogrid::pipeline::session::{Request, Session};
use echogrid::sensor::Overrides;
use echogrid::world::rig::Noise;
use echogrid::world::{Rig, Simulation, World, scan, simulate};
use std::path::Path;

fn shipped(name: &str) -> World {
    World::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds").join(name)).unwrap()
}

/// Simulates one scan at each stop, maps it at 0.1 m (ε 5 cm, a missing echo frees nothing) and scores it.
fn mapped(world: &World, rig: &Rig, seed: u64, method: &str, hit_range: Option<f64>) -> Numbers {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.jsonl");
    simulate(&Simulation { world, rig, seed, scans: None }, std::fs::File::create(&log).unwrap(), &|_| {}).unwrap();
    let overrides = Overrides { epsilon: Some(0.05), no_echo_range: Some(0.0), hit_range, ..Overrides::default() };
    let request = Request {
        log: LogOptions { overrides, ..LogOptions::default() },
        settings: Settings::of(method).unwrap(),
        resolution: 0.1,
        bounds: None,
        until: None,
        strict: true,
    };
    let session = Session::open(&log, &request).unwrap();
    let map = session.map(&mut Cpu::new(0).unwrap(), 10_000, &|_| {}).unwrap().finished.map;
    let truth = Truth::of_world(world.clone(), None).unwrap();
    score("map", &map, &truth, &Options::default()).unwrap().numbers
}

#[test]
fn one_bounce_only_leaves_a_fraction_of_the_danger() {
    let danger = |name: &str, bounces: u8| -> u64 {
        let mut rig = Rig::named("dense").unwrap();
        rig.physics.bounces = bounces;
        (1..=3).map(|seed| mapped(&shipped(name), &rig, seed, "bayes", None).zones.z5).sum()
    };
    // Z5 over three seeds, one bounce to three: between a tenth and a quarter; in the room of 4.6 × 3.4 m, where most third
    // echoes lie beyond the range, a third (as on the floor, whose rooms are large).
    for (name, low, high) in
        [("bend.toml", 0.1, 0.25), ("cartons.toml", 0.1, 0.25), ("turned.toml", 0.1, 0.25), ("room.toml", 0.2, 0.4)]
    {
        let (one, three) = (danger(name, 1), danger(name, 3));
        let ratio = one as f64 / three as f64;
        eprintln!("{name}: Z5 {one} with one bounce, {three} with three: {ratio:.3}");
        assert!((low..=high).contains(&ratio), "{name}: {one} of {three} cells of danger, {ratio:.3}");
    }
}

#[test]
fn echoes_from_beyond_two_metres_are_the_danger() {
    let world = shipped("bend.toml");
    for method in ["certainty", "dempster-shafer", "bayes", "himm"] {
        let all = mapped(&world, &world.rig, 1, method, None);
        let near = mapped(&world, &world.rig, 1, method, Some(2.0));
        eprintln!("{method}: danger {:?} and {:?}, Z5 {} and {}", all.danger, near.danger, all.zones.z5, near.zones.z5);
        assert!(near.danger < all.danger && 4 * near.zones.z5 < all.zones.z5, "{method}");
        assert!(near.recall_tolerant.unwrap() > 0.8 && near.precision_tolerant.unwrap() > 0.55, "{method}: {near:?}");
    }
}

#[test]
fn a_centimetre_of_noise_is_a_centimetre_of_spread_and_little_danger() {
    let world = shipped("bend.toml");
    let mut noisy = Rig::named("dense").unwrap();
    noisy.transducers[0].noise = Noise { metres: 0.01, share: 0.0 };
    let mut clean = noisy.clone();
    (clean.spurious, clean.cross_talk, clean.physics.flutter) = (0.0, 0.0, 0.0);
    let mut silent = clean.clone();
    silent.transducers[0].noise = Noise { metres: 0.0, share: 0.0 };
    let differences: Vec<f64> = (0..world.trajectory.len() as u64)
        .flat_map(|k| scan(&world, &clean, 4, k).into_iter().zip(scan(&world, &silent, 4, k)))
        .filter(|(a, b)| a.range.is_finite() && b.range.is_finite())
        .map(|(a, b)| a.range - b.range)
        .collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let spread = (differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / n).sqrt();
    // two roundings to 1 cm, each of variance 1/12 cm²
    let want = 0.01 * (1.0 + 2.0 / 12.0_f64).sqrt();
    assert!(n > 1500.0 && mean.abs() < 0.001 && (spread - want).abs() < 0.001, "{n} echoes: {mean}, {spread}");
    let (with, without) = (mapped(&world, &noisy, 1, "bayes", None), mapped(&world, &world.rig, 1, "bayes", None));
    let ratio = with.zones.z5 as f64 / without.zones.z5 as f64;
    assert!((0.8..1.25).contains(&ratio), "Z5 {} and {}", with.zones.z5, without.zones.z5);
}

/// A room with a box and a pillar, all of it turned about the origin, and a path through it.
fn turned(degrees: f64) -> World {
    let (s, c) = degrees.to_radians().sin_cos();
    let p = |x: f64, y: f64| format!("[{}, {}]", c * x - s * y, s * x + c * y);
    let outline = [p(0.02, 0.03), p(5.83, 0.03), p(5.83, 4.27), p(0.02, 4.27), p(0.02, 0.03)].join(", ");
    let path = [p(1.1, 1.0), p(4.6, 1.2), p(4.4, 3.1)].join(", ");
    let text = format!(
        "[[outline]]\npoints = [{outline}]\n[[box]]\ncentre = {}\nsize = [0.6, 0.4]\nturn = \"{}deg\"\n\
         [[circle]]\ncentre = {}\nradius = 0.3\n[path]\npoints = [{path}]\nstep = 0.3\n",
        p(2.6, 2.4),
        degrees + 20.0,
        p(1.2, 3.2)
    );
    World::parse(Path::new("turned.toml"), &text).unwrap()
}

#[test]
fn a_turned_world_sounds_as_it_did() {
    let mut rig = Rig::named("ring24").unwrap();
    (rig.spurious, rig.cross_talk, rig.physics.flutter) = (0.0, 0.0, 0.0);
    rig.transducers.iter_mut().for_each(|t| t.noise = Noise { metres: 0.0, share: 0.0 });
    let readings = |world: &World| -> Vec<f64> {
        (0..world.trajectory.len() as u64).flat_map(|k| scan(world, &rig, 1, k)).map(|r| r.range).collect()
    };
    let straight = readings(&turned(0.0));
    for degrees in [7.0, 90.0, 181.3] {
        let other = readings(&turned(degrees));
        assert_eq!(straight.len(), other.len());
        // poses are rounded to 1 µm and 1 µrad: an echo at the edge of a beam or of hearing may come or go
        let differ = straight.iter().zip(&other).filter(|(a, b)| a != b && (*a - *b).abs() > 0.011).count();
        eprintln!("{degrees}°: {differ} of {} readings differ", straight.len());
        assert!(differ * 200 <= straight.len(), "{degrees}°: {differ} of {} readings differ", straight.len());
    }
}

#[test]
fn a_room_of_another_size_turned_by_seven_degrees_is_as_hard() {
    let (room, other) = (shipped("room.toml"), shipped("turned.toml"));
    for world in [&room, &other] {
        let n = mapped(world, &world.rig, 1, "bayes", None);
        eprintln!("{}: danger {:?}, accuracy {:?}", world.name, n.danger, n.accuracy);
        assert!(n.danger.unwrap() > 0.25 && n.accuracy.unwrap() > 0.9, "{}: {n:?}", world.name);
    }
}
