//! The levels of a layer that is looked at, made when they are asked for: a tile from the four below it, those of level 0
//! by whoever knows the cells. What was made is kept, in bounded memory, until it is out of date.

use super::cache::Cache;
use super::tile::{EDGE, Place, Tile};
use crate::Result;
use crate::grid::Scale;
use crate::output::png;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What tells layers apart, such as the number of a source and that of its view.
pub type Key = [u32; 2];

/// Tiles of level 0 that are out of date, as the pyramid remembers them: this many times.
const REMEMBERED: usize = 256;

/// A layer to be shown.
pub struct Shown<'a> {
    /// Its key; two layers never share one.
    pub key: Key,
    /// Columns and rows of its grid.
    pub extent: [usize; 2],
    /// Its colours, which decide which of four values is the strongest.
    pub scale: Scale,
    /// The values of the tile of level 0 in a column and row of tiles, row by row from the bottom, not a number where no
    /// reading reached; `None`: none reached any of it. Called on rayon's threads, several at once: it must not wait
    /// for a lock whose holder waits for rayon, so hold the lock around [`Pyramid::tile`] instead.
    pub base: &'a (dyn Fn([usize; 2]) -> Result<Option<Vec<f32>>> + Sync),
}

/// Tiles of several layers, in bounded memory.
#[derive(Debug)]
pub struct Pyramid {
    held: Mutex<Held>,
}

#[derive(Debug)]
struct Held {
    tiles: Cache<(Key, Place), Option<Arc<Tile>>>,
    /// Counts what became out of date.
    now: u64,
    /// What became so lately: a tile that was begun before is not kept. `None`: all of the layer.
    stale: VecDeque<(Key, Option<Vec<[usize; 2]>>)>,
}

impl Pyramid {
    /// An empty one that holds at most so many bytes.
    pub fn new(bytes: usize) -> Pyramid {
        Pyramid { held: Mutex::new(Held { tiles: Cache::new(bytes), now: 0, stale: VecDeque::new() }) }
    }

    /// A tile of a layer; `None`: no reading reached any of it, or it lies outside the grid.
    ///
    /// # Errors
    /// Those of [`Shown::base`].
    pub fn tile(&self, of: &Shown, at: Place) -> Result<Option<Arc<Tile>>> {
        self.find(of, at, true)
    }

    /// Of a layer these tiles of level 0 (column, row), and all above them, are out of date.
    pub fn invalidate(&self, key: Key, tiles: &[[usize; 2]]) {
        let mut held = self.held();
        held.forget(key, Some(tiles.to_vec()));
        let mut level = tiles.to_vec();
        // A grid has at most 2^24 cells a side.
        for k in 0..=24 {
            level.sort_unstable();
            level.dedup();
            for [column, row] in &mut level {
                held.tiles.remove(&(key, Place { level: k, column: *column, row: *row }));
                (*column, *row) = (*column / 2, *row / 2);
            }
        }
    }

    /// All of a layer is out of date.
    pub fn clear(&self, key: Key) {
        let mut held = self.held();
        held.forget(key, None);
        held.tiles.retain(|(k, _)| *k != key);
    }

    /// Finds a tile or makes it. What is only passed on the way up from level 0 is kept where there is room: it is made
    /// again sooner than what is above it.
    fn find(&self, of: &Shown, at: Place, asked: bool) -> Result<Option<Arc<Tile>>> {
        let extent = at.extent(of.extent);
        if extent.contains(&0) {
            return Ok(None);
        }
        let begun = {
            let mut held = self.held();
            if let Some(tile) = held.tiles.get(&(of.key, at)) {
                return Ok(tile);
            }
            held.now
        };
        let values = match at.below() {
            None => (of.base)([at.column, at.row])?,
            Some(below) => self.gather(of, extent, &below)?,
        };
        let some = values.filter(|v| v.iter().any(|v| !v.is_nan()));
        let tile = some.map(|values| Arc::new(Tile { extent, values }));
        let bytes = tile.as_ref().map_or(0, |t| 4 * t.values.len());
        let mut held = self.held();
        if !held.is_stale(of.key, at, begun) && (asked || at.level > 0 || held.tiles.has_room(bytes)) {
            held.tiles.put((of.key, at), tile.clone(), bytes);
        }
        Ok(tile)
    }

    /// A tile's values from the four below.
    fn gather(&self, of: &Shown, extent: [usize; 2], below: &[Place; 4]) -> Result<Option<Vec<f32>>> {
        let quarters = below.par_iter().map(|at| self.find(of, *at, false)).collect::<Result<Vec<_>>>()?;
        if quarters.iter().all(Option::is_none) {
            return Ok(None);
        }
        let mut values = vec![f32::NAN; extent[0] * extent[1]];
        for (k, quarter) in quarters.iter().enumerate() {
            let Some(quarter) = quarter else { continue };
            let ([width, _], half) = png::half(of.scale, quarter.extent, &quarter.values);
            let (left, bottom) = (k % 2 * EDGE / 2, k / 2 * EDGE / 2);
            for (row, line) in half.chunks_exact(width).enumerate() {
                values[(bottom + row) * extent[0] + left..][..width].copy_from_slice(line);
            }
        }
        Ok(Some(values))
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Held {
    fn forget(&mut self, key: Key, tiles: Option<Vec<[usize; 2]>>) {
        self.now += 1;
        self.stale.push_back((key, tiles));
        if self.stale.len() > REMEMBERED {
            self.stale.pop_front();
        }
    }

    /// Whether a tile became out of date since it was begun.
    fn is_stale(&self, key: Key, at: Place, begun: u64) -> bool {
        let since = (self.now - begun) as usize;
        let lately = self.stale.iter().rev().take(since);
        let meets = |tiles: &[[usize; 2]]| tiles.iter().any(|t| at.holds(*t));
        since > self.stale.len()
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
        let [width, height] = Place { level: 0, column, row }.extent(EXTENT);
        let cell = |k: usize| value(column * EDGE + k % width, row * EDGE + k / width, version);
        Some((0..width * height).map(cell).collect())
    }

    /// The whole level at once.
    fn whole(level: usize, scale: Scale, version: f32) -> ([usize; 2], Vec<f32>) {
        let all = (0..EXTENT[0] * EXTENT[1]).map(|k| value(k % EXTENT[0], k / EXTENT[0], version)).collect();
        (0..level).fold((EXTENT, all), |(extent, values): (_, Vec<f32>), _| png::half(scale, extent, &values))
    }

    #[track_caller]
    fn agrees(pyramid: &Pyramid, shown: &Shown, version: f32) {
        for level in 0..crate::view::levels(EXTENT) {
            let ([width, height], all) = whole(level, shown.scale, version);
            for (row, column) in (0..height.div_ceil(EDGE)).flat_map(|r| (0..width.div_ceil(EDGE)).map(move |c| (r, c)))
            {
                let at = Place { level, column, row };
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
    fn levels_made_tile_by_tile_are_those_of_the_whole_whatever_the_memory() {
        let scale = Scale::Signed { limit: 50.0 };
        for bytes in [0, 600_000, 1 << 28] {
            let pyramid = Pyramid::new(bytes);
            let base = |at| Ok(part(at, 1.0));
            agrees(&pyramid, &Shown { key: [0, 0], extent: EXTENT, scale, base: &base }, 1.0);
        }
    }

    #[test]
    fn only_what_is_out_of_date_is_made_again() {
        let scale = Scale::Grey { low: 0.0, high: 1.0 };
        let pyramid = Pyramid::new(1 << 28);
        let asked = AtomicUsize::new(0);
        let base = |at| {
            asked.fetch_add(1, Ordering::Relaxed);
            Ok(part(at, 1.0))
        };
        let first = Shown { key: [0, 0], extent: EXTENT, scale, base: &base };
        let second = Shown { key: [0, 1], ..first };
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
        let top = Place { level: 2, column: 0, row: 0 };
        let before = pyramid.tile(&second, top).expect("a tile");
        let after = pyramid.tile(&Shown { base: &changed, ..first }, top).expect("a tile");
        assert_eq!(asked.swap(0, Ordering::Relaxed), 1);
        assert_ne!(before, after);
        pyramid.clear([0, 0]);
        agrees(&pyramid, &first, 1.0);
        assert_eq!(asked.load(Ordering::Relaxed), 12);
    }

    #[test]
    fn what_changes_while_a_tile_is_made_is_not_kept() {
        let scale = Scale::Grey { low: 0.0, high: 1.0 };
        let pyramid = Pyramid::new(1 << 28);
        let slow = |at| {
            pyramid.invalidate([0, 0], &[[1, 0]]);
            Ok(part(at, 1.0))
        };
        let at = Place { level: 0, column: 1, row: 0 };
        pyramid.tile(&Shown { key: [0, 0], extent: EXTENT, scale, base: &slow }, at).expect("a tile");
        let base = |at| Ok(part(at, 2.0));
        agrees(&pyramid, &Shown { key: [0, 0], extent: EXTENT, scale, base: &base }, 2.0);
    }

    #[test]
    fn an_error_is_told_and_not_kept() {
        let scale = Scale::Grey { low: 0.0, high: 1.0 };
        let pyramid = Pyramid::new(1 << 28);
        let fails = |_| Err(crate::Error::Usage("broken".into()));
        let top = Place { level: 2, column: 0, row: 0 };
        assert!(pyramid.tile(&Shown { key: [0, 0], extent: EXTENT, scale, base: &fails }, top).is_err());
        let base = |at| Ok(part(at, 1.0));
        agrees(&pyramid, &Shown { key: [0, 0], extent: EXTENT, scale, base: &base }, 1.0);
    }
}
