//! Saved maps to look at: a map, another one beside it and their difference, the truth and the map's errors against it. What is opened
//! is only what describes them; cells are read where a page looks.

mod plane;
mod saved;
mod scored;
mod session;

use super::legend::classed;
use super::{Answer, Ask, Key, Place, Pyramid, Shown, View, legend, levels};
use crate::grid::{GridSpec, Scale};
use crate::output::Stored;
use crate::{Error, Result};
use plane::{Laid, Plane};
use saved::{COMBINED, Saved, What, class_name};
use scored::Scored;
use serde_json::{Value, json};
use std::path::Path;

/// Bytes of tiles that are kept, at most.
const TILES: u64 = 256 << 20;
/// The difference's key.
const DIFFERENCE: Key = [u32::MAX, 0];
/// Colours of true classes, and of a difference.
const SIGNED: Scale = Scale::Signed { limit: 1.0 };

/// What is looked at, beside the map.
#[derive(Debug, Clone, Copy, Default)]
pub struct Beside<'a> {
    /// Another map.
    pub with: Option<&'a Path>,
    /// What is true: a world, built in or a TOML file, or a map.
    pub truth: Option<&'a Path>,
    /// Memory that may be used, bytes.
    pub memory: Option<u64>,
}

/// Saved maps, as a page sees them.
pub struct MapView {
    grid: GridSpec,
    sources: Vec<Source>,
    scored: Option<Scored>,
    pyramid: Pyramid,
    session: Value,
}

/// Something with views.
struct Source {
    name: String,
    kind: Kind,
    views: Vec<Shape>,
}

enum Kind {
    Map(Box<Saved>),
    Truth,
}

/// A view: its name, what is shown, how.
struct Shape {
    name: String,
    show: Show,
    scale: Scale,
    /// As the session lists it.
    listed: Value,
}

#[derive(Clone, Copy)]
enum Show {
    Map(What),
    Levels,
    Truth,
}

impl MapView {
    /// What a user should know of the truth.
    pub fn notes(&self) -> &[String] {
        self.scored.as_ref().map_or(&[], |s| &s.notes)
    }

    /// Opens a map's folder, and what is looked at beside it.
    ///
    /// # Errors
    /// [`Error::Input`] where a folder is no map or what describes it can't be read; [`Error::Usage`] where the maps' cells
    /// are not of one size; [`Error::Resources`] where there isn't the memory to score it against the truth.
    pub fn open(path: &Path, beside: &Beside) -> Result<MapView> {
        let stored = Stored::open(path)?;
        let grid = stored.grid;
        let scored = beside.truth.map(|truth| Scored::of(&stored, &name_of(path), truth, beside.memory)).transpose()?;
        let laid = Laid::of(&grid, &grid, "the map")?;
        let mut sources = vec![Source::map(name_of(path), Saved::new(stored, laid), scored.is_some())];
        if let Some(with) = beside.with {
            let stored = Stored::open(with)?;
            let laid = Laid::of(&grid, &stored.grid, &with.display().to_string())?;
            sources.push(Source::map(name_of(with), Saved::new(stored, laid), false));
        }
        if let [first, second] = sources.as_mut_slice()
            && first.name == second.name
        {
            // the folders' names don't tell them apart
            first.name = path.display().to_string();
            second.name = beside.with.map_or_else(String::new, |p| p.display().to_string());
        }
        sources.extend(scored.as_ref().map(|s| Source::truth(s.name.clone())));
        let tiles = beside.memory.map_or(TILES, |m| TILES.min(m / 2));
        let pyramid = Pyramid::new(usize::try_from(tiles).unwrap_or(usize::MAX));
        let mut view = MapView { grid, sources, scored, pyramid, session: Value::Null };
        view.session = view.describe(&name_of(path));
        Ok(view)
    }

    fn extent(&self) -> [usize; 2] {
        [self.grid.width, self.grid.height]
    }

    fn tile(&self, ask: &Ask) -> Result<Answer> {
        let at = Place::asked(ask, self.extent())?;
        let (source, view) = (ask.text("source")?, ask.text("view")?);
        let bytes = match source {
            "difference" => self.difference(view, at)?,
            _ => {
                let number = source.parse::<usize>().ok().filter(|n| *n < self.sources.len());
                let number = number.ok_or_else(|| Error::Usage(format!("there is no source {source}")))?;
                let of = &self.sources[number];
                let index = of.views.iter().position(|v| v.name == view);
                let index = index.ok_or_else(|| Error::Usage(format!("{} has no view {view}", of.name)))?;
                let key = [number as u32, index as u32];
                match (of.views[index].show, &of.kind, &self.scored) {
                    (Show::Map(what), Kind::Map(map), _) => map.picture(&self.pyramid, key, what, at)?,
                    (Show::Levels, _, Some(s)) => self.plane(&s.levels, key, of.views[index].scale, at)?,
                    (Show::Truth, _, Some(s)) => self.plane(&s.truth, key, SIGNED, at)?,
                    _ => None,
                }
            }
        };
        Ok(bytes.map_or(Answer::Nothing, |bytes| Answer::Bytes("image/png", bytes)))
    }

    fn plane(&self, plane: &Plane, key: Key, scale: Scale, at: Place) -> Result<Option<Vec<u8>>> {
        let base = |tile| plane.tile(tile);
        self.shown(key, scale, at, &base)
    }

    fn shown(
        &self,
        key: Key,
        scale: Scale,
        at: Place,
        base: &(dyn Fn([usize; 2]) -> Result<Option<Vec<f32>>> + Sync),
    ) -> Result<Option<Vec<u8>>> {
        let shown = Shown { key, extent: self.extent(), scale, base };
        self.pyramid.tile(&shown, at)?.map(|t| t.picture(scale)).transpose()
    }

    /// The two maps, if there is a difference to show: both have cells of one size, that fall on one another.
    fn pair(&self) -> Option<[&Saved; 2]> {
        match &self.sources[..] {
            [Source { kind: Kind::Map(a), .. }, Source { kind: Kind::Map(b), .. }, ..] => {
                b.laid.exact.then_some([a.as_ref(), b.as_ref()])
            }
            _ => None,
        }
    }

    /// The second map less the first. Where only one has seen a cell, the other counts as 0: it knows nothing.
    fn difference(&self, view: &str, at: Place) -> Result<Option<Vec<u8>>> {
        let pair = self.pair().filter(|_| view == "combined");
        let [a, b] = pair.ok_or_else(|| Error::Usage(format!("there is no difference {view}")))?;
        let base = |tile| {
            let of = |map: &Saved| map.tile(What::Combined, tile);
            Ok(match (of(a)?, of(b)?) {
                (None, None) => None,
                (Some(a), None) => Some(a.into_iter().map(|v| -v).collect()),
                (None, Some(b)) => Some(b),
                (Some(a), Some(b)) => Some(a.into_iter().zip(b).map(|(a, b)| less(b, a)).collect()),
            })
        };
        self.shown(DIFFERENCE, SIGNED, at, &base)
    }

    fn cell(&self, ask: &Ask) -> Result<Answer> {
        let at = [ask.number("column")?, ask.number("row")?];
        let [column, row] = at;
        let [width, height] = self.extent();
        if column >= width || row >= height {
            return Err(Error::Usage(format!("there is no cell {column}, {row}: the map has {width} × {height}")));
        }
        let (x, y) = self.grid.centre(column, row);
        let mut sources = Vec::new();
        for (k, source) in self.sources.iter().enumerate() {
            sources.push(match (&source.kind, &self.scored) {
                (Kind::Map(map), scored) => {
                    let mut cell = map.cell(&source.name, at)?;
                    let level = scored.as_ref().filter(|_| k == 0).and_then(|s| s.level(at));
                    if let (Some(level), Some(values)) = (level, cell["values"].as_array_mut()) {
                        values.push(json!(["error_level", level]));
                    }
                    cell
                }
                (Kind::Truth, scored) => {
                    let class = scored.as_ref().map_or(0, |s| s.truth.at(at));
                    let class_name = class_name(f64::from(class));
                    json!({"name": source.name, "touched": class != 0, "class": class_name, "values": []})
                }
            });
        }
        let (x, y) = (crate::output::tidy(x), crate::output::tidy(y));
        Ok(Answer::Json(json!({"column": column, "row": row, "x": x, "y": y, "sources": sources})))
    }
}

impl View for MapView {
    fn answer(&self, ask: &Ask) -> Result<Answer> {
        match (ask.post, ask.path) {
            (false, "api/session") => Ok(Answer::Json(self.session.clone())),
            (false, "api/tile") => self.tile(ask),
            (false, "api/cell") => self.cell(ask),
            _ => Ok(Answer::Unknown),
        }
    }
}

/// `b − a`; what isn't known counts as 0 where the other is.
fn less(b: f32, a: f32) -> f32 {
    match (b.is_nan(), a.is_nan()) {
        (true, true) => f32::NAN,
        (true, false) => -a,
        (false, true) => b,
        (false, false) => b - a,
    }
}

/// What a folder or file is called, without what comes before and after its name.
fn name_of(path: &Path) -> String {
    let resolved = path.canonicalize();
    let path = resolved.as_deref().unwrap_or(path);
    let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
    name.map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned())
}
