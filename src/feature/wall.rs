//! Walls and points from regions of constant depth: a wall is a transitive group of regions on one line that overlap or nearly so.

use super::features::{Features, PointFeature, Wall};
use super::rcd::{Rcd, Source};
use super::rules::Rules;
use super::vote::same_place;
use crate::geometry::plane::{Point, Vector, intersect_lines, left_normal};
use nalgebra::distance;

/// The cosine of the largest angle between normals of one wall.
const PARALLEL: f64 = 0.984_807_753; // cos 10°
/// The largest gap between two regions of one wall, metres.
const MAX_GAP: f64 = 0.20;
/// The same for two regions that lie on one line within the accuracy of a sonar, metres.
const MAX_COLLINEAR_GAP: f64 = 0.5;
/// The cosine of the largest angle between their normals.
const COLLINEAR: f64 = 0.995_004_165; // cos 0.1
/// The least spread of feet to which a line is fitted, metres.
const MIN_SPREAD: f64 = 0.3;
/// The cosine of the largest angle between the fitted normal and that of the nearest region.
const MAX_TURN: f64 = 0.965_925_826; // cos 15°
/// Feet nearer than this are one point, metres.
const SAME: f64 = 0.15;

/// Disjoint sets of indices.
struct UnionFind(Vec<usize>);

impl UnionFind {
    fn root(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    /// Joins two sets; the smaller root remains.
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

/// The transitive groups of the regions `of` that are `same`; regions farther apart than `reach` in x never are.
fn grouped(rcds: &[Rcd], mut of: Vec<usize>, reach: f64, same: impl Fn(&Rcd, &Rcd) -> bool) -> Vec<Vec<usize>> {
    of.sort_by(|a, b| rcds[*a].foot.x.total_cmp(&rcds[*b].foot.x).then(a.cmp(b)));
    let mut sets = UnionFind((0..of.len()).collect());
    for (i, a) in of.iter().enumerate() {
        let near = of.iter().enumerate().skip(i + 1).take_while(|(_, b)| rcds[**b].foot.x - rcds[*a].foot.x <= reach);
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

/// Whether two regions belong to one wall.
fn one_wall(a: &Rcd, b: &Rcd) -> bool {
    let (near, far) = if a.range <= b.range { (a, b) } else { (b, a) };
    let off = near.normal.dot(&(far.foot - near.foot)).abs();
    let along = left_normal(near.normal);
    let gap = along.dot(&(far.foot - near.foot)).abs() - a.half - b.half;
    let turn = a.normal.dot(&b.normal);
    let collinear = off <= 0.04 + 0.01 * far.range && turn >= COLLINEAR;
    off <= 0.08 + 0.02 * far.range && turn >= PARALLEL && gap <= if collinear { MAX_COLLINEAR_GAP } else { MAX_GAP }
}

/// The walls of the regions that are walls.
pub fn walls(rcds: &[Rcd]) -> Vec<Wall> {
    let own: Vec<usize> = (0..rcds.len()).filter(|k| rcds[*k].source == Source::Wall).collect();
    let longest = own.iter().map(|k| rcds[*k].half).fold(0.0, f64::max);
    let sure = |g: &Vec<usize>| g.len() > 1 || g.iter().any(|k| rcds[*k].clear);
    grouped(rcds, own, 2.0 * longest + MAX_COLLINEAR_GAP, one_wall)
        .into_iter()
        .filter(sure)
        .map(|group| wall(rcds, group))
        .collect()
}

/// The wall of a group of regions.
fn wall(rcds: &[Rcd], group: Vec<usize>) -> Wall {
    let of = |k: &usize| &rcds[*k];
    let closest = group.iter().map(of).min_by(|a, b| a.range.total_cmp(&b.range)).unwrap_or(&rcds[group[0]]);
    let (normal, through) = fit_line(rcds, &group)
        .filter(|(n, _)| n.dot(&closest.normal) > MAX_TURN)
        .unwrap_or((closest.normal, closest.foot));
    let mut wall = Wall {
        normal,
        offset: normal.dot(&through.coords),
        extent: [f64::INFINITY, f64::NEG_INFINITY],
        rcds: Vec::new(),
    };
    for rcd in group.iter().map(of) {
        let s = wall.place(rcd.foot);
        wall.extent = [wall.extent[0].min(s - rcd.half), wall.extent[1].max(s + rcd.half)];
    }
    wall.rcds = group;
    wall
}

/// The line through the feet by weighted total least squares: its normal and a point; `None` if the feet do not spread enough.
///
/// The principal axis of the 2 × 2 scatter matrix is taken from its angle, ½ atan2(2 xy, xx − yy). `SymmetricEigen` gives
/// another last bit in four of five groups, which would change maps.
fn fit_line(rcds: &[Rcd], group: &[usize]) -> Option<(Vector, Point)> {
    let weighted = || group.iter().map(|k| (rcds[*k].foot, (0.02 + 0.005 * rcds[*k].range).powi(-2)));
    let total: f64 = weighted().map(|(_, w)| w).sum();
    let mean = Point::from(weighted().fold(Vector::zeros(), |m, (p, w)| m + p.coords * w) * (1.0 / total));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (p, w) in weighted() {
        let d = p - mean;
        let (x, y) = (d.x, d.y);
        (xx, xy, yy) = (xx + w * x * x, xy + w * x * y, yy + w * y * y);
    }
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let along = Vector::new(turn.cos(), turn.sin());
    let places = || group.iter().map(|k| along.dot(&rcds[*k].foot.coords));
    let spread = places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min);
    let away = group.iter().fold(Vector::zeros(), |s, k| s + rcds[*k].normal);
    let normal = left_normal(along);
    let normal = if normal.dot(&away) < 0.0 { normal * -1.0 } else { normal };
    (spread >= MIN_SPREAD).then_some((normal, mean))
}

/// Marks the regions at the intersections of two other walls as points, whatever the votes, and gives their indices. In one or two
/// scans this is the only evidence of a point.
pub fn points_at_corners(rcds: &mut [Rcd], walls: &[Wall]) -> Vec<usize> {
    let mut found = Vec::new();
    for (i, a) in walls.iter().enumerate() {
        for b in &walls[i + 1..] {
            let Some(at) = concave(a, b) else { continue };
            for (k, rcd) in rcds.iter().enumerate() {
                if distance(&rcd.foot, &at) > same_place(rcd.range) {
                    continue;
                }
                let own = [a, b].iter().any(|w| w.rcds.binary_search(&k).is_ok());
                let between = a.normal.perp(&rcd.normal) * rcd.normal.perp(&b.normal) > 0.0
                    && (a.normal + b.normal).dot(&rcd.normal) > 0.0;
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

/// The intersection of the lines of two walls, if each lies in front of the other and they meet at 25° to 155°.
pub fn concave(a: &Wall, b: &Wall) -> Option<Point> {
    const LEAST: f64 = 0.422_618_26; // sin 25°
    if a.normal.perp(&b.normal).abs() < LEAST || a.front(b.middle()) <= 0.0 || b.front(a.middle()) <= 0.0 {
        return None;
    }
    let (t, _) = intersect_lines(a.at(0.0), a.at(1.0), b.at(0.0), b.at(1.0))?;
    Some(a.at(t))
}

/// The points that two scans saw, or that lie where walls meet (`at_corners`).
pub fn point_features(rcds: &[Rcd], at_corners: &[usize]) -> Vec<PointFeature> {
    let own: Vec<usize> = (0..rcds.len()).filter(|k| rcds[*k].source == Source::Point).collect();
    let groups = grouped(rcds, own, SAME, |a, b| distance(&a.foot, &b.foot) <= SAME);
    let several = |group: &Vec<usize>| {
        group.iter().any(|k| rcds[*k].scan != rcds[group[0]].scan || at_corners.binary_search(k).is_ok())
    };
    let point = |group: Vec<usize>| {
        let sum = group.iter().fold(Vector::zeros(), |s, k| s + rcds[*k].foot.coords);
        PointFeature { at: Point::from(sum * (1.0 / group.len() as f64)), rcds: group }
    };
    groups.into_iter().filter(several).map(point).collect()
}

/// The walls and points of regions, phantoms among them.
pub fn find_features(rcds: &mut [Rcd], rules: &Rules) -> Features {
    let told = rules.points && !rules.paper;
    let at_corners = if told { points_at_corners(rcds, &walls(rcds)) } else { Vec::new() };
    Features { walls: walls(rcds), points: point_features(rcds, &at_corners), corners: Vec::new(), lines: Vec::new() }
}
