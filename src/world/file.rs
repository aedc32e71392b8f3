//! A world's TOML file: its shapes, its path and its rig, checked. `docs/worlds.md` describes the format.

use super::campus::{self, Campus};
use super::corner::corners;
use super::index::Index;
use super::path::{self, Closed, Outline, Way};
use super::rig::Rig;
use super::shape::{Arc, SURFACES, Surface, Wall};
use super::text::{Part, Text};
use super::{World, index};
use crate::Result;
use crate::geometry::plane::{Point, add, cross, distance};
use sha2::{Digest, Sha256};
use std::f64::consts::TAU;
use std::path::Path;
use toml::de::{DeTable, DeValue};

/// Nothing is shorter, metres.
const SHORTEST: f64 = 1e-3;
const TOP: [&str; 10] = ["name", "classes", "outline", "wall", "box", "circle", "path", "rig", "sensor", "campus"];

/// What a file builds, piece by piece, with the line of each piece.
struct Builder<'a> {
    text: &'a Text<'a>,
    classes: Vec<String>,
    declared: bool,
    walls: Vec<Wall>,
    arcs: Vec<Arc>,
    closed: Vec<Closed>,
    wall_lines: Vec<u64>,
    arc_lines: Vec<u64>,
}

/// Parses and checks a world; `path` is for messages.
pub(crate) fn parse(path: &Path, source: &str) -> Result<World> {
    let text = Text::new(path, source);
    let root = DeTable::parse(source).map_err(|e| {
        text.fail(
            &e.span().unwrap_or_default(),
            format!("not TOML: {} (numbers are written like 0.5, texts in quotes)", e.message()),
        )
    })?;
    let top = Part { text: &text, name: "a world", table: root.get_ref(), at: 0..0 };
    top.check(&TOP)?;
    let classes = top.words("classes")?;
    let declared = !classes.is_empty();
    for (k, class) in classes.iter().enumerate() {
        if class.is_empty() || classes[..k].contains(class) {
            let what = format!("classes: {class:?} stands twice or is empty: give each class a name of its own");
            return Err(text.fail(&top.place("classes"), what));
        }
    }
    let mut b = Builder {
        text: &text,
        classes,
        declared,
        walls: Vec::new(),
        arcs: Vec::new(),
        closed: Vec::new(),
        wall_lines: Vec::new(),
        arc_lines: Vec::new(),
    };
    for part in parts(&top, "outline", "[[outline]]")? {
        b.outline(&part)?;
    }
    for part in parts(&top, "wall", "[[wall]]")? {
        b.polyline(&part)?;
    }
    for part in parts(&top, "box", "[[box]]")? {
        b.rectangle(&part)?;
    }
    for part in parts(&top, "circle", "[[circle]]")? {
        b.circle(&part)?;
    }
    let mut way: Option<Way> = None;
    for part in parts(&top, "path", "[path]")? {
        way = Some(path::read(&part)?);
    }
    for part in parts(&top, "campus", "[campus]")? {
        let classes = [b.class_of("wall", &part.at)?, b.class_of("furniture", &part.at)?];
        let built = campus::build(&Campus::read(&part)?, classes);
        let line = text.line(&part.at);
        b.wall_lines.extend(std::iter::repeat_n(line, built.walls.len()));
        b.walls.extend(built.walls);
        way = way.or(Some(Way::along(built.path, line)));
    }
    if b.walls.is_empty() && b.arcs.is_empty() {
        return Err(crate::Error::input(
            path,
            "the world is empty: add an [[outline]], a [[wall]], a [[box]] or a [[circle]]",
        ));
    }
    let way = way.ok_or_else(|| {
        crate::Error::input(
            path,
            "the world has no [path]: add one, with points = [[x, y], …] and step, or poses = [[x, y, heading], …]",
        )
    })?;
    let rig_part = parts(&top, "rig", "[rig]")?;
    let sensors = parts(&top, "sensor", "[[sensor]]")?;
    let rig = Rig::read(rig_part.first(), &sensors)?;
    let bounds = index::bounds(&b.walls, &b.arcs);
    let lines: Vec<u64> = b.wall_lines.iter().chain(&b.arc_lines).copied().collect();
    let index = Index::new(b.walls, b.arcs);
    path::check(&way, &index, &b.closed, &lines, path)?;
    let place = top.get("path").or(top.get("campus")).map_or(0..0, |v| v.span());
    rig.check(&index, &way.stops).map_err(|what| text.fail(&place, what))?;
    let mut corners = corners(&index);
    corners.sort_by(|a, b| a.at.0.total_cmp(&b.at.0).then(a.at.1.total_cmp(&b.at.1)));
    let sha256 = Sha256::digest(source).iter().map(|byte| format!("{byte:02x}")).collect();
    let name = match top.word("name")? {
        Some((name, _)) => name.to_string(),
        None => path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default(),
    };
    Ok(World { name, classes: b.classes, index, corners, stops: way.stops, rig, bounds, sha256 })
}

/// The tables of a name: `[name]` or every `[[name]]`.
fn parts<'a>(top: &Part<'a>, key: &str, name: &'static str) -> Result<Vec<Part<'a>>> {
    let Some(value) = top.get(key) else { return Ok(Vec::new()) };
    let wrong = |at: std::ops::Range<usize>| top.text.fail(&at, format!("{key} is a table: write {name}"));
    let part = |v: &'a toml::Spanned<DeValue<'a>>| match v.get_ref() {
        DeValue::Table(table) => Ok(Part { text: top.text, name, table, at: v.span() }),
        _ => Err(wrong(v.span())),
    };
    match value.get_ref() {
        DeValue::Array(items) if name.starts_with("[[") => items.iter().map(part).collect(),
        DeValue::Table(_) if !name.starts_with("[[") => Ok(vec![part(value)?]),
        _ => Err(wrong(value.span())),
    }
}

impl Builder<'_> {
    fn surface(&self, part: &Part<'_>) -> Result<Surface> {
        part.choice("surface", &SURFACES, Surface::Specular)
    }

    fn class(&mut self, part: &Part<'_>) -> Result<Option<u16>> {
        let Some((name, at)) = part.word("class")? else { return Ok(None) };
        if name.is_empty() {
            return Err(self.text.fail(&at, "class is empty: give it a name, or leave it out"));
        }
        self.class_of(name, &at)
    }

    /// A class' number, from 1; one that isn't known yet is added, unless the file declares its classes.
    fn class_of(&mut self, name: &str, at: &std::ops::Range<usize>) -> Result<Option<u16>> {
        let known = self.classes.iter().position(|c| c == name);
        if known.is_none() && self.declared {
            let names: Vec<&str> = self.classes.iter().map(String::as_str).collect();
            let hint = crate::support::similar::similar(name, &names);
            return Err(self.text.fail(at, format!("class {name:?} isn't in classes{hint}: add it there")));
        }
        let k = known.unwrap_or_else(|| {
            self.classes.push(name.into());
            self.classes.len() - 1
        });
        Ok(u16::try_from(k + 1).ok())
    }

    fn points(&self, part: &Part<'_>, least: usize) -> Result<Vec<(Point, std::ops::Range<usize>)>> {
        let rows = part.need("points", part.rows("points", 2)?, "[[0.0, 0.0], [1.0, 0.0]]")?;
        if rows.len() < least {
            let what = format!("{} points: {} needs at least {least}", rows.len(), part.name);
            return Err(self.text.fail(&part.place("points"), what));
        }
        let points: Vec<_> = rows.into_iter().map(|(r, at)| ((r[0], r[1]), at)).collect();
        for pair in points.windows(2) {
            if distance(pair[0].0, pair[1].0) < SHORTEST {
                let (x, y) = pair[1].0;
                let what = format!("a wall of zero length at [{x}, {y}]: remove the point that stands twice");
                return Err(self.text.fail(&pair[1].1, what));
            }
        }
        Ok(points)
    }

    /// A free side, as a world's file says it.
    fn inside(part: &Part<'_>, default: bool) -> Result<bool> {
        part.choice("free", &[("inside", true), ("outside", false)], default)
    }

    fn outline(&mut self, part: &Part<'_>) -> Result<()> {
        part.check(&["points", "free", "surface", "class"])?;
        let points = self.points(part, 4)?;
        let (first, (last, at)) = (points[0].0, points[points.len() - 1].clone());
        if distance(first, last) > 1e-9 {
            let what = format!(
                "the outline is open: it begins at [{}, {}] and ends at [{}, {}]; repeat the first point at the end, or make it a [[wall]]",
                first.0, first.1, last.0, last.1
            );
            return Err(self.text.fail(&at, what));
        }
        let corners: Vec<Point> = points[1..].iter().map(|p| p.0).collect();
        let lines: Vec<u64> = points[1..].iter().map(|p| self.text.line(&p.1)).collect();
        for i in 0..corners.len() {
            for k in i + 2..corners.len() - usize::from(i == 0) {
                let next = |k: usize| corners[(k + 1) % corners.len()];
                let met = crate::geometry::plane::meet(corners[i], next(i), corners[k], next(k));
                if met.is_some_and(|(t, u)| (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)) {
                    let what = format!(
                        "the outline crosses itself (with the side before line {}): reorder its points",
                        lines[k]
                    );
                    return Err(self.text.fail(&points[i + 1].1, what));
                }
            }
        }
        let inside = Self::inside(part, true)?;
        self.closed(part, &corners, &lines, inside)
    }

    /// A closed outline, its free side put to the left.
    fn closed(&mut self, part: &Part<'_>, corners: &[Point], lines: &[u64], inside: bool) -> Result<()> {
        let (surface, class) = (self.surface(part)?, self.class(part)?);
        let n = corners.len();
        let area: f64 = (0..n).map(|k| cross(corners[k], corners[(k + 1) % n])).sum();
        if area.abs() < SHORTEST * SHORTEST {
            let what = "it encloses nothing: all its points lie on one line; make it a [[wall]]";
            return Err(self.text.fail(&part.at, what));
        }
        self.closed.push(Closed { shape: Outline::Polygon(corners.to_vec()), inside, line: lines[0] });
        for k in 0..n {
            let (p, q) = (corners[k], corners[(k + 1) % n]);
            let (a, b) = if (area > 0.0) == inside { (p, q) } else { (q, p) };
            self.walls.push(Wall { a, b, surface, class, thin: false });
            self.wall_lines.push(lines[(k + 1) % n]);
        }
        Ok(())
    }

    fn polyline(&mut self, part: &Part<'_>) -> Result<()> {
        part.check(&["points", "surface", "class"])?;
        let points = self.points(part, 2)?;
        let (surface, class) = (self.surface(part)?, self.class(part)?);
        for pair in points.windows(2) {
            self.walls.push(Wall { a: pair[0].0, b: pair[1].0, surface, class, thin: true });
            self.wall_lines.push(self.text.line(&pair[1].1));
        }
        Ok(())
    }

    fn rectangle(&mut self, part: &Part<'_>) -> Result<()> {
        part.check(&["centre", "size", "turn", "free", "surface", "class"])?;
        let centre = part.need("centre", part.point("centre")?, "[1.0, 2.0]")?;
        let (w, h) = part.need("size", part.point("size")?, "[0.5, 0.4]")?;
        if w < SHORTEST || h < SHORTEST {
            let what = format!("size [{w}, {h}]: a box needs a width and a height of 1 mm or more");
            return Err(self.text.fail(&part.place("size"), what));
        }
        let (s, c) = part.angle("turn")?.unwrap_or(0.0).sin_cos();
        let corner = |x: f64, y: f64| add(centre, (c * x * w - s * y * h, s * x * w + c * y * h));
        let corners = [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        let line = self.text.line(&part.at);
        let inside = Self::inside(part, false)?;
        self.closed(part, &corners, &[line; 4], inside)
    }

    fn circle(&mut self, part: &Part<'_>) -> Result<()> {
        part.check(&["centre", "radius", "from", "to", "free", "surface", "class"])?;
        let centre = part.need("centre", part.point("centre")?, "[1.0, 2.0]")?;
        let radius = part.need("radius", part.positive("radius")?, "0.2")?;
        if radius < SHORTEST {
            return Err(self.text.fail(&part.place("radius"), format!("radius {radius} m: give 1 mm or more")));
        }
        let (from, sweep) = match (part.angle("from")?, part.angle("to")?) {
            (None, None) => (0.0, TAU),
            (Some(from), Some(to)) if (to - from).abs() >= TAU - 1e-9 => (from, TAU),
            (Some(from), Some(to)) => {
                let sweep = (to - from).rem_euclid(TAU);
                if sweep * radius < SHORTEST {
                    let what = "an arc of less than 1 mm: it goes from `from` to `to`, counter-clockwise; leave out both for a whole circle";
                    return Err(self.text.fail(&part.place("to"), what));
                }
                (from, sweep)
            }
            _ => return Err(self.text.fail(&part.at, "an arc needs both from and to, counter-clockwise")),
        };
        let (inside, surface, class) = (Self::inside(part, false)?, self.surface(part)?, self.class(part)?);
        if sweep < TAU && part.get("free").is_some() {
            let what = "an arc is thin, both its sides are free: remove free, or leave out from and to";
            return Err(self.text.fail(&part.place("free"), what));
        }
        if sweep >= TAU {
            let line = self.text.line(&part.at);
            self.closed.push(Closed { shape: Outline::Circle(centre, radius), inside, line });
        }
        self.arcs.push(Arc { centre, radius, from, sweep, surface, class, inside });
        self.arc_lines.push(self.text.line(&part.at));
        Ok(())
    }
}
