//! Laws that the kernels obey on random cones, on the CPU (the GPU is held against it elsewhere).

use crate::common::{Run, Scene, cone_settings, settings};
use crate::scenes::{laser, random, reading, scene, sonar};
use echogrid::binning::batch::{Batch, Binning};
use echogrid::binning::snap::{Footprint, snap};
use echogrid::geometry::layout::{CELL, CHUNK, Cone, Frame, TILE, TILE_CELLS};
use echogrid::grid::GridSpec;
use echogrid::kernels::cpu::Cpu;
use echogrid::kernels::{Backend, ChunkStates};
use echogrid::log::reading::{Outcome, Reading};
use echogrid::method::{self, Method, Step};
use echogrid::oracle::OracleMap;
use echogrid::sensor::Sensor;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const RESOLUTION: f64 = 0.125;

/// Not square, neither side whole tiles.
fn grid() -> GridSpec {
    GridSpec { anchor: (0.0, 0.0), resolution: RESOLUTION, i0: -45, j0: -37, width: 90, height: 75 }
}

fn sensors() -> Vec<Sensor> {
    let mut laser = laser(0.3, 4.0);
    laser.no_echo_range = 1.0;
    vec![sonar(13.0, 0.3, 4.0), sonar(60.0, 0.1, 2.5), laser]
}

fn any_readings() -> impl Strategy<Value = Vec<Reading>> {
    let one = (0..3usize, -6.0..6.0f64, -5.0..5.0f64, -7.0..7.0f64, 0.0..4.0f64, 0..5u8);
    let one = one.prop_map(|(k, x, y, heading, range, echo)| {
        let outcome = if echo == 0 { Outcome::NoEcho } else { Outcome::Hit };
        reading(k, (x, y, heading), range, outcome)
    });
    prop::collection::vec(one, 1..40)
}

fn on(grid: GridSpec, readings: &[Reading]) -> Scene {
    scene("law", grid, sensors(), readings.to_vec())
}

/// Runs a method on cones as they are; the state of each cell, word by word.
fn run_cones(method: &dyn Method, size: [usize; 2], cones: Vec<Cone>, grid: &GridSpec) -> Vec<Vec<u32>> {
    let mut cpu = Cpu::new(1).unwrap();
    for steps in method.sweeps() {
        let no_echo_arcs = steps.contains(&Step::NormalizeByCount);
        let batch: Batch = Binning { size, footprint: method.footprint(), no_echo_arcs, only: None }.bin(cones.clone());
        let frame = Frame {
            size: size.map(|s| s as u32),
            mode: 0,
            scale: (grid.resolution / f64::from(CELL)) as f32,
            constants: method.constants(),
            limits: [0; 4],
        };
        cpu.apply(method, frame, &batch, steps, &mut Vec::new()).unwrap();
    }
    cells(method, size, &cpu.finish(method).unwrap())
}

fn cells(method: &dyn Method, size: [usize; 2], chunks: &ChunkStates) -> Vec<Vec<u32>> {
    assert!(size.iter().all(|s| *s <= CHUNK * TILE), "one chunk");
    let fresh = vec![0; method::planes(method)];
    let mut cells = vec![fresh; size[0] * size[1]];
    let Some(state) = chunks.get(&Default::default()) else { return cells };
    for (k, cell) in cells.iter_mut().enumerate() {
        let (x, y) = (k % size[0], k / size[0]);
        let slot = y / TILE * CHUNK + x / TILE;
        let at = slot * method::tile_words(method) + y % TILE * TILE + x % TILE;
        for (p, word) in cell.iter_mut().enumerate() {
            *word = state[at + p * TILE_CELLS];
        }
    }
    cells
}

fn snapped(method: &dyn Method, readings: &[Reading]) -> Vec<Cone> {
    let sensors = sensors();
    let one = |r: &Reading| {
        let sensor = &sensors[r.record.sensor as usize];
        // Wedges as wide as the beam, for the truth.
        let edges = (method.footprint() == Footprint::Wedge)
            .then_some((r.record.pose.heading + sensor.half_width, r.record.pose.heading - sensor.half_width));
        let (cone, snapped) = snap(&grid(), sensor, r, method.footprint(), edges)?;
        Some(Cone { profile: method.profile(sensor, &snapped), ..cone })
    };
    readings.iter().filter_map(one).collect()
}

/// A quarter turn to the left about the grid, which becomes `height` wide.
fn turned(cone: &Cone, height: usize) -> Cone {
    let turn = |v: [i32; 2]| [-v[1], v[0]];
    let at = cone.sensor;
    Cone {
        sensor: [CELL * height as i32 - at[1], at[0]],
        axis: turn(cone.axis),
        left: turn(cone.left),
        right: turn(cone.right),
        ..*cone
    }
}

/// Whether some cell's centre lies exactly on a border of the axis' band or of the hit cell, which go to one side; or exactly
/// on the open edge of a wedge. A turn takes such a cell to the other side.
fn has_tie(cone: &Cone) -> bool {
    let (x, y) = (i64::from(cone.axis[0]), i64::from(cone.axis[1]));
    if x.abs() == y.abs() {
        return true;
    }
    let (c, s, k) = if y.abs() > x.abs() { (y, x, 1) } else { (x, y, 0) };
    let g = grid();
    (0..g.height as i64).any(|j| {
        (0..g.width as i64).any(|i| {
            let v = [32 * i + 16 - i64::from(cone.sensor[0]), 32 * j + 16 - i64::from(cone.sensor[1])];
            let (a, b) = (v[k], v[1 - k]);
            (b * c - a * s).abs() == 16 * c.abs()
        })
    })
}

/// Whether two complements of Occ agree when sums were added in another order. A sum of n terms, none negative, is off by
/// n·u at most, so each reading's share by twice that; no arc here has 500 cells.
fn near(a: u32, b: u32, readings: usize) -> bool {
    let most = readings as f32 * 2.0 * 500.0 * (f32::EPSILON / 2.0);
    (f32::from_bits(a) - f32::from_bits(b)).abs() <= most
}

fn layer<'a>(run: &'a Run, name: &str) -> &'a echogrid::grid::Data {
    &run.map.layer(name).unwrap().data
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 24,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(20),
        ..ProptestConfig::default()
    })]

    #[test]
    fn conservation(readings in any_readings()) {
        let scene = on(grid(), &readings);
        for (name, settings) in cone_settings() {
            let (run, oracle) = (scene.cpu(settings), scene.oracle(settings));
            let counted: u64 = run.visits.interior.iter().chain(&run.visits.arc).map(|n| u64::from(*n)).sum();
            prop_assert_eq!((run.map.updates, counted), (oracle.updates, oracle.updates), "{}", name);
            prop_assert_eq!(
                (run.counts.outside, run.counts.empty_arc, run.counts.wide),
                (oracle.outside, oracle.empty_arc, oracle.wide),
                "{}", name
            );
            let each: u64 = readings.iter().map(|r| on(grid(), &[*r]).cpu(settings).map.updates).sum();
            prop_assert_eq!(each, run.map.updates, "{}: one by one", name);
        }
    }

    #[test]
    fn a_quarter_turn(readings in any_readings()) {
        let (width, height) = (grid().width, grid().height);
        for name in ["certainty", "dempster-shafer", "dempster-shafer-murphy", "bayes", "bayes-constant", "himm"] {
            let method = method::make(settings(name));
            let mut cones = snapped(method.as_ref(), &readings);
            if name == "himm" {
                cones.retain(|c| !has_tie(c));
            }
            let turned = cones.iter().map(|c| turned(c, height)).collect();
            let still = run_cones(method.as_ref(), [width, height], cones, &grid());
            let after = run_cones(method.as_ref(), [height, width], turned, &grid());
            for y in 0..height {
                for x in 0..width {
                    let (a, b) = (&still[y * width + x], &after[x * height + height - 1 - y]);
                    // Σ Occ_k is added tile by tile, in another order after a turn: all but occupancy is the same.
                    let words = if name == "certainty" { 3 } else { a.len() };
                    prop_assert_eq!(&a[..words], &b[..words], "{}: cell {},{}", name, x, y);
                    if name == "certainty" {
                        prop_assert!(near(a[3], b[3], readings.len()), "occupancy of cell {},{}", x, y);
                    }
                }
            }
        }
    }

    #[test]
    fn whole_cells_translate(readings in any_readings(), di in -60i64..60, dj in -60i64..60, tiles in any::<bool>()) {
        // By whole tiles even the order of Σ Occ_k's parts is the same; by cells all but occupancy.
        let (di, dj) = if tiles { (di / 16 * 16, dj / 16 * 16) } else { (di, dj) };
        // Large enough that no cone leaves it before or after: n and the sums run over the cells inside.
        let large = [384, 384];
        for (name, settings) in cone_settings() {
            let method = method::make(settings);
            let middle = |c: &Cone, by: [i64; 2]| {
                let to = [0, 1].map(|k| c.sensor[k] + CELL * (144 + by[k]) as i32);
                Cone { sensor: to, ..*c }
            };
            let cones = snapped(method.as_ref(), &readings);
            let here = cones.iter().map(|c| middle(c, [0, 0])).collect();
            let there = cones.iter().map(|c| middle(c, [di, dj])).collect();
            let a = run_cones(method.as_ref(), large, here, &grid());
            let b = run_cones(method.as_ref(), large, there, &grid());
            let exact = tiles || !name.starts_with("certainty");
            for y in 64..320i64 {
                for x in 64..320i64 {
                    let (p, q) = (&a[(y * 384 + x) as usize], &b[((y + dj) * 384 + x + di) as usize]);
                    let words = if exact { p.len() } else { 3 };
                    prop_assert_eq!(&p[..words], &q[..words], "{}: cell {},{}", name, x, y);
                    if !exact {
                        prop_assert!(near(p[3], q[3], readings.len()), "occupancy of cell {},{}", x, y);
                    }
                }
            }
        }
    }

    #[test]
    fn any_batch_split(readings in any_readings(), batch in 1usize..20) {
        let scene = on(grid(), &readings);
        for (name, settings) in cone_settings() {
            let method = method::make(settings);
            let split = scene.run(method.as_ref(), &mut Cpu::new(1).unwrap(), batch);
            let whole = scene.cpu(settings);
            prop_assert!(split.map == whole.map && split.visits == whole.visits, "{} in batches of {}", name, batch);
            prop_assert_eq!(split.counts, whole.counts, "{}", name);
        }
    }

    #[test]
    fn order_where_the_rule_commutes(readings in any_readings()) {
        let backwards: Vec<Reading> = readings.iter().rev().copied().collect();
        let (scene, reversed) = (on(grid(), &readings), on(grid(), &backwards));
        for name in ["dempster-shafer", "dempster-shafer-rho", "dempster-shafer-murphy"] {
            let (a, b) = (scene.cpu(settings(name)), reversed.cpu(settings(name)));
            prop_assert!(a.map == b.map && a.visits == b.visits, "{}", name);
        }
        let truth = method::make(settings("truth"));
        let size = [grid().width, grid().height];
        let a = run_cones(truth.as_ref(), size, snapped(truth.as_ref(), &readings), &grid());
        let b = run_cones(truth.as_ref(), size, snapped(truth.as_ref(), &backwards), &grid());
        prop_assert_eq!(a, b);
        // Sums of f32 round another way: within what the reference allows each.
        for name in ["bayes", "bayes-no-floors", "bayes-constant"] {
            let (a, b) = (scene.cpu(settings(name)), reversed.cpu(settings(name)));
            let bound = |m: &OracleMap, k: usize| m.layer("log_odds").unwrap().bound[k];
            let (p, q) = (scene.oracle(settings(name)), reversed.oracle(settings(name)));
            for k in 0..grid().cells() {
                let apart = (layer(&a, "log_odds").get(k) - layer(&b, "log_odds").get(k)).abs();
                prop_assert!(apart <= bound(&p, k) + bound(&q, k) + 1e-12, "{}: cell {}: {}", name, k, apart);
            }
            prop_assert!(a.visits == b.visits);
        }
    }

    #[test]
    fn masses_and_evidence_stay_in_range(readings in any_readings()) {
        let scene = on(grid(), &readings);
        for name in ["dempster-shafer", "dempster-shafer-rho", "dempster-shafer-murphy"] {
            let run = scene.cpu(settings(name));
            for k in 0..grid().cells() {
                let m = ["empty", "full", "unknown"].map(|l| layer(&run, l).get(k));
                prop_assert!(m.iter().all(|v| (0.0..=1.0).contains(v)), "{}: {:?}", name, m);
                // Each of the three is rounded to f32.
                prop_assert!((m.iter().sum::<f64>() - 1.0).abs() <= 1.5 * f64::from(f32::EPSILON) / 2.0, "{}: {:?}", name, m);
                prop_assert!(layer(&run, "conflict").get(k) >= 0.0, "{}", name);
            }
        }
        for name in ["certainty", "certainty-batch"] {
            let run = scene.cpu(settings(name));
            for k in 0..grid().cells() {
                prop_assert!(["emp", "occ"].iter().all(|l| (0.0..=1.0).contains(&layer(&run, l).get(k))), "{}", name);
            }
        }
        for name in ["himm", "himm-gro"] {
            let run = scene.cpu(settings(name));
            prop_assert!((0..grid().cells()).all(|k| (0.0..=15.0).contains(&layer(&run, "count").get(k))), "{}", name);
        }
        let run = scene.cpu(settings("bayes"));
        for k in 0..grid().cells() {
            let p = ["p_occ", "p_emp"].map(|l| layer(&run, l).get(k));
            prop_assert!(p.iter().all(|p| (0.0..=1.0).contains(p)) && (p[0] + p[1] - 1.0).abs() <= f64::from(f32::EPSILON));
        }
    }
}

/// Thousands of strong readings on both sides leave masses that are still masses.
#[test]
fn masses_of_a_parked_robot() {
    let one = random(11, 3, [-1.0, -1.0, 1.0, 1.0], &sensors(), 1.0);
    let readings: Vec<Reading> = one.iter().cycle().take(6000).copied().collect();
    let scene = on(grid(), &readings);
    for name in ["dempster-shafer", "dempster-shafer-rho", "dempster-shafer-murphy"] {
        let run = scene.cpu(settings(name));
        crate::common::assert_oracle(&format!("parked robot {name}"), &run, &scene.oracle(settings(name)));
        for k in 0..grid().cells() {
            let m = ["empty", "full", "unknown"].map(|l| layer(&run, l).get(k));
            let sum: f64 = m.iter().sum();
            assert!(m.iter().all(|v| (0.0..=1.0).contains(v)) && (sum - 1.0).abs() <= 1e-7, "{name}: {m:?}");
        }
    }
}
