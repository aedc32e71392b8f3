//! Walls from regions of constant depth: those of one line that overlap or nearly so, transitively.

use super::features::{Features, Spot, Wall};
use super::rcd::{Rcd, Source};
use super::rules::Rules;
use super::vote::same_place;
use crate::geometry::plane::{Point, add, cross, distance, dot, meet, sub, times};

/// Normals of one wall differ by less: cosine.
const PARALLEL: f64 = 0.984_807_753; // cos 10°
/// A gap between two regions of one wall, metres.
const GAP: f64 = 0.20;
/// A gap between two that lie on one line as well as can be told, metres; and the cosine of their turn.
const WIDE: f64 = 0.5;
const TIGHT: f64 = 0.995_004_165; // cos 0.1
/// Feet that spread less give no line, metres.
const SPREAD: f64 = 0.3;
/// A line through the feet may turn the normal by less: cosine.
const TURN: f64 = 0.965_925_826; // cos 15°
/// Points nearer than this are one, metres.
const SAME: f64 = 0.15;

/// Sets of numbers, joined one by one.
struct Sets(Vec<usize>);

impl Sets {
    fn root(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    /// The smaller number leads.
    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }

    fn groups(mut self, of: &[usize]) -> Vec<Vec<usize>> {
        let mut groups: std::collections::BTreeMap<usize, Vec<usize>> = std::collections::BTreeMap::new();
        for (place, k) in of.iter().enumerate() {
            let root = self.root(place);
            groups.entry(root).or_default().push(*k);
        }
        groups.into_values().collect()
    }
}

/// The groups of those that are `same`, transitively; none is so with what lies farther than `reach` from it in x.
fn grouped(rcds: &[Rcd], mut of: Vec<usize>, reach: f64, same: impl Fn(&Rcd, &Rcd) -> bool) -> Vec<Vec<usize>> {
    of.sort_by(|a, b| rcds[*a].foot.0.total_cmp(&rcds[*b].foot.0).then(a.cmp(b)));
    let mut sets = Sets((0..of.len()).collect());
    for (i, a) in of.iter().enumerate() {
        let near = of.iter().enumerate().skip(i + 1).take_while(|(_, b)| rcds[**b].foot.0 - rcds[*a].foot.0 <= reach);
        for (j, b) in near {
            if same(&rcds[*a], &rcds[*b]) {
                sets.join(i, j);
            }
        }
    }
    let mut groups = sets.groups(&of);
    groups.iter_mut().for_each(|g| g.sort_unstable());
    groups.sort_unstable();
    groups
}

/// Whether two regions are of one wall.
fn one_wall(a: &Rcd, b: &Rcd) -> bool {
    let (near, far) = if a.range <= b.range { (a, b) } else { (b, a) };
    let off = dot(near.normal, sub(far.foot, near.foot)).abs();
    let along = (-near.normal.1, near.normal.0);
    let gap = dot(along, sub(far.foot, near.foot)).abs() - a.half - b.half;
    let turn = dot(a.normal, b.normal);
    let tight = off <= 0.04 + 0.01 * far.range && turn >= TIGHT;
    off <= 0.08 + 0.02 * far.range && turn >= PARALLEL && gap <= if tight { WIDE } else { GAP }
}

/// The walls of the regions that are walls.
pub fn walls(rcds: &[Rcd]) -> Vec<Wall> {
    let own: Vec<usize> = (0..rcds.len()).filter(|k| rcds[*k].source == Source::Wall).collect();
    let longest = own.iter().map(|k| rcds[*k].half).fold(0.0, f64::max);
    let sure = |g: &Vec<usize>| g.len() > 1 || g.iter().any(|k| rcds[*k].clear);
    grouped(rcds, own, 2.0 * longest + WIDE, one_wall).into_iter().filter(sure).map(|group| wall(rcds, group)).collect()
}

fn wall(rcds: &[Rcd], group: Vec<usize>) -> Wall {
    let of = |k: &usize| &rcds[*k];
    let closest = group.iter().map(of).min_by(|a, b| a.range.total_cmp(&b.range)).unwrap_or(&rcds[group[0]]);
    let (normal, through) =
        line(rcds, &group).filter(|(n, _)| dot(*n, closest.normal) > TURN).unwrap_or((closest.normal, closest.foot));
    let mut wall =
        Wall { normal, offset: dot(normal, through), extent: [f64::INFINITY, f64::NEG_INFINITY], rcds: Vec::new() };
    for rcd in group.iter().map(of) {
        let s = wall.place(rcd.foot);
        wall.extent = [wall.extent[0].min(s - rcd.half), wall.extent[1].max(s + rcd.half)];
    }
    wall.rcds = group;
    wall
}

/// Total least squares on the feet, where they spread enough: the normal and a point of the line.
fn line(rcds: &[Rcd], group: &[usize]) -> Option<(Point, Point)> {
    let weighted = || group.iter().map(|k| (rcds[*k].foot, (0.02 + 0.005 * rcds[*k].range).powi(-2)));
    let total: f64 = weighted().map(|(_, w)| w).sum();
    let mean = times(weighted().fold((0.0, 0.0), |m, (p, w)| add(m, times(p, w))), 1.0 / total);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (p, w) in weighted() {
        let (x, y) = sub(p, mean);
        (xx, xy, yy) = (xx + w * x * x, xy + w * x * y, yy + w * y * y);
    }
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let along = (turn.cos(), turn.sin());
    let places = || group.iter().map(|k| dot(along, rcds[*k].foot));
    let spread = places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min);
    let away = group.iter().fold((0.0, 0.0), |s, k| add(s, rcds[*k].normal));
    let normal = (-along.1, along.0);
    let normal = if dot(normal, away) < 0.0 { times(normal, -1.0) } else { normal };
    (spread >= SPREAD).then_some((normal, mean))
}

/// Regions that lie where two other walls meet are points, whatever the votes: this is what serves one or two scans.
pub fn points_at_corners(rcds: &mut [Rcd], walls: &[Wall]) -> Vec<usize> {
    let mut found = Vec::new();
    for (i, a) in walls.iter().enumerate() {
        for b in &walls[i + 1..] {
            let Some(at) = concave(a, b) else { continue };
            for (k, rcd) in rcds.iter().enumerate() {
                if distance(rcd.foot, at) > same_place(rcd.range) {
                    continue;
                }
                let own = [a, b].iter().any(|w| w.rcds.binary_search(&k).is_ok());
                let between = cross(a.normal, rcd.normal) * cross(rcd.normal, b.normal) > 0.0
                    && dot(add(a.normal, b.normal), rcd.normal) > 0.0;
                if !own && between {
                    found.push(k);
                }
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    found.iter().for_each(|k| rcds[*k].source = Source::Point);
    found
}

/// Where two walls' lines meet, if each stands in front of the other at 25° to 155°.
pub fn concave(a: &Wall, b: &Wall) -> Option<Point> {
    const LEAST: f64 = 0.422_618_26; // sin 25°
    if cross(a.normal, b.normal).abs() < LEAST || a.front(b.middle()) <= 0.0 || b.front(a.middle()) <= 0.0 {
        return None;
    }
    let (t, _) = meet(a.at(0.0), a.at(1.0), b.at(0.0), b.at(1.0))?;
    Some(a.at(t))
}

/// Points that two scans saw, or that lie where walls meet (`at_corners`).
pub fn spots(rcds: &[Rcd], at_corners: &[usize]) -> Vec<Spot> {
    let own: Vec<usize> = (0..rcds.len()).filter(|k| rcds[*k].source == Source::Point).collect();
    let groups = grouped(rcds, own, SAME, |a, b| distance(a.foot, b.foot) <= SAME);
    let several = |group: &Vec<usize>| {
        group.iter().any(|k| rcds[*k].scan != rcds[group[0]].scan || at_corners.binary_search(k).is_ok())
    };
    let spot = |group: Vec<usize>| {
        let sum = group.iter().fold((0.0, 0.0), |s, k| add(s, rcds[*k].foot));
        Spot { at: times(sum, 1.0 / group.len() as f64), rcds: group }
    };
    groups.into_iter().filter(several).map(spot).collect()
}

/// The features of so many regions, before phantoms are told from them: walls and points.
pub fn gather(rcds: &mut [Rcd], rules: &Rules) -> Features {
    let told = rules.points && !rules.paper;
    let at_corners = if told { points_at_corners(rcds, &walls(rcds)) } else { Vec::new() };
    Features { walls: walls(rcds), spots: spots(rcds, &at_corners), corners: Vec::new(), lines: Vec::new() }
}
