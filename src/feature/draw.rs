//! Turns a decided reading into an update: free regions as fans, occupied segments.

use super::decide::{BEARINGS, Case, Decision};
use super::features::{Corner, Features, Wall};
use super::ping::Ping;
use super::update::{Fan, Origin, Part, Routine, Update};
use crate::geometry::plane::{Point, intersect_ray};
use nalgebra::distance;

/// A wall is drawn this far beyond its ends, metres.
const BEYOND: f64 = 0.15;
/// The walls of a corner are drawn up to this distance from it, metres.
const CORNER: f64 = 0.5;

/// The cells of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cells {
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// Half the thickness of the arc ε, metres.
    pub epsilon: f64,
}

/// The largest distance of a dropped vertex from the side of a fan, cells: fewer sides are less work.
const TOLERANCE: f64 = 0.05;

/// The farthest distance of anything drawn from the sensor, cells: the kernels take 512.
const MAX_DISTANCE: f64 = 511.0;

struct Drawing<'a> {
    ping: &'a Ping,
    decision: &'a Decision,
    cells: Cells,
    z: f64,
}

/// The update of a reading; `None` if it has no effect.
pub fn draw(ping: &Ping, decision: &Decision, features: &Features, cells: Cells) -> Option<Update> {
    let silent = ping.range.is_none();
    if silent && decision.case == Case::Routine && ping.frees <= 0.0 {
        return None;
    }
    // A missing echo frees up to a wall, or if none is known up to the sensor's no-echo range.
    let z = ping.range.unwrap_or(if decision.case == Case::Routine { ping.frees } else { ping.reach });
    let drawing = Drawing { ping, decision, cells, z };
    let (parts, routine) = match decision.case {
        Case::Associated => drawing.associated(features),
        Case::Outlier | Case::Behind => (Vec::new(), drawing.emptiness()),
        Case::Routine => (Vec::new(), Some(drawing.routine(1.0))),
    };
    let mut update = Update { reading: ping.reading(z), number: ping.number, case: decision.case, parts, routine };
    // A corner just beyond the range of the sonar may be too far for the kernels.
    let most = MAX_DISTANCE * cells.resolution;
    for part in &mut update.parts {
        part.occupied.retain(|line| line.iter().all(|p| distance(p, &ping.at) <= most));
    }
    Some(update)
}

impl Drawing<'_> {
    /// The range beyond which a limit has no effect: a little beyond the arc.
    fn relevant_range(&self) -> f64 {
        self.z + self.cells.epsilon + 2.0 * self.cells.resolution
    }

    /// The fan whose vertices lie at a distance of `far` at each bearing.
    fn fan(&self, far: impl Fn(usize) -> f64) -> Option<Fan> {
        // The robot stands there: a quarter of a cell is free whatever the limit, so that no triangle is degenerate.
        let least = 0.25 * self.cells.resolution;
        let (from, rays) = (self.ping.at, &self.decision.rays);
        let most = MAX_DISTANCE * self.cells.resolution;
        let all: [Point; BEARINGS] = std::array::from_fn(|k| from + rays[k] * far(k).max(least).min(most));
        // Without the vertices that lie on the side between their kept neighbours.
        let within = TOLERANCE * self.cells.resolution;
        let (mut vertices, mut last) = (vec![all[0]], 0);
        for to in 2..BEARINGS {
            let side = [all[last], all[to]];
            let on = |k: usize| {
                intersect_ray(from, rays[k], side).is_some_and(|d| (d - distance(&from, &all[k])).abs() <= within)
            };
            if !(last + 1..to).all(on) {
                last = to - 1;
                vertices.push(all[last]);
            }
        }
        vertices.push(all[BEARINGS - 1]);
        Some(Fan { vertices })
    }

    /// The range up to which the free limit lets cells be freed at a bearing.
    fn free_range(&self, k: usize) -> f64 {
        self.decision.free[k]
    }

    /// The distance to the line of a wall at a bearing, less half a cell.
    fn line(&self, wall: &Wall, k: usize) -> f64 {
        let half = 0.5 * self.cells.resolution * (wall.normal.x.abs() + wall.normal.y.abs());
        let slant = wall.normal.dot(&self.decision.rays[k]);
        if slant > 1e-9 { (wall.front(self.ping.at) - half) / slant } else { f64::INFINITY }
    }

    fn routine(&self, weight: f64) -> Routine {
        let far = self.relevant_range();
        let limits = &self.decision.limits;
        let limited = limits.iter().any(|f| *f < far);
        let free = if limited { self.fan(|k| self.free_range(k).min(far)) } else { None };
        let arc = if limited { self.fan(|k| limits[k].min(far)) } else { None };
        Routine { weight, free, arc, occupies: true }
    }

    /// An update that only frees: up to the limit, and where there is none up to the nearest one.
    fn emptiness(&self) -> Option<Routine> {
        let least = self.decision.free.iter().copied().fold(f64::INFINITY, f64::min);
        let far = |k: usize| if self.decision.limits[k].is_finite() { self.free_range(k) } else { least };
        let free = self.fan(|k| far(k).min(self.relevant_range()));
        Some(Routine { weight: 1.0, free, arc: None, occupies: false })
    }

    fn associated(&self, features: &Features) -> (Vec<Part>, Option<Routine>) {
        let association = &self.decision.association;
        let other = association.other();
        let total = association.weights().iter().sum::<f64>() + other;
        let mut parts = Vec::new();
        let mut part = |origin: Origin, p: f64, (free, occupied): (Option<Fan>, Vec<[Point; 2]>)| {
            parts.push(Part { origin, weight: p / total, free, occupied });
        };
        if let Some((k, p)) = association.wall {
            part(Origin::Wall, p, self.wall(&features.walls[k]));
        }
        if let Some((k, p)) = association.corner {
            let corner = &features.corners[k];
            part(Origin::Corner, p, self.corner(corner, corner.walls.map(|w| &features.walls[w])));
        }
        if let Some((k, p)) = association.point {
            let at = features.points[k].at;
            part(
                Origin::Point,
                p,
                (self.fan(|k| (self.z - self.cells.epsilon).min(self.free_range(k))), vec![[at, at]]),
            );
        }
        (parts, Some(self.routine(other / total)))
    }

    /// The projections of the ends of the arc onto a wall's line, as positions along it.
    fn feet(&self, wall: &Wall) -> [f64; 2] {
        [0, BEARINGS - 1].map(|k| wall.place(self.ping.at + self.decision.rays[k] * self.z))
    }

    fn wall(&self, wall: &Wall) -> (Option<Fan>, Vec<[Point; 2]>) {
        let [low, high] = [wall.extent[0] - BEYOND, wall.extent[1] + BEYOND];
        let feet = self.feet(wall);
        let (from, to) = (feet[0].min(feet[1]).max(low), feet[0].max(feet[1]).min(high));
        let occupied = if from < to { vec![[wall.at(from), wall.at(to)]] } else { Vec::new() };
        let base = self.z - self.cells.epsilon;
        let far = |k: usize| {
            let (line, ray) = (self.line(wall, k), self.decision.rays[k]);
            let place = |t: f64| wall.place(self.ping.at + ray * t);
            let within = (low..=high).contains(&place(base));
            let mut far = base.min(line);
            if base < line && within {
                // Up to the line, or to the end of the strip in front of the wall.
                let slope = wall.along().dot(&ray);
                let edge = if slope > 0.0 { high } else { low };
                let exit = if slope == 0.0 { f64::INFINITY } else { (edge - wall.place(self.ping.at)) / slope };
                far = line.min(exit).min(self.z + CORNER);
            }
            far.min(self.free_range(k))
        };
        (self.fan(far), occupied)
    }

    fn corner(&self, corner: &Corner, walls: [&Wall; 2]) -> (Option<Fan>, Vec<[Point; 2]>) {
        let line = |wall: &Wall| {
            let (at, middle) = (wall.place(corner.at), wall.place(wall.middle()));
            let side = if middle >= at { 1.0 } else { -1.0 };
            let far = self.feet(wall).map(|f| side * (f - at)).into_iter().fold(0.0, f64::max).min(CORNER);
            [corner.at, wall.at(at + side * far)]
        };
        let far = |k: usize| {
            let lines = self.line(walls[0], k).min(self.line(walls[1], k));
            lines.min(self.free_range(k)).min(self.z + CORNER)
        };
        (self.fan(far), walls.map(line).to_vec())
    }
}
