//! Regions of constant depth (Leonard & Durrant-Whyte 1992): successive bearings of a dense circular scan with the same range,
//! because one surface returns the echoes.

use super::ping::Ping;
use crate::geometry::plane::{Point, Vector};
use std::f64::consts::{PI, TAU};

/// The largest step between the bearings of a dense scan, radians.
const DENSE: f64 = 2.5 * PI / 180.0;
/// Fewest readings of a region.
const MIN_READINGS: usize = 4;
/// Most bearings between two runs of one surface.
const MAX_GAP: usize = 3;

/// The amplitude of the loudest echo, relative to the faintest that is detected at the farthest range.
const LOUDEST: f64 = 1.5;

/// What returned the echoes of a region.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A plane: the region's centre is the foot of its normal.
    Wall,
    /// A corner or an edge.
    Point,
}

/// A region of constant depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Rcd {
    /// The position of the scan, metres.
    pub centre: Point,
    /// The nearest point of the surface, metres.
    pub foot: Point,
    /// Unit vector from `centre` to `foot`.
    pub normal: Vector,
    /// The distance from `centre` to `foot`, metres.
    pub range: f64,
    /// Half of the known length of the surface, metres.
    pub half: f64,
    /// The number of the scan.
    pub scan: u64,
    /// What returned the echoes.
    pub source: Source,
    /// Whether `source` follows from its own readings; else other regions decide.
    pub fitted: bool,
    /// Whether it is a feature by itself; else another region must confirm it.
    pub clear: bool,
    /// The first and the last line of the log with its readings.
    pub lines: [u64; 2],
    /// The number of its echoes.
    pub count: u32,
}

/// The largest difference between ranges of one surface, metres: 3 cm, or five standard deviations of a sonar's noise.
pub fn tolerance(range: f64) -> f64 {
    (5.0 * (0.004 + 0.002 * range)).max(0.03)
}

/// The relative amplitude of an echo from `d` metres, by spreading and absorption of sound.
fn amplitude(d: f64) -> f64 {
    (-0.36 * d).exp() / d
}

/// The largest bearing off the axis at which a plane at that range is detected, radians, if amplitudes are `gain` times the least at
/// the farthest range.
fn visible(beta: f64, range: f64, r_max: f64, gain: f64) -> f64 {
    let (least, most) = (amplitude(r_max), amplitude(0.15));
    beta * ((gain * amplitude(range.clamp(0.15, r_max)) / least).ln() / (most / least).ln()).clamp(0.0, 1.0).sqrt()
}

/// A run of echoes of one surface.
struct Run {
    /// Indices of the pings.
    members: Vec<usize>,
    /// Ascending.
    ranges: Vec<f64>,
}

impl Run {
    fn median(&self) -> f64 {
        self.ranges[self.ranges.len() / 2]
    }

    fn push(&mut self, k: usize, range: f64) {
        let at = self.ranges.partition_point(|r| *r < range);
        self.ranges.insert(at, range);
        self.members.push(k);
    }
}

/// The regions of one scan, if its bearings are dense; `pings` are those of one sensor in one scan, in any order.
pub fn regions(pings: &[Ping]) -> Vec<Rcd> {
    let mut order: Vec<&Ping> = pings.iter().collect();
    let bearing = |p: &Ping| p.record.pose.heading.rem_euclid(TAU);
    order.sort_by(|a, b| bearing(a).total_cmp(&bearing(b)));
    let n = order.len();
    let step = |k: usize| (bearing(order[(k + 1) % n]) - bearing(order[k])).rem_euclid(TAU);
    // Whether a run may go on from ping k to the next.
    let joined = |k: usize| n > 1 && step(k) <= DENSE && step(k) > 0.0;
    let goes_on = |k: usize| match (joined(k), order[k].range, order[(k + 1) % n].range) {
        (true, Some(a), Some(b)) => (a - b).abs() <= tolerance(a),
        _ => false,
    };
    // The circle is cut where no run crosses.
    let Some(first) = (0..n).find(|k| !goes_on(*k)) else { return Vec::new() };
    let mut runs: Vec<Run> = Vec::new();
    let mut open = false;
    for k in (1..=n).map(|k| (first + k) % n) {
        let Some(range) = order[k].range else {
            open = false;
            continue;
        };
        open &= joined((k + n - 1) % n);
        match runs.last_mut().filter(|r| open && (r.median() - range).abs() <= tolerance(range)) {
            Some(run) => run.push(k, range),
            None => runs.push(Run { members: vec![k], ranges: vec![range] }),
        }
        open = true;
    }
    let steps: Vec<f64> = (0..n).filter(|k| joined(*k)).map(step).collect();
    let Some(alpha) = median(steps) else { return Vec::new() };
    let ahead = |from: usize, to: usize| ((bearing(order[to]) - bearing(order[from])).rem_euclid(TAU) / alpha).round();
    join(&mut runs, &ahead);
    runs.iter().flat_map(|run| parts(&order, run, alpha)).collect()
}

/// The regions of a run: one, or two if it is wider than one surface can be detected.
fn parts(order: &[&Ping], run: &Run, alpha: f64) -> Vec<Rcd> {
    let first = order[run.members[0]];
    let (range, beta) = (run.median(), first.half_width);
    let fewest = MIN_READINGS.max((0.6 * visible(beta, range, first.reach, 1.0) / alpha).ceil() as usize);
    if run.members.len() < fewest {
        return Vec::new();
    }
    let turned = |k: &usize| first.axis.perp(&order[*k].axis).atan2(first.axis.dot(&order[*k].axis)).rem_euclid(TAU);
    let span = run.members.iter().map(turned).fold(0.0, f64::max);
    let most = 2.0 * visible(beta, range, first.reach, LOUDEST);
    if span <= most + 2.0 * alpha {
        return region(order, &run.members).into_iter().collect();
    }
    // The part at either end, as wide as one surface can be detected.
    let within = |low: f64| {
        let own = move |k: &&usize| (low - 1e-9..=low + most + 1e-9).contains(&turned(k));
        run.members.iter().filter(own).copied().collect::<Vec<usize>>()
    };
    let halves = [within(0.0), within(span - most)];
    halves.iter().filter(|h| h.len() >= MIN_READINGS).filter_map(|h| region(order, h)).collect()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Joins runs of one surface that are separated by stray or missing echoes; `ahead` is the number of steps from one reading to
/// another, counter-clockwise.
fn join(runs: &mut Vec<Run>, ahead: &dyn Fn(usize, usize) -> f64) {
    let mut k = 0;
    while k < runs.len() {
        let (run, first, last) = (&runs[k], runs[k].members[0], runs[k].members[runs[k].members.len() - 1]);
        // The runs are in the order of their bearings; stray echoes within the run are skipped.
        let within = |j: &usize| ahead(first, runs[*j].members[0]) < ahead(first, last);
        let near = |j: &usize| ahead(last, runs[*j].members[0]) <= (MAX_GAP + 1) as f64;
        let next = (k + 1..runs.len())
            .chain(0..k)
            .take_while(|j| within(j) || near(j))
            .find(|j| near(j) && (runs[*j].median() - run.median()).abs() <= 0.75 * tolerance(run.median()));
        let Some(j) = next else {
            k += 1;
            continue;
        };
        let other = runs.remove(j);
        k -= usize::from(j < k);
        for (member, range) in other.members.iter().zip(&other.ranges) {
            runs[k].push(*member, *range);
        }
    }
}

/// The region of a run.
fn region(order: &[&Ping], members: &[usize]) -> Option<Rcd> {
    let pings: Vec<&Ping> = members.iter().map(|k| order[*k]).collect();
    let first = pings.first()?;
    let sum = pings.iter().fold(Vector::zeros(), |s, p| s + p.axis);
    let normal = sum * (1.0 / sum.norm());
    let centre = first.centre();
    let n = pings.len() as f64;
    let distance = |p: &&Ping| p.range.unwrap_or_default() + normal.dot(&(p.at - centre));
    let range = pings.iter().map(distance).sum::<f64>() / n;
    let span = pings.iter().map(|p| normal.perp(&p.axis).asin().abs()).fold(0.0, f64::max);
    let lines = pings.iter().map(|p| p.record.line);
    Some(Rcd {
        centre,
        foot: centre + normal * range,
        normal,
        range,
        half: range * span.sin(),
        scan: first.record.scan,
        source: Source::Wall,
        fitted: false,
        clear: true,
        lines: [lines.clone().min()?, lines.max()?],
        count: pings.len() as u32,
    })
}
