//! The trajectory of the robot: along way points at a fixed distance, or through given poses.

use super::index::ShapeIndex;
use super::text::Table;
use crate::geometry::plane::{Point, distance_to_segment, lerp, nearest_parameter};
use crate::log::reading::Pose;
use crate::{Error, Result};
use nalgebra::distance;
use std::path::Path;

/// The least distance between the robot's centre and a surface, metres.
const CLEARANCE: f64 = 0.01;
/// Most scans of a trajectory.
const MAX_SCANS: f64 = 1e7;
/// The lowest speed, m/s.
const MIN_SPEED: f64 = 1e-3;

/// A pose at which the robot scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedPose {
    /// Seconds since the start.
    pub t: f64,
    /// The robot's pose, world frame.
    pub pose: Pose,
}

/// A trajectory with its positions in the file.
pub(crate) struct PlannedPath {
    pub trajectory: Vec<TimedPose>,
    /// The way points between which the robot drives, each with its line.
    way_points: Vec<(Point, u64)>,
    /// The lines of given poses.
    pose_lines: Vec<u64>,
}

/// Reads `[path]`.
pub(crate) fn read(table: &Table<'_>) -> Result<PlannedPath> {
    table.check(&["points", "step", "speed", "poses", "period"])?;
    for (key, with, other) in [("step", "points", "poses"), ("speed", "points", "poses"), ("period", "poses", "points")]
    {
        if table.get(key).is_some() && table.get(other).is_some() {
            return Err(table.fail(key, format!("{key} goes with {with}, not with {other}: remove it")));
        }
    }
    match (table.rows("points", 2)?, table.rows("poses", 3)?) {
        (Some(points), None) => {
            if points.len() < 2 {
                return Err(table.fail("points", "a path needs two points or more; use poses for one scan"));
            }
            let step = table.need("step", table.positive("step")?, "0.3")?;
            let speed = table.positive("speed")?.unwrap_or(0.5);
            if speed < MIN_SPEED {
                return Err(table.fail("speed", format!("speed = {speed:?} m/s: give {MIN_SPEED} or more")));
            }
            let way_points =
                points.iter().map(|r| (Point::new(r.get_ref()[0], r.get_ref()[1]), table.text.line(&r.span())));
            let path = PlannedPath { trajectory: Vec::new(), way_points: way_points.collect(), pose_lines: Vec::new() };
            if let Some(twice) = path.way_points.windows(2).find(|p| p[0].0 == p[1].0) {
                let (p, line) = twice[1];
                let what = format!("the point [{}, {}] stands twice in a row: remove one", p.x, p.y);
                return Err(Error::at(table.text.path, line, what));
            }
            let total: f64 = path.way_points.windows(2).map(|p| distance(&p[0].0, &p[1].0)).sum();
            if total / step > MAX_SCANS {
                let what = format!("step {step:?} m makes more than 1e7 scans: give a longer one");
                return Err(table.fail("step", what));
            }
            Ok(path.sampled(step, speed))
        }
        (None, Some(poses)) => {
            if poses.is_empty() {
                return Err(table.fail("poses", "poses is empty: add [x, y] or [x, y, heading]"));
            }
            let period = table.positive("period")?.unwrap_or(1.0);
            let pose_lines = poses.iter().map(|r| table.text.line(&r.span())).collect();
            let timed = |(k, row): (usize, &toml::Spanned<Vec<f64>>)| {
                let row = row.get_ref();
                let heading = row.get(2).copied().unwrap_or(0.0);
                TimedPose { t: k as f64 * period, pose: rounded(Pose { x: row[0], y: row[1], heading }) }
            };
            let trajectory = poses.iter().enumerate().map(timed).collect();
            Ok(PlannedPath { trajectory, way_points: Vec::new(), pose_lines })
        }
        (None, None) => Err(table
            .text
            .fail(&table.span, "[path] is empty: give points = [[x, y], …] and step, or poses = [[x, y, heading], …]")),
        _ => Err(table.text.fail(&table.span, "give points or poses, not both")),
    }
}

impl PlannedPath {
    /// A path with a scan every 0.3 m along points that all come from one line of the file.
    pub fn along(points: Vec<Point>, line: u64) -> PlannedPath {
        let way_points = points.into_iter().map(|p| (p, line)).collect();
        PlannedPath { trajectory: Vec::new(), way_points, pose_lines: Vec::new() }.sampled(0.3, 0.5)
    }

    /// The path with a scan every `step` metres, heading along it; `speed` in m/s.
    fn sampled(mut self, step: f64, speed: f64) -> PlannedPath {
        let mut next = 0.0;
        let mut done = 0.0;
        for leg in self.way_points.windows(2) {
            let (a, b) = (leg[0].0, leg[1].0);
            let (d, run) = (b - a, distance(&a, &b));
            let heading = d.y.atan2(d.x);
            while next <= done + run {
                let p = lerp(a, b, (next - done) / run.max(1e-9));
                let pose = rounded(Pose { x: p.x, y: p.y, heading });
                self.trajectory.push(TimedPose { t: (next / speed * 1e6).round() / 1e6, pose });
                next += step;
            }
            done += run;
        }
        self
    }
}

/// A pose rounded to 1 µm and 1 µrad, so that logs are the same on machines whose sines differ.
pub(crate) fn rounded(pose: Pose) -> Pose {
    let round = |v: f64| (v * 1e6).round() / 1e6 + 0.0;
    Pose { x: round(pose.x), y: round(pose.y), heading: round(pose.heading) }
}

/// A closed shape with one solid side.
pub(crate) struct ClosedShape {
    pub boundary: Boundary,
    /// Whether its inside is free; else its inside is solid.
    pub inside: bool,
    /// Its line in the file.
    pub line: u64,
}

/// The boundary of a closed shape, metres.
pub(crate) enum Boundary {
    Polygon(Vec<Point>),
    Circle { centre: Point, radius: f64 },
}

impl ClosedShape {
    /// Whether a point lies inside.
    fn contains(&self, p: Point) -> bool {
        match &self.boundary {
            Boundary::Circle { centre, radius } => distance(&p, centre) < *radius,
            Boundary::Polygon(corners) => {
                // even-odd rule: the sides that a ray to the right crosses
                let sides = (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]));
                let crossed = |(a, b): &(Point, Point)| {
                    (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
                };
                sides.filter(crossed).count() % 2 == 1
            }
        }
    }
}

/// The shape on whose solid side a point lies: one with a solid inside that contains it, or if none of those with a free
/// inside contains it, the first of them.
fn solid_shape_at(shapes: &[ClosedShape], p: Point) -> Option<&ClosedShape> {
    let solid = shapes.iter().find(|c| !c.inside && c.contains(p));
    let mut rooms = shapes.iter().filter(|c| c.inside).peekable();
    let outside = rooms.peek().copied();
    solid.or(if rooms.any(|c| c.contains(p)) { None } else { outside })
}

/// What a path must keep clear of.
pub(crate) struct Obstacles<'a> {
    pub index: &'a ShapeIndex,
    pub closed: &'a [ClosedShape],
    /// The lines of the walls and then of the arcs.
    pub lines: &'a [u64],
    /// The world's file, for messages.
    pub file: &'a Path,
}

impl Obstacles<'_> {
    /// Refuses a path through a wall, along one, or on the solid side of a shape.
    ///
    /// # Errors
    /// [`Error::Input`] with the line of the path's point.
    pub fn check(&self, path: &PlannedPath) -> Result<()> {
        for leg in path.way_points.windows(2) {
            let ((a, _), (b, line)) = (leg[0], leg[1]);
            for item in self.index.near_segment(a, b, CLEARANCE) {
                let Some((at, crosses)) = contact(self.index, item, a, b) else { continue };
                let does = if crosses { "runs through" } else { "touches" };
                let what = format!(
                    "the path from [{}, {}] to [{}, {}] {does} the wall of line {} at [{:.2}, {:.2}]: keep 1 cm off, or add a way point round it",
                    a.x,
                    a.y,
                    b.x,
                    b.y,
                    self.line_of(item),
                    at.x,
                    at.y
                );
                return Err(Error::at(self.file, line, what));
            }
        }
        let poses = path.trajectory.iter().map(|stop| stop.pose.position()).zip(path.pose_lines.iter().copied());
        for (p, line) in path.way_points.iter().copied().chain(poses) {
            self.check_point(p, line)?;
        }
        Ok(())
    }

    fn check_point(&self, p: Point, line: u64) -> Result<()> {
        let (x, y) = (p.x, p.y);
        if let Some(shape) = solid_shape_at(self.closed, p) {
            let what = format!(
                "the path's [{x}, {y}] lies on the solid side of the shape of line {}: move the point, or correct that shape's free side",
                shape.line
            );
            return Err(Error::at(self.file, line, what));
        }
        if let Some(item) = self.index.within(p, CLEARANCE).first() {
            let wall = self.line_of(*item);
            let what = format!("the path's [{x}, {y}] touches the wall of line {wall}: keep 1 cm off");
            return Err(Error::at(self.file, line, what));
        }
        Ok(())
    }

    fn line_of(&self, item: u32) -> u64 {
        self.lines.get(item as usize).copied().unwrap_or(0)
    }
}

/// Where a leg comes too close to a wall or an arc, if it does, and whether it crosses it.
fn contact(index: &ShapeIndex, item: u32, a: Point, b: Point) -> Option<(Point, bool)> {
    let crossing = index.intersections(item, a, b).into_iter().find(|t| (0.0..=1.0).contains(t));
    if let Some(t) = crossing {
        return Some((lerp(a, b, t), true));
    }
    let onto = |p: Point| lerp(a, b, nearest_parameter(p, a, b));
    // two things that don't cross are nearest at an end of one of them, or where the leg passes the centre of a circle
    let (candidates, off): (Vec<Point>, Box<dyn Fn(Point) -> f64>) = match index.walls.get(item as usize) {
        Some(w) => (vec![a, b, onto(w.a), onto(w.b)], Box::new(move |p| distance_to_segment(p, w.a, w.b))),
        None => {
            let arc = &index.arcs[item as usize - index.walls.len()];
            let candidates = vec![a, b, onto(arc.centre), onto(arc.at(0.0)), onto(arc.at(arc.sweep))];
            (candidates, Box::new(move |p| arc.distance_to(p)))
        }
    };
    candidates.into_iter().find(|p| off(*p) < CLEARANCE).map(|p| (p, false))
}
