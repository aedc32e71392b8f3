//! Regions of constant depth from sonars that look one way: a transducer's successive readings while the robot passes a surface.

use super::ping::Ping;
use super::rcd::{Rcd, Source};
use crate::geometry::plane::{Point, add, cross, distance, dot, sub, times};
use std::collections::BTreeMap;

/// A run's travel: from which on it tells something, and where it ends, metres.
const TRAVEL: [f64; 2] = [0.25, 1.0];
/// Fewest readings of a run.
const FEWEST: usize = 4;
/// The heading changes by less over a run, radians.
const TURN: f64 = 0.087_266_463;
/// A range may leave what a surface in the cone would give by so much, metres.
const TOLERANCE: f64 = 0.03;
/// Readings nearer together are one, metres.
const STEP: f64 = 0.01;
/// One of wall and point must fit so well, metres, and so much better than the other.
const FITS: f64 = 0.015;
const BETTER: f64 = 0.8;
/// What lies no farther off the robot's way is straight ahead, or behind, radians.
const AHEAD: f64 = 0.35;
/// Bearings tried across the cone.
const TRIED: usize = 61;

/// The runs under way, by sensor, and how far the robot has travelled since they began, metres.
#[derive(Debug, Clone, Default)]
pub struct Runs(BTreeMap<u32, (Vec<Ping>, f64)>);

impl Runs {
    /// Takes a sensor's next reading; gives the region that ends with the one before.
    pub fn push(&mut self, ping: &Ping) -> Option<Rcd> {
        let (run, travelled) = self.0.entry(ping.record.sensor).or_default();
        let Some(last) = run.last() else {
            run.extend(ping.range.map(|_| *ping));
            return None;
        };
        if ping.range.is_some() && distance(last.at, ping.at) < STEP {
            return None;
        }
        *travelled += distance(last.at, ping.at);
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

    /// Ends all runs.
    pub fn finish(&mut self) -> Vec<Rcd> {
        std::mem::take(&mut self.0).into_values().filter_map(|(run, _)| region(&run)).collect()
    }
}

/// Whether a reading may be of the surface that the run passes.
fn continues(run: &[Ping], ping: &Ping) -> bool {
    let (first, last) = (&run[0], &run[run.len() - 1]);
    let (Some(before), Some(z)) = (last.range, ping.range) else { return false };
    if cross(first.axis, ping.axis).abs() > TURN.sin() || dot(first.axis, ping.axis) < 0.0 {
        return false;
    }
    let step = sub(ping.at, last.at);
    // −n · step over the normals n in the cone: its ends, and the step's own direction where that lies inside.
    let (ahead, aside) = (dot(ping.axis, step), cross(ping.axis, step));
    let (sin, cos) = ping.half_width.sin_cos();
    let [left, right] = [ahead * cos + aside * sin, ahead * cos - aside * sin];
    let far = step.0.hypot(step.1);
    let inside = aside.abs() <= ahead.abs() * ping.half_width.tan();
    let (mut low, mut high) = (left.min(right), left.max(right));
    if inside {
        (low, high) = if ahead >= 0.0 { (low, far) } else { (-far, high) };
    }
    let change = before - z;
    change >= low - TOLERANCE && change <= high + TOLERANCE
}

/// What a run's readings fit.
struct Fit {
    normal: Point,
    /// The foot or the point as the middle reading sees it, metres from it.
    range: f64,
    rms: f64,
}

fn region(run: &[Ping]) -> Option<Rcd> {
    let (first, last) = (run.first()?, run.last()?);
    if run.len() < FEWEST || distance(first.at, last.at) < TRAVEL[0] {
        return None;
    }
    let middle = &run[run.len() / 2];
    let (wall, point) = (best(middle, |n| wall(run, middle, n)), best(middle, |n| point(run, middle, n)));
    let (fit, other, source) =
        if wall.rms <= point.rms { (&wall, &point, Source::Wall) } else { (&point, &wall, Source::Point) };
    if fit.rms > FITS {
        return None;
    }
    // What fits both as well is taken for a wall straight ahead, else for a point, if another region says so too.
    let clear = fit.rms <= BETTER * other.rms;
    let travel = sub(last.at, first.at);
    let ahead = cross(wall.normal, travel).abs() < AHEAD.sin() * distance(first.at, last.at);
    let (fit, source) = match (clear, ahead) {
        (true, _) => (fit, source),
        (false, true) => (&wall, Source::Wall),
        (false, false) => (&point, Source::Point),
    };
    let along = (-fit.normal.1, fit.normal.0);
    let places = run.iter().map(|p| dot(along, sub(p.at, middle.at)));
    let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    // A wall's feet move with the robot: the region is in the middle of them, and so is the place that it is seen from.
    let (shift, half) = match source {
        Source::Wall => (times(along, (low + high) / 2.0), (high - low) / 2.0 + 0.05),
        Source::Point => ((0.0, 0.0), 0.05),
    };
    let centre = add(middle.at, shift);
    Some(Rcd {
        centre,
        foot: add(centre, times(fit.normal, fit.range)),
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

/// The best of the bearings across the cone.
fn best(middle: &Ping, fit: impl Fn(Point) -> Fit) -> Fit {
    let left = (-middle.axis.1, middle.axis.0);
    let at = |k: usize| {
        let turn = middle.half_width * (2.0 * k as f64 / (TRIED - 1) as f64 - 1.0);
        add(times(middle.axis, turn.cos()), times(left, turn.sin()))
    };
    let first = fit(at(0));
    (1..TRIED).map(|k| fit(at(k))).fold(first, |best, f| if f.rms < best.rms { f } else { best })
}

/// z = ρ − n · S.
fn wall(run: &[Ping], middle: &Ping, normal: Point) -> Fit {
    let n = run.len() as f64;
    let rest = || run.iter().map(|p| p.range.unwrap_or_default() + dot(normal, sub(p.at, middle.at)));
    let range = rest().sum::<f64>() / n;
    let square = rest().map(|r| (r - range) * (r - range)).sum::<f64>();
    Fit { normal, range, rms: (square / n).sqrt() }
}

/// z = |P − S|.
fn point(run: &[Ping], middle: &Ping, normal: Point) -> Fit {
    let n = run.len() as f64;
    let mut range = middle.range.unwrap_or_default();
    let mut square = 0.0;
    for _ in 0..4 {
        let at = times(normal, range);
        let (mut step, mut slope) = (0.0, 0.0);
        square = 0.0;
        for ping in run {
            let v = sub(at, sub(ping.at, middle.at));
            let far = v.0.hypot(v.1).max(1e-6);
            let (rest, along) = (ping.range.unwrap_or_default() - far, dot(v, normal) / far);
            square += rest * rest;
            step += along * rest;
            slope += along * along;
        }
        range += step / slope.max(1e-9);
    }
    Fit { normal, range, rms: (square / n).sqrt() }
}
