//! Regions of constant depth from fixed sonars: successive readings of one sonar while the robot passes a surface.

use super::ping::Ping;
use super::rcd::{Rcd, Source};
use crate::geometry::plane::{Vector, left_normal};
use nalgebra::{UnitComplex, distance};
use std::collections::BTreeMap;

/// The least and the largest travel of a run, metres.
const TRAVEL: [f64; 2] = [0.25, 1.0];
/// Fewest readings of a run.
const MIN_READINGS: usize = 4;
/// The largest change of the heading over a run, radians.
const MAX_TURN: f64 = 0.087_266_463;
/// The largest deviation of a range from those that a surface in the cone can give, metres.
const TOLERANCE: f64 = 0.03;
/// The least travel between two readings, metres.
const MIN_STEP: f64 = 0.01;
/// The largest residual of a fit, root mean square, metres.
const MAX_RESIDUAL: f64 = 0.015;
/// A fit is better than another if its residual is less than this part of the other's.
const BETTER: f64 = 0.8;
/// A surface is straight ahead or behind if its normal is within this angle of the robot's direction, radians.
const AHEAD: f64 = 0.35;
/// The number of bearings tried across the cone.
const CANDIDATES: usize = 61;

/// The current run of each sensor, and the robot's travel since its beginning, metres.
#[derive(Debug, Clone, Default)]
pub struct Runs(BTreeMap<u32, (Vec<Ping>, f64)>);

impl Runs {
    /// Takes the next reading of a sensor; gives the region that ended before it, if there is one.
    pub fn push(&mut self, ping: &Ping) -> Option<Rcd> {
        let (run, travelled) = self.0.entry(ping.record.sensor).or_default();
        let Some(last) = run.last() else {
            run.extend(ping.range.map(|_| *ping));
            return None;
        };
        if ping.range.is_some() && distance(&last.at, &ping.at) < MIN_STEP {
            return None;
        }
        *travelled += distance(&last.at, &ping.at);
        if continues(run, ping) && *travelled <= TRAVEL[1] {
            run.push(*ping);
            return None;
        }
        let found = region(run);
        run.clear();
        *travelled = 0.0;
        run.extend(ping.range.map(|_| *ping));
        found
    }

    /// Ends all runs; gives their regions.
    pub fn finish(&mut self) -> Vec<Rcd> {
        std::mem::take(&mut self.0).into_values().filter_map(|(run, _)| region(&run)).collect()
    }
}

/// Whether a reading may belong to the surface of a run.
fn continues(run: &[Ping], ping: &Ping) -> bool {
    let (first, last) = (&run[0], &run[run.len() - 1]);
    let (Some(before), Some(z)) = (last.range, ping.range) else { return false };
    if first.axis.perp(&ping.axis).abs() > MAX_TURN.sin() || first.axis.dot(&ping.axis) < 0.0 {
        return false;
    }
    let step = ping.at - last.at;
    // The extremes of −n · step over the normals n in the cone: at its edges, or at the direction of the step if it lies inside.
    let (ahead, aside) = (ping.axis.dot(&step), ping.axis.perp(&step));
    let (sin, cos) = ping.half_width.sin_cos();
    let [left, right] = [ahead * cos + aside * sin, ahead * cos - aside * sin];
    let far = step.x.hypot(step.y);
    let inside = aside.abs() <= ahead.abs() * ping.half_width.tan();
    let (mut low, mut high) = (left.min(right), left.max(right));
    if inside {
        (low, high) = if ahead >= 0.0 { (low, far) } else { (-far, high) };
    }
    let change = before - z;
    change >= low - TOLERANCE && change <= high + TOLERANCE
}

/// The fit of a run's readings to a wall or to a point.
struct Fit {
    normal: Vector,
    /// The distance of the foot or of the point from the middle reading, metres.
    range: f64,
    rms: f64,
}

fn region(run: &[Ping]) -> Option<Rcd> {
    let (first, last) = (run.first()?, run.last()?);
    if run.len() < MIN_READINGS || distance(&first.at, &last.at) < TRAVEL[0] {
        return None;
    }
    let middle = &run[run.len() / 2];
    let (wall, point) = (best(middle, |n| wall(run, middle, n)), best(middle, |n| point(run, middle, n)));
    let (fit, other, source) =
        if wall.rms <= point.rms { (&wall, &point, Source::Wall) } else { (&point, &wall, Source::Point) };
    if fit.rms > MAX_RESIDUAL {
        return None;
    }
    // If both fit equally well it is a wall straight ahead, else a point, and another region must confirm it.
    let clear = fit.rms <= BETTER * other.rms;
    let travel = last.at - first.at;
    let ahead = wall.normal.perp(&travel).abs() < AHEAD.sin() * distance(&first.at, &last.at);
    let (fit, source) = match (clear, ahead) {
        (true, _) => (fit, source),
        (false, true) => (&wall, Source::Wall),
        (false, false) => (&point, Source::Point),
    };
    let along = left_normal(fit.normal);
    let places = run.iter().map(|p| along.dot(&(p.at - middle.at)));
    let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    // The feet of a wall move with the robot: the region is in their middle, and so is the position from which it is seen.
    let (shift, half) = match source {
        Source::Wall => (along * ((low + high) / 2.0), (high - low) / 2.0 + 0.05),
        Source::Point => (Vector::zeros(), 0.05),
    };
    let centre = middle.at + shift;
    Some(Rcd {
        centre,
        foot: centre + fit.normal * fit.range,
        normal: fit.normal,
        range: fit.range,
        half,
        scan: middle.record.scan,
        source,
        fitted: true,
        clear,
        lines: [first.record.line, last.record.line],
        count: run.len() as u32,
    })
}

/// The best fit among bearings across the cone.
fn best(middle: &Ping, fit: impl Fn(Vector) -> Fit) -> Fit {
    let at = |k: usize| {
        let turn = middle.half_width * (2.0 * k as f64 / (CANDIDATES - 1) as f64 - 1.0);
        UnitComplex::new(turn) * middle.axis
    };
    let first = fit(at(0));
    (1..CANDIDATES).map(|k| fit(at(k))).fold(first, |best, f| if f.rms < best.rms { f } else { best })
}

/// The fit of a wall at distance ρ: z = ρ − n · S, S the displacement from the middle reading.
fn wall(run: &[Ping], middle: &Ping, normal: Vector) -> Fit {
    let n = run.len() as f64;
    let rest = || run.iter().map(|p| p.range.unwrap_or_default() + normal.dot(&(p.at - middle.at)));
    let range = rest().sum::<f64>() / n;
    let square = rest().map(|r| (r - range) * (r - range)).sum::<f64>();
    Fit { normal, range, rms: (square / n).sqrt() }
}

/// The fit of a point P: z = |P − S|, by Gauss–Newton steps along the bearing.
fn point(run: &[Ping], middle: &Ping, normal: Vector) -> Fit {
    let n = run.len() as f64;
    let mut range = middle.range.unwrap_or_default();
    let mut square = 0.0;
    for _ in 0..4 {
        let at = normal * range;
        let (mut step, mut slope) = (0.0, 0.0);
        square = 0.0;
        for ping in run {
            let v = at - (ping.at - middle.at);
            let far = v.x.hypot(v.y).max(1e-6);
            let (rest, along) = (ping.range.unwrap_or_default() - far, v.dot(&normal) / far);
            square += rest * rest;
            step += along * rest;
            slope += along * along;
        }
        range += step / slope.max(1e-9);
    }
    Fit { normal, range, rms: (square / n).sqrt() }
}
