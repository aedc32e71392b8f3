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
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    const EXTENT: [usize; 2] = [1000, 700];

    /// Every seventh cell of a row is seen; nothing is in the lower left tile.
    fn value(column: usize, row: usize, version: f32) -> f32 {
        let seen = (column + row).is_multiple_of(7) && (column >= EDGE || row >= EDGE);
        if seen { version * ((column * 31 + row * 17) % 101) as f32 - 50.0 } else { f32::NAN }
    }

    fn part([column, row]: [usize; 2], version: f32) -> Option<Vec<f32>> {
        let [width, height] = TileId { level: 0, column, row }.extent(EXTENT);
        let cell = |k: usize| value(column * EDGE + k % width, row * EDGE + k / width, version);
        Some((0..width * height).map(cell).collect())
    }

    /// The whole level at once.
    fn whole(level: usize, scale: Scale, version: f32) -> ([usize; 2], Vec<f32>) {
        let all = (0..EXTENT[0] * EXTENT[1]).map(|k| value(k % EXTENT[0], k / EXTENT[0], version)).collect();
        (0..level).fold((EXTENT, all), |(extent, values): (_, Vec<f32>), _| png::half(scale, extent, &values))
    }

    #[track_caller]
    fn agrees(pyramid: &Pyramid, shown: &PyramidLayer, version: f32) {
        for level in 0..crate::view::levels(EXTENT) {
            let ([width, height], all) = whole(level, shown.scale, version);
            for (row, column) in (0..height.div_ceil(EDGE)).flat_map(|r| (0..width.div_ceil(EDGE)).map(move |c| (r, c)))
            {
                let at = TileId { level, column, row };
                let [w, h] = at.extent(EXTENT);
                let wanted: Vec<f32> =
                    (0..w * h).map(|k| all[(row * EDGE + k / w) * width + column * EDGE + k % w]).collect();
                let tile = pyramid.tile(shown, at).expect("a tile");
                let found = tile.as_ref().map_or(vec![f32::NAN; w * h], |t| t.values.clone());
                assert_eq!(tile.is_none(), wanted.iter().all(|v| v.is_nan()), "{at:?}");
                let bits = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<u32>>();
                assert_eq!(bits(&found), bits(&wanted), "{at:?}");
            }
        }
    }

    #[test]
    fn levels_built_tile_by_tile_are_those_of_the_whole_whatever_the_memory() {
        let scale = Scale::Signed { limit: 50.0 };
        for bytes in [0, 600_000, 1 << 28] {
            let pyramid = Pyramid::new(bytes);
            let base = |at| Ok(part(at, 1.0));
            agrees(&pyramid, &PyramidLayer { key: [0, 0], extent: EXTENT, scale, level0: &base }, 1.0);
        }
    }

    #[test]
    fn only_invalidated_tiles_are_built_again() {
        let scale = Scale::Grey { low: 0.0, high: 1.0 };
        let pyramid = Pyramid::new(1 << 28);
        let asked = AtomicUsize::new(0);
        let base = |at| {
            asked.fetch_add(1, Ordering::Relaxed);
            Ok(part(at, 1.0))
        };
        let first = PyramidLayer { key: [0, 0], extent: EXTENT, scale, level0: &base };
        let second = PyramidLayer { key: [0, 1], ..first };
        agrees(&pyramid, &first, 1.0);
        agrees(&pyramid, &second, 1.0);
        assert_eq!(asked.swap(0, Ordering::Relaxed), 24);
        agrees(&pyramid, &first, 1.0);
        assert_eq!(asked.load(Ordering::Relaxed), 0);
        // one tile changes, another layer doesn't
        let changed = |at: [usize; 2]| {
            asked.fetch_add(1, Ordering::Relaxed);
            Ok(if at == [1, 2] { None } else { part(at, 1.0) })
        };
        pyramid.invalidate([0, 0], &[[1, 2], [1, 2]]);
        agrees(&pyramid, &second, 1.0);
        assert_eq!(asked.load(Ordering::Relaxed), 0);
        let top = TileId { level: 2, column: 0, row: 0 };
        let before = pyramid.tile(&second, top).expect("a tile");
        let after = pyramid.tile(&PyramidLayer { level0: &changed, ..first }, top).expect("a tile");
        assert_eq!(asked.swap(0, Ordering::Relaxed), 1);
        assert_ne!(before, after);
        pyramid.clear([0, 0]);
        agrees(&pyramid, &first, 1.0);
        assert_eq!(asked.load(Ordering::Relaxed), 12);
    }

    #[test]
    fn a_tile_invalidated_while_it_is_built_is_not_cached() {
        let scale = Scale::Grey { low: 0.0, high: 1.0 };
        let pyramid = Pyramid::new(1 << 28);
        let slow = |at| {
            pyramid.invalidate([0, 0], &[[1, 0]]);
            Ok(part(at, 1.0))
        };
        let at = TileId { level: 0, column: 1, row: 0 };
        pyramid.tile(&PyramidLayer { key: [0, 0], extent: EXTENT, scale, level0: &slow }, at).expect("a tile");
        let base = |at| Ok(part(at, 2.0));
        agrees(&pyramid, &PyramidLayer { key: [0, 0], extent: EXTENT, scale, level0: &base }, 2.0);
    }

    #[test]
    fn an_error_is_returned_and_not_cached() {
        let scale = Scale::Grey { low: 0.0, high: 1.0 };
        let pyramid = Pyramid::new(1 << 28);
        let fails = |_| Err(crate::Error::Usage("broken".into()));
        let top = TileId { level: 2, column: 0, row: 0 };
        assert!(pyramid.tile(&PyramidLayer { key: [0, 0], extent: EXTENT, scale, level0: &fails }, top).is_err());
        let base = |at| Ok(part(at, 1.0));
        agrees(&pyramid, &PyramidLayer { key: [0, 0], extent: EXTENT, scale, level0: &base }, 1.0);
    }
}
