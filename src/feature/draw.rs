//! A decided reading as an update: its free regions as fans, its occupied lines.

use super::decide::{BEARINGS, Case, Decision};
use super::features::{Corner, Features, Wall, hit};
use super::ping::Ping;
use super::update::{Fan, Origin, Part, Routine, Update};
use crate::geometry::plane::{Point, add, distance, dot, times};

/// A wall is occupied, and freed before, so much beyond its ends, metres.
const BEYOND: f64 = 0.15;
/// A corner's walls are occupied up to so far from it, metres.
const CORNER: f64 = 0.5;

/// The cells that it is drawn on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cells {
    /// Edge of a cell, metres.
    pub resolution: f64,
    /// ε, metres.
    pub epsilon: f64,
}

/// A fan's side may pass its vertices by so much, cells: fewer sides are less work.
const STRAIGHT: f64 = 0.05;

/// Nothing that is drawn lies farther from the sensor, cells: the kernels take 512.
const FARTHEST: f64 = 511.0;

struct Drawing<'a> {
    ping: &'a Ping,
    decision: &'a Decision,
    cells: Cells,
    z: f64,
}

/// The update of a reading; `None`: it says nothing.
pub fn draw(ping: &Ping, decision: &Decision, features: &Features, cells: Cells) -> Option<Update> {
    let silent = ping.range.is_none();
    if silent && decision.case == Case::Routine && ping.frees <= 0.0 {
        return None;
    }
    // A missing echo frees up to a wall, or where none is known so far as its sensor is trusted.
    let z = ping.range.unwrap_or(if decision.case == Case::Routine { ping.frees } else { ping.reach });
    let drawing = Drawing { ping, decision, cells, z };
    let (parts, routine) = match decision.case {
        Case::Associated => drawing.associated(features),
        Case::Outlier | Case::Behind => (Vec::new(), drawing.emptiness()),
        Case::Routine => (Vec::new(), Some(drawing.routine(1.0))),
    };
    let mut update = Update { reading: ping.reading(z), number: ping.number, case: decision.case, parts, routine };
    // The kernels take no more; a corner just beyond a sonar's reach may be farther.
    let most = FARTHEST * cells.resolution;
    for part in &mut update.parts {
        part.occupied.retain(|line| line.iter().all(|p| distance(*p, ping.at) <= most));
    }
    Some(update)
}

impl Drawing<'_> {
    /// How far a limit matters: a little beyond the arc.
    fn far(&self) -> f64 {
        self.z + self.cells.epsilon + 2.0 * self.cells.resolution
    }

    /// The fan whose vertices lie that far at each bearing.
    fn fan(&self, far: impl Fn(usize) -> f64) -> Option<Fan> {
        // The robot stands there: a quarter of a cell is free whatever a limit says, and no triangle is without area.
        let least = 0.25 * self.cells.resolution;
        let (from, rays) = (self.ping.at, &self.decision.rays);
        let most = FARTHEST * self.cells.resolution;
        let all: [Point; BEARINGS] = std::array::from_fn(|k| add(from, times(rays[k], far(k).max(least).min(most))));
        // Without those that lie, on their rays, on the side between their neighbours that are kept.
        let within = STRAIGHT * self.cells.resolution;
        let (mut vertices, mut last) = (vec![all[0]], 0);
        for to in 2..BEARINGS {
            let side = [all[last], all[to]];
            let on = |k: usize| hit(from, rays[k], side).is_some_and(|d| (d - distance(from, all[k])).abs() <= within);
            if !(last + 1..to).all(on) {
                last = to - 1;
                vertices.push(all[last]);
            }
        }
        vertices.push(all[BEARINGS - 1]);
        Some(Fan { vertices })
    }

    /// Where freeing ends at a bearing for the free limit's sake.
    fn margin(&self, k: usize) -> f64 {
        self.decision.before[k]
    }

    /// How far a wall's line is at a bearing, half a cell before it.
    fn line(&self, wall: &Wall, k: usize) -> f64 {
        let half = 0.5 * self.cells.resolution * (wall.normal.0.abs() + wall.normal.1.abs());
        let slant = dot(wall.normal, self.decision.rays[k]);
        if slant > 1e-9 { (wall.front(self.ping.at) - half) / slant } else { f64::INFINITY }
    }

    fn routine(&self, weight: f64) -> Routine {
        let far = self.far();
        let limits = &self.decision.limits;
        let limited = limits.iter().any(|f| *f < far);
        let free = if limited { self.fan(|k| self.margin(k).min(far)) } else { None };
        let arc = if limited { self.fan(|k| limits[k].min(far)) } else { None };
        Routine { weight, free, arc, occupies: true }
    }

    /// Only emptiness: up to the limit, and where there is none up to the least one.
    fn emptiness(&self) -> Option<Routine> {
        let least = self.decision.before.iter().copied().fold(f64::INFINITY, f64::min);
        let far = |k: usize| if self.decision.limits[k].is_finite() { self.margin(k) } else { least };
        let free = self.fan(|k| far(k).min(self.far()));
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
        if let Some((k, p)) = association.spot {
            let at = features.spots[k].at;
            part(Origin::Point, p, (self.fan(|k| (self.z - self.cells.epsilon).min(self.margin(k))), vec![[at, at]]));
        }
        (parts, Some(self.routine(other / total)))
    }

    /// Feet of the ends of the cone's front on a wall's line, as places along it.
    fn feet(&self, wall: &Wall) -> [f64; 2] {
        [0, BEARINGS - 1].map(|k| wall.place(add(self.ping.at, times(self.decision.rays[k], self.z))))
    }

    fn wall(&self, wall: &Wall) -> (Option<Fan>, Vec<[Point; 2]>) {
        let [low, high] = [wall.extent[0] - BEYOND, wall.extent[1] + BEYOND];
        let feet = self.feet(wall);
        let (from, to) = (feet[0].min(feet[1]).max(low), feet[0].max(feet[1]).min(high));
        let occupied = if from < to { vec![[wall.at(from), wall.at(to)]] } else { Vec::new() };
        let base = self.z - self.cells.epsilon;
        let far = |k: usize| {
            let (line, ray) = (self.line(wall, k), self.decision.rays[k]);
            let place = |t: f64| wall.place(add(self.ping.at, times(ray, t)));
            let within = (low..=high).contains(&place(base));
            let mut far = base.min(line);
            if base < line && within {
                // On to the line, or to where the strip before the wall ends.
                let slope = dot(wall.along(), ray);
                let edge = if slope > 0.0 { high } else { low };
                let exit = if slope == 0.0 { f64::INFINITY } else { (edge - wall.place(self.ping.at)) / slope };
                far = line.min(exit).min(self.z + CORNER);
            }
            far.min(self.margin(k))
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
            lines.min(self.margin(k)).min(self.z + CORNER)
        };
        (self.fan(far), walls.map(line).to_vec())
    }
}
