//! The counting sensor models: the specification's values and sums, cases that can be worked out by hand, real labelled logs.

use crate::common::{Scene, assert_oracle, data, gpu, say};
use crate::scenes::{bounds, laser};
use echogrid::binning::batch::BATCH;
use echogrid::evaluate::verify::{BackendRun, check_backend};
use echogrid::geometry::layout::Frame;
use echogrid::kernels::Backend;
use echogrid::kernels::cpu::Cpu;
use echogrid::log::Options;
use echogrid::log::reading::{Outcome, Pose, Reading, Record};
use echogrid::method::settings::{Csm, Settings};
use echogrid::method::{self, csm};
use echogrid::pipeline::readings::ReadingInput;
use echogrid::pipeline::session::{MappedLog, Request, Session};

const INTEL: [&str; 2] = ["eecs568_intel/sample_Intel_dataset.mat", "eecs568_intel/sample_Intel_dataset_semantic.mat"];

fn settings(method: &str, keys: &[(&str, &str)]) -> Settings {
    let mut settings = Settings::of(method).unwrap();
    keys.iter().for_each(|(key, value)| assert!(settings.set(key, value).unwrap(), "{key}"));
    settings
}

fn model(method: &str) -> Csm {
    match Settings::of(method) {
        Some(Settings::Csm(csm)) => csm,
        other => panic!("{other:?}"),
    }
}

/// The kernel's values in [T], by the polynomial that both backends evaluate; and all over, against its definition.
#[test]
fn the_kernel() {
    let method = method::make(settings("csm-continuous", &[]));
    let frame = Frame { size: [1, 1], mode: 0, scale: 1.0, constants: method.constants(), limits: method.limits(0.1) };
    let wanted =
        [(0.0, 0.1), (0.025, 0.09021124), (0.05, 0.06591549), (0.1, 0.01666667), (0.15, 0.000751172), (0.2, 0.0)];
    for (d, k) in wanted {
        let found = f64::from(csm::kernel(&frame, d * 1e6));
        // Printed to eight places; f32.
        assert!((found - k).abs() <= 5e-9 + 32.0 / 16_777_216.0 * k, "k({d}) is {found}, not {k}");
    }
    for micrometres in (0..=210_000).step_by(7) {
        let t = (f64::from(micrometres) * 1e-6 / 0.2).min(1.0);
        let turn = std::f64::consts::TAU * t;
        let exact = 0.1 * ((2.0 + turn.cos()) / 3.0 * (1.0 - t) + turn.sin() / std::f64::consts::TAU);
        let found = csm::kernel(&frame, micrometres as f32);
        assert!(found >= 0.0);
        let away = (f64::from(found) - exact).abs();
        assert!(away <= 3e-8 + 4e-6 * exact, "k at {micrometres} µm is {found}, not {exact}");
    }
    // The last µm at which an increment is more than 1e-6.
    let reach = csm::reach(&model("csm-continuous"));
    let at = |micrometres: i32| f64::from(csm::kernel(&frame, micrometres as f32));
    assert!(at(reach - 1) > 1e-6 && at(reach + 1) < 1e-6, "{reach}");
}

#[test]
fn the_prior() {
    for (name, classes, variance) in [("csm-discrete", 2, 0.249501), ("csm-semantic-continuous", 7, 0.121598)] {
        let layers = method::make(settings(name, &[])).layers();
        let fill = |name: &str| f64::from(layers.iter().find(|l| l.name == name).unwrap().fill);
        assert!((fill("variance") - variance).abs() < 5e-7, "{name}: {}", fill("variance"));
        assert!((fill("mean") - (classes as f64 - 1.0) / classes as f64).abs() < 1e-6);
        assert_eq!((layers.len(), fill("label")), (3 + classes, 0.0));
        assert!(layers[3..].iter().all(|l| l.fill == 0.001));
    }
}

/// Beams of one robot pose: bearing, range (infinite: none) and label.
fn scan(at: (f64, f64), beams: &[(f64, f64, u16)], number: u64) -> Vec<ReadingInput> {
    let robot = Pose { x: at.0, y: at.1, heading: 0.0 };
    let item = |&(bearing, range, label): &(f64, f64, u16)| {
        let pose = Pose { heading: bearing, ..robot };
        let label = Some(label).filter(|l| *l > 0);
        let record = Record { t: 0.0, scan: number, sensor: 0, robot, pose, range, label, line: number + 1 };
        (Reading { record, outcome: Outcome::Hit, range }, None)
    };
    beams.iter().map(item).collect()
}

/// A map of 20 × 9 cells of 10 cm; cell (0, 4)'s centre is (0.05, 0.45).
fn by_hand(scans: &[Vec<ReadingInput>]) -> Scene {
    let mut sensor = laser(0.5, 80.0);
    (sensor.r_min, sensor.no_echo_range) = (0.0, 0.0);
    Scene {
        name: "by hand".into(),
        grid: bounds([0.0, 0.0, 2.0, 0.9], 0.1),
        sensors: vec![sensor],
        items: scans.concat(),
        updates: Vec::new(),
    }
}

/// A layer of a scene by cpu, and by gpu where there is one: they must agree.
fn layer(scene: &Scene, settings: Settings, name: &str) -> Vec<f64> {
    let of = |run: crate::common::Run| {
        let data = &run.map.layer(name).unwrap().data;
        (0..data.len()).map(|k| data.get(k)).collect::<Vec<f64>>()
    };
    let cpu = of(scene.cpu(settings));
    if let Some(run) = scene.gpu(settings) {
        let gpu = of(run);
        assert!(cpu.iter().zip(&gpu).all(|(a, b)| (a - b).abs() < 1e-6), "{name}");
    }
    cpu
}

const ROW: usize = 4 * 20;

#[test]
fn one_beam_counts_what_lies_on_it() {
    // One beam along row 4 to 1.2 m from the sensor: obstacle ± 10 cm, so hits are cells at (1.1, 1.3) m, free ones nearer.
    let scene = by_hand(&[scan((0.05, 0.45), &[(0.0, 1.2, 0)], 0)]);
    let settings = settings("csm-discrete", &[("w_obstacle", "0.2")]);
    let (hits, free) = (layer(&scene, settings, "alpha_1"), layer(&scene, settings, "alpha_2"));
    let count = |v: &[f64], k: usize| (v[k] - 0.001).round();
    for column in 0..20 {
        // The pose's own cell is skipped; |d - z| < w/2 is strict, d < z too.
        let d = column as f64 * 0.1;
        let wanted = if column == 12 {
            (1.0, 0.0)
        } else if d > 0.0 && column < 12 {
            (0.0, 1.0)
        } else {
            (0.0, 0.0)
        };
        assert_eq!((count(&hits, ROW + column), count(&free, ROW + column)), wanted, "column {column}");
    }
    // Off the row only what is within half a beam's width, 1.35°, which no other row's centre is before 4.2 m.
    assert_eq!(hits.iter().chain(&free).map(|a| (a - 0.001).round()).sum::<f64>(), 12.0);
}

#[test]
fn a_cell_takes_the_nearest_beam_and_of_equals_the_lower() {
    // Two beams 90° apart see the diagonal's cells equally near: the first of the log has them.
    let bearings = [(0.0, 1.0, 1), (std::f64::consts::FRAC_PI_2, 0.2, 2)];
    for order in [[0, 1], [1, 0]] {
        let beams = order.map(|k| bearings[k]);
        let scene = by_hand(&[scan((0.05, 0.05), &beams, 0)]);
        let settings = settings("csm-semantic-discrete", &[("w_beam", "100deg"), ("w_obstacle", "0.01")]);
        let free = layer(&scene, settings, "alpha_7");
        // Cell (3, 3) is 0.42 m away: before the hit of the one, behind that of the other.
        let seen = (free[3 * 20 + 3] - 0.001).round();
        assert_eq!(seen, if order[0] == 0 { 1.0 } else { 0.0 }, "{order:?}");
    }
}

#[test]
fn a_beam_that_came_back_from_nowhere_may_be_the_nearest() {
    let beams = [(0.0, f64::INFINITY, 1), (0.02, 1.2, 1)];
    let scene = by_hand(&[scan((0.05, 0.45), &beams, 0)]);
    let wide = [("w_beam", "10deg"), ("w_obstacle", "0.2")];
    let free = layer(&scene, settings("csm-discrete", &wide), "alpha_2");
    assert!(free[ROW..ROW + 20].iter().all(|a| (a - 0.001).abs() < 1e-6), "{:?}", &free[ROW..ROW + 20]);
}

#[test]
fn only_so_many_poses_speak_and_of_equally_near_ones_the_earlier() {
    // Twenty scans at one place: the first sixteen count.
    let many: Vec<_> = (0..20).map(|n| scan((0.05, 0.45), &[(0.0, 1.2, if n < 16 { 1 } else { 2 })], n)).collect();
    let scene = by_hand(&many);
    let of = |neighbours: &str, layer_name: &str| {
        let keys = [("neighbours", neighbours), ("w_obstacle", "0.2")];
        let layer = layer(&scene, settings("csm-semantic-discrete", &keys), layer_name);
        (layer[ROW + 12] - 0.001).round()
    };
    assert_eq!([of("16", "alpha_1"), of("16", "alpha_2")], [16.0, 0.0]);
    assert_eq!([of("18", "alpha_1"), of("18", "alpha_2")], [16.0, 2.0]);
    assert_eq!([of("all", "alpha_1"), of("all", "alpha_2")], [16.0, 4.0]);
    assert_eq!([of("1", "alpha_1"), of("1", "alpha_2")], [1.0, 0.0]);
}

#[test]
fn where_an_increment_ends_to_count() {
    // The cell lies 186991.5 µm beyond the hit: k is a hair below 1e-6 there, but a whole µm is what decides.
    let mut scene = by_hand(&[scan((0.0, 0.0), &[(0.0, 1.0, 0)], 0)]);
    let reach = f64::from(csm::reach(&model("csm-continuous")));
    assert_eq!(reach, 186_992.0);
    for (dx, dy, touched) in
        [(0.18699, 0.000749, true), (0.186991, 0.0, true), (0.186992, 0.0, false), (0.187, 0.0, false)]
    {
        scene.grid = bounds([1.0 + dx - 0.05, dy - 0.05, 1.0 + dx + 0.05, dy + 0.05], 0.1);
        let settings = settings("csm-continuous", &[]);
        let oracle = scene.oracle(settings);
        assert_eq!(oracle.is_touched(0), touched, "{dx}, {dy}");
        assert_oracle("the end of an increment, cpu", &scene.cpu(settings), &oracle);
        if let Some(run) = scene.gpu(settings) {
            assert_oracle("the end of an increment, gpu", &run, &oracle);
        }
    }
    // Two of them together are more than 1e-6, and touch.
    let twice = [scan((0.0, 0.0), &[(0.0, 1.0, 0)], 0), scan((0.0, 0.0), &[(0.0, 1.0, 0)], 1)];
    let mut scene = by_hand(&twice);
    scene.grid = bounds([1.137, -0.05, 1.237, 0.05], 0.1);
    let oracle = scene.oracle(settings("csm-continuous", &[]));
    assert!(oracle.is_touched(0) && oracle.updates == 0);
    assert_oracle("two small increments, cpu", &scene.cpu(settings("csm-continuous", &[])), &oracle);
}

/// Hundreds of poses within a millimetre: a tile's candidates are looked through, and none is lost.
#[test]
fn a_parked_robot_that_trembles() {
    let mut random = crate::scenes::Random::new(9);
    let scans: Vec<_> = (0..700)
        .map(|n| {
            let at = (1.0 + random.within(-0.001, 0.001), 0.4 + random.within(-0.001, 0.001));
            let beams: Vec<_> =
                (0..4).map(|k| (f64::from(k) * 1.5 + random.within(-0.4, 0.4), random.within(0.1, 1.0), 0)).collect();
            scan(at, &beams, n)
        })
        .collect();
    let mut scene = by_hand(&scans);
    scene.grid = bounds([0.0, 0.0, 2.0, 0.9], 0.02);
    for (name, keys) in [("csm-discrete", &[("w_beam", "60deg")][..]), ("csm-continuous", &[])] {
        let settings = settings(name, keys);
        let oracle = scene.oracle(settings);
        assert!(oracle.updates > 5_000, "{}", oracle.updates);
        let run = scene.cpu(settings);
        assert_oracle(&format!("parked {name} cpu"), &run, &oracle);
        // Of 700 candidates for each of 24 tiles few are left.
        assert!(run.statistics.entries < 24 * 350, "{}", run.statistics.entries);
    }
}

#[test]
fn the_continuous_update_by_its_formula() {
    let scene = by_hand(&[scan((0.05, 0.45), &[(0.0, 1.2, 0)], 0)]);
    let k = |d: f64| {
        let t = (d / 0.2).min(1.0);
        let turn = std::f64::consts::TAU * t;
        0.1 * ((2.0 + turn.cos()) / 3.0 * (1.0 - t) + turn.sin() / std::f64::consts::TAU)
    };
    type Free = fn(f64, f64, &dyn Fn(f64) -> f64) -> f64;
    let rules: [(&str, Free); 3] = [
        ("projection", |a, p, k| if (0.0..=1.2 + 1e-9).contains(&a) { k(p) } else { 0.0 }),
        ("clamp", |a, p, k| k(p.hypot(a - a.clamp(0.0, 1.0)))),
        ("sample", |a, p, k| (0..=12).map(|m| k(p.hypot(a - 0.1 * f64::from(m)))).sum()),
    ];
    for (rule, free) in rules {
        let settings = settings("csm-continuous", &[("free", rule)]);
        let (hits, frees) = (layer(&scene, settings, "alpha_1"), layer(&scene, settings, "alpha_2"));
        for cell in 0..180 {
            let (a, p) = ((cell % 20) as f64 * 0.1, ((cell / 20) as f64 * 0.1 - 0.4).abs());
            let pose = a == 0.0 && p < 1e-9;
            let wanted = if pose { (0.0, 0.0) } else { (k((a - 1.2).hypot(p)), free(a, p, &k)) };
            let found = (hits[cell] - 0.001, frees[cell] - 0.001);
            assert!((found.0 - wanted.0).abs() < 2e-6, "{rule}, cell {cell}: hit {} for {}", found.0, wanted.0);
            assert!((found.1 - wanted.1).abs() < 2e-6, "{rule}, cell {cell}: free {} for {}", found.1, wanted.1);
        }
    }
}

fn session(log: &str, settings: Settings, resolution: f64, bounds: Option<[f64; 4]>) -> Option<Session> {
    let request = Request { log: Options::default(), settings, resolution, bounds, until: None, strict: true };
    Some(Session::open(&data(log)?, &request).unwrap())
}

/// Maps on cpu and, where there is one, gpu; both are held against the oracle.
fn verified(session: &Session, name: &str, with_oracle: bool) -> Vec<MappedLog> {
    let oracle = with_oracle.then(|| session.oracle().unwrap());
    let mut maps = Vec::new();
    let mut run = |backend: &mut dyn Backend| {
        let mapped = session.map(backend, BATCH, &|_| {}).unwrap();
        if let Some(oracle) = &oracle {
            let (backend, adapter) = (backend.name(), backend.adapter());
            let run = BackendRun { name: backend, adapter, finished: &mapped.finished, wrong_counts: 0, seconds: 0.0 };
            let found = check_backend(session, oracle, run).unwrap();
            assert!(found.passed && found.membership == 0, "{name}: {found:?}");
        }
        maps.push(mapped);
    };
    run(&mut Cpu::new(0).unwrap());
    if let Some(mut gpu) = gpu() {
        run(&mut *gpu);
    }
    maps
}

/// [T] of both files at 0.135 m, on every backend.
#[test]
fn the_intel_lab() {
    // Sample points at -15 + 0.135 k, -25 + 0.135 k.
    let bounds = Some([-15.0675, -25.0675, -15.0675 + 261.0 * 0.135, -25.0675 + 261.0 * 0.135]);
    let labelled = [6962.0, 4529.0, 3461.0, 3565.0, 2672.0, 5134.0];
    let spread = [357.4353, 219.8561, 168.4136, 174.7209, 134.8921, 256.2504];
    type Wanted = (&'static str, usize, usize, Option<[usize; 3]>, Vec<f64>);
    let wanted: [Wanted; 4] = [
        ("csm-discrete", 0, 30382, Some([5309, 24542, 531]), vec![26323.0, 167786.0]),
        ("csm-continuous", 0, 31419, Some([4003, 27415, 1]), vec![1311.568, 18505.009]),
        ("csm-semantic-discrete", 1, 30382, None, [&labelled[..], &[167786.0]].concat()),
        ("csm-semantic-continuous", 1, 31419, None, [&spread[..], &[18505.009]].concat()),
    ];
    for (name, file, touched, classes, increments) in wanted {
        let Some(session) = session(INTEL[file], settings(name, &[]), 0.135, bounds) else { return };
        assert_eq!((session.grid.width, session.grid.height), (261, 261));
        assert_eq!((session.survey.scans, session.survey.counts.used), (743, 130_323));
        for mapped in verified(&session, name, true) {
            let map = &mapped.finished.map;
            let count = |layer: &str, value: f64| {
                let data = &map.layer(layer).unwrap().data;
                (0..data.len()).filter(|k| data.get(*k) == value).count()
            };
            assert_eq!(count("touched", 1.0), touched, "{name}");
            if let Some([occupied, empty, undecided]) = classes {
                assert_eq!((count("class", 1.0), count("class", -1.0)), (occupied, empty), "{name}");
                assert_eq!(touched - occupied - empty, undecided, "{name}");
            }
            assert_eq!(map.increments.len(), increments.len());
            for (found, want) in map.increments.iter().zip(&increments) {
                let exact = name.ends_with("discrete");
                let close = if exact { found == want } else { (found - want).abs() <= 1e-4 * want };
                assert!(close, "{name}: {:?} for {increments:?}", map.increments);
            }
        }
    }
}

/// Real lasers, with poses by the thousand: nearest poses, beams and counts are the oracle's, to the last.
#[test]
fn carmen_logs() {
    for (log, bounds) in [
        ("carmen_corrected/intel-corrected.log.gz", [-15.0, -25.0, 20.0, 10.0]),
        ("carmen_corrected/freiburg-079-corrected.log.gz", [-12.0, -8.0, 30.0, 12.0]),
    ] {
        for name in ["csm-discrete", "csm-continuous"] {
            let Some(session) = session(log, settings(name, &[]), 0.25, Some(bounds)) else { return };
            let maps = verified(&session, log, true);
            assert!(maps[0].finished.map.updates > 20_000, "{log}: {}", maps[0].finished.map.updates);
            say(&format!("{log} {name}: {} updates, equal", maps[0].finished.map.updates));
        }
    }
}

/// The 16 nearest of the whole log, however it is batched and on however many threads.
#[test]
fn the_same_bytes_of_a_real_log() {
    let Some(session) = session(INTEL[0], settings("csm-continuous", &[]), 0.135, None) else { return };
    let bytes = |threads: usize, batch: usize| {
        let mapped = session.map(&mut Cpu::new(threads).unwrap(), batch, &|_| {}).unwrap();
        let bits = |l: &echogrid::grid::Layer| (0..l.data.len()).map(|k| l.data.get(k).to_bits()).collect::<Vec<_>>();
        (mapped.statistics.batches, mapped.finished.map.layers.iter().map(bits).collect::<Vec<_>>())
    };
    let (batches, whole) = bytes(0, BATCH);
    for (threads, batch) in [(1, BATCH), (2, 7), (0, 1000)] {
        let (more, again) = bytes(threads, batch);
        assert!(again == whole, "{threads} threads, batches of {batch}");
        assert!(batch == BATCH || more > batches, "{more} batches");
    }
}
