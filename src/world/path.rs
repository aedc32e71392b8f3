//! Where the robot scans: along way points, one step from the next, or at given poses.

use super::index::Index;
use super::text::Part;
use crate::geometry::plane::{Point, along, distance, from_segment, nearest_share, sub};
use crate::log::reading::Pose;
use crate::{Error, Result};
use std::path::Path;

/// The path comes no nearer to anything, metres.
const CLEARANCE: f64 = 0.01;
/// No path has more scans.
const MOST: f64 = 1e7;
/// The slowest robot, m/s.
const SLOWEST: f64 = 1e-3;

/// A stop: seconds since the start, and the robot's pose.
pub type Stop = (f64, Pose);

/// A path as it was read.
pub(crate) struct Way {
    pub stops: Vec<Stop>,
    /// The way points, where the robot drives from one to the next, and their lines.
    points: Vec<(Point, u64)>,
    /// The lines of explicit poses.
    lines: Vec<u64>,
}

/// Reads `[path]`.
pub(crate) fn read(part: &Part<'_>) -> Result<Way> {
    part.check(&["points", "step", "speed", "poses", "period"])?;
    for (key, with, other) in [("step", "points", "poses"), ("speed", "points", "poses"), ("period", "poses", "points")]
    {
        if part.get(key).is_some() && part.get(other).is_some() {
            return Err(part
                .text
                .fail(&part.place(key), format!("{key} goes with {with}, not with {other}: remove it")));
        }
    }
    match (part.rows("points", 2)?, part.rows("poses", 3)?) {
        (Some(points), None) => {
            if points.len() < 2 {
                return Err(part
                    .text
                    .fail(&part.place("points"), "a path needs two points or more; use poses for one scan"));
            }
            let step = part.need("step", part.positive("step")?, "0.3")?;
            let speed = part.positive("speed")?.unwrap_or(0.5);
            if speed < SLOWEST {
                let what = format!("speed = {speed:?} m/s: give {SLOWEST} or more");
                return Err(part.text.fail(&part.place("speed"), what));
            }
            let points = points.into_iter().map(|(r, at)| ((r[0], r[1]), part.text.line(&at))).collect();
            let way = Way { stops: Vec::new(), points, lines: Vec::new() };
            if let Some(twice) = way.points.windows(2).find(|p| p[0].0 == p[1].0) {
                let (x, y) = twice[1].0;
                let what = format!("the point [{x}, {y}] stands twice in a row: remove one");
                return Err(Error::at(part.text.path, twice[1].1, what));
            }
            let total: f64 = way.points.windows(2).map(|p| distance(p[0].0, p[1].0)).sum();
            if total / step > MOST {
                return Err(part.text.fail(
                    &part.place("step"),
                    format!("step {step:?} m makes more than 1e7 scans: give a longer one"),
                ));
            }
            Ok(way.stepped(step, speed))
        }
        (None, Some(poses)) => {
            if poses.is_empty() {
                return Err(part.text.fail(&part.place("poses"), "poses is empty: add [x, y] or [x, y, heading]"));
            }
            let period = part.positive("period")?.unwrap_or(1.0);
            let lines = poses.iter().map(|(_, at)| part.text.line(at)).collect();
            let pose = |(k, (r, _)): (usize, &(Vec<f64>, _))| {
                let heading = r.get(2).copied().unwrap_or(0.0);
                (k as f64 * period, rounded(Pose { x: r[0], y: r[1], heading }))
            };
            Ok(Way { stops: poses.iter().enumerate().map(pose).collect(), points: Vec::new(), lines })
        }
        (None, None) => Err(part
            .text
            .fail(&part.at, "[path] is empty: give points = [[x, y], …] and step, or poses = [[x, y, heading], …]")),
        _ => Err(part.text.fail(&part.at, "give points or poses, not both")),
    }
}

impl Way {
    /// A path along points that all stand on one line of the file, a scan each 0.3 m.
    pub fn along(points: Vec<Point>, line: u64) -> Way {
        let points = points.into_iter().map(|p| (p, line)).collect();
        Way { stops: Vec::new(), points, lines: Vec::new() }.stepped(0.3, 0.5)
    }

    /// A scan each `step` metres of the whole way, looking along it; `speed` in m/s.
    fn stepped(mut self, step: f64, speed: f64) -> Way {
        let mut next = 0.0;
        let mut done = 0.0;
        for leg in self.points.windows(2) {
            let (a, b) = (leg[0].0, leg[1].0);
            let (d, run) = (sub(b, a), distance(a, b));
            let heading = d.1.atan2(d.0);
            while next <= done + run {
                let (x, y) = along(a, b, (next - done) / run.max(1e-9));
                self.stops.push(((next / speed * 1e6).round() / 1e6, rounded(Pose { x, y, heading })));
                next += step;
            }
            done += run;
        }
        self
    }
}

/// To 1 µm and 1 µrad: where machines' sines differ, their logs don't.
pub(crate) fn rounded(pose: Pose) -> Pose {
    let round = |v: f64| (v * 1e6).round() / 1e6 + 0.0;
    Pose { x: round(pose.x), y: round(pose.y), heading: round(pose.heading) }
}

/// A closed shape, its free side, and its line.
pub(crate) struct Closed {
    pub shape: Outline,
    /// Whether its inside is free; else its inside is solid.
    pub inside: bool,
    pub line: u64,
}

/// The form of a closed shape.
pub(crate) enum Outline {
    Polygon(Vec<Point>),
    Circle(Point, f64),
}

impl Closed {
    /// Whether a place lies inside.
    fn holds(&self, p: Point) -> bool {
        match &self.shape {
            Outline::Circle(centre, radius) => distance(p, *centre) < *radius,
            Outline::Polygon(corners) => {
                // even-odd: sides that a ray to the right crosses
                let sides = (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]));
                let right = |(a, b): &(Point, Point)| {
                    (a.1 > p.1) != (b.1 > p.1) && p.0 < a.0 + (p.1 - a.1) / (b.1 - a.1) * (b.0 - a.0)
                };
                sides.filter(right).count() % 2 == 1
            }
        }
    }
}

/// The shape on whose solid side a place lies: it is inside a solid one, or in none of those whose inside is free.
fn solid(closed: &[Closed], p: Point) -> Option<&Closed> {
    let buried = closed.iter().find(|c| !c.inside && c.holds(p));
    let mut rooms = closed.iter().filter(|c| c.inside).peekable();
    let outside = rooms.peek().copied();
    buried.or(if rooms.any(|c| c.holds(p)) { None } else { outside })
}

/// Refuses a path through a wall, along one, or inside something solid; `lines` are those of the walls and the arcs.
pub(crate) fn check(way: &Way, index: &Index, closed: &[Closed], lines: &[u64], path: &Path) -> Result<()> {
    let line_of = |item: u32| lines.get(item as usize).copied().unwrap_or(0);
    for leg in way.points.windows(2) {
        let ((a, _), (b, line)) = (leg[0], leg[1]);
        for item in index.beside(a, b, CLEARANCE) {
            let Some((at, crosses)) = met(index, item, a, b) else { continue };
            let does = if crosses { "runs through" } else { "touches" };
            let what = format!(
                "the path from [{}, {}] to [{}, {}] {does} the wall of line {} at [{:.2}, {:.2}]: keep 1 cm off, or add a way point round it",
                a.0,
                a.1,
                b.0,
                b.1,
                line_of(item),
                at.0,
                at.1
            );
            return Err(Error::at(path, line, what));
        }
    }
    let places = way.points.iter().copied();
    let poses = way.stops.iter().map(|(_, p)| (p.x, p.y)).zip(way.lines.iter().copied());
    for ((x, y), line) in places.chain(poses) {
        if let Some(shape) = solid(closed, (x, y)) {
            let what = format!(
                "the path's [{x}, {y}] lies on the solid side of the shape of line {}: move the point, or correct that shape's free side",
                shape.line
            );
            return Err(Error::at(path, line, what));
        }
        let touched = index.near((x, y), CLEARANCE);
        if let Some(item) = touched.first() {
            let what = format!("the path's [{x}, {y}] touches the wall of line {}: keep 1 cm off", line_of(*item));
            return Err(Error::at(path, line, what));
        }
    }
    Ok(())
}

/// Where a leg comes too near a wall or an arc, if it does, and whether it crosses it.
fn met(index: &Index, item: u32, a: Point, b: Point) -> Option<(Point, bool)> {
    let crossing = index.shares(item, a, b).into_iter().find(|t| (0.0..=1.0).contains(t));
    if let Some(t) = crossing {
        return Some((along(a, b, t), true));
    }
    let onto = |p: Point| along(a, b, nearest_share(p, a, b));
    // where two things that don't cross are nearest, one of them ends, or the leg passes a circle's centre
    let (places, off): (Vec<Point>, Box<dyn Fn(Point) -> f64>) = match index.walls.get(item as usize) {
        Some(w) => (vec![a, b, onto(w.a), onto(w.b)], Box::new(move |p| from_segment(p, w.a, w.b))),
        None => {
            let arc = &index.arcs[item as usize - index.walls.len()];
            let places = vec![a, b, onto(arc.centre), onto(arc.at(0.0)), onto(arc.at(arc.sweep))];
            (places, Box::new(move |p| arc.off(p)))
        }
    };
    places.into_iter().find(|p| off(*p) < CLEARANCE).map(|p| (p, false))
}
