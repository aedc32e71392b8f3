//! Every error level, and the shares that are counted.

use crate::common::*;
use echogrid::evaluate::score::{Options, Zones, level, score};

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
    type Case = (i8, Option<i8>, i8, Option<i8>, u8);
    let cases: [Case; 19] = [
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
    assert_eq!(n.unknown, Some(2.0 / 14.0));
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
