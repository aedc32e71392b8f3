//! Saved maps: a map, a second map and their difference, a truth and the map's errors against it. Opening reads only the maps'
//! descriptions; cells are read where the page shows them.

mod alignment;
mod saved_map;
mod scored_map;
mod session;

use super::legend::class_legend;
use super::protocol::{Cell, CellSource, NamedValue, Session, ViewInfo};
use super::{LayerKey, Pyramid, PyramidLayer, Request, Response, TileId, View, legend, levels};
use crate::grid::{GridSpec, Scale};
use crate::output::Stored;
use crate::{Error, Result};
use alignment::{GridAlignment, LabelGrid};
use saved_map::{COMBINED, MapLayer, SavedMap, cell_class};
use scored_map::ScoredMap;
use std::path::Path;

/// Largest number of bytes of cached tiles.
const TILE_CACHE: u64 = 256 << 20;
/// The difference's key.
const DIFFERENCE: LayerKey = [u32::MAX, 0];
/// Colours of true classes, and of a difference.
const SIGNED: Scale = Scale::Signed { limit: 1.0 };

/// What is shown beside the map.
#[derive(Debug, Clone, Copy, Default)]
pub struct Companions<'a> {
    /// A second map.
    pub with: Option<&'a Path>,
    /// The truth: a world, built in or a TOML file, or a map.
    pub truth: Option<&'a Path>,
    /// Memory that may be used, bytes.
    pub memory: Option<u64>,
}

/// Saved maps, as the page shows them.
pub struct MapView {
    grid: GridSpec,
    sources: Vec<Source>,
    scored: Option<ScoredMap>,
    pyramid: Pyramid,
    session: Session,
}

/// A map or a truth with its views.
struct Source {
    name: String,
    kind: SourceKind,
    views: Vec<MapSourceView>,
}

enum SourceKind {
    Map(Box<SavedMap>),
    Truth,
}

/// A view of a map or a truth.
struct MapSourceView {
    content: ViewContent,
    scale: Scale,
    /// The view as the session lists it, with its name.
    info: ViewInfo,
}

/// What a view's values are.
#[derive(Clone, Copy)]
enum ViewContent {
    /// A layer of a map.
    Map(MapLayer),
    /// The error levels of the first map.
    Levels,
    /// The true classes.
    Truth,
}

impl MapView {
    /// Notes on the truth for the user.
    pub fn notes(&self) -> &[String] {
        self.scored.as_ref().map_or(&[], |s| &s.notes)
    }

    /// Opens a map's folder, and what is shown beside it.
    ///
    /// # Errors
    /// [`Error::Input`] where a folder is no map or its description can't be read; [`Error::Usage`] where the maps' cells
    /// differ in size; [`Error::Resources`] where there isn't the memory to score it against the truth.
    pub fn open(path: &Path, beside: &Companions) -> Result<MapView> {
        let stored = Stored::open(path)?;
        let grid = stored.grid;
        let scored =
            beside.truth.map(|truth| ScoredMap::of(&stored, &name_of(path), truth, beside.memory)).transpose()?;
        let alignment = GridAlignment::of(&grid, &grid, "the map")?;
        let mut sources = vec![Source::map(name_of(path), SavedMap::new(stored, alignment), scored.is_some())];
        if let Some(with) = beside.with {
            let stored = Stored::open(with)?;
            let alignment = GridAlignment::of(&grid, &stored.grid, &with.display().to_string())?;
            sources.push(Source::map(name_of(with), SavedMap::new(stored, alignment), false));
        }
        if let [first, second] = sources.as_mut_slice()
            && first.name == second.name
        {
            // The folders have the same name.
            first.name = path.display().to_string();
            second.name = beside.with.map_or_else(String::new, |p| p.display().to_string());
        }
        sources.extend(scored.as_ref().map(|s| Source::truth(s.name.clone())));
        let tiles = beside.memory.map_or(TILE_CACHE, |m| TILE_CACHE.min(m / 2));
        let pyramid = Pyramid::new(usize::try_from(tiles).unwrap_or(usize::MAX));
        let session = session::session(&name_of(path), &grid, &sources, scored.as_ref());
        Ok(MapView { grid, sources, scored, pyramid, session })
    }

    fn extent(&self) -> [usize; 2] {
        [self.grid.width, self.grid.height]
    }

    fn tile(&self, request: &Request) -> Result<Response> {
        let id = TileId::requested(request, self.extent())?;
        let (source, view) = (request.query_text("source")?, request.query_text("view")?);
        let bytes = match source {
            "difference" => self.difference(view, id)?,
            _ => {
                let number = source.parse::<usize>().ok().filter(|n| *n < self.sources.len());
                let number = number.ok_or_else(|| Error::Usage(format!("there is no source {source}")))?;
                let of = &self.sources[number];
                let index = of.views.iter().position(|v| v.info.name == view);
                let index = index.ok_or_else(|| Error::Usage(format!("{} has no view {view}", of.name)))?;
                let key = [number as u32, index as u32];
                match (of.views[index].content, &of.kind, &self.scored) {
                    (ViewContent::Map(layer), SourceKind::Map(map), _) => {
                        map.tile_png(&self.pyramid, key, layer, id)?
                    }
                    (ViewContent::Levels, _, Some(s)) => self.labels(&s.levels, key, of.views[index].scale, id)?,
                    (ViewContent::Truth, _, Some(s)) => self.labels(&s.truth, key, SIGNED, id)?,
                    _ => None,
                }
            }
        };
        Ok(bytes.map_or(Response::NoContent, |bytes| Response::Bytes("image/png", bytes)))
    }

    /// A tile of labels as PNG.
    fn labels(&self, labels: &LabelGrid, key: LayerKey, scale: Scale, id: TileId) -> Result<Option<Vec<u8>>> {
        let level0 = |tile| labels.tile(tile);
        self.tile_png(&PyramidLayer { key, extent: self.extent(), scale, level0: &level0 }, id)
    }

    fn tile_png(&self, layer: &PyramidLayer, id: TileId) -> Result<Option<Vec<u8>>> {
        self.pyramid.tile(layer, id)?.map(|t| t.to_png(layer.scale)).transpose()
    }

    /// The second map minus the first. Where only one has seen a cell the other counts as 0, which is unknown.
    fn difference(&self, view: &str, id: TileId) -> Result<Option<Vec<u8>>> {
        let pair = map_pair(&self.sources).filter(|_| view == "combined");
        let [a, b] = pair.ok_or_else(|| Error::Usage(format!("there is no difference {view}")))?;
        let level0 = |tile| {
            let of = |map: &SavedMap| map.tile(MapLayer::Combined, tile);
            Ok(match (of(a)?, of(b)?) {
                (None, None) => None,
                (Some(a), None) => Some(a.into_iter().map(|v| -v).collect()),
                (None, Some(b)) => Some(b),
                (Some(a), Some(b)) => Some(a.into_iter().zip(b).map(|(a, b)| difference(b, a)).collect()),
            })
        };
        self.tile_png(&PyramidLayer { key: DIFFERENCE, extent: self.extent(), scale: SIGNED, level0: &level0 }, id)
    }

    fn cell(&self, request: &Request) -> Result<Response> {
        let at = [request.query_number("column")?, request.query_number("row")?];
        let [column, row] = at;
        let [width, height] = self.extent();
        if column >= width || row >= height {
            return Err(Error::Usage(format!("there is no cell {column}, {row}: the map has {width} × {height}")));
        }
        let (x, y) = self.grid.centre(column, row);
        let mut sources = Vec::new();
        for (k, source) in self.sources.iter().enumerate() {
            sources.push(match (&source.kind, &self.scored) {
                (SourceKind::Map(map), scored) => {
                    let mut cell = map.cell(&source.name, at)?;
                    let level = scored.as_ref().filter(|_| k == 0).and_then(|s| s.level(at));
                    cell.values.extend(level.map(|level| NamedValue("error_level".into(), Some(level.into()))));
                    cell
                }
                (SourceKind::Truth, scored) => {
                    let class = scored.as_ref().map_or(0, |s| s.truth.at(at));
                    CellSource {
                        name: source.name.clone(),
                        touched: class != 0,
                        class: cell_class(f64::from(class)),
                        interior: None,
                        arc: None,
                        values: Vec::new(),
                        chosen: None,
                    }
                }
            });
        }
        let (x, y) = (crate::output::tidy(x), crate::output::tidy(y));
        Response::json(&Cell { column, row, x, y, sources })
    }
}

impl View for MapView {
    fn respond(&self, request: &Request) -> Result<Response> {
        match (request.post, request.path) {
            (false, "api/session") => Response::json(&self.session),
            (false, "api/tile") => self.tile(request),
            (false, "api/cell") => self.cell(request),
            _ => Ok(Response::NotFound),
        }
    }
}

/// The two maps of a difference, if there is one: their cells must coincide.
fn map_pair(sources: &[Source]) -> Option<[&SavedMap; 2]> {
    match sources {
        [Source { kind: SourceKind::Map(a), .. }, Source { kind: SourceKind::Map(b), .. }, ..] => {
            b.alignment.exact.then_some([a.as_ref(), b.as_ref()])
        }
        _ => None,
    }
}

/// `b − a`; an unknown value counts as 0 where the other is known.
fn difference(b: f32, a: f32) -> f32 {
    match (b.is_nan(), a.is_nan()) {
        (true, true) => f32::NAN,
        (true, false) => -a,
        (false, true) => b,
        (false, false) => b - a,
    }
}

/// The name of a folder, or of a file without its extension.
fn name_of(path: &Path) -> String {
    let resolved = path.canonicalize();
    let path = resolved.as_deref().unwrap_or(path);
    let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
    name.map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned())
}
