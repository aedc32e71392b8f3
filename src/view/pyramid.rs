//! Image pyramids of layers, built on demand: a tile from the four below it, those of level 0 from a function of the layer. Tiles are
//! cached in bounded memory until they are invalidated.

use super::cache::Cache;
use super::tile::{EDGE, Tile, TileId};
use crate::Result;
use crate::grid::Scale;
use crate::output::png;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The identity of a layer, such as the number of a source and that of its view.
pub type LayerKey = [u32; 2];

/// How many of the last invalidations are remembered.
const REMEMBERED: usize = 256;

/// A layer whose tiles are requested.
pub struct PyramidLayer<'a> {
    /// Its key; two layers never share one.
    pub key: LayerKey,
    /// Columns and rows of its grid.
    pub extent: [usize; 2],
    /// Its colours, which decide how four values are reduced to one.
    pub scale: Scale,
    /// The values of the tile of level 0 in a column and row of tiles, row by row from the bottom, NaN where no reading reached;
    /// `None` where none reached any of it. Called on several of rayon's threads at once. It must not wait for a lock whose
    /// holder waits for rayon: hold such a lock around [`Pyramid::tile`] instead.
    pub level0: &'a (dyn Fn([usize; 2]) -> Result<Option<Vec<f32>>> + Sync),
}

/// The cached tiles of several layers.
#[derive(Debug)]
pub struct Pyramid {
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    tiles: Cache<(LayerKey, TileId), Option<Arc<Tile>>>,
    /// How many invalidations there were.
    invalidations: u64,
    /// The last of them: a tile whose construction began before is not cached. `None`: all of the layer.
    recent: VecDeque<(LayerKey, Option<Vec<[usize; 2]>>)>,
}

impl Pyramid {
    /// An empty pyramid whose cache holds at most so many bytes.
    pub fn new(bytes: usize) -> Pyramid {
        Pyramid { state: Mutex::new(State { tiles: Cache::new(bytes), invalidations: 0, recent: VecDeque::new() }) }
    }

    /// A tile of a layer; `None` where no reading reached any of it, or it lies outside the grid.
    ///
    /// # Errors
    /// Those of [`PyramidLayer::level0`].
    pub fn tile(&self, layer: &PyramidLayer, id: TileId) -> Result<Option<Arc<Tile>>> {
        self.find_or_build(layer, id, true)
    }

    /// Invalidates these tiles of level 0 (column, row) of a layer, and all above them.
    pub fn invalidate(&self, key: LayerKey, tiles: &[[usize; 2]]) {
        let mut state = self.state();
        state.record(key, Some(tiles.to_vec()));
        let mut level = tiles.to_vec();
        // A grid has at most 2^24 cells a side.
        for k in 0..=24 {
            level.sort_unstable();
            level.dedup();
            for [column, row] in &mut level {
                state.tiles.remove(&(key, TileId { level: k, column: *column, row: *row }));
                (*column, *row) = (*column / 2, *row / 2);
            }
        }
    }

    /// Invalidates all tiles of a layer.
    pub fn clear(&self, key: LayerKey) {
        let mut state = self.state();
        state.record(key, None);
        state.tiles.retain(|(k, _)| *k != key);
    }

    /// Finds a tile or builds it. A tile of level 0 that was not itself `requested` is cached only where there is room: it is
    /// faster to build than those above it.
    fn find_or_build(&self, layer: &PyramidLayer, id: TileId, requested: bool) -> Result<Option<Arc<Tile>>> {
        let extent = id.extent(layer.extent);
        if extent.contains(&0) {
            return Ok(None);
        }
        let begun = {
            let mut state = self.state();
            if let Some(tile) = state.tiles.get(&(layer.key, id)) {
                return Ok(tile);
            }
            state.invalidations
        };
        let values = match id.children() {
            None => (layer.level0)([id.column, id.row])?,
            Some(children) => self.reduce(layer, extent, &children)?,
        };
        let some = values.filter(|v| v.iter().any(|v| !v.is_nan()));
        let tile = some.map(|values| Arc::new(Tile { extent, values }));
        let bytes = tile.as_ref().map_or(0, |t| 4 * t.values.len());
        let mut state = self.state();
        if !state.is_stale(layer.key, id, begun) && (requested || id.level > 0 || state.tiles.has_room(bytes)) {
            state.tiles.insert((layer.key, id), tile.clone(), bytes);
        }
        Ok(tile)
    }

    /// A tile's values from those of its children.
    fn reduce(&self, layer: &PyramidLayer, extent: [usize; 2], children: &[TileId; 4]) -> Result<Option<Vec<f32>>> {
        let quarters =
            children.par_iter().map(|id| self.find_or_build(layer, *id, false)).collect::<Result<Vec<_>>>()?;
        if quarters.iter().all(Option::is_none) {
            return Ok(None);
        }
        let mut values = vec![f32::NAN; extent[0] * extent[1]];
        for (k, quarter) in quarters.iter().enumerate() {
            let Some(quarter) = quarter else { continue };
            let ([width, _], half) = png::half(layer.scale, quarter.extent, &quarter.values);
            let (left, bottom) = (k % 2 * EDGE / 2, k / 2 * EDGE / 2);
            for (row, line) in half.chunks_exact(width).enumerate() {
                values[(bottom + row) * extent[0] + left..][..width].copy_from_slice(line);
            }
        }
        Ok(Some(values))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn record(&mut self, key: LayerKey, tiles: Option<Vec<[usize; 2]>>) {
        self.invalidations += 1;
        self.recent.push_back((key, tiles));
        if self.recent.len() > REMEMBERED {
            self.recent.pop_front();
        }
    }

    /// Whether a tile was invalidated since its construction began.
    fn is_stale(&self, key: LayerKey, id: TileId, begun: u64) -> bool {
        let since = (self.invalidations - begun) as usize;
        let lately = self.recent.iter().rev().take(since);
        let meets = |tiles: &[[usize; 2]]| tiles.iter().any(|t| id.covers(*t));
        since > self.recent.len()
            || lately.filter(|(k, _)| *k == key).any(|(_, tiles)| tiles.as_deref().is_none_or(meets))
    }
}

#[cfg(test)]
mod tests;
