//! The specification's computed vectors through the real kernels: readings placed by hand so that a cell's centre falls on
//! the stated distance and angle exactly. Angles come from right triangles of whole cells (24, 7, 25 and 40, 9, 41), with β
//! a whole multiple of the triangle's angle.

use crate::common::{Run, Scene, gpu, settings};
use crate::scenes::{bounds, laser, reading, scene, sonar};
use echogrid::binning::batch::BATCH;
use echogrid::grid::GridSpec;
use echogrid::log::reading::Outcome::Hit;
use echogrid::log::reading::Reading;
use echogrid::method;
use echogrid::method::settings::{DempsterShafer, MassModel, Settings};
use echogrid::oracle;
use echogrid::sensor::Sensor;

/// f32 profiles: a few ULP of values up to 1.
const CLOSE: f64 = 1e-6;

/// Runs the scene on the cpu and, where there is one, on the gpu.
fn both(scene: &Scene, settings: Settings, check: impl Fn(&Run)) {
    check(&scene.cpu(settings));
    if let Some(run) = scene.gpu(settings) {
        check(&run);
    }
}

fn value(run: &Run, layer: &str, column: usize, row: usize) -> f64 {
    run.map.layer(layer).unwrap().data.get(row * run.map.grid.width + column)
}

fn near(found: f64, want: f64, tolerance: f64, what: &str) {
    assert!((found - want).abs() <= tolerance, "{what}: {found}, not {want}");
}

/// A grid of 1 m cells, so that lengths are in cells; the sensor of the cases sits in the middle of cell (0, 10).
fn plain() -> GridSpec {
    bounds([0.0, 0.0, 64.0, 21.0], 1.0)
}

fn one(sensor: Sensor, range: f64) -> Scene {
    scene("one reading", plain(), vec![sensor], vec![reading(0, (0.5, 10.5, 0.0), range, Hit)])
}

/// A sonar whose β is `times` the angle of the triangle (x, y).
fn triangle(x: f64, y: f64, times: f64, r_min: f64, epsilon: f64) -> Sensor {
    let mut sensor = sonar(0.0, r_min, 64.0);
    sensor.half_width = times * y.atan2(x);
    sensor.epsilon = Some(epsilon);
    sensor
}

#[test]
fn certainty_profiles() {
    let settings = settings("certainty");
    // One metre of the vectors is 25 cells here: R = 2, r_min = 0.3, ε = 0.1.
    let metre = 25.0;
    let sensor = Sensor { epsilon: Some(0.1 * metre), ..sonar(15.0, 0.3 * metre, 64.0) };
    let mut fine = Scene { grid: bounds([0.0, 0.0, 64.0, 21.0], 0.5), ..one(sensor, 2.0 * metre) };
    fine.items[0].0.record.pose.x = 0.25;
    fine.items[0].0.record.pose.y = 10.25;
    // Half cells: cell (c, 20) lies c / 50 of the vectors' metres away.
    both(&fine, settings, |run| {
        for (d, want) in [(1.0, 0.80859375), (0.3, 1.0), (1.9, 0.0), (0.1, 1.0)] {
            near(value(run, "emp", (d * 50.0f64).round() as usize, 20), want, CLOSE, "emp");
        }
        assert!(value(run, "occ", 100, 20) > 0.0);
        for column in [95, 105] {
            near(value(run, "occ", column, 20), 0.0, 0.0, "occ(2 -+ 0.1, 0)");
        }
    });
    // 1.95 and 2.05 m: cells of a tenth of ε.
    let sensor = Sensor { epsilon: Some(10.0), ..sonar(15.0, 1.0, 64.0) };
    both(&one(sensor, 40.0), settings, |run| {
        let peak = value(run, "occ", 40, 10);
        // A cell holds 1 − occ: each of the two is rounded to 2⁻²⁴, which the small sum magnifies.
        let rounded = f64::from(f32::EPSILON) / peak;
        near(value(run, "occ", 35, 10) / peak, 0.75, rounded, "occ(1.95, 0) / occ(2, 0)");
        near(value(run, "occ", 45, 10) / peak, 0.75, rounded, "occ(2.05, 0) / occ(2, 0)");
        near(value(run, "occ", 50, 10), 0.0, 0.0, "occ(2.1, 0)");
    });
    // Half of β off the axis at 1 m.
    both(&one(triangle(24.0, 7.0, 2.0, 7.5, 2.5), 50.0), settings, |run| {
        near(value(run, "emp", 24, 17), 0.6064453125, CLOSE, "emp(1, β/2)");
        near(value(run, "emp", 24, 3), 0.6064453125, CLOSE, "emp(1, -β/2)");
        near(value(run, "emp", 25, 10), 0.80859375, CLOSE, "emp(1, 0)");
    });
    // A third of β off it, three quarters of the way.
    both(&one(triangle(40.0, 9.0, 3.0, 2.0, 1.0), 55.0), settings, |run| {
        near(value(run, "emp", 40, 19), 0.3888889, CLOSE, "emp(1.5, β/3)");
    });
    // Half of ε behind R, half of β off the axis: the reading's sum, from the reference, undoes the normalising.
    let scene = one(triangle(24.0, 7.0, 2.0, 1.0, 2.0), 24.0);
    let work = oracle::trace(
        &oracle::Setup { grid: &scene.grid, sensors: &scene.sensors, settings: &settings },
        &scene.readings(),
        None,
        0,
    )
    .unwrap();
    both(&scene, settings, |run| {
        // The sum magnifies the rounding of 1 − occ.
        let rounded = f64::from(f32::EPSILON) * work.sum;
        near(value(run, "occ", 24, 17) * work.sum, 0.5625, rounded, "occ(2.05, β/2)");
    });
    // On the cone's edge both are 0: β is the triangle's angle (the snapped edge holds the cell or just misses it).
    both(&one(triangle(24.0, 7.0, 1.0, 1.0, 2.0), 25.0), settings, |run| {
        near(value(run, "occ", 24, 17), 0.0, CLOSE, "occ(2, β)");
    });
}

/// A single row of cells, 1 m each, along which lasers look: an arc is a few cells of it.
fn row(sensors: Vec<Sensor>, readings: Vec<Reading>) -> Scene {
    scene("a row", bounds([0.0, 0.0, 64.0, 1.0], 1.0), sensors, readings)
}

fn beam(r_min: f64, epsilon: f64, r_max: f64) -> Sensor {
    Sensor { r_min, epsilon: Some(epsilon), ..laser(0.1, r_max) }
}

#[test]
fn certainty_cancels_normalises_and_enhances() {
    let settings = settings("certainty");
    // Arc cells at R − 1, R and R + 1 with ε 2: 0.75, 1, 0.75 (and two zeros). Before, two beams across the row leave Emp of
    // 0.5 in the second, 0.8 in the third: (d / (R − ε))² is (2378/3363)² = 0.5 and (1292/2889)² = 0.2 to 1e-7, in 1/32 cell.
    let unit = 1.0 / 32.0;
    let along = reading(0, (0.5, 0.5, 0.0), 20.0, Hit);
    let across = |column: usize, d: f64, span: f64| {
        let down = -std::f64::consts::FRAC_PI_2;
        reading(0, (column as f64 + 0.5, 0.5 + d * unit, down), span * unit + 2.0, Hit)
    };
    let sensors = vec![beam(0.0, 2.0, 200.0)];
    let prepared = vec![across(20, 2378.0, 3363.0), across(21, 1292.0, 2889.0)];
    let check = |times: usize, want: [f64; 3]| {
        let mut readings = prepared.clone();
        readings.extend(vec![along; times]);
        both(&row(sensors.clone(), readings), settings, |run| {
            for (k, emp) in [0.0, 0.5, 0.8].into_iter().enumerate() {
                near(value(run, "emp", 19 + k, 0), emp, CLOSE, "emp");
                near(value(run, "occ", 19 + k, 0), want[k], CLOSE, "occ");
            }
        });
    };
    check(1, [0.5357143, 0.3571429, 0.1071429]);
    check(2, [0.7844388, 0.5867347, 0.2028061]);
}

#[test]
fn dempster_shafer_combinations() {
    let settings = settings("dempster-shafer");
    // Ten arc cells: 16 to 25, then 31 to 40; cell 20 is on the first arc and inside the second cone.
    let near_hit = reading(0, (0.5, 0.5, 0.0), 20.5, Hit);
    let far_hit = reading(0, (0.5, 0.5, 0.0), 35.5, Hit);
    let all = [near_hit, near_hit, far_hit, far_hit];
    let wants = [(0.0, 0.1), (0.0, 0.19), (0.0825688, 0.1743119), (0.1596639, 0.1596639)];
    for (n, (empty, full)) in wants.into_iter().enumerate() {
        both(&row(vec![beam(0.0, 4.6, 60.0)], all[..=n].to_vec()), settings, |run| {
            near(value(run, "empty", 20, 0), empty, CLOSE, "m(E)");
            near(value(run, "full", 20, 0), full, CLOSE, "m(F)");
            let sum: f64 = ["empty", "full", "unknown"].iter().map(|l| value(run, l, 20, 0)).sum();
            near(sum, 1.0, CLOSE, "Σ m");
            if n == 2 {
                near(value(run, "conflict", 20, 0), -(1.0f64 - 0.019).ln(), CLOSE, "Con");
            }
        });
    }
}

#[test]
fn murphys_masses_combine() {
    // θ = 0: ½[(R − d)/R + 1]·Max_occ. With Max_occ 0.8 the arc gives 0.4 at R and 0.6 at R/2; the interior 0.6 at 0.8 R.
    let settings = Settings::DempsterShafer(DempsterShafer {
        model: MassModel::Murphy,
        max_occ: 0.8,
        ..DempsterShafer::default()
    });
    let from = |d: f64, range: f64| reading(0, (30.5 - d, 0.5, 0.0), range, Hit);
    let sensors = vec![beam(0.0, 1.0, 40.0)];
    let fill = row(sensors.clone(), vec![from(40.0, 40.0), from(20.0, 20.0)]);
    both(&fill, settings, |run| near(value(run, "full", 30, 0), 0.76, CLOSE, "F .4 and F .6"));
    let conflict = row(sensors, vec![from(40.0, 40.0), from(32.0, 36.0)]);
    both(&conflict, settings, |run| {
        let wants = [("full", 4.0 / 19.0), ("empty", 9.0 / 19.0), ("unknown", 6.0 / 19.0), ("conflict", 0.274437)];
        for (layer, want) in wants {
            near(value(run, layer, 30, 0), want, CLOSE, layer);
        }
    });
}

#[test]
fn bayes_expressions_and_recursion() {
    let settings = settings("bayes");
    // R is 125/3 cells; a hit at 25 cells, a third of β off the axis: d = 0.6 R. Then from elsewhere the cell is inside, on
    // the axis at 0.35 R.
    let mut sensor = triangle(24.0, 7.0, 3.0, 0.3, 1.0);
    sensor.r_max = 125.0 / 3.0;
    sensor.hit_range = sensor.r_max;
    let hit = reading(0, (0.5, 10.5, 0.0), 25.0, Hit);
    let d: f64 = 0.35 * 125.0 / 3.0;
    let miss = reading(0, (24.5 - (32.0 * d).round() / 32.0, 17.5, 0.0), 25.0, Hit);
    for (readings, want, tolerance) in [
        (vec![hit], 0.5226667, CLOSE),
        (vec![hit, hit], 0.545240, CLOSE),
        // The sensor's place is snapped to 1/32 cell: d is off by up to 1/64, P by half of it over R, the odds by 7 times that.
        (vec![hit, hit, miss], 0.202759, 0.5 / 64.0 / 41.0 * 2.0),
    ] {
        both(&scene("bayes", plain(), vec![sensor.clone()], readings), settings, |run| {
            near(value(run, "p_occ", 24, 17), want, tolerance, "P(occupied)");
            near(value(run, "p_emp", 24, 17), 1.0 - want, tolerance, "P(empty)");
        });
    }
    // On the axis: s = 9 of R = 10, d = 9; and inside s = 6, d = 3.5, in half metres (20 cells to R).
    let axis = Sensor { epsilon: Some(1.0), ..sonar(15.0, 0.3, 20.0) };
    both(&one(axis.clone(), 18.0), settings, |run| near(value(run, "p_occ", 18, 10), 0.539, CLOSE, "P(s|Occ)"));
    both(&one(axis, 12.0), settings, |run| near(value(run, "p_emp", 7, 10), 0.825, CLOSE, "P(s|Emp)"));
}

#[test]
fn himm_on_five_by_five() {
    let up = std::f64::consts::FRAC_PI_2;
    // (row from the top, column)
    let hits = [(2, 0), (2, 0), (2, 1), (2, 1), (1, 0), (1, 1), (1, 2), (0, 2)];
    let readings =
        hits.iter().map(|&(row, column)| reading(0, (f64::from(column) + 0.5, -0.5, up), 5.0 - f64::from(row), Hit));
    let grid = bounds([0.0, 0.0, 5.0, 5.0], 1.0);
    let scene = scene("himm", grid, vec![sonar(15.0, 0.3, 10.0)], readings.collect());
    let counts =
        |run: &Run| run.map.layer("count").map(|l| (0..25).map(|k| l.data.get(k)).collect::<Vec<_>>()).unwrap();
    let rows = |top: [[f64; 3]; 3]| {
        let row = |r: usize| top.get(r).map_or(vec![0.0; 5], |t| [t.as_slice(), &[0.0, 0.0]].concat());
        (0..5).rev().flat_map(row).collect::<Vec<f64>>()
    };
    let plain = rows([[0.0, 0.0, 3.0], [3.0, 3.0, 2.0], [5.0, 5.0, 0.0]]);
    both(&scene, settings("himm"), |run| assert_eq!(counts(run), plain));
    let grown = rows([[0.0, 0.0, 15.0], [11.5, 15.0, 14.0], [5.0, 11.0, 0.0]]);
    assert_eq!(counts(&scene.cpu(settings("himm-gro"))), grown);
}

#[test]
fn the_growth_rate_operator_is_refused_on_the_gpu() {
    let Some(mut gpu) = gpu() else { return };
    let method = method::make(settings("himm-gro"));
    let scene = one(sonar(15.0, 0.3, 10.0), 5.0);
    let items = scene.items.iter().map(|i| Ok(*i));
    let mut mapper =
        echogrid::pipeline::mapper::Mapper::new(scene.grid, &scene.sensors, method.as_ref(), &mut *gpu, BATCH).unwrap();
    let error = mapper.sweep(0, items).unwrap_err().to_string();
    assert!(error.contains("growth-rate") && error.contains("--backend cpu"), "{error}");
}
