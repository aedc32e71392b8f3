//! The shapes and the path of a world's file, checked one by one.

use super::campus::{self, Campus};
use super::path::{self, Boundary, ClosedShape, PlannedPath};
use super::shape::{Arc, SURFACES, Surface, Wall};
use super::text::{SourceText, Span, Table};
use crate::geometry::plane::{Point, intersect_lines};
use crate::{Error, Result};
use nalgebra::{Isometry2, distance};
use std::f64::consts::TAU;
use toml::Spanned;

/// The shortest side and the least radius, metres.
const MIN_LENGTH: f64 = 1e-3;

/// The shapes of a file so far, with the line of each.
pub(super) struct Builder<'a> {
    text: &'a SourceText<'a>,
    pub classes: Vec<String>,
    /// Whether the file lists its classes, so that no other may be used.
    declared: bool,
    pub walls: Vec<Wall>,
    pub arcs: Vec<Arc>,
    pub closed: Vec<ClosedShape>,
    pub wall_lines: Vec<u64>,
    pub arc_lines: Vec<u64>,
}

impl<'a> Builder<'a> {
    /// No shapes yet, and the declared classes.
    pub fn new(top: &Table<'a>) -> Result<Builder<'a>> {
        let classes = top.strings("classes")?;
        for (k, class) in classes.iter().enumerate() {
            if class.is_empty() || classes[..k].contains(class) {
                let what = format!("classes: {class:?} stands twice or is empty: give each class a name of its own");
                return Err(top.fail("classes", what));
            }
        }
        Ok(Builder {
            text: top.text,
            declared: !classes.is_empty(),
            classes,
            walls: Vec::new(),
            arcs: Vec::new(),
            closed: Vec::new(),
            wall_lines: Vec::new(),
            arc_lines: Vec::new(),
        })
    }

    /// Reads every shape, and gives the path.
    pub fn read(&mut self, top: &Table<'a>) -> Result<PlannedPath> {
        for table in top.tables("outline", "[[outline]]")? {
            self.outline(&table)?;
        }
        for table in top.tables("wall", "[[wall]]")? {
            self.polyline(&table)?;
        }
        for table in top.tables("box", "[[box]]")? {
            self.rectangle(&table)?;
        }
        for table in top.tables("circle", "[[circle]]")? {
            self.circle(&table)?;
        }
        let mut path: Option<PlannedPath> = None;
        for table in top.tables("path", "[path]")? {
            path = Some(path::read(&table)?);
        }
        for table in top.tables("campus", "[campus]")? {
            let classes = [self.class_of("wall", &table.span)?, self.class_of("furniture", &table.span)?];
            let built = campus::build(&Campus::read(&table)?, classes);
            let line = self.text.line(&table.span);
            self.wall_lines.extend(std::iter::repeat_n(line, built.walls.len()));
            self.walls.extend(built.walls);
            path = path.or(Some(PlannedPath::along(built.path, line)));
        }
        let file = self.text.path;
        if self.walls.is_empty() && self.arcs.is_empty() {
            let what = "the world is empty: add an [[outline]], a [[wall]], a [[box]] or a [[circle]]";
            return Err(Error::input(file, what));
        }
        let what =
            "the world has no [path]: add one, with points = [[x, y], …] and step, or poses = [[x, y, heading], …]";
        path.ok_or_else(|| Error::input(file, what))
    }

    fn surface(&self, table: &Table<'_>) -> Result<Surface> {
        table.choice("surface", &SURFACES, Surface::Specular)
    }

    fn class(&mut self, table: &Table<'_>) -> Result<Option<u16>> {
        let Some(name) = table.string("class")? else { return Ok(None) };
        if name.get_ref().is_empty() {
            return Err(table.fail("class", "class is empty: give it a name, or leave it out"));
        }
        self.class_of(name.get_ref(), &name.span())
    }

    /// The number of a class, from 1; a new one is added, unless the file lists its classes.
    fn class_of(&mut self, name: &str, span: &Span) -> Result<Option<u16>> {
        let known = self.classes.iter().position(|c| c == name);
        if known.is_none() && self.declared {
            let names: Vec<&str> = self.classes.iter().map(String::as_str).collect();
            let hint = crate::support::suggest::similar(name, &names);
            return Err(self.text.fail(span, format!("class {name:?} isn't in classes{hint}: add it there")));
        }
        let k = known.unwrap_or_else(|| {
            self.classes.push(name.into());
            self.classes.len() - 1
        });
        Ok(u16::try_from(k + 1).ok())
    }

    /// The key `points`, at least so many.
    fn points(&self, table: &Table<'_>, least: usize) -> Result<Vec<Spanned<Point>>> {
        let rows = table.need("points", table.rows("points", 2)?, "[[0.0, 0.0], [1.0, 0.0]]")?;
        if rows.len() < least {
            let what = format!("{} points: {} needs at least {least}", rows.len(), table.name);
            return Err(table.fail("points", what));
        }
        let points: Vec<_> =
            rows.iter().map(|r| Spanned::new(r.span(), Point::new(r.get_ref()[0], r.get_ref()[1]))).collect();
        for pair in points.windows(2) {
            let (a, b) = (pair[0].get_ref(), pair[1].get_ref());
            if distance(a, b) < MIN_LENGTH {
                let what = format!("a wall of zero length at [{}, {}]: remove the point that stands twice", b.x, b.y);
                return Err(self.text.fail(&pair[1].span(), what));
            }
        }
        Ok(points)
    }

    /// The key `free`: whether the inside is the free side.
    fn inside(table: &Table<'_>, default: bool) -> Result<bool> {
        table.choice("free", &[("inside", true), ("outside", false)], default)
    }

    fn outline(&mut self, table: &Table<'_>) -> Result<()> {
        table.check(&["points", "free", "surface", "class"])?;
        let points = self.points(table, 4)?;
        let (first, end) = (points[0].get_ref(), &points[points.len() - 1]);
        let last = end.get_ref();
        if distance(first, last) > 1e-9 {
            let what = format!(
                "the outline is open: it begins at [{}, {}] and ends at [{}, {}]; repeat the first point at the end, or make it a [[wall]]",
                first.x, first.y, last.x, last.y
            );
            return Err(self.text.fail(&end.span(), what));
        }
        let corners: Vec<Point> = points[1..].iter().map(|p| *p.get_ref()).collect();
        let lines: Vec<u64> = points[1..].iter().map(|p| self.text.line(&p.span())).collect();
        for i in 0..corners.len() {
            for k in i + 2..corners.len() - usize::from(i == 0) {
                let next = |k: usize| corners[(k + 1) % corners.len()];
                let met = intersect_lines(corners[i], next(i), corners[k], next(k));
                if met.is_some_and(|(t, u)| (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)) {
                    let what = format!(
                        "the outline crosses itself (with the side before line {}): reorder its points",
                        lines[k]
                    );
                    return Err(self.text.fail(&points[i + 1].span(), what));
                }
            }
        }
        let inside = Self::inside(table, true)?;
        self.closed(table, &corners, &lines, inside)
    }

    /// Adds the walls of a closed polygon, with the free side to the left.
    fn closed(&mut self, table: &Table<'_>, corners: &[Point], lines: &[u64], inside: bool) -> Result<()> {
        let (surface, class) = (self.surface(table)?, self.class(table)?);
        let n = corners.len();
        let area: f64 = (0..n).map(|k| corners[k].coords.perp(&corners[(k + 1) % n].coords)).sum();
        if area.abs() < MIN_LENGTH * MIN_LENGTH {
            let what = "it encloses nothing: all its points lie on one line; make it a [[wall]]";
            return Err(self.text.fail(&table.span, what));
        }
        self.closed.push(ClosedShape { boundary: Boundary::Polygon(corners.to_vec()), inside, line: lines[0] });
        for k in 0..n {
            let (p, q) = (corners[k], corners[(k + 1) % n]);
            let (a, b) = if (area > 0.0) == inside { (p, q) } else { (q, p) };
            self.walls.push(Wall { a, b, surface, class, thin: false });
            self.wall_lines.push(lines[(k + 1) % n]);
        }
        Ok(())
    }

    fn polyline(&mut self, table: &Table<'_>) -> Result<()> {
        table.check(&["points", "surface", "class"])?;
        let points = self.points(table, 2)?;
        let (surface, class) = (self.surface(table)?, self.class(table)?);
        for pair in points.windows(2) {
            self.walls.push(Wall { a: *pair[0].get_ref(), b: *pair[1].get_ref(), surface, class, thin: true });
            self.wall_lines.push(self.text.line(&pair[1].span()));
        }
        Ok(())
    }

    fn rectangle(&mut self, table: &Table<'_>) -> Result<()> {
        table.check(&["centre", "size", "turn", "free", "surface", "class"])?;
        let centre = table.need("centre", table.point("centre")?, "[1.0, 2.0]")?;
        let size = table.need("size", table.point("size")?, "[0.5, 0.4]")?;
        let (w, h) = (size.x, size.y);
        if w < MIN_LENGTH || h < MIN_LENGTH {
            let what = format!("size [{w}, {h}]: a box needs a width and a height of 1 mm or more");
            return Err(table.fail("size", what));
        }
        let pose = Isometry2::new(centre.coords, table.angle("turn")?.unwrap_or(0.0));
        let corner = |x: f64, y: f64| pose * Point::new(x * w, y * h);
        let corners = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        let line = self.text.line(&table.span);
        let inside = Self::inside(table, false)?;
        self.closed(table, &corners, &[line; 4], inside)
    }

    fn circle(&mut self, table: &Table<'_>) -> Result<()> {
        table.check(&["centre", "radius", "from", "to", "free", "surface", "class"])?;
        let centre = table.need("centre", table.point("centre")?, "[1.0, 2.0]")?;
        let radius = table.need("radius", table.positive("radius")?, "0.2")?;
        if radius < MIN_LENGTH {
            return Err(table.fail("radius", format!("radius {radius} m: give 1 mm or more")));
        }
        let (from, sweep) = match (table.angle("from")?, table.angle("to")?) {
            (None, None) => (0.0, TAU),
            (Some(from), Some(to)) if (to - from).abs() >= TAU - 1e-9 => (from, TAU),
            (Some(from), Some(to)) => {
                let sweep = (to - from).rem_euclid(TAU);
                if sweep * radius < MIN_LENGTH {
                    let what = "an arc of less than 1 mm: it goes from `from` to `to`, counter-clockwise; leave out both for a whole circle";
                    return Err(table.fail("to", what));
                }
                (from, sweep)
            }
            _ => return Err(self.text.fail(&table.span, "an arc needs both from and to, counter-clockwise")),
        };
        let (inside, surface, class) = (Self::inside(table, false)?, self.surface(table)?, self.class(table)?);
        if sweep < TAU && table.get("free").is_some() {
            let what = "an arc is thin, both its sides are free: remove free, or leave out from and to";
            return Err(table.fail("free", what));
        }
        if sweep >= TAU {
            let line = self.text.line(&table.span);
            self.closed.push(ClosedShape { boundary: Boundary::Circle { centre, radius }, inside, line });
        }
        self.arcs.push(Arc { centre, radius, from, sweep, surface, class, inside });
        self.arc_lines.push(self.text.line(&table.span));
        Ok(())
    }
}
