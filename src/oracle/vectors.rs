//! The specification's computed vectors, and hand-made small cases.

use super::bound::BoundedValue;
use super::cone::{Cone, Rule};
use super::{
    Region, bayes, certainty, dempster_shafer, map,
    trace::{Setup, trace},
};
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Pose, Reading, Record};
use crate::method::settings::{Bayes, DempsterShafer, Himm, Settings};
use crate::sensor::{AtMax, Kind, Sensor};

/// A sonar at the robot's centre with nothing special about it.
pub(super) fn sonar(half_width_deg: f64) -> Sensor {
    Sensor {
        id: "s".into(),
        kind: Kind::Sonar,
        x: 0.0,
        y: 0.0,
        axis: 0.0,
        half_width: half_width_deg.to_radians(),
        r_min: 0.3,
        r_max: 10.0,
        at_r_max: AtMax::Hit,
        hit_range: 10.0,
        no_echo_range: 1.5,
        epsilon: None,
    }
}

/// A reading from a pose.
pub(super) fn reading(x: f64, y: f64, heading: f64, range: f64, outcome: Outcome) -> Reading {
    let pose = Pose { x, y, heading };
    let record = Record { t: 0.0, scan: 0, sensor: 0, robot: pose, pose, range, label: None, line: 1 };
    Reading { record, outcome, range }
}

fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b}");
}

#[test]
fn certainty_profiles() {
    let beta = 15f64.to_radians();
    let emp = |d, degrees: f64| certainty::emp_k(d, degrees.to_radians(), 2.0 - 0.1 - 0.3, 0.3, beta);
    for (d, degrees, want) in
        [(1.0, 0.0, 0.80859375), (0.3, 0.0, 1.0), (1.9, 0.0, 0.0), (1.0, 7.5, 0.6064453125), (1.5, 5.0, 0.3888889)]
    {
        near(emp(d, degrees), want, 5e-8);
    }
    let occ = |d, degrees: f64| certainty::occ_k(d, degrees.to_radians(), 2.0, 0.1, beta);
    for (d, degrees, want) in
        [(2.0, 0.0, 1.0), (1.95, 0.0, 0.75), (2.05, 7.5, 0.5625), (2.1, 0.0, 0.0), (2.0, 15.0, 0.0)]
    {
        near(occ(d, degrees), want, 1e-12);
    }
}

#[test]
fn certainty_cancels_normalises_and_enhances() {
    let cancelled: Vec<f64> =
        [(0.75, 0.0), (1.0, 0.5), (0.75, 0.8)].iter().map(|(o, e): &(f64, f64)| o * (1.0 - e)).collect();
    let sum: f64 = cancelled.iter().sum();
    let want = [(0.75, 0.5357143, 0.7844388), (0.5, 0.3571429, 0.5867347), (0.15, 0.1071429, 0.2028061)];
    for (c, (raw, normalised, twice)) in cancelled.iter().zip(want) {
        near(*c, raw, 1e-12);
        near(c / sum, normalised, 5e-8);
        near(certainty::enhance(c / sum, c / sum), twice, 5e-8);
    }
}

#[test]
fn a_reading_is_explained_as_it_is_applied() {
    let grid = GridSpec::from_bounds([0.0, 0.0, 5.0, 5.0], 0.1).unwrap();
    let sensors = [sonar(15.0)];
    let readings = [reading(0.5, 2.5, 0.1, 2.0, Outcome::Hit), reading(0.6, 2.0, 0.4, 1.5, Outcome::Hit)];
    let settings = Settings::of("certainty").unwrap();
    let before = map(&grid, &sensors, &readings[..1], &settings, None).unwrap();
    let after = map(&grid, &sensors, &readings, &settings, None).unwrap();
    let setup = Setup { grid: &grid, sensors: &sensors, settings: &settings };
    let traced = trace(&setup, &readings, None, 1).unwrap();
    let arc: Vec<_> = traced.cells.iter().filter(|c| c.update.region == Region::Arc).collect();
    assert_eq!(arc.len(), traced.arc_cells);
    near(arc.iter().map(|c| c.cancelled).sum(), traced.sum, 1e-12);
    near(arc.iter().map(|c| c.normalised).sum(), 1.0, 1e-12);
    for cell in &traced.cells {
        let k = cell.update.row * grid.width + cell.update.column;
        let layer = if cell.update.region == Region::Arc { "occ" } else { "emp" };
        let was = before.layer(layer).unwrap().values[k];
        assert_eq!(certainty::enhance(was, cell.normalised), after.layer(layer).unwrap().values[k]);
    }
}

#[test]
fn dempster_shafer_combinations() {
    let check = |empties: &[f64], fulls: &[f64], want: [f64; 4]| {
        let sum = |m: &[f64]| m.iter().map(|v| (1.0 - v).ln()).sum::<f64>();
        let m = dempster_shafer::masses(sum(empties), sum(fulls));
        for (value, want) in [m.empty, m.full, m.unknown, m.conflict].into_iter().zip(want) {
            if want >= 0.0 {
                near(value, want, 5e-5);
            }
        }
    };
    check(&[], &[0.1], [0.0, 0.1, 0.9, 0.0]);
    check(&[], &[0.1, 0.1], [0.0, 0.19, 0.81, 0.0]);
    check(&[0.1], &[0.1, 0.1], [0.0825688, 0.1743119, -1.0, -(1.0f64 - 0.019).ln()]);
    check(&[0.1, 0.1], &[0.1, 0.1], [0.1596639, 0.1596639, -1.0, -1.0]);
    check(&[], &[0.4, 0.6], [0.0, 0.76, 0.24, 0.0]);
    check(&[0.6], &[0.4], [0.4737, 0.2105, 0.3158, 0.274437]);
    // hundreds of strong readings on both sides: still finite
    let m = dempster_shafer::masses(-3000.0, -2999.0);
    near(m.empty + m.full + m.unknown, 1.0, 1e-12);
    near(m.full / m.empty, (-1.0f64).exp(), 1e-9);
}

#[test]
fn bayes_expressions_and_recursion() {
    let grid = GridSpec::from_bounds([0.0, 0.0, 1.0, 1.0], 0.1).unwrap();
    let cone = |z| Cone::new(&grid, &sonar(15.0), &reading(0.0, 0.0, 0.0, z, Outcome::Hit), Rule::Cone, None).unwrap();
    let settings = Bayes::default();
    let p =
        |z, region, d, degrees: f64| bayes::likelihood(&settings, &cone(z), region, (d, degrees.to_radians())).value;
    near(1.0 - p(6.0, Region::Interior, 3.5, 0.0), 0.825, 1e-12);
    near(p(6.0, Region::Arc, 6.0, 5.0), 0.5226667, 5e-8);
    near(p(9.0, Region::Arc, 9.0, 0.0), 0.539, 1e-12);
    let mut belief = 0.5;
    for (given, want) in [(0.52266667, 0.522667), (0.52266667, 0.545240), (0.175, 0.202759)] {
        belief = bayes::recursion(belief, given);
        near(belief, want, 5e-7);
    }
    // far and off-axis: neutral by the floors, to the bit
    let edge = bayes::likelihood(&settings, &cone(9.0), Region::Arc, (9.0, 14f64.to_radians()));
    assert_eq!(edge, BoundedValue { value: 0.5, bound: 0.0 });
}

#[test]
fn murphy_masses_follow_the_expressions() {
    let grid = GridSpec::from_bounds([0.0, 0.0, 1.0, 1.0], 0.1).unwrap();
    let hit = reading(0.0, 0.0, 0.0, 6.0, Outcome::Hit);
    let cone = Cone::new(&grid, &sonar(15.0), &hit, Rule::Cone, None).unwrap();
    let mut settings = DempsterShafer::default();
    settings.model = crate::method::settings::MassModel::Murphy;
    let mass =
        |region, d, degrees: f64| dempster_shafer::mass(&settings, &cone, region, (d, degrees.to_radians()), 7).value;
    near(mass(Region::Arc, 6.0, 5.0), 0.5226667, 5e-8);
    near(mass(Region::Interior, 3.5, 0.0), 0.825, 1e-12);
    near(mass(Region::Interior, 0.0, 0.0), 0.98, 1e-12);
}

/// The 5 × 5 grid of the specification, its rows from the top.
fn himm(gro: bool) -> Vec<Vec<f64>> {
    let grid = GridSpec::from_bounds([0.0, 0.0, 5.0, 5.0], 1.0).unwrap();
    let hits = [(2, 0), (2, 0), (2, 1), (2, 1), (1, 0), (1, 1), (1, 2), (0, 2)];
    let up = std::f64::consts::FRAC_PI_2;
    let readings: Vec<Reading> = hits
        .iter()
        .map(|&(row, column)| reading(f64::from(column) + 0.5, -0.5, up, 5.0 - f64::from(row), Outcome::Hit))
        .collect();
    let map = map(&grid, &[sonar(15.0)], &readings, &Settings::Himm(Himm { gro }), None).unwrap();
    let count = map.layer("count").unwrap();
    assert!(count.bound.iter().all(|b| *b == 0.0));
    count.values.chunks(5).rev().map(<[f64]>::to_vec).collect()
}

#[test]
fn himm_on_five_by_five() {
    let zero = vec![0.0; 5];
    let row = |a: f64, b: f64, c: f64| vec![a, b, c, 0.0, 0.0];
    assert_eq!(himm(false), [row(0., 0., 3.), row(3., 3., 2.), row(5., 5., 0.), zero.clone(), zero.clone()]);
    assert_eq!(himm(true), [row(0., 0., 15.), row(11.5, 15., 14.), row(5., 11., 0.), zero.clone(), zero]);
}

#[test]
fn a_laser_leaves_no_holes() {
    let grid = GridSpec::from_bounds([-4.0, -4.0, 4.0, 4.0], 0.1).unwrap();
    let mut laser = sonar(0.1);
    laser.kind = Kind::Laser;
    for k in 0..200 {
        let hit = reading(0.013, 0.027, 0.031 * f64::from(k), 3.0, Outcome::Hit);
        let cells = super::updated_cells(&grid, &laser, &hit, &Settings::of("bayes").unwrap(), None).unwrap();
        assert!(cells.iter().any(|c| c.region == Region::Arc), "reading {k} has no arc");
        assert!(cells.iter().filter(|c| c.region == Region::Interior).count() >= 19, "reading {k} has holes");
        assert!(cells.iter().all(|c| c.theta == 0.0));
    }
}

#[test]
fn truth_gives_every_cell_of_a_fan_one_beam() {
    let grid = GridSpec::from_bounds([-3.0, -3.0, 3.0, 3.0], 0.1).unwrap();
    let mut laser = sonar(0.5);
    laser.kind = Kind::Laser;
    let step = 1f64.to_radians();
    let fan: Vec<f64> = (0..180).map(|k| f64::from(k) * step).collect();
    let readings: Vec<Reading> = fan.iter().map(|&h| reading(0.02, 0.01, h, 2.0, Outcome::Hit)).collect();
    let wedges: Vec<(f64, f64)> = fan.iter().map(|h| (h + step / 2.0, h - step / 2.0)).collect();
    let map = map(&grid, &[laser], &readings, &Settings::Truth, Some(&wedges)).unwrap();
    for (k, (hits, passes)) in map.arc.iter().zip(&map.interior).enumerate() {
        let (x, y) = grid.centre(k % grid.width, k / grid.width);
        let (d, fan) = ((x - 0.02).hypot(y - 0.01), y > 0.12);
        assert!(hits + passes <= 1, "cell {k} belongs to two beams");
        if fan && d > 0.2 && (d - 2.0).abs() > 0.08 {
            assert_eq!((*hits, *passes), (0, u32::from(d < 2.0)), "cell {k} at {d} m");
        }
        if fan && (d - 2.0).abs() < 0.07 {
            assert_eq!((*hits, *passes), (1, 0), "cell {k} at {d} m");
        }
    }
    assert_eq!([(1, 0), (2, 0), (2, 4), (2, 5), (0, 2)].map(|(h, p)| super::truth::decide(h, p)), [0, 1, 1, -1, -1]);
}
