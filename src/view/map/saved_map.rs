//! A saved map: tiles of its combined layer from the levels that are stored with it, tiles of its layers from their cells.

use super::alignment::GridAlignment;
use crate::Result;
use crate::evaluate::score::probabilities;
use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use crate::output::{Pieces, Stored};
use crate::view::cache::Cache;
use crate::view::protocol::{CellClass, CellSource, NamedValue};
use crate::view::{EDGE, LayerKey, Pyramid, PyramidLayer, TileId, pixels, tile};
use serde_json::Number;
use std::sync::{Arc, Mutex, PoisonError};

/// The combined layer's colours.
pub(super) const COMBINED: Scale = Scale::Signed { limit: 1.0 };
/// The palette entry of 0, and the number of entries between 0 and 1.
const MIDDLE: f32 = 128.0;
const STEPS: f32 = 127.0;
/// Bytes of cached pieces.
const PIECE_CACHE: usize = 64 << 20;
/// The layers from which the combined layer of a map without an overview is computed.
const EVIDENCE: [&str; 10] = ["p_occ", "full", "unknown", "occ", "map", "count", "hits", "passes", "class", "touched"];

/// Where a piece is stored: in a layer, or in a level of the overview.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum PieceSource {
    Layer(usize),
    Overview(usize),
}

type PieceCache = Cache<(PieceSource, [usize; 2]), Option<Arc<Data>>>;

/// A map on disk, aligned with the base grid.
pub(super) struct SavedMap {
    pub stored: Stored,
    pub alignment: GridAlignment,
    touched: Option<usize>,
    class: Option<usize>,
    pieces: Mutex<PieceCache>,
}

/// What is shown of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MapLayer {
    /// The combined layer, computed from its evidence.
    Combined,
    /// A layer by its number.
    Layer(usize),
}

impl SavedMap {
    /// A map at its position on the base grid.
    pub fn new(stored: Stored, alignment: GridAlignment) -> SavedMap {
        let (touched, class) = (stored.layer("touched"), stored.layer("class"));
        SavedMap { stored, alignment, touched, class, pieces: Mutex::new(Cache::new(PIECE_CACHE)) }
    }

    /// A tile as PNG; `None` where no reading reached any of it.
    pub fn tile_png(&self, pyramid: &Pyramid, key: LayerKey, layer: MapLayer, id: TileId) -> Result<Option<Vec<u8>>> {
        let scale = match layer {
            MapLayer::Combined => COMBINED,
            MapLayer::Layer(k) => self.stored.layers[k].scale,
        };
        let levels = self.stored.overview.len();
        if layer == MapLayer::Combined && self.alignment.is_base() && levels > 0 {
            if id.level < levels {
                return self.stored_tile_png(id);
            }
            // Levels above the stored ones are built from the last of them.
            let last = levels - 1;
            let level0 = |piece: [usize; 2]| Ok(self.entries(last, piece)?.map(|e| values(&e)));
            let tiles = PyramidLayer { key, extent: pixels(self.alignment.extent, last), scale, level0: &level0 };
            let found = pyramid.tile(&tiles, TileId { level: id.level - last, ..id })?;
            return found.map(|t| t.to_png(scale)).transpose();
        }
        let level0 = |tile: [usize; 2]| self.tile(layer, tile);
        let tiles = PyramidLayer { key, extent: self.alignment.base(), scale, level0: &level0 };
        pyramid.tile(&tiles, id)?.map(|t| t.to_png(scale)).transpose()
    }

    /// A tile of a stored level as PNG: the stored palette entries are the pixels.
    fn stored_tile_png(&self, id: TileId) -> Result<Option<Vec<u8>>> {
        let entries = self.entries(id.level, [id.column, id.row])?.filter(|e| e.iter().any(|e| *e != 0));
        entries.map(|e| tile::encode_png(id.extent(self.alignment.extent), COMBINED, e)).transpose()
    }

    /// The values of a tile of level 0.
    pub fn tile(&self, layer: MapLayer, at: [usize; 2]) -> Result<Option<Vec<f32>>> {
        if self.alignment.is_base() {
            return self.values(layer, at);
        }
        self.alignment.tile(at, |piece| Ok(self.values(layer, piece)?.map(Arc::new)))
    }

    /// A piece's values, NaN where no reading reached.
    fn values(&self, layer: MapLayer, at: [usize; 2]) -> Result<Option<Vec<f32>>> {
        match layer {
            MapLayer::Combined if !self.stored.overview.is_empty() => Ok(self.entries(0, at)?.map(|e| values(&e))),
            MapLayer::Combined => self.combined(at),
            MapLayer::Layer(k) => {
                let Some(touched) = self.touched(at)? else { return Ok(None) };
                let data = self.piece(PieceSource::Layer(k), at)?;
                let fill = self.stored.layers[k].fill as f32;
                let value = |(n, touched): (usize, &u8)| match (touched, &data) {
                    (0, _) => f32::NAN,
                    (_, None) => fill,
                    (_, Some(data)) => data.get(n) as f32,
                };
                Ok(Some(touched.iter().enumerate().map(value).collect()))
            }
        }
    }

    /// Which cells of a piece a reading reached; `None` where it reached none.
    fn touched(&self, at: [usize; 2]) -> Result<Option<Vec<u8>>> {
        let Some(layer) = self.touched else { return Ok(None) };
        let data = self.piece(PieceSource::Layer(layer), at)?;
        Ok(match data.as_deref() {
            Some(Data::U8(touched)) if touched.iter().any(|t| *t != 0) => Some(touched.clone()),
            _ => None,
        })
    }

    /// The combined layer of a map that was saved without it, from its probabilities of occupied.
    fn combined(&self, at: [usize; 2]) -> Result<Option<Vec<f32>>> {
        let Some(touched) = self.touched(at)? else { return Ok(None) };
        let [width, height] = TileId { level: 0, column: at[0], row: at[1] }.extent(self.alignment.extent);
        let layer = |(k, of): (usize, &crate::output::StoredLayer)| -> Result<Layer> {
            let data = self.piece(PieceSource::Layer(k), at)?;
            let data = data.map_or_else(|| Data::F32(vec![of.fill as f32; width * height]), |d| (*d).clone());
            Ok(Layer { name: of.name.clone(), about: "", data, fill: of.fill, scale: of.scale })
        };
        let evidence = self.stored.layers.iter().enumerate().filter(|(_, l)| EVIDENCE.contains(&l.name.as_str()));
        let layers = evidence.map(layer).collect::<Result<Vec<Layer>>>()?;
        let grid = GridSpec { width, height, ..self.stored.grid };
        let map = Map { grid, method: self.stored.method.clone(), layers, updates: 0, increments: Vec::new() };
        let value = |(p, touched): (f32, &u8)| if *touched != 0 { 2.0 * p - 1.0 } else { f32::NAN };
        Ok(Some(probabilities(&map).into_iter().zip(&touched).map(value).collect()))
    }

    /// Palette entries of a piece of a level of the overview.
    fn entries(&self, level: usize, at: [usize; 2]) -> Result<Option<Vec<u8>>> {
        let data = self.piece(PieceSource::Overview(level), at)?;
        Ok(match data.as_deref() {
            Some(Data::U8(entries)) => Some(entries.clone()),
            _ => None,
        })
    }

    /// A piece, from the cache or from disk.
    fn piece(&self, of: PieceSource, at: [usize; 2]) -> Result<Option<Arc<Data>>> {
        if let Some(piece) = self.pieces.lock().unwrap_or_else(PoisonError::into_inner).get(&(of, at)) {
            return Ok(piece);
        }
        let pieces: &Pieces = match of {
            PieceSource::Layer(k) => &self.stored.layers[k].pieces,
            PieceSource::Overview(k) => &self.stored.overview[k],
        };
        let piece = pieces.read(at)?.map(Arc::new);
        let bytes = piece.as_ref().map_or(0, |data| data.len() * pieces.value_bytes());
        self.pieces.lock().unwrap_or_else(PoisonError::into_inner).insert((of, at), piece.clone(), bytes);
        Ok(piece)
    }

    /// The map's state at a cell of the base grid.
    pub fn cell(&self, name: &str, cell: [usize; 2]) -> Result<CellSource> {
        let own = self.alignment.cell(cell);
        let value = |layer: usize| -> Result<Option<Number>> {
            let Some([column, row]) = own else { return Ok(None) };
            let at = [column / EDGE, row / EDGE];
            let width = EDGE.min(self.alignment.extent[0] - at[0] * EDGE);
            Ok(match self.piece(PieceSource::Layer(layer), at)?.as_deref() {
                Some(data) => stored_number(data, row % EDGE * width + column % EDGE),
                None => number(self.stored.layers[layer].fill),
            })
        };
        let of = |layer: Option<usize>| -> Result<f64> {
            let number = layer.map_or(Ok(None), value)?;
            Ok(number.and_then(|n| n.as_f64()).unwrap_or_default())
        };
        let (touched, class) = (of(self.touched)? != 0.0, cell_class(of(self.class)?));
        let others = (0..self.stored.layers.len()).filter(|k| ![self.touched, self.class].contains(&Some(*k)));
        let values = others.map(|k| Ok(NamedValue(self.stored.layers[k].name.clone(), value(k)?)));
        let (name, values) = (name.into(), values.collect::<Result<_>>()?);
        Ok(CellSource { name, touched, class, interior: None, arc: None, values, chosen: None })
    }
}

/// A class layer's value as a class.
pub(super) fn cell_class(class: f64) -> CellClass {
    match class {
        c if c > 0.0 => CellClass::Occupied,
        c if c < 0.0 => CellClass::Empty,
        _ => CellClass::Unknown,
    }
}

/// The values of palette entries.
fn values(entries: &[u8]) -> Vec<f32> {
    entries.iter().map(|e| if *e == 0 { f32::NAN } else { (f32::from(*e) - MIDDLE) / STEPS }).collect()
}

/// A stored value as JSON; an f32 in its own shortest digits.
fn stored_number(data: &Data, k: usize) -> Option<Number> {
    match data {
        Data::F32(v) => v.get(k).and_then(|v| v.to_string().parse().ok()).and_then(Number::from_f64),
        _ => number(data.get(k)),
    }
}

/// A number as JSON, without a decimal point where it is whole.
fn number(value: f64) -> Option<Number> {
    if value.fract() == 0.0 && value.abs() < 1e15 { Some((value as i64).into()) } else { Number::from_f64(value) }
}
