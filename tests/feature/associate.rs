//! Which feature a reading came from. The walls are x = 3 and y = 4, seen from below and from the left; they meet at (3, 4).

use crate::common::{Coordinates, above, equal, p, ping, right};
use echogrid::feature::associate::{Association, associate};
use echogrid::feature::{Corner, Features, PointFeature, Rules};

fn room() -> Features {
    let corner = Corner { at: p(3.0, 4.0), walls: [0, 1], probability: 1.0, extrapolated_walls: [None; 2] };
    Features { walls: vec![right(3.0, -1.0, 4.0), above(4.0, -1.0, 3.0)], corners: vec![corner], ..Features::default() }
}

fn of(features: &Features, at: impl Coordinates, degrees: f64, z: f64) -> Association {
    associate(&ping(at, degrees, Some(z)), z, features, &Rules::default())
}

fn gaussian(d: f64) -> f64 {
    (-d * d / (2.0 * 0.05 * 0.05)).exp()
}

#[test]
fn a_wall_s_peak_is_1_and_5_cm_off_it_is_a_deviation() {
    let exact = of(&room(), (0.0, 1.0), 90.0, 3.0);
    assert_eq!(exact.wall.unwrap().0, 1);
    equal(exact.wall.unwrap().1, 1.0);
    assert_eq!((exact.corner, exact.point), (None, None));
    assert!(exact.other() < 1e-9);
    for d in [-0.05, 0.05] {
        let off = of(&room(), (0.0, 1.0), 90.0, 3.0 + d);
        equal(off.weights()[0], gaussian(0.05));
        equal(off.other(), 1.0 - gaussian(0.05));
        equal(off.best(), gaussian(0.05));
    }
    assert_eq!(of(&room(), (0.0, 1.0), 90.0, 2.8).wall, None, "four deviations are nothing");
}

#[test]
fn beyond_a_wall_s_end_the_end_counts() {
    // 3 cm to the left of (−1, 4)
    equal(of(&room(), (-1.03, 1.0), 90.0, 3.0).weights()[0], gaussian(0.03));
    // and 3 cm left, 4 cm short
    equal(of(&room(), (-1.03, 1.0), 90.0, 2.96).weights()[0], gaussian(0.05));
}

#[test]
fn from_behind_a_face_it_is_none_of_its() {
    // looking down from y = 5 onto y = 4, and left from x = 4 onto x = 3
    assert_eq!(of(&room(), (0.0, 5.0), 270.0, 1.0), Association::default());
    assert_eq!(of(&room(), (4.0, 1.0), 180.0, 1.0), Association::default());
    equal(Association::default().other(), 1.0);
}

#[test]
fn the_best_wall_counts() {
    // tip at (2.98, 3.99)
    let found = of(&room(), (0.98, 3.99), 0.0, 2.0);
    assert_eq!(found.wall.unwrap().0, 1);
    equal(found.wall.unwrap().1, gaussian(0.01));
}

#[test]
fn a_corner_is_told_by_the_range_anywhere_in_the_beam() {
    // from (0, 0) the corner is 5 m away at 53.13°
    for (turned, range, p) in [(0.0, 5.0, 1.0), (14.0, 5.0, 1.0), (-14.0, 4.95, gaussian(0.05)), (16.0, 5.0, 0.0)] {
        let found = of(&room(), (0.0, 0.0), 53.130_102 + turned, range);
        equal(found.weights()[1], p);
    }
    // from behind one of its walls it is no corner
    assert_eq!(of(&room(), (0.0, 5.0), -18.4, 10f64.sqrt()).corner, None);
    let without = Rules { corners: false, ..Rules::default() };
    assert_eq!(associate(&ping((0.0, 0.0), 60.0, Some(5.0)), 5.0, &room(), &without).corner, None);
}

#[test]
fn the_paper_s_corner_is_told_by_the_projected_point() {
    let paper = Rules { paper: true, ..Rules::default() };
    let found = associate(&ping((0.0, 0.0), 53.130_102_354, Some(4.8)), 4.8, &room(), &paper);
    equal(found.weights()[1], (-0.5f64).exp());
    // 10° aside is 0.87 m away at 5 m
    assert_eq!(associate(&ping((0.0, 0.0), 63.13, Some(5.0)), 5.0, &room(), &paper).corner, None);
}

#[test]
fn wall_and_corner_may_both_be_and_nothing_else_is_what_remains() {
    let found = of(&room(), (0.0, 0.0), 53.130_102_354, 4.96);
    // 4 cm before the corner: 3.2 cm before y = 4, and 2.4 before x = 3
    let [wall, corner, _] = found.weights();
    assert_eq!(found.wall.unwrap().0, 0);
    assert!((wall - gaussian(0.024)).abs() < 1e-9 && (corner - gaussian(0.04)).abs() < 1e-9);
    equal(found.other(), (1.0 - wall) * (1.0 - corner));
}

#[test]
fn a_point_counts_where_it_exceeds_twice_the_others() {
    let with = |(x, y): (f64, f64)| Features { points: vec![PointFeature { at: p(x, y), rcds: Vec::new() }], ..room() };
    // alone, in the beam and aside
    let found = of(&with((0.0, 2.0)), (0.0, 0.0), 104.0, 2.05);
    assert_eq!(found.point.unwrap().0, 0);
    equal(found.weights()[2], gaussian(0.05));
    assert_eq!(of(&with((0.0, 2.0)), (0.0, 0.0), 106.0, 2.0).point, None);
    // 7 cm before the wall, where a point is: the wall's 0.375 is less than half of 1
    let found = of(&with((0.0, 3.93)), (0.0, 0.0), 90.0, 3.93);
    assert_eq!((found.wall, found.point.unwrap().0), (None, 0));
    // 5 cm before it: the wall's 0.607 is more
    let found = of(&with((0.0, 3.95)), (0.0, 0.0), 90.0, 3.95);
    assert_eq!((found.wall.unwrap().0, found.point), (1, None));
}

#[test]
fn far_features_do_not_change_it() {
    let mut all = room();
    all.walls.extend((0..20).map(|k| above(4.0, 100.0 + f64::from(k), 100.5 + f64::from(k))));
    all.points.push(PointFeature { at: p(200.0, 0.0), rcds: Vec::new() });
    for degrees in (0..360).step_by(7) {
        let one = |f: &Features| of(f, (0.0, 0.5), f64::from(degrees), 3.2);
        assert_eq!(one(&room()), one(&all));
    }
}
