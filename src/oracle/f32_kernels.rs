//! Test of the bounds: stand-ins for the kernels, in f32 with errors added to roots and angles, stay within them in every cell;
//! stand-ins with a seeded fault do not.

use super::cone::{Cell, Cone};
use super::real_log::test1_or_random;
use super::{OracleMap, Region, cones, map};
use crate::method::settings::{Bayes, DempsterShafer, MassModel, Settings};

/// A fault seeded into the stand-in.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    None,
    /// The hit band's profile is a tenth narrower.
    NarrowBand,
    /// Hit and miss are swapped.
    Swapped,
    /// The last reading with an arc is dropped.
    Dropped,
}

/// A cell's distance and angle as a kernel may have them: off by a few ULP, this way or that.
fn polar(cone: &Cone, cell: &Cell, k: usize) -> (f32, f32) {
    let (d, theta) = cone.polar(cell.v);
    let sway = |k: usize| 2.0 * ((k.wrapping_mul(0x9E37_79B9) >> 7) % 1024) as f64 / 1023.0 - 1.0;
    let u = f64::from(f32::EPSILON) / 2.0;
    ((d * (1.0 + 8.0 * u * sway(k))) as f32, (theta * (1.0 + 20.0 * u * sway(k + 77))) as f32)
}

/// θ/β as a kernel has it.
fn angle_fraction(cone: &Cone, theta: f32) -> f32 {
    (theta * (1.0 / cone.beta) as f32).min(1.0)
}

fn region(cell: &Cell, fault: Fault) -> Region {
    match (cell.region, fault) {
        (Region::Arc, Fault::Swapped) => Region::Interior,
        (Region::Interior, Fault::Swapped) => Region::Arc,
        (region, _) => region,
    }
}

/// The next complement: the product, and very near 0 the recursion itself in f64.
fn enhance(rest: f32, not_e: f32) -> f32 {
    let product = rest * not_e;
    if rest >= 2f32.powi(-31) {
        let units = f64::from(product) * 2f64.powi(53);
        return if product < 2f32.powi(-31) { (units.round_ties_even() / 2f64.powi(53)) as f32 } else { product };
    }
    (1.0 - super::certainty::enhance(1.0 - f64::from(rest), f64::from(1.0 - not_e))) as f32
}

fn certainty(size: usize, readings: &[(&Cone, Vec<Cell>)], fault: Fault) -> Vec<Vec<f32>> {
    let (mut q, mut s) = (vec![1f32; size], vec![1f32; size]);
    for (cone, cells) in readings {
        let mut arc = Vec::new();
        for (k, cell) in cells.iter().enumerate() {
            let (d, theta) = polar(cone, cell, k);
            let t = angle_fraction(cone, theta);
            if region(cell, fault) == Region::Interior {
                let inverse = if cone.span > 0.0 { (1.0 / cone.span) as f32 } else { 0.0 };
                let p = ((d - cone.r_min as f32).max(0.0) * inverse).min(1.0);
                q[cell.index] = enhance(q[cell.index], p * p + t * t - p * p * t * t);
            } else {
                let narrow = if fault == Fault::NarrowBand { 0.9 } else { 1.0 };
                let z = (d - cone.range as f32) * (1.0 / (cone.epsilon * narrow)) as f32;
                arc.push((cell.index, (1.0 - z * z).max(0.0) * (1.0 - t * t)));
            }
        }
        for (index, own) in &mut arc {
            *own *= q[*index];
        }
        let sum: f32 = arc.iter().map(|a| a.1).sum();
        for (index, v) in arc.into_iter().filter(|_| sum > 0.0) {
            s[index] = enhance(s[index], (1.0 - v / sum).max(0.0));
        }
    }
    let map = q.iter().zip(&s).map(|(q, s)| if s <= q { 1.0 - s } else { q - 1.0 }).collect();
    vec![q.iter().map(|q| 1.0 - q).collect(), s.iter().map(|s| 1.0 - s).collect(), map]
}

/// Murphy's expression in f32.
fn expression(cone: &Cone, (d, theta): (f32, f32), most: f32) -> f32 {
    0.5 * ((1.0 - (d * (1.0 / cone.r_max) as f32).min(1.0)) + (1.0 - angle_fraction(cone, theta))) * most
}

fn bayes(size: usize, readings: &[(&Cone, Vec<Cell>)], s: &Bayes, fault: Fault) -> Vec<Vec<f32>> {
    let (mut occupied, mut empty, mut scale) = (vec![1f32; size], vec![1f32; size], vec![0; size]);
    for (cone, cells) in readings {
        for (k, cell) in cells.iter().enumerate() {
            let arc = region(cell, fault) == Region::Arc;
            let (most, floor) = if arc { (s.max_occ, s.region_one_floor) } else { (1.0, s.region_two_floor) };
            let p = expression(cone, polar(cone, cell, k), most as f32).max(floor as f32).clamp(0.02, 0.98);
            let k = cell.index;
            occupied[k] *= if arc { p } else { 1.0 - p };
            empty[k] *= if arc { 1.0 - p } else { p };
            for (product, sign) in [(&mut occupied[k], 1), (&mut empty[k], -1)] {
                if *product < 1e-9 {
                    *product *= 30f32.exp2();
                    scale[k] -= 30 * sign;
                }
            }
        }
    }
    let odds: Vec<f32> = (0..size)
        .map(|k| {
            let ratio = f64::from(occupied[k]) / f64::from(empty[k]);
            (ratio.ln() + f64::from(scale[k]) * std::f64::consts::LN_2) as f32
        })
        .collect();
    let p = |sign: f32| odds.iter().map(|l| 1.0 / (1.0 + (-sign * l).exp())).collect();
    vec![odds.clone(), p(1.0), p(-1.0)]
}

fn dempster_shafer(size: usize, readings: &[(&Cone, Vec<Cell>)], s: &DempsterShafer, fault: Fault) -> Vec<Vec<f32>> {
    let murphy = s.model == MassModel::Murphy;
    let unit = if murphy { 24.0f64.exp2() } else { 40.0f64.exp2() };
    let (mut le, mut lf) = (vec![0i64; size], vec![0i64; size]);
    for (cone, cells) in readings {
        let n = cells.iter().filter(|c| c.region == Region::Arc).count();
        for (k, cell) in cells.iter().enumerate() {
            let arc = region(cell, fault) == Region::Arc;
            let log = if murphy {
                let most = if arc { s.max_occ as f32 } else { 1.0 };
                let m = expression(cone, polar(cone, cell, k), most).clamp(0.0, s.cap as f32);
                f64::from((1.0 - m).ln())
            } else {
                // only hits with an arc are fed to this stand-in
                if n == 0 { 0.0 } else { (1.0 - (1.0 / n as f64).min(s.cap)).ln() }
            };
            let sums = if arc { &mut lf } else { &mut le };
            sums[cell.index] += (log * unit).round() as i64;
        }
    }
    let sums = le.iter().zip(&lf).map(|(e, f)| super::dempster_shafer::masses(*e as f64 / unit, *f as f64 / unit));
    let mut layers = vec![Vec::new(), Vec::new(), Vec::new(), Vec::new()];
    for m in sums {
        for (layer, v) in layers.iter_mut().zip([m.empty, m.full, m.unknown, m.conflict]) {
            layer.push(v as f32);
        }
    }
    layers
}

/// The largest error as a share of its bound, over the layers.
fn worst(oracle: &OracleMap, layers: &[Vec<f32>]) -> f64 {
    let mut worst = 0.0f64;
    for (reference, layer) in oracle.layers.iter().zip(layers) {
        for ((v, b), x) in reference.values.iter().zip(&reference.bound).zip(layer) {
            let error = (v - f64::from(*x)).abs();
            worst = worst.max(if error == 0.0 { 0.0 } else { error / b });
        }
    }
    worst
}

#[test]
fn bounds_hold_and_faults_are_seen() {
    let (grid, sensor, readings) = test1_or_random();
    let sensors = [sensor];
    for (method, set) in [
        ("certainty", None),
        ("bayes", None),
        ("bayes", Some(("region_one_floor", "0"))),
        ("dempster-shafer", None),
        ("dempster-shafer", Some(("model", "murphy"))),
    ] {
        let mut settings = Settings::of(method).unwrap();
        if let Some((key, value)) = set {
            settings.set(key, value).unwrap();
        }
        let oracle = map(&grid, &sensors, &readings, &settings, None).unwrap();
        let cones = cones(&grid, &sensors, &readings, &settings, None).unwrap();
        let mut each: Vec<(&Cone, Vec<Cell>)> = Vec::new();
        for cone in &cones {
            let mut cells = Vec::new();
            cone.cells(&grid, &mut cells);
            each.push((cone, cells));
        }
        let mut run = |fault: Fault| {
            if fault == Fault::Dropped {
                let last = each.iter().rposition(|(_, cells)| cells.iter().any(|c| c.region == Region::Arc)).unwrap();
                each.remove(last);
            }
            let layers = match &settings {
                Settings::Certainty(_) => certainty(grid.cells(), &each, fault),
                Settings::Bayes(s) => bayes(grid.cells(), &each, s, fault),
                Settings::DempsterShafer(s) => dempster_shafer(grid.cells(), &each, s, fault),
                _ => return (0.0, Vec::new()),
            };
            (worst(&oracle, &layers), layers)
        };
        let (good, layers) = run(Fault::None);
        eprintln!("{method} {set:?}: the worst error is {good:.4} of its bound");
        assert!(good <= 1.0, "{method}: an error of {good} bounds");
        if method == "certainty" {
            for k in (0..grid.cells()).filter(|k| !oracle.ambiguous[*k] && oracle.is_touched(*k)) {
                assert_eq!(layers[2][k] > 0.0, oracle.class[k] == 1, "class of cell {k}");
            }
            assert!(run(Fault::NarrowBand).0 > 10.0);
        }
        for fault in [Fault::Swapped, Fault::Dropped] {
            let bad = run(fault).0;
            assert!(bad > 2.0, "{method}: {fault:?} passes with {bad} bounds");
        }
    }
}
