//! The sonar's physics, and the same bytes for the same seed.

use echogrid::log::reading::Record;
use echogrid::world::rig::Noise;
use echogrid::world::{Rig, Simulation, World, scan, simulate};
use std::path::Path;

fn shipped(name: &str) -> World {
    World::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds").join(name)).unwrap()
}

/// A rig without false echoes, noise or flutter.
fn clean(name: &str) -> Rig {
    let mut rig = Rig::named(name).unwrap();
    (rig.spurious, rig.cross_talk, rig.physics.flutter) = (0.0, 0.0, 0.0);
    rig.transducers.iter_mut().for_each(|t| t.noise = Noise { metres: 0.0, share: 0.0 });
    rig
}

fn log(world: &World, rig: &Rig, seed: u64, threads: usize) -> Vec<u8> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| simulate(&Simulation { world, rig, seed, scans: Some(30) }, Vec::new(), &|_| {})).unwrap().1
}

fn off(r: &Record, bearing: f64) -> f64 {
    let turn = (r.pose.heading.to_degrees() - bearing).rem_euclid(360.0);
    turn.min(360.0 - turn)
}

/// The share of readings without an echo over all stops.
fn missing(name: &str) -> f64 {
    let world = shipped(name);
    let all: Vec<Record> = (0..world.trajectory.len() as u64 * 3)
        .flat_map(|k| scan(&world, &Rig::named("dense").unwrap(), 5, k))
        .collect();
    all.iter().filter(|r| r.range == f64::INFINITY).count() as f64 / all.len() as f64
}

#[test]
fn arcs_of_constant_depth_around_each_walls_normal() {
    let world = shipped("room.toml");
    let records = scan(&world, &clean("dense"), 1, 0);
    // from (1.5, 1.3): right, top, left, bottom
    for (bearing, depth) in [(0.0, 3.12), (90.0, 2.13), (180.0, 1.48), (270.0, 1.27)] {
        let arc: Vec<_> =
            records.iter().filter(|r| off(r, bearing) < 16.0 && (r.range - depth + 0.14).abs() < 0.021).collect();
        let widest = arc.iter().map(|r| off(r, bearing)).fold(0.0, f64::max);
        // e^(−2κθ²/β²)·0.95·A(d) = A(5)/1.5 gives the half width
        let loss = |d: f64| (-0.36 * d).exp() / d;
        let want = 15.0 * ((0.95 * loss(depth - 0.14) / (loss(5.0) / 1.5)).ln() / (2.0 * 2.626)).sqrt().min(1.0);
        assert!((widest - want).abs() < 2.0, "{bearing}°: ±{widest}°, not ±{want}°");
        assert!(arc.len() as f64 > 0.9 * 2.0 * want / 1.8 - 2.0, "{} readings about {bearing}°", arc.len());
    }
}

#[test]
fn an_echo_from_each_square_corner_and_nothing_between() {
    let world = shipped("room.toml");
    let rig = clean("dense");
    for (k, at) in [(0, (1.5, 1.3)), (1, (3.2, 2.0))] {
        let records = scan(&world, &rig, 1, k);
        for corner in [(0.02, 0.03), (4.62, 0.03), (4.62, 3.43), (0.02, 3.43)] {
            let (dx, dy): (f64, f64) = (corner.0 - at.0, corner.1 - at.1);
            let bearing = dy.atan2(dx).to_degrees();
            let back = records.iter().filter(|r| off(r, bearing) < 3.0 && (r.range - dx.hypot(dy) + 0.14).abs() < 0.02);
            assert!(back.count() >= 2, "scan {k}: no echo from {corner:?}");
        }
    }
    // between a wall's arc and a corner's: nothing, or an echo from far beyond the wall
    for bearing in [155.0, 201.0, 60.0] {
        let between: Vec<_> = scan(&world, &rig, 1, 0).into_iter().filter(|r| off(r, bearing) < 2.7).collect();
        assert!(between.len() >= 3 && between.iter().all(|r| r.range > 3.0), "{bearing}°: {between:?}");
    }
}

#[test]
fn echoes_are_missing_as_often_as_measured() {
    let [room, bend, cartons] = ["room.toml", "bend.toml", "cartons.toml"].map(missing);
    eprintln!("NoEcho: room {room:.3}, bend {bend:.3}, cartons {cartons:.3}");
    assert!((0.5..0.7).contains(&room) && (0.5..0.7).contains(&bend) && (0.2..0.35).contains(&cartons));
}

#[test]
fn phantoms_behind_walls_come_through_mirrors() {
    let world = shipped("bend.toml");
    let long = |bounces: u8| {
        let mut rig = clean("dense");
        rig.physics.bounces = bounces;
        let mut bare = clean("dense");
        bare.physics.specular = false;
        let through = |k: u64| {
            let pairs = scan(&world, &rig, 1, k).into_iter().zip(scan(&world, &bare, 1, k));
            pairs.filter(|(r, b)| r.range.is_finite() && r.range > b.range + 1.0).count()
        };
        (0..world.trajectory.len() as u64).map(through).sum::<usize>()
    };
    let (one, three) = (long(1), long(3));
    eprintln!("echoes 1 m beyond the nearest surface: {one} with one bounce, {three} with three");
    assert!(three > one + 200, "{one}, {three}");
}

#[test]
fn without_specularity_the_nearest_distance_in_the_cone() {
    let world = shipped("cartons.toml");
    let mut rig = clean("dense");
    rig.physics.specular = false;
    let mut laser = clean("laser");
    laser.transducers[0].sensor.r_min = 0.0;
    for k in [3, 17] {
        for r in scan(&world, &rig, 1, k) {
            // many laser beams from the transducer's own place, over the cone
            let text = format!(
                "{}\n[path]\nposes = [[{}, {}, {}]]\n[[sensor]]\nid = 'l'\nkind = 'laser'\n",
                std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/cartons.toml"))
                    .unwrap()
                    .split("[path]")
                    .next()
                    .unwrap(),
                r.pose.x,
                r.pose.y,
                r.pose.heading
            );
            if r.pose.heading.fract() > 0.05 {
                continue; // a twentieth of them will do
            }
            let here = World::parse(Path::new("here.toml"), &text).unwrap();
            let mut fan = laser.clone();
            (fan.transducers[0].beams, fan.transducers[0].step) = (1201, 30.0_f64.to_radians() / 1200.0);
            let nearest = scan(&here, &fan, 1, 0).iter().map(|b| b.range).fold(f64::INFINITY, f64::min);
            assert!((r.range - nearest).abs() < 0.011, "{} m, the rays say {nearest} m", r.range);
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let world = shipped("cartons.toml");
    for name in ["dense", "ring8", "laser"] {
        let rig = Rig::named(name).unwrap();
        let one = log(&world, &rig, 7, 1);
        assert_eq!(one, log(&world, &rig, 7, 2), "{name}");
        assert_ne!(one, log(&world, &rig, 8, 2), "{name}");
    }
}

#[test]
fn every_shipped_world_opens_and_every_rig_reads_it() {
    for name in ["room", "bend", "cartons", "floor", "campus"] {
        let world = shipped(&format!("{name}.toml"));
        let [x0, y0, x1, y1] = world.bounds();
        assert!(world.scans().iter().all(|s| x0 < s.x && s.x < x1 && y0 < s.y && s.y < y1), "{name}");
        for rig in echogrid::world::RIGS {
            let rig = Rig::named(rig).unwrap();
            let records = scan(&world, &rig, 1, 0);
            assert_eq!(records.len() as u64, rig.readings());
            assert!(records.iter().any(|r| r.range.is_finite()), "{name}, {}", rig.name);
        }
    }
}

/// A world of these shapes, heard from (1, 1) by one sonar that looks along `heading`, degrees, without noise.
fn heard(shapes: &str, heading: f64, more: &str) -> f64 {
    let text = format!(
        "{shapes}\n[path]\nposes = [[1, 1, \"{heading}deg\"]]\n[rig]\nnoise = 0\nnoise_share = 0\nspurious = 0\n\
         cross_talk = 0\nflutter = 0\n{more}\n[[sensor]]\nid = \"s\"\nhalf_width = \"15deg\"\nr_min = 0.15\nr_max = 5\n"
    );
    let world = World::parse(Path::new("one.toml"), &text).unwrap();
    scan(&world, &world.rig, 1, 0)[0].range
}

#[test]
fn one_echo_at_a_time() {
    let wall = |x: f64| format!("[[wall]]\npoints = [[{x}, 0], [{x}, 2]]\n");
    assert_eq!(heard(&wall(3.0), 0.0, ""), 2.0);
    assert_eq!(heard(&wall(3.0), 180.0, ""), f64::INFINITY);
    // the nearest thing in the cone hides the rest, also where it is too near to be measured
    let two = format!("{}{}", wall(1.1), wall(3.0));
    assert_eq!(heard(&two, 0.0, "specular = false"), f64::INFINITY);
    assert_eq!(heard(&wall(3.0), 0.0, "specular = false"), 2.0);
    // a whole circle however its angles are written; none is no circle
    for angles in
        ["", "from = 0\nto = \"360deg\"\n", "from = \"-180deg\"\nto = \"180deg\"\n", "from = 0\nto = \"720deg\"\n"]
    {
        let circle = format!("[[circle]]\ncentre = [3, 1]\nradius = 0.5\n{angles}");
        assert_eq!(heard(&circle, 0.0, ""), 1.5, "{angles}");
    }
    // a part of a circle is thin: it answers on its outer side, and on its inner one
    let arc = |from: f64, to: f64| {
        format!("[[circle]]\ncentre = [2.5, 1]\nradius = 0.5\nfrom = \"{from}deg\"\nto = \"{to}deg\"\n")
    };
    assert_eq!(heard(&arc(90.0, 270.0), 0.0, ""), 1.0);
    assert_eq!(heard(&arc(-90.0, 90.0), 0.0, ""), 2.0);
    // a smooth wall aslant by more than the beam sends nothing back, a rough one does, from where the beam meets it
    let slant = "[[wall]]\npoints = [[1.8, 0], [3.2, 2]]\n";
    assert_eq!(heard(slant, 0.0, ""), f64::INFINITY);
    let rough = heard(&format!("{slant}surface = \"diffuse\"\n"), 0.0, "");
    assert!((1.2..1.5).contains(&rough), "{rough}");
    let ball = "[[circle]]\ncentre = [2.5, 1]\nradius = 0.5\nsurface = \"diffuse\"\n";
    assert!((heard(ball, 0.0, "") - 1.0).abs() < 0.02);
}

#[test]
fn a_hair_of_overlap_costs_no_corner() {
    // the corridor's cooler, pushed into its wall or pulled off it by less than a millimetre
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/bend.toml")).unwrap();
    let missing = |y: &str| {
        let world =
            World::parse(Path::new("bend.toml"), &text.replace("[4.215, 0.219]", &format!("[4.215, {y}]"))).unwrap();
        let all = (0..world.trajectory.len() as u64).flat_map(|k| scan(&world, &clean("dense"), 1, k));
        all.filter(|r| r.range == f64::INFINITY).count() as f64
    };
    let flush = missing("0.22");
    for y in ["0.215", "0.2191", "0.2195", "0.2199", "0.2200001", "0.2205", "0.2209"] {
        assert!((missing(y) / flush - 1.0).abs() < 0.01, "{y}: {} missing, {flush} where it stands flush", missing(y));
    }
}
