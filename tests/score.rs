//! Scores against hand-made truths: levels, zones, shares, probabilities, shifts.

#![allow(clippy::unwrap_used, reason = "clippy.toml allows it in test functions; here are their helpers too")]

use echogrid::grid::{Data, GridSpec, Layer, Map, Scale};
use echogrid::score::{Options, Quality, Requirement, Score, Truth, Zones, level, probabilities, score, table};
use echogrid::world::room;

const O: i8 = 1;
const U: i8 = 0;
const E: i8 = -1;

fn layer(name: &str, data: Data) -> Layer {
    Layer { name: name.into(), about: "", data, fill: 0.0, scale: Scale::Signed { limit: 1.0 } }
}

/// A map of classes, every cell of it touched, its lower left cell at column `i0`, row `j0`.
fn map_at(i0: i64, j0: i64, width: usize, class: &[i8]) -> Map {
    let grid = GridSpec { anchor: (0.0, 0.0), resolution: 0.1, i0, j0, width, height: class.len() / width };
    let touched = layer("touched", Data::U8(vec![1; class.len()]));
    let layers = vec![touched, layer("class", Data::I8(class.to_vec()))];
    Map { grid, method: "hand".into(), layers, updates: 0 }
}

fn map(class: &[i8]) -> Map {
    map_at(0, 0, 5, class)
}

/// A truth of all cells of the 5 × 5 grid.
fn world(class: &[i8]) -> Truth {
    let whole = class.to_vec();
    let draw = Box::new(move |grid: &GridSpec| {
        assert_eq!((grid.width, grid.height), (5, 5));
        Ok(whole.clone())
    });
    Truth::World { bounds: [0.0, 0.0, 0.5, 0.5], r_max: 0.0, draw }
}

fn scored(map: &Map, truth: &Truth) -> Score {
    score("m", map, truth, &Options::default()).unwrap()
}

/// 5 × 5 cells of `rest`, but for the centre and, if given, its upper right neighbour.
fn five(rest: i8, centre: i8, neighbour: Option<i8>) -> Vec<i8> {
    let mut cells = vec![rest; 25];
    cells[12] = centre;
    cells[18] = neighbour.unwrap_or(rest);
    cells
}

/// The centre cell's level.
fn centre(truth: &[i8], map_: &[i8]) -> u8 {
    let score = scored(&map(map_), &world(truth));
    assert_eq!(score.numbers.cells, 25);
    let middle = score.cells.margin + 2;
    score.cells.levels[middle * score.cells.grid.width + middle]
}

#[test]
fn every_level_in_a_hand_made_5_by_5() {
    // The classes of the centre and of one neighbour, true and obtained; all else is empty in both.
    let cases: [(i8, Option<i8>, i8, Option<i8>, u8); 19] = [
        (E, None, E, None, 0),
        (O, None, O, None, 0),
        (U, None, U, None, 0),
        (E, Some(O), O, None, 1),
        (U, Some(O), O, None, 1),
        (E, Some(O), O, Some(O), 1),
        (O, None, U, Some(O), 2),
        (O, Some(O), U, Some(O), 2),
        (E, None, U, None, 3),
        (E, Some(O), U, Some(O), 3),
        (O, None, U, None, 4),
        (O, Some(O), U, None, 4),
        (U, None, O, None, 5),
        (E, None, O, None, 6),
        (E, None, O, Some(O), 6),
        (U, None, E, None, 7),
        (O, None, E, Some(O), 8),
        (O, Some(O), E, None, 9),
        (O, None, E, None, 9),
    ];
    for (actual, true_near, obtained, near, expected) in cases {
        let found = centre(&five(E, actual, true_near), &five(E, obtained, near));
        assert_eq!(found, expected, "{actual} near {true_near:?} shown as {obtained} near {near:?}");
    }
}

#[test]
fn all_eight_neighbours_count_and_no_other_cell() {
    for k in (0..25).filter(|k| *k != 12) {
        let (column, row) = (k % 5, k / 5);
        let beside = (1..=3).contains(&column) && (1..=3).contains(&row);
        let mut truth = vec![E; 25];
        truth[k] = O;
        assert_eq!(centre(&truth, &five(E, O, None)), if beside { 1 } else { 6 }, "Test2, cell {k}");
        let mut obtained = vec![E; 25];
        obtained[k] = O;
        assert_eq!(centre(&five(E, O, None), &obtained), if beside { 8 } else { 9 }, "Test1, cell {k}");
    }
}

#[test]
fn a_row_never_runs_into_the_next() {
    // The last cell of a row and the first of the next are no neighbours.
    let (mut truth, mut obtained) = (vec![E; 25], vec![E; 25]);
    truth[9] = O; // column 4, row 1
    obtained[10] = O; // column 0, row 2
    let levels = scored(&map(&obtained), &world(&truth)).numbers.levels;
    assert_eq!(levels, [23, 0, 0, 0, 0, 0, 1, 0, 0, 1]);
}

#[test]
fn zones_are_sums_of_levels() {
    let zones = Zones::of(&[1, 2, 4, 8, 16, 32, 64, 128, 256, 512]);
    assert_eq!(zones, Zones { z1: 3, z2: 3 + 28 + 96, z3: 28, z4: 96, z5: 896 });
    assert_eq!(level(E, O, true, false), 6);
    assert_eq!(level(O, U, true, true), 2);
}

#[test]
fn shares_by_hand() {
    // Truth: a wall of five, four of free space below, the rest unknown. Map: two of the wall found, one freed, one left
    // unknown, one shown a cell too low, one phantom.
    let truth = [
        E, E, E, E, U, /**/ E, E, E, E, E, /**/ O, O, O, O, O, /**/ U, U, U, U, U, /**/ U, U, U, U,
        U,
    ];
    let shown = [
        O, E, E, E, U, /**/ E, E, E, E, O, /**/ O, O, E, U, U, /**/ U, U, U, U, E, /**/ U, U, U, U,
        U,
    ];
    let n = scored(&map(&shown), &world(&truth)).numbers;
    // (0, 0) E→O far from the wall: 6. (4, 1) E→O beside it: 1. (2, 2) O→E beside a found one: 8. (3, 2) O→U with
    // (4, 1) beside it: 2, (4, 2) likewise. (4, 3) U→E: 7.
    assert_eq!(n.levels, [19, 1, 2, 0, 0, 0, 1, 1, 1, 0]);
    assert_eq!(n.zones, Zones { z1: 20, z2: 23, z3: 2, z4: 1, z5: 2 });
    assert_eq!((n.cells, n.known, n.occupied, n.occupied_found, n.o_to_e), (25, 12, 5, 2, 1));
    assert_eq!(n.accuracy, Some(9.0 / 12.0));
    assert_eq!(n.danger, Some(1.0 / 3.0));
    assert_eq!(n.freed, Some(1.0 / 5.0));
    assert_eq!(n.recall, Some(2.0 / 5.0));
    assert_eq!(n.precision, Some(2.0 / 4.0));
    assert_eq!(n.iou, Some(2.0 / 7.0));
    assert_eq!(n.recall_tolerant, Some(1.0));
    assert_eq!(n.precision_tolerant, Some(3.0 / 4.0));
    assert!((n.f1.unwrap() - 2.0 * 0.4 * 0.5 / 0.9).abs() < 1e-12);
    let unknown = shown.iter().filter(|c| **c == U).count() as f64;
    assert_eq!(n.unknown, Some(unknown / 25.0));
}

#[test]
fn the_tolerance_is_in_cells() {
    let (mut truth, mut shown) = (vec![E; 25], vec![E; 25]);
    truth[0] = O;
    shown[3] = O; // three columns away
    for (tolerance, found) in [(0, 0.0), (1, 0.0), (2, 0.0), (3, 1.0), (4, 1.0)] {
        let options = Options { tolerance, decide: None };
        let n = score("m", &map(&shown), &world(&truth), &options).unwrap().numbers;
        assert_eq!((n.recall_tolerant, n.precision_tolerant), (Some(found), Some(found)), "{tolerance}");
        assert_eq!(n.levels, [23, 0, 0, 0, 0, 0, 1, 0, 0, 1], "levels know only the neighbours");
    }
}

/// The demo's room, its true classes on a grid.
fn room_truth() -> Truth {
    let draw = Box::new(|grid: &GridSpec| Ok(room::truth(grid)));
    Truth::World { bounds: [0.0, 0.0, 5.0, 4.0], r_max: 1.0, draw }
}

#[test]
fn the_truth_is_perfect_and_its_negative_all_danger() {
    let grid = GridSpec::around([-1.5, -1.5, 6.5, 5.5], 0.05).unwrap();
    let truth = room::truth(&grid);
    let on = |class: Vec<i8>| Map { grid, ..map_at(0, 0, grid.width, &class) };
    let same = scored(&on(truth.clone()), &room_truth());
    let n = &same.numbers;
    assert_eq!((n.levels[0], n.zones.z1), (n.cells, n.cells));
    assert_eq!(
        (n.accuracy, n.danger, n.iou, n.f1, n.f1_tolerant),
        (Some(1.0), Some(0.0), Some(1.0), Some(1.0), Some(1.0))
    );
    assert_eq!((n.quality.brier, n.quality.auc, n.quality.ece), (Some(0.0), Some(1.0), Some(0.0)));
    assert!(n.quality.log_loss.unwrap() < 1e-5 && n.occupied > 100);
    let near = same.near.as_ref().unwrap();
    assert_eq!((n.cells, near.cells), (140 * 120, 120 * 100));

    let negative = scored(&on(truth.iter().map(|c| -c).collect()), &room_truth());
    let n = &negative.numbers;
    assert_eq!((n.danger, n.accuracy, n.quality.auc), (Some(1.0), Some(0.0), Some(0.0)));
    assert_eq!(n.zones.z5, n.occupied);
    assert_eq!((n.occupied_found, n.recall), (0, Some(0.0)));
}

#[test]
fn outside_a_map_all_is_unknown() {
    // A map of one cell in the middle of the world.
    let truth = five(E, O, None);
    let n = scored(&map_at(2, 2, 1, &[O]), &world(&truth)).numbers;
    assert_eq!(n.levels, [1, 0, 0, 24, 0, 0, 0, 0, 0, 0]);
    assert_eq!(n.unknown, Some(24.0 / 25.0));
}

#[test]
fn against_a_map_only_what_both_saw_is_compared() {
    let mut shown = map(&five(E, O, None));
    let mut touched = vec![1; 25];
    touched[0] = 0;
    shown.layers[0].data = Data::U8(touched);
    let mut truth = five(E, E, None);
    truth[1] = U;
    let score = scored(&shown, &Truth::Map(map(&truth)));
    assert_eq!(score.numbers.levels, [22, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    assert!(score.near.is_none());
    // A neighbour outside the shared rectangle counts: the truth goes on where the map ends.
    let right = Truth::Map(map_at(0, 0, 2, &[E, O]));
    assert_eq!(scored(&map_at(0, 0, 1, &[O]), &right).numbers.levels[1], 1);
    let right = Truth::Map(map_at(0, 0, 1, &[O]));
    assert_eq!(scored(&map_at(0, 0, 2, &[E, O]), &right).numbers.levels[8], 1);
}

#[test]
fn shifting_both_by_whole_cells_changes_nothing() {
    let class: Vec<i8> = (0..40 * 30).map(|k: i64| ((k * k * 7 + k / 3) % 5 % 3 - 1) as i8).collect();
    let other: Vec<i8> = (0..40 * 30).map(|k: i64| ((k * k * 11 + k / 7) % 7 % 3 - 1) as i8).collect();
    let at = |i, j| scored(&map_at(i + 3, j - 2, 40, &other), &Truth::Map(map_at(i, j, 40, &class)));
    let here = at(0, 0);
    for (i, j) in [(7, -3), (-1000, 12345)] {
        let there = at(i, j);
        assert_eq!((here.numbers.clone(), &here.cells.levels), (there.numbers, &there.cells.levels));
    }
    // By the anchor as well, if by whole cells.
    let mut truth = map_at(0, 0, 40, &class);
    truth.grid = GridSpec { anchor: (-0.7, 0.4), i0: 7, j0: -4, ..truth.grid };
    assert_eq!(scored(&map_at(3, -2, 40, &other), &Truth::Map(truth)).numbers, here.numbers);
}

#[test]
fn grids_that_do_not_fall_on_one_another_are_refused() {
    let (good, options) = (map(&[E; 25]), Options::default());
    let refused = |grid: GridSpec| {
        let error = score("m", &good, &Truth::Map(Map { grid, ..good.clone() }), &options).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        error.to_string()
    };
    assert!(refused(GridSpec { resolution: 0.05, ..good.grid }).contains("--resolution"));
    assert!(refused(GridSpec { anchor: (0.03, 0.0), ..good.grid }).contains("--bounds"));
    assert!(refused(GridSpec { i0: 50, ..good.grid }).contains("no cell in common"));
    let unseen = Truth::Map(map(&[U; 25]));
    assert!(score("m", &good, &unseen, &options).unwrap_err().to_string().contains("both have seen"));
}

fn close(found: Option<f64>, expected: f64) {
    assert!((found.unwrap() - expected).abs() < 1e-6, "{found:?}, not {expected}");
}

#[test]
fn probabilities_by_hand() {
    // Brier (.01 + .16 + .16 + .25 + .25)/5; log loss −(ln .9 + ln .6 + ln .6 + ln .5 + ln .5)/5.
    let cells = vec![(0.9, true), (0.6, true), (0.4, false), (0.5, true), (0.5, false)];
    let q = Quality::of(cells);
    close(q.brier, 0.83 / 5.0);
    close(q.log_loss, -(0.9f64.ln() + 2.0 * 0.6f64.ln() + 2.0 * 0.5f64.ln()) / 5.0);
    // Of six pairs five are in order and one is a tie.
    close(q.auc, 5.5 / 6.0);
    // Bins: .9 off by .1, .6 by .4, .4 by .4, the two of .5 by none.
    close(q.ece, (0.1 + 0.4 + 0.4) / 5.0);
    assert_eq!(Quality::of(Vec::new()), Quality::default());
    assert_eq!(Quality::of(vec![(1.0, true)]).auc, None);
    // The log loss of a certain error is finite; 1 lies in the last bin.
    close(Quality::of(vec![(1.0, false)]).log_loss, -(1e-6f64.ln()));
    close(Quality::of(vec![(1.0, true), (0.95, false)]).ece, 0.95 / 2.0);
    // All tied: no better than chance.
    close(Quality::of(vec![(0.3, true), (0.3, false), (0.3, false)]).auc, 0.5);
}

#[test]
fn each_methods_probability() {
    let f = |v: [f32; 2]| Data::F32(v.to_vec());
    let of = |layers: &[(&str, [f32; 2])], touched: [u8; 2]| {
        let mut map = map_at(0, 0, 2, &[E, O]);
        map.layers[0].data = Data::U8(touched.to_vec());
        map.layers.extend(layers.iter().map(|(name, v)| layer(name, f(*v))));
        probabilities(&map)
    };
    assert_eq!(of(&[("log_odds", [0.0, 1.0]), ("p_occ", [0.25, 0.75])], [1, 1]), [0.25, 0.75]);
    assert_eq!(of(&[("emp", [0.5, 0.0]), ("occ", [0.0, 1.0]), ("map", [-0.5, 1.0])], [1, 1]), [0.25, 1.0]);
    assert_eq!(of(&[("empty", [0.5, 0.0]), ("full", [0.25, 0.5]), ("unknown", [0.25, 0.5])], [1, 1]), [0.375, 0.75]);
    assert_eq!(of(&[("count", [0.0, 15.0])], [0, 1]), [0.5, 1.0]);
    assert_eq!(of(&[("hits", [0.0, 3.0]), ("passes", [0.0, 1.0])], [1, 1]), [0.5, 0.75]);
    assert_eq!(of(&[], [1, 1]), [0.0, 1.0]);
}

#[test]
fn decided_by_probability_if_asked() {
    let mut shown = map_at(0, 0, 4, &[E; 4]);
    shown.layers.push(layer("p_occ", Data::F32(vec![0.61, 0.6, 0.39, 0.9])));
    shown.layers[0].data = Data::U8(vec![1, 1, 1, 0]);
    let truth = Truth::World { bounds: [0.0, 0.0, 0.4, 0.1], r_max: 0.0, draw: Box::new(|_| Ok(vec![O, U, E, U])) };
    let options = Options { tolerance: 1, decide: Some((0.6, 0.4)) };
    assert_eq!(score("m", &shown, &truth, &options).unwrap().numbers.levels[0], 4);
}

#[test]
fn requirements() {
    let truth = five(E, O, None);
    let score = scored(&map(&truth), &world(&truth));
    let check = |text: &str| text.parse::<Requirement>().unwrap().check(&score);
    for (text, held) in [
        ("danger<=0", true),
        ("danger < 0", false),
        ("accuracy == 1", true),
        ("levels.0>=25", true),
        ("zones.z5>0", false),
        ("z5==0", true),
        ("near.z1>=25", true),
        ("near.zones.z1>25", false),
        ("near.auc>0.9", true),
        ("occupied_found==1", true),
    ] {
        assert_eq!(check(text).unwrap().held, held, "{text}");
    }
    let error = check("dangr<1").unwrap_err();
    assert!(error.to_string().contains("did you mean \"danger\"") && error.exit_code() == 2, "{error}");
    for text in ["danger", "<1", "danger<=", "danger<=x", "danger=1", "danger<=nan", "a!b"] {
        assert!(text.parse::<Requirement>().is_err(), "{text}");
    }
    // What has no value holds nothing.
    let empty = scored(&map(&[E; 25]), &world(&[E; 25]));
    let check = |text: &str| text.parse::<Requirement>().unwrap().check(&empty).unwrap();
    assert_eq!((check("danger<=1").held, check("danger<=1").value), (false, None));
    let against_map = scored(&map(&truth), &Truth::Map(map(&truth)));
    let near = "near.danger<1".parse::<Requirement>().unwrap().check(&against_map).unwrap_err();
    assert!(near.to_string().contains("only a world"), "{near}");
}

#[test]
fn the_table_marks_the_best() {
    let truth = five(E, O, None);
    let good = scored(&map(&truth), &world(&truth));
    let bad = Score { path: "runs/b/".into(), ..scored(&map(&five(E, E, None)), &world(&truth)) };
    let table = table(&[good, bad]);
    let line = |name: &str| table.lines().find(|l| l.starts_with(name)).unwrap().split_whitespace().collect::<Vec<_>>();
    assert_eq!(table.lines().next().unwrap().split_whitespace().collect::<Vec<_>>(), ["m", "b"]);
    assert_eq!(line("danger  "), ["danger", "0.000", "*", "1.000"]);
    assert_eq!(line("left unknown"), ["left", "unknown", "0.0", "%", "0.0", "%"]);
    assert_eq!(line("near: Z5 cells"), ["near:", "Z5", "cells", "0", "*", "1"]);
}
