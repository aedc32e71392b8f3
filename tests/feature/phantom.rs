//! What is seen through a wall is its mirror image.

use crate::common::{p, point, region};
use echogrid::feature::phantom::drop_phantoms;
use echogrid::feature::wall::{point_features, walls};
use echogrid::feature::{Features, Rcd};
use echogrid::geometry::plane::Point;

/// The features left of some regions: the y of the walls, the y of the points.
fn left(rcds: &[Rcd], path: &[[Point; 2]]) -> [Vec<f64>; 2] {
    let mut features = Features { walls: walls(rcds), points: point_features(rcds, &[]), ..Features::default() };
    drop_phantoms(&mut features, rcds, path);
    let walls = features.walls.iter().map(|w| w.at(0.0).y).collect();
    [walls, features.points.iter().map(|s| s.at.y).collect()]
}

/// A wall's regions at a height, seen from below at these x.
fn seen(y: f64, from: &[f64]) -> Vec<Rcd> {
    from.iter().enumerate().map(|(k, x)| region((*x, 0.0), 90.0, y, 0.3, k as u64)).collect()
}

#[test]
fn a_wall_behind_a_wall_goes_and_the_wall_stays() {
    let rcds = [seen(2.0, &[0.0, 0.5, 1.0]), seen(4.0, &[0.2, 0.7])].concat();
    assert_eq!(left(&rcds, &[]), [vec![2.0], Vec::new()]);
    // beside it, it is no image
    let rcds = [seen(2.0, &[0.0, 0.5, 1.0]), seen(4.0, &[2.2, 2.7])].concat();
    assert_eq!(left(&rcds, &[])[0], [2.0, 4.0]);
    // 15 cm behind, it may be the same wall
    for (y, many) in [(2.14, 2), (2.16, 1)] {
        let rcds = [seen(2.0, &[0.0, 0.5, 1.0]), seen(y, &[0.5])].concat();
        assert_eq!(left(&rcds, &[])[0].len(), many, "{y}");
    }
}

#[test]
fn half_of_the_sightings_may_pass_through() {
    // the second wall's first two sightings pass through the first wall (up to x = 1.3), its others beside it
    let second = |beside: &[f64]| [seen(2.0, &[0.0, 0.5, 1.0]), seen(4.0, &[0.8, 1.2]), seen(4.0, beside)].concat();
    assert_eq!(left(&second(&[1.8]), &[])[0], [2.0]);
    assert_eq!(left(&second(&[1.8, 2.2]), &[])[0], [2.0, 4.0]);
}

#[test]
fn a_point_behind_a_wall_goes() {
    let points = |x: f64| vec![point((x, 0.0), 90.0, 3.0, 7), point((x + 0.1, 0.0), 90.0, 3.0, 8)];
    assert_eq!(left(&[seen(2.0, &[0.0, 0.5]), points(0.2)].concat(), &[]), [vec![2.0], Vec::new()]);
    assert_eq!(left(&[seen(2.0, &[0.0, 0.5]), points(1.5)].concat(), &[]), [vec![2.0], vec![3.0]]);
}

#[test]
fn a_wall_that_the_robot_crossed_goes_and_hides_nothing() {
    let rcds = [seen(2.0, &[0.0, 0.5, 1.0]), seen(4.0, &[0.2, 0.7])].concat();
    assert_eq!(left(&rcds, &[[p(0.5, 1.5), p(0.5, 2.5)]])[0], [4.0]);
    // a path that stops before it, or passes beside it
    assert_eq!(left(&rcds, &[[p(0.5, 1.5), p(0.5, 1.9)], [p(1.5, 1.5), p(1.5, 2.5)]])[0], [2.0]);
}

#[test]
fn a_wall_that_more_look_through_than_see_it_goes_and_what_they_see_stays() {
    // two of five sightings pass through what was seen once
    let far = seen(4.0, &[0.4, 0.6, 1.0, 1.4, 1.8]);
    assert_eq!(left(&[seen(2.0, &[0.5]), far.clone()].concat(), &[])[0], [4.0]);
    assert_eq!(left(&[seen(2.0, &[0.4, 0.6]), far].concat(), &[])[0], [2.0, 4.0]);
}

/// Known: each makes the other fall in the first round, so that in the second nothing speaks against either.
#[test]
fn a_wall_that_all_look_through_stays_too() {
    let rcds = [seen(2.0, &[0.5]), seen(4.0, &[0.3, 0.5, 0.7])].concat();
    assert_eq!(left(&rcds, &[])[0], [2.0, 4.0]);
}

#[test]
fn what_few_saw_behind_a_short_safe_line_goes() {
    // two walls whose ends are 2g apart around x = 0, and another wall behind that gap
    let behind = |gap: f64, y: f64, from: &[f64]| {
        let sides = [seen(2.0, &[-gap - 0.3, -gap - 0.8]), seen(2.0, &[gap + 0.3, gap + 0.8])].concat();
        left(&[sides, seen(y, from)].concat(), &[])[0].len()
    };
    assert_eq!(behind(0.5, 3.0, &[0.0]), 2, "a line of 1 m");
    assert_eq!(behind(0.7, 3.0, &[0.0]), 3, "a line of 1.4 m is a door");
    assert_eq!(behind(0.5, 2.2, &[0.0]), 3, "20 cm behind it");
    assert_eq!(behind(0.5, 3.0, &[-0.3, -0.1, 0.1]), 2, "three scans");
    assert_eq!(behind(0.5, 3.0, &[-0.3, -0.1, 0.1, 0.3]), 3, "four scans are believed");
}

#[test]
fn nothing_and_far_things_change_nothing() {
    assert_eq!(left(&[], &[[p(0.0, 0.0), p(1.0, 0.0)]]), [Vec::<f64>::new(), vec![]]);
    let near = [seen(2.0, &[0.0, 0.5, 1.0]), seen(4.0, &[0.2, 0.7])].concat();
    let far = seen(2.5, &[500.0, 500.5, 501.0]);
    assert_eq!(left(&[near, far].concat(), &[[p(400.0, 0.0), p(401.0, 9.0)]])[0], [2.0, 2.5]);
}
