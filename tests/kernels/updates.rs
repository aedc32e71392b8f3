//! Updates that features made of readings: oracle against cpu against gpu, cases that can be worked out by hand, what is refused.

use crate::common::{Run, Scene, assert_oracle, assert_same, gpu, patched_gpu};
use crate::scenes::{self, bounds, reading, scene, sonar, updates_on};
use echogrid::Error;
use echogrid::binning::update;
use echogrid::evaluate::compare::{self, compare};
use echogrid::evaluate::verify;
use echogrid::feature::{Case, Fan, Origin, Part, Routine, Update};
use echogrid::geometry::plane::Point;
use echogrid::grid::GridSpec;
use echogrid::kernels::Backend;
use echogrid::kernels::cpu::Cpu;
use echogrid::log::Writer;
use echogrid::log::reading::Outcome;
use echogrid::method::{self, settings::Settings};
use echogrid::pipeline::session::{Request, Session};
use echogrid::pipeline::updates::Updater;

fn features() -> Settings {
    Settings::of("features").unwrap()
}

/// Holds cpu and gpu against the oracle, and against each other; the cpu's result.
fn agree(scene: &Scene) -> Run {
    let oracle = scene.oracle(features());
    let cpu = scene.cpu(features());
    assert_oracle(&format!("{} cpu", scene.name), &cpu, &oracle);
    if let Some(run) = scene.gpu(features()) {
        assert_oracle(&format!("{} gpu", scene.name), &run, &oracle);
        if gpu().is_some_and(|g| g.adapter_info().name.contains("llvmpipe")) {
            assert_same(&format!("{} gpu and cpu", scene.name), &run, &cpu);
        }
    }
    cpu
}

#[test]
fn updates_of_every_shape() {
    let scene = scenes::updates();
    let run = agree(&scene);
    let (interior, arc) = (run.visits.interior.iter().sum::<u32>(), run.visits.arc.iter().sum::<u32>());
    assert!(interior > 40_000 && arc > 12_000, "{interior} freed, {arc} occupied");
    assert!(run.counts.outside > 30 && run.counts.empty_arc > 30, "{:?}", run.counts);
}

/// Fine cells and coarse ones, given bounds, a strip of one column, four chunks.
#[test]
fn updates_on_other_grids() {
    let sensors = || vec![sonar(15.0, 0.17, 5.0), sonar(60.0, 0.1, 2.0)];
    let around = |resolution: f64, i0: i64, width: usize, height: usize| GridSpec {
        anchor: (0.0, 0.0),
        resolution,
        i0,
        j0: i0,
        width,
        height,
    };
    for (seed, count, grid) in [
        (21, 150, around(0.011, -200, 301, 290)),
        (22, 500, around(1.3, -5, 9, 7)),
        (23, 500, bounds([-3.217, -2.003, 4.0, 3.5], 0.07)),
        (24, 500, around(0.1, -20, 1, 61)),
        (25, 1500, around(0.05, -520, 1100, 1090)),
    ] {
        let name = format!("updates in cells of {} m, {} columns", grid.resolution, grid.width);
        assert!(agree(&updates_on(&name, seed, count, grid, sensors())).map.updates > 0);
    }
}

/// Without features each update is the Bayesian grid's: to the bit, and its counts too.
#[test]
fn plain_updates_are_those_of_bayes() {
    let real = scenes::real("sonar_ring_8/test1", 0.05, true);
    let scenes =
        [scenes::crowd(), scenes::ragged(), scenes::parked(), scenes::chunks(), scenes::edges(), scenes::nowhere()];
    for scene in scenes.into_iter().chain(real) {
        let both = |own: &Run, bayes: &Run, what: &str| {
            let found = compare(&own.map, &bayes.map, &compare::Options::default()).unwrap();
            assert!(found.equal, "{} {what}: {found:?}", scene.name);
            assert!(own.visits.interior == bayes.visits.interior && own.visits.arc == bayes.visits.arc);
            let counts = |r: &Run| (r.map.updates, r.counts.outside, r.counts.empty_arc);
            assert_eq!(counts(own), counts(bayes), "{} {what}", scene.name);
        };
        let bayes = Settings::of("bayes").unwrap();
        both(&scene.cpu(features()), &scene.cpu(bayes), "cpu");
        if let (Some(own), Some(bayes)) = (scene.gpu(features()), scene.gpu(bayes)) {
            both(&own, &bayes, "gpu");
        }
    }
}

/// However many are taken at a time, of so many shapes as to take several windows.
#[test]
fn windows_and_threads() {
    let scene = scenes::updates();
    let (method, whole) = (method::make(features()), scene.cpu(features()));
    for batch in [1, 7, 1000] {
        for threads in [1, 2] {
            let run = scene.run(method.as_ref(), &mut Cpu::new(threads).unwrap(), batch);
            assert_same(&format!("windows of {batch}, {threads} threads"), &run, &whole);
        }
    }
}

/// One update on 20 × 20 cells of 10 cm; the sensor stands on the centre of cell (5, 5).
fn one(parts: Vec<Part>, routine: Option<Routine>) -> Scene {
    let reading = reading(0, (0.55, 0.55, 0.0), 0.9, Outcome::Hit);
    let mut scene = scene("one update", bounds([0.0, 0.0, 2.0, 2.0], 0.1), vec![sonar(15.0, 0.1, 2.0)], vec![reading]);
    scene.updates = vec![Update { reading, number: 3, case: Case::Associated, parts, routine }];
    scene
}

fn fan(vertices: &[(f64, f64)]) -> Option<Fan> {
    Some(Fan { vertices: vertices.iter().map(|v| Point::new(0.55 + 0.1 * v.0, 0.55 + 0.1 * v.1)).collect() })
}

/// The cells, from the sensor's, that an update frees, and occupies.
fn cells(scene: &Scene) -> [Vec<(i32, i32)>; 2] {
    let run = agree(scene);
    [&run.visits.interior, &run.visits.arc].map(|counts| {
        let some = counts.iter().enumerate().filter(|(_, n)| **n > 0);
        some.map(|(k, _)| ((k % 20) as i32 - 5, (k / 20) as i32 - 5)).collect()
    })
}

fn p_occ(scene: &Scene, (column, row): (i32, i32)) -> f64 {
    agree(scene).map.layer("p_occ").unwrap().data.get(((row + 5) * 20 + column + 5) as usize)
}

fn part(weight: f64, free: Option<Fan>, occupied: &[[(f64, f64); 2]]) -> Part {
    let at = |v: (f64, f64)| Point::new(0.55 + 0.1 * v.0, 0.55 + 0.1 * v.1);
    Part { origin: Origin::Wall, weight, free, occupied: occupied.iter().map(|[a, b]| [at(*a), at(*b)]).collect() }
}

#[test]
fn a_fan_holds_its_far_side_and_both_outer_rays() {
    // Two triangles make a square; the ray between them belongs to the second.
    let square = fan(&[(3.0, 0.0), (3.0, 3.0), (0.0, 3.0)]);
    let [freed, occupied] = cells(&one(vec![part(1.0, square, &[])], None));
    let wanted: Vec<(i32, i32)> = (0..4).flat_map(|y| (0..4).map(move |x| (x, y))).collect();
    assert_eq!((freed, occupied), (wanted, vec![]));
    // A side is the triangle's: of (2, 0) and (0, 2) what is not beyond x + y = 2.
    let [freed, _] = cells(&one(vec![part(1.0, fan(&[(2.0, 0.0), (0.0, 2.0)]), &[])], None));
    assert_eq!(freed, [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)]);
    // A step outwards on a ray adds nothing by itself; the ray belongs to the triangle that begins there.
    let [freed, _] = cells(&one(vec![part(1.0, fan(&[(1.0, 0.0), (1.0, 1.0), (2.0, 2.0), (0.0, 2.0)]), &[])], None));
    assert_eq!(freed, [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]);
}

#[test]
fn shapes_without_an_area_hold_nothing() {
    let none = [
        fan(&[]),
        fan(&[(3.0, 0.0)]),
        fan(&[(3.0, 0.0), (5.0, 0.0)]),
        fan(&[(3.0, 0.0), (-3.0, 0.0)]),
        fan(&[(0.0, 3.0), (3.0, 0.0)]),
        fan(&[(0.0, 0.0), (3.0, 0.0)]),
        fan(&[(0.0, 0.0), (0.0, 0.0)]),
        None,
    ];
    for free in none {
        let scene = one(vec![part(1.0, free, &[])], None);
        assert_eq!(cells(&scene), [vec![], vec![]]);
        assert_eq!(scene.cpu(features()).counts.outside, 1);
    }
}

#[test]
fn lines_and_points() {
    // Within half a cell across, from end to end: on row 4 from column 2 to 6; a diagonal; a point on a corner and on a centre.
    let on = |line: [(f64, f64); 2]| cells(&one(vec![part(1.0, None, &[line])], None))[1].clone();
    let row: Vec<(i32, i32)> = (2..=6).map(|x| (x, 4)).collect();
    assert_eq!(on([(2.0, 4.0), (6.0, 4.0)]), row);
    // Half a cell from two rows it is both.
    assert_eq!(on([(2.0, 4.5), (4.0, 4.5)]), [(2, 4), (3, 4), (4, 4), (2, 5), (3, 5), (4, 5)]);
    let diagonal = on([(0.0, 0.0), (2.0, 2.0)]);
    assert_eq!(diagonal, [(0, 0), (1, 0), (0, 1), (1, 1), (2, 1), (1, 2), (2, 2)]);
    assert_eq!(on([(2.0, 2.0); 2]), [(2, 2)]);
    assert_eq!(on([(2.5, 2.5); 2]), [(2, 2), (3, 2), (2, 3), (3, 3)]);
    assert_eq!(on([(2.75, 2.0); 2]), [(2, 2), (3, 2)]);
}

#[test]
fn what_is_said_is_weighted() {
    let wall = part(0.5, fan(&[(4.0, -2.0), (4.0, 2.0)]), &[[(4.0, -2.0), (4.0, 2.0)]]);
    let corner = part(0.25, fan(&[(3.0, 0.0), (0.0, 3.0)]), &[[(2.0, 0.0), (2.0, 0.0)]]);
    let routine = Routine { weight: 0.25, free: fan(&[(2.0, -1.0), (2.0, 1.0)]), arc: None, occupies: true };
    let scene = one(vec![wall, corner], Some(routine));
    // Bayes' own, of R = 2 m: at 0.1 m on the axis of a beam.
    let bayes = |d: f64| 0.5 * ((2.0 - d) / 2.0 + 1.0);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} for {b}");
    near(p_occ(&scene, (1, 0)), 0.5 * 0.2 + 0.25 * 0.2 + 0.25 * (1.0 - bayes(0.1)));
    // Free by the wall, occupied by the corner, which frees it too; the last that the routine part may free.
    near(p_occ(&scene, (2, 0)), 0.5 * 0.2 + 0.25 * 0.8 + 0.25 * (1.0 - bayes(0.2)));
    // On the wall's line, which its free region ends with; nothing of the rest.
    near(p_occ(&scene, (4, 1)), 0.5 * 0.8 + 0.5 * 0.5);
    // On the routine part's arc alone, which has no limit.
    near(p_occ(&scene, (9, 0)), 0.75 * 0.5 + 0.25 * 0.98 * bayes(0.9));
    // Between line and arc nothing is said: no update.
    let run = agree(&scene);
    let at = |x: usize, y: usize| (y + 5) * 20 + x + 5;
    assert_eq!([run.visits.interior[at(6, 0)], run.visits.arc[at(6, 0)]], [0, 0]);
    assert_eq!([run.visits.arc[at(2, 0)], run.visits.arc[at(4, 0)], run.visits.arc[at(1, 0)]], [1, 1, 0]);
}

#[test]
fn limits_of_the_routine_part() {
    let all = cells(&one(vec![], Some(Routine { weight: 1.0, free: None, arc: None, occupies: true })));
    let upper = fan(&[(15.0, 0.0), (0.0, 15.0)]);
    let limited = |free: &Option<Fan>, arc: &Option<Fan>, occupies| {
        cells(&one(vec![], Some(Routine { weight: 1.0, free: free.clone(), arc: arc.clone(), occupies })))
    };
    let above = |cells: &[(i32, i32)]| cells.iter().copied().filter(|c| c.1 >= 0).collect::<Vec<_>>();
    assert!(all[0].len() > 10 && all[1].len() > 3);
    assert_eq!(limited(&upper, &None, true), [above(&all[0]), all[1].clone()]);
    assert_eq!(limited(&None, &upper, true), [all[0].clone(), above(&all[1])]);
    assert_eq!(limited(&None, &None, false), [all[0].clone(), vec![]]);
    assert_eq!(limited(&fan(&[]), &fan(&[]), true), [vec![], vec![]]);
}

#[test]
fn what_reaches_too_far_is_refused() {
    let refused = |scene: &Scene, what: &str| {
        let method = method::make(features());
        let updates = scene.updates().into_iter().map(Ok);
        let mut cpu = Cpu::new(1).unwrap();
        let mut updater = Updater::new(&scene.grid, &scene.sensors, method.as_ref(), &mut cpu, 8);
        let applied = updater.apply(updates, &|_| {});
        match applied {
            Err(Error::Usage(message)) => assert!(message.contains(what), "{message}"),
            other => panic!("{what}: {other:?}"),
        }
    };
    let away = "m, more than 512 cells of 0.1 m: give a coarser `resolution` or a smaller `r_max`";
    for free in
        [fan(&[(513.0, 0.0), (0.0, 1.0)]), fan(&[(1.0, 0.0), (-400.0, 400.0)]), fan(&[(1.0, 0.0), (f64::NAN, 0.0)])]
    {
        refused(&one(vec![part(1.0, free, &[])], None), away);
    }
    refused(&one(vec![part(1.0, None, &[[(0.0, 0.0), (0.0, f64::INFINITY)]])], None), away);
    let mut far = one(vec![], Some(Routine { weight: 1.0, free: None, arc: None, occupies: true }));
    far.updates[0].reading.range = 51.2;
    refused(&far, "the update of line 1 reaches 51.30 m, more than 512 cells");
    far.updates[0].reading.record.sensor = 1;
    refused(&far, "the update of line 1 names sensor 1, of 1");
    let three = one(vec![part(0.3, None, &[]); 3], None);
    refused(&three, "3 parts, more than two features");
    // As far as it may: every corner of the reach.
    let edge = one(vec![part(1.0, fan(&[(0.0, -512.0), (362.0, 362.0)]), &[[(-512.0, 0.0), (512.0, 0.0)]])], None);
    assert!(agree(&edge).map.updates > 100);

    let message = update::check(&[sonar(15.0, 0.1, 26.0)], 0.05).unwrap_err().to_string();
    assert!(message.contains("r_max is 26 m") && message.contains("coarser `resolution`"), "{message}");
    assert!(update::check(&[sonar(15.0, 0.1, 25.0), scenes::laser(0.5, 80.0)], 0.05).is_ok());
}

/// `echogrid verify` on a log: passes as it is; with a fault it fails, and names the readings that reached the cell.
#[test]
fn verify_names_the_readings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.jsonl");
    let mut scene = scenes::parked();
    scene.sensors[0].id = "front".into();
    let mut writer = Writer::new(Vec::new(), &scene.sensors, &[]).unwrap();
    scene.items.iter().take(80).for_each(|(reading, _)| writer.write(&reading.record).unwrap());
    std::fs::write(&path, writer.finish().unwrap()).unwrap();
    let request = Request {
        log: Default::default(),
        settings: features(),
        resolution: 0.05,
        bounds: None,
        until: None,
        strict: true,
    };
    let session = Session::open(&path, &request).unwrap();
    assert_eq!(session.updates(7).unwrap().0.len(), 7);
    let oracle = session.oracle().unwrap();
    let check = |backend: &mut dyn Backend| {
        let mapped = session.map(backend, 33, &|_| {}).unwrap();
        let counts = (mapped.counts.outside, mapped.counts.empty_arc, mapped.counts.wide);
        assert_eq!(counts, (oracle.outside, oracle.empty_arc, oracle.wide));
        let (name, finished) = (backend.name(), &mapped.finished);
        let run = verify::BackendRun { name, adapter: String::new(), finished, wrong_counts: 0, seconds: 0.0 };
        verify::check_backend(&session, &oracle, run).unwrap()
    };
    assert!(check(&mut Cpu::new(0).unwrap()).passed);
    let Some(mut patched) = patched_gpu(&[("update.number, contributions_0", "update.number + 1u, contributions_0")])
    else {
        return;
    };
    let found = check(&mut patched);
    assert!(!found.passed && found.membership > 1000);
    let last = found.membership_cell.unwrap().last_readings;
    assert!(last.len() == 3 && last[0].sensor == "front" && last[0].line > last[2].line, "{last:?}");
}
