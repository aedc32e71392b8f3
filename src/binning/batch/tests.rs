//! Tests the lists against exact membership, tile by tile.

use super::*;
use crate::binning::snap::{region, snap};
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Pose, Reading, Record};
use crate::sensor::{AtMax, Kind, Sensor};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::collections::BTreeMap;

/// Grid sizes whose sides are not whole numbers of tiles; the second grid has four chunks.
const GRIDS: [[usize; 2]; 2] = [[151, 90], [1100, 1040]];
const RESOLUTION: f64 = 0.125;

/// A random cone: position in cells, heading, range in cells, β in degrees, ε in cells, and kind.
type Draw = ((f64, f64), f64, f64, f64, f64, u8);

fn any_cone(place: [Range<f64>; 2], far: f64) -> impl Strategy<Value = Draw> {
    let [x, y] = place;
    // β = 0, β = 60° and axes along the world's axes are drawn often.
    let beta = prop_oneof![Just(0.0), Just(60.0), 0.0..60.0f64];
    let heading = prop_oneof![-7.0..7.0f64, (-8..8i32).prop_map(|k| f64::from(k) * std::f64::consts::FRAC_PI_4)];
    ((x, y), heading, 0.0..far, beta, prop_oneof![Just(0.0), 0.0..4.0f64], 0..4u8)
}

fn cone(size: [usize; 2], footprint: Footprint, draw: &Draw) -> Option<Cone> {
    let ((x, y), heading, range, beta, epsilon, kind) = *draw;
    let grid = GridSpec { anchor: (0.0, 0.0), resolution: RESOLUTION, i0: 0, j0: 0, width: size[0], height: size[1] };
    let sensor = Sensor {
        id: "s".into(),
        kind: if kind % 2 == 0 { Kind::Sonar } else { Kind::Laser },
        x: 0.0,
        y: 0.0,
        axis: 0.0,
        half_width: beta.to_radians(),
        r_min: 0.1,
        r_max: 1e4,
        at_r_max: AtMax::Hit,
        hit_range: 1e4,
        no_echo_range: 1.0,
        epsilon: Some(epsilon * RESOLUTION),
    };
    let pose = Pose { x: x * RESOLUTION, y: y * RESOLUTION, heading };
    let range = range * RESOLUTION;
    let record = Record { t: 0.0, scan: 0, sensor: 0, robot: pose, pose, range, label: None, line: 1 };
    let outcome = if kind < 2 { Outcome::Hit } else { Outcome::NoEcho };
    let edges = (footprint == Footprint::Wedge).then(|| (heading + beta.to_radians(), heading - beta.to_radians()));
    snap(&grid, &sensor, &Reading { record, outcome, range }, footprint, edges).map(|(cone, _)| cone)
}

/// The entries of every tile, by the tile's lower left cell.
fn lists(batch: &Batch) -> BTreeMap<[u32; 2], Vec<Entry>> {
    let mut lists = BTreeMap::new();
    for chunk in &batch.chunks {
        let mut slots = chunk.tiles.iter().map(|t| t.slot);
        let mut last = slots.next().unwrap();
        slots.for_each(|s| assert!(s > std::mem::replace(&mut last, s), "slots ascend"));
        for tile in &chunk.tiles {
            for k in 0..2 {
                let at = [tile.slot % CHUNK as u32, tile.slot / CHUNK as u32];
                assert_eq!(tile.corner[k], chunk.place.first_cell()[k] as u32 + at[k] * TILE as u32);
            }
            let entries = chunk.entries[tile.entries[0] as usize..tile.entries[1] as usize].to_vec();
            assert!(!entries.is_empty() && lists.insert(tile.corner, entries).is_none());
        }
        let listed: u32 = chunk.tiles.iter().map(|t| t.entries[1] - t.entries[0]).sum();
        assert_eq!(listed as usize, chunk.entries.len());
    }
    lists
}

/// Decides cell by cell whether a tile has any cell in the interior or on the arc, any on the arc, and only interior cells.
fn exact(cone: &Cone, footprint: Footprint, size: [usize; 2], corner: [i64; 2]) -> (bool, bool, bool) {
    let (mut any, mut arc, mut all) = (false, false, true);
    for cell in 0..TILE_CELLS as i64 {
        let at = [corner[0] + cell % TILE as i64, corner[1] + cell / TILE as i64];
        let within = at[0] < size[0] as i64 && at[1] < size[1] as i64;
        let (i, a) = if within { region(cone, footprint, at[0], at[1]) } else { (false, false) };
        (any, arc, all) = (any | i | a, arc | a, all & i);
    }
    (any, arc, all)
}

/// Checks every tile's list against exact membership. Returns how many tiles were listed needlessly, and how many as inside.
fn check(size: [usize; 2], footprint: Footprint, no_echo_arcs: bool, cones: Vec<Cone>) -> (usize, usize) {
    let binning = Binning { size, footprint, no_echo_arcs, only: None };
    let batch = binning.bin(cones);
    let lists = lists(&batch);
    let (mut spare, mut inside) = (0, 0);
    let mut parts: Vec<Vec<u32>> = vec![Vec::new(); batch.cones().len()];
    let [across, up] = size.map(|s| s.div_ceil(TILE));
    let mut tiles: Vec<[usize; 2]> = (0..up).flat_map(|j| (0..across).map(move |i| [i, j])).collect();
    // The order is chunk by chunk and in each chunk tile row by tile row.
    tiles.sort_by_key(|[i, j]| [j / CHUNK, i / CHUNK, *j, *i]);
    for [i, j] in tiles {
        let corner = [(i * TILE) as u32, (j * TILE) as u32];
        let list = lists.get(&corner).map_or(&[][..], Vec::as_slice);
        assert!(list.windows(2).all(|w| w[0].index() < w[1].index()), "tile {corner:?}: not in log order");
        let mut entries = list.iter().peekable();
        for (k, cone) in batch.cones().iter().enumerate() {
            let entry = entries.next_if(|e| e.index() == k);
            let (any, arc, all) = exact(cone, footprint, size, corner.map(i64::from));
            let arc = arc && (no_echo_arcs || cone.flags & NO_ECHO == 0);
            match entry {
                None => assert!(!any, "tile {corner:?} misses cone {cone:?}"),
                Some(e) => {
                    assert!(!arc || e.cone & ARC != 0, "tile {corner:?}: no arc flag for {cone:?}");
                    assert!(all || e.cone & INSIDE == 0, "tile {corner:?} is not inside {cone:?}");
                    assert!(e.cone & INSIDE == 0 || e.cone & ARC == 0 || footprint == Footprint::Axis);
                    if e.cone & ARC != 0 {
                        parts[k].push(e.slot);
                    }
                    spare += usize::from(!any);
                    inside += usize::from(e.cone & INSIDE != 0);
                }
            }
        }
        assert!(entries.next().is_none());
    }
    // The parts of a reading are consecutive, chunk by chunk and tile row by tile row, and none occurs twice.
    assert_eq!(batch.first_part().len(), batch.cones().len() + 1);
    for (k, parts) in parts.iter().enumerate() {
        let own: Vec<u32> = (batch.first_part()[k]..batch.first_part()[k + 1]).collect();
        assert_eq!(parts, &own, "parts of cone {k}");
        assert_eq!(batch.cones()[k].index as usize, k);
    }
    (spare, inside)
}

const FOOTPRINTS: [Footprint; 3] = [Footprint::Cone, Footprint::Wedge, Footprint::Axis];

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(5),
        ..ProptestConfig::default()
    })]

    #[test]
    fn lists_hold_every_member(
        draws in prop::collection::vec(any_cone([-60.0..210.0, -60.0..150.0], 120.0), 1..24),
        no_echo_arcs in any::<bool>(),
    ) {
        for footprint in FOOTPRINTS {
            let cones = draws.iter().filter_map(|d| cone(GRIDS[0], footprint, d)).collect();
            check(GRIDS[0], footprint, no_echo_arcs, cones);
        }
    }

    #[test]
    fn lists_hold_every_member_of_far_readings(
        draws in prop::collection::vec(any_cone([-3000.0..3000.0, -3000.0..3000.0], 5000.0), 1..12),
    ) {
        for footprint in FOOTPRINTS {
            let cones = draws.iter().filter_map(|d| cone(GRIDS[0], footprint, d)).collect();
            check(GRIDS[0], footprint, true, cones);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 6,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(6),
        ..ProptestConfig::default()
    })]

    #[test]
    fn lists_across_chunks(draws in prop::collection::vec(any_cone([900.0..1100.0, 900.0..1040.0], 300.0), 1..12)) {
        for footprint in FOOTPRINTS {
            let cones: Vec<Cone> = draws.iter().filter_map(|d| cone(GRIDS[1], footprint, d)).collect();
            check(GRIDS[1], footprint, true, cones);
        }
    }
}

/// Makes `count` cones with a small random number generator.
fn many(count: u32) -> Vec<Cone> {
    let at = |k: u32, step: u32, n: u32| f64::from(k.wrapping_mul(step) % n);
    let draw = |k: u32| {
        let place = (at(k, 7919, 151), at(k, 104_729, 90));
        (place, at(k, 1299, 628) / 100.0, at(k, 31, 70), at(k, 17, 61), 1.0, (k % 4) as u8)
    };
    (0..count).filter_map(|k| cone(GRIDS[0], Footprint::Cone, &draw(k))).collect()
}

#[test]
fn lists_are_tight_enough_and_some_tiles_are_inside() {
    let cones = many(300);
    let entries: usize = {
        let binning = Binning { size: GRIDS[0], footprint: Footprint::Cone, no_echo_arcs: true, only: None };
        binning.bin(cones.clone()).chunks.iter().map(|c| c.entries.len()).sum()
    };
    let (spare, inside) = check(GRIDS[0], Footprint::Cone, true, cones);
    assert!(spare * 8 < entries, "{spare} of {entries} entries are for nothing");
    assert!(inside > 50, "{inside} of {entries} entries inside");
}

#[test]
fn the_number_of_threads_leaves_no_trace() {
    let cones = many(3000);
    let binning = Binning { size: GRIDS[0], footprint: Footprint::Cone, no_echo_arcs: true, only: None };
    let bin = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| binning.bin(cones.clone()))
    };
    let one = bin(1);
    // 1, 2 and 7 threads cut the log into 4, 8 and 28 runs.
    for threads in [2, 7] {
        let other = bin(threads);
        assert!(other.chunks == one.chunks && other.first_part() == one.first_part() && other.cones() == one.cones());
    }
    // The lists equal those made by listing one reading after the other.
    let mut tiles: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (k, cone) in cones.iter().enumerate() {
        for (corner, entries) in lists(&binning.bin(vec![*cone])) {
            tiles.entry(corner).or_default().extend(entries.iter().map(|_| k));
        }
    }
    let whole: BTreeMap<[u32; 2], Vec<usize>> =
        lists(&one).into_iter().map(|(at, list)| (at, list.iter().map(|e| e.index()).collect())).collect();
    assert!(whole == tiles);
}

#[test]
fn no_readings_make_no_tiles() {
    let binning = Binning { size: GRIDS[0], footprint: Footprint::Cone, no_echo_arcs: false, only: None };
    let batch = binning.bin(Vec::new());
    assert!(batch.chunks.is_empty() && batch.cones().is_empty());
    assert_eq!(batch.first_part(), [0]);
}

/// Tests 16 tiles at once in 32 bits against one by one in 64 bits.
#[test]
fn narrow_is_what_one_by_one_is() {
    use fearless_simd::{Level, Simd, dispatch};
    fn rows<S: Simd>(simd: S, shape: &Shape, at: [i64; 2]) -> Vec<Met> {
        let columns = Columns::of(simd, shape, at[0]);
        (0..TILES as i64).map(|j| columns.meet(shape, &shape.extremes(1, at[1] + 512 * j))).collect()
    }
    let (mut met, mut arcs, mut insides) = (0, 0, 0);
    for (k, near) in many(600).into_iter().enumerate() {
        // Every third cone reaches as far as 32 bits allow, in its own direction.
        let far = Cone { reach: [32_000, 32_768], ..near };
        let cone = if k % 3 == 0 { far } else { near };
        for footprint in FOOTPRINTS {
            let shape = Shape::of(&cone, footprint);
            for corner in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                // The tiles start at each corner of the box.
                let at = [0, 1].map(|k| if corner[k] == 0 { shape.low[k] } else { shape.high[k] - 16 * 512 });
                let rows = dispatch!(Level::new(), simd => rows(simd, &shape, at));
                for (j, row) in rows.iter().enumerate() {
                    let up = shape.extremes(1, at[1] + 512 * j as i64);
                    for i in 0..TILES {
                        let one = shape.meets(&shape.extremes(0, at[0] + 512 * i as i64), &up);
                        let bit = |bits: u32| bits >> i & 1 != 0;
                        let found = bit(row.some).then_some((bit(row.arc), bit(row.inside)));
                        assert_eq!(found, one, "cone {k}, {footprint:?}, tile {i}, {j} from {at:?}");
                        let (arc, inside) = one.unwrap_or_default();
                        (met, arcs, insides) =
                            (met + usize::from(one.is_some()), arcs + usize::from(arc), insides + usize::from(inside));
                    }
                }
            }
        }
    }
    assert!(met > 10_000 && arcs > 1000 && insides > 1000, "{met} met, {arcs} arcs, {insides} inside");
}
