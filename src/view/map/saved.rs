//! A saved map as something to look at: its combined layer from the levels that are stored with it, its layers from their cells.

use super::plane::Laid;
use crate::Result;
use crate::evaluate::score::probabilities;
use crate::grid::{Data, GridSpec, Layer, Map, Scale};
use crate::output::{Pieces, Stored};
use crate::view::cache::Cache;
use crate::view::{EDGE, Key, Place, Pyramid, Shown, pixels, tile};
use serde_json::{Value, json};
use std::sync::{Arc, Mutex, PoisonError};

/// The combined layer's colours.
pub(super) const COMBINED: Scale = Scale::Signed { limit: 1.0 };
/// Palette entry of 0, and how many entries 1 is from it.
const MIDDLE: f32 = 128.0;
const STEPS: f32 = 127.0;
/// Bytes of pieces that are kept.
const KEPT: usize = 64 << 20;
/// What a map without an overview is made its combined layer from.
const EVIDENCE: [&str; 10] = ["p_occ", "full", "unknown", "occ", "map", "count", "hits", "passes", "class", "touched"];

/// Which of a map's pieces: a layer's, or those of a level of its overview.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Of {
    Layer(usize),
    Overview(usize),
}

type Kept = Cache<(Of, [usize; 2]), Option<Arc<Data>>>;

/// A map on disk, laid on the grid that is looked at.
pub(super) struct Saved {
    pub stored: Stored,
    pub laid: Laid,
    touched: Option<usize>,
    class: Option<usize>,
    kept: Mutex<Kept>,
}

/// What of a map is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum What {
    Combined,
    Layer(usize),
}

impl Saved {
    /// A map, laid.
    pub fn new(stored: Stored, laid: Laid) -> Saved {
        let (touched, class) = (stored.layer("touched"), stored.layer("class"));
        Saved { stored, laid, touched, class, kept: Mutex::new(Cache::new(KEPT)) }
    }

    /// A tile's PNG; `None`: no reading reached any of it.
    pub fn picture(&self, pyramid: &Pyramid, key: Key, what: What, at: Place) -> Result<Option<Vec<u8>>> {
        let scale = match what {
            What::Combined => COMBINED,
            What::Layer(k) => self.stored.layers[k].scale,
        };
        let levels = self.stored.overview.len();
        if what == What::Combined && self.laid.same() && levels > 0 {
            if at.level < levels {
                return self.stored_level(at);
            }
            // What lies above the stored levels is made from the last of them.
            let last = levels - 1;
            let base = |piece: [usize; 2]| Ok(self.entries(last, piece)?.map(|e| values(&e)));
            let shown = Shown { key, extent: pixels(self.laid.extent, last), scale, base: &base };
            let found = pyramid.tile(&shown, Place { level: at.level - last, ..at })?;
            return found.map(|t| t.picture(scale)).transpose();
        }
        let base = |tile: [usize; 2]| self.tile(what, tile);
        let shown = Shown { key, extent: self.laid.on(), scale, base: &base };
        pyramid.tile(&shown, at)?.map(|t| t.picture(scale)).transpose()
    }

    /// A tile of a level that is stored: its palette entries are those of the picture.
    fn stored_level(&self, at: Place) -> Result<Option<Vec<u8>>> {
        let entries = self.entries(at.level, [at.column, at.row])?.filter(|e| e.iter().any(|e| *e != 0));
        entries.map(|e| tile::picture(at.extent(self.laid.extent), COMBINED, e)).transpose()
    }

    /// The values that a tile of level 0 shows.
    pub fn tile(&self, what: What, at: [usize; 2]) -> Result<Option<Vec<f32>>> {
        if self.laid.same() {
            return self.values(what, at);
        }
        self.laid.tile(at, |piece| Ok(self.values(what, piece)?.map(Arc::new)))
    }

    /// A piece's values, not a number where no reading reached.
    fn values(&self, what: What, at: [usize; 2]) -> Result<Option<Vec<f32>>> {
        match what {
            What::Combined if !self.stored.overview.is_empty() => Ok(self.entries(0, at)?.map(|e| values(&e))),
            What::Combined => self.combined(at),
            What::Layer(k) => {
                let Some(touched) = self.touched(at)? else { return Ok(None) };
                let data = self.piece(Of::Layer(k), at)?;
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

    /// Which cells of a piece a reading reached; `None`: none of them.
    fn touched(&self, at: [usize; 2]) -> Result<Option<Vec<u8>>> {
        let Some(layer) = self.touched else { return Ok(None) };
        let data = self.piece(Of::Layer(layer), at)?;
        Ok(match data.as_deref() {
            Some(Data::U8(touched)) if touched.iter().any(|t| *t != 0) => Some(touched.clone()),
            _ => None,
        })
    }

    /// The combined layer of a map that was written without: from its probabilities of occupied.
    fn combined(&self, at: [usize; 2]) -> Result<Option<Vec<f32>>> {
        let Some(touched) = self.touched(at)? else { return Ok(None) };
        let [width, height] = Place { level: 0, column: at[0], row: at[1] }.extent(self.laid.extent);
        let layer = |(k, of): (usize, &crate::output::StoredLayer)| -> Result<Layer> {
            let data = self.piece(Of::Layer(k), at)?;
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
        let data = self.piece(Of::Overview(level), at)?;
        Ok(match data.as_deref() {
            Some(Data::U8(entries)) => Some(entries.clone()),
            _ => None,
        })
    }

    /// A piece, from what is kept or from disk.
    fn piece(&self, of: Of, at: [usize; 2]) -> Result<Option<Arc<Data>>> {
        if let Some(piece) = self.kept.lock().unwrap_or_else(PoisonError::into_inner).get(&(of, at)) {
            return Ok(piece);
        }
        let pieces: &Pieces = match of {
            Of::Layer(k) => &self.stored.layers[k].pieces,
            Of::Overview(k) => &self.stored.overview[k],
        };
        let piece = pieces.read(at)?.map(Arc::new);
        let bytes = piece.as_ref().map_or(0, |data| data.len() * pieces.value_bytes());
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).put((of, at), piece.clone(), bytes);
        Ok(piece)
    }

    /// What the map says of a cell of the grid that is looked at.
    pub fn cell(&self, name: &str, cell: [usize; 2]) -> Result<Value> {
        let own = self.laid.cell(cell);
        let value = |layer: usize| -> Result<Value> {
            let Some([column, row]) = own else { return Ok(Value::Null) };
            let at = [column / EDGE, row / EDGE];
            let width = EDGE.min(self.laid.extent[0] - at[0] * EDGE);
            let piece = self.piece(Of::Layer(layer), at)?;
            let stored = piece.as_deref().map(|data| number(data, row % EDGE * width + column % EDGE));
            Ok(stored.unwrap_or_else(|| plain(self.stored.layers[layer].fill)))
        };
        let of = |layer: Option<usize>| layer.map_or(Ok(Value::Null), value);
        let (touched, class) = (of(self.touched)?, of(self.class)?);
        let others = (0..self.stored.layers.len()).filter(|k| ![self.touched, self.class].contains(&Some(*k)));
        let values =
            others.map(|k| Ok(json!([self.stored.layers[k].name, value(k)?]))).collect::<Result<Vec<Value>>>()?;
        Ok(json!({
            "name": name,
            "touched": touched.as_f64().is_some_and(|t| t != 0.0),
            "class": class_name(class.as_f64().unwrap_or_default()),
            "values": values,
        }))
    }
}

/// A class's name.
pub(super) fn class_name(class: f64) -> &'static str {
    match class {
        c if c > 0.0 => "occupied",
        c if c < 0.0 => "empty",
        _ => "unknown",
    }
}

/// What palette entries stand for.
fn values(entries: &[u8]) -> Vec<f32> {
    entries.iter().map(|e| if *e == 0 { f32::NAN } else { (f32::from(*e) - MIDDLE) / STEPS }).collect()
}

/// A value as JSON: whole as such, f32 with the digits that it has.
fn number(data: &Data, k: usize) -> Value {
    match data {
        Data::F32(v) => v.get(k).map_or(Value::Null, |v| json!(v.to_string().parse::<f64>().ok())),
        _ => plain(data.get(k)),
    }
}

/// A number, without a point where it is whole.
fn plain(value: f64) -> Value {
    if value.fract() == 0.0 && value.abs() < 1e15 { json!(value as i64) } else { json!(value) }
}
