//! Which cells are compared: perfect maps, negatives, shifts, edges, grids that don't fit.

use crate::common::*;
use echogrid::ErrorKind;
use echogrid::evaluate::score::{Options, Truth, score};
use echogrid::grid::{Data, GridSpec, Map};
use echogrid::world::{World, true_map};
use std::path::Path;

/// A world that ships with the project.
fn shipped(name: &str) -> World {
    World::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds").join(name)).unwrap()
}

#[test]
fn the_truth_is_perfect_and_its_negative_all_danger() {
    let world = shipped("cartons.toml");
    let grid = GridSpec::around([-2.0, -2.0, 13.0, 5.0], 0.05).unwrap();
    let class = true_map(&world, &world.scans(), &grid, 1.0);
    let truth = Truth::of_world(world, Some(1.0)).unwrap();
    let on = |class: Vec<i8>| Map { grid, ..map_at(0, 0, grid.width, &class) };
    let same = scored(&on(class.clone()), &truth);
    let n = &same.numbers;
    assert_eq!((n.levels[0], n.zones.z1), (n.cells, n.cells));
    assert_eq!(
        (n.accuracy, n.danger, n.iou, n.f1, n.f1_tolerant),
        (Some(1.0), Some(0.0), Some(1.0), Some(1.0), Some(1.0))
    );
    assert_eq!((n.quality.brier, n.quality.auc, n.quality.ece), (Some(0.0), Some(1.0), Some(0.0)));
    assert!(n.quality.log_loss.unwrap() < 1e-5 && n.occupied > 100);
    let near = same.near.as_ref().unwrap();
    // the box 0.02..10.52 by 0.03..2.61, wider by 1 m and by 0.5 m: outward to whole cells, or by their centres
    assert_eq!((n.cells, near.cells), (251 * 93, 230 * 71));

    let negative = scored(&on(class.iter().map(|c| -c).collect()), &truth);
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
        assert_eq!(error.kind(), ErrorKind::Usage);
        error.to_string()
    };
    assert!(refused(GridSpec { resolution: 0.05, ..good.grid }).contains("--resolution"));
    assert!(refused(GridSpec { anchor: (0.03, 0.0), ..good.grid }).contains("--bounds"));
    assert!(refused(GridSpec { i0: 50, ..good.grid }).contains("no cell in common"));
    let unseen = Truth::Map(map(&[U; 25]));
    assert!(score("m", &good, &unseen, &options).unwrap_err().to_string().contains("both have seen"));
}

#[test]
fn a_worlds_file_is_a_truth() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/bend.toml");
    let world = World::open(&path).unwrap();
    let truth = Truth::open(&path, Some(3.0)).unwrap();
    let [x0, y0, x1, y1] = world.bounds();
    let grid = GridSpec::around([x0 - 4.0, y0 - 4.0, x1 + 4.0, y1 + 4.0], 0.1).unwrap();
    let class = true_map(&world, &world.scans(), &grid, 3.0);
    let same = scored(&Map { grid, ..map_at(0, 0, grid.width, &class) }, &truth);
    assert_eq!((same.numbers.levels[0], same.numbers.accuracy), (same.numbers.cells, Some(1.0)));
    assert!(same.numbers.occupied > 100 && same.near.unwrap().cells < same.numbers.cells);
    assert_eq!(Truth::open(&path, Some(f64::NAN)).unwrap_err().kind(), ErrorKind::Usage);
}
