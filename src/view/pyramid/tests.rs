//! Tests of the pyramid.

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
        for (row, column) in (0..height.div_ceil(EDGE)).flat_map(|r| (0..width.div_ceil(EDGE)).map(move |c| (r, c))) {
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
