//! Safe lines between ends that are near each other.

use crate::common::{above, gap, p, region, right};
use echogrid::feature::line::lines;
use echogrid::feature::{Corner, Features, PointFeature, Rcd};
use echogrid::geometry::plane::Point;

/// Two walls at y = 2 with a gap around x = 0, made of region 0.
fn gapped(wide: f64) -> Features {
    let mut walls = vec![above(2.0, -3.0, -wide / 2.0), above(2.0, wide / 2.0, 3.0)];
    walls[0].rcds = vec![0];
    Features { walls, ..Features::default() }
}

/// A sighting from (x, 0) upwards.
fn sighting(x: f64, range: f64) -> Rcd {
    region((x, 0.0), 90.0, range, 0.2, 1)
}

fn length([a, b]: [Point; 2]) -> f64 {
    gap(a, b)
}

#[test]
fn a_gap_of_up_to_70_cm_is_closed() {
    let found = lines(&gapped(0.6), &[sighting(-1.0, 2.0)], &[]);
    assert_eq!(found.len(), 1);
    assert!((length(found[0]) - 0.6).abs() < 1e-9 && found[0].iter().all(|e| (e.y - 2.0).abs() < 1e-9));
    assert_eq!(lines(&gapped(0.71), &[sighting(-1.0, 2.0)], &[]), [] as [[Point; 2]; 0]);
    // ends that touch need none
    assert_eq!(lines(&gapped(0.005), &[sighting(-1.0, 2.0)], &[]).len(), 0);
}

#[test]
fn the_robot_s_path_opens_it() {
    let closed = |step: [Point; 2]| lines(&gapped(0.6), &[sighting(-1.0, 2.0)], &[step]).len();
    assert_eq!(closed([p(0.1, 1.5), p(0.1, 2.5)]), 0);
    assert_eq!(closed([p(0.1, 2.5), p(0.1, 1.5)]), 0, "either way");
    assert_eq!(closed([p(0.1, 1.5), p(0.1, 1.99)]), 1);
    assert_eq!(closed([p(0.4, 1.5), p(0.4, 2.5)]), 1, "beside it");
    assert_eq!(closed([p(0.1, 1.5), p(0.1, 1.5)]), 1, "a robot that stands");
}

#[test]
fn a_sighting_opens_it_unless_it_ends_at_once() {
    let closed = |rcd: Rcd| lines(&gapped(0.6), &[rcd], &[]).len();
    assert_eq!(closed(sighting(0.1, 2.2)), 0);
    assert_eq!(closed(sighting(0.1, 2.09)), 1);
    // what no feature is made of opens nothing
    assert_eq!(lines(&gapped(0.6), &[sighting(-1.0, 2.0), sighting(0.1, 4.0)], &[]).len(), 1);
}

#[test]
fn a_short_wall_s_own_ends_are_not_joined_and_points_and_corners_are_ends() {
    let own = Features { walls: vec![right(1.0, 0.0, 0.5)], ..Features::default() };
    assert_eq!(lines(&own, &[], &[]).len(), 0);
    let point = |x: f64| PointFeature { at: p(x, 0.0), rcds: Vec::new() };
    let corner = Corner { at: p(0.0, 0.5), walls: [0, 0], probability: 1.0, extrapolated_walls: [None; 2] };
    let three = Features { points: vec![point(0.0), point(0.6)], corners: vec![corner], ..Features::default() };
    // 0.6, 0.5 and √0.61 = 0.78 m
    assert_eq!(lines(&three, &[], &[]), [[p(0.0, 0.0), p(0.6, 0.0)], [p(0.0, 0.0), p(0.0, 0.5)]]);
}
