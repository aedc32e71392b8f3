//! Walls from regions, and points.

use crate::common::{above, equal, near, p, point, region, right, way};
use echogrid::feature::rcd::Source;
use echogrid::feature::wall::{concave, find_features, point_features, points_at_corners, walls};
use echogrid::feature::{Rcd, Rules, Wall};
use echogrid::geometry::plane::Vector;

/// A region of the wall at y = 2, seen from (x, 0), ± 0.2 m.
fn at(x: f64) -> Rcd {
    region((x, 0.0), 90.0, 2.0, 0.2, (10.0 * x) as u64)
}

fn members(walls: &[Wall]) -> Vec<Vec<usize>> {
    walls.iter().map(|w| w.rcds.clone()).collect()
}

#[test]
fn regions_of_one_line_are_one_wall_over_gaps_up_to_half_a_metre() {
    let found = walls(&[at(0.0), at(0.8)]);
    assert_eq!(members(&found), [vec![0, 1]], "a gap of 0.4 m");
    let wall = &found[0];
    near(wall.normal, (0.0, 1.0), 1e-9);
    equal(wall.offset, 2.0);
    // along it is to the left: from x = 1.0 to −0.2
    near(wall.ends()[0], (1.0, 2.0), 1e-9);
    near(wall.ends()[1], (-0.2, 2.0), 1e-9);
    assert_eq!(members(&walls(&[at(0.0), at(1.0)])), [vec![0], vec![1]], "a gap of 0.6 m");
    assert_eq!(members(&walls(&[at(0.0), at(1.6), at(0.8)])), [vec![0, 1, 2]], "by the one between");
}

#[test]
fn regions_that_are_not_quite_of_one_line_need_a_smaller_gap() {
    // 7 cm off: within 12, not within 6 as one line
    let other = |x: f64| region((x, 0.07), 90.0, 2.0, 0.2, 9);
    assert_eq!(walls(&[at(0.0), other(0.55)]).len(), 1, "a gap of 0.15 m");
    assert_eq!(walls(&[at(0.0), other(0.65)]).len(), 2, "a gap of 0.25 m");
    // 13 cm off, or turned by 11°: another wall
    assert_eq!(walls(&[at(0.0), region((0.3, 0.13), 90.0, 2.0, 0.2, 9)]).len(), 2);
    assert_eq!(walls(&[at(0.0), region((0.3, 0.0), 101.0, 2.0, 0.2, 9)]).len(), 2);
}

#[test]
fn the_two_sides_of_a_wall_are_two_faces() {
    let other_side = region((0.0, 4.0), 270.0, 2.0, 0.2, 1);
    let found = walls(&[at(0.0), other_side]);
    assert_eq!(members(&found), [vec![0], vec![1]]);
    assert!(found[0].front(p(0.0, 0.0)) > 0.0 && found[0].front(p(0.0, 4.0)) < 0.0);
    assert!(found[1].front(p(0.0, 0.0)) < 0.0 && found[1].front(p(0.0, 4.0)) > 0.0);
    equal(found[0].front(p(7.0, 0.5)), 1.5);
}

#[test]
fn a_line_goes_through_feet_that_spread_else_it_is_the_closest_s_tangent() {
    let (a, b) = (at(0.0), region((0.6, 0.0), 90.0, 2.03, 0.2, 1));
    let found = walls(&[a.clone(), b.clone()]);
    assert_eq!(found.len(), 1);
    for rcd in [&a, &b] {
        equal(found[0].front(rcd.foot), 0.0);
    }
    near(found[0].normal, way(90.0 + (0.05f64).atan().to_degrees()), 1e-9);
    let close = region((0.2, 0.0), 90.0, 2.03, 0.2, 1);
    let found = walls(&[close, a]);
    near(found[0].normal, (0.0, 1.0), 1e-12);
    equal(found[0].offset, 2.0);
}

#[test]
fn a_nearer_foot_weighs_more() {
    // three feet of a line at y = 1 and one 6 cm above, from 1 m and from 4 m: 1/(2.5 cm)² and 1/(4 cm)²
    let foot = |x: f64, y: f64, range: f64| region((x, y - range), 90.0, range, 0.5, 1);
    let all = [foot(0.0, 1.0, 1.0), foot(1.0, 1.06, 4.0), foot(2.0, 1.0, 1.0)];
    let found = walls(&all);
    assert_eq!(found.len(), 1);
    let (near_weight, far_weight) = (1.0 / 0.025f64.powi(2), 1.0 / 0.04f64.powi(2));
    let mean = 1.0 + 0.06 * far_weight / (2.0 * near_weight + far_weight);
    equal(found[0].offset, mean);
}

#[test]
fn a_single_region_that_is_not_clear_is_no_wall_and_two_are() {
    let vague = |x: f64| Rcd { clear: false, ..at(x) };
    assert_eq!(walls(&[vague(0.0)]), []);
    assert_eq!(walls(&[vague(0.0), vague(0.5)]).len(), 1);
    assert_eq!(walls(&[point((0.0, 0.0), 90.0, 2.0, 1)]), []);
}

#[test]
fn what_is_far_does_not_change_walls() {
    let near: Vec<Rcd> = (0..5).map(|k| at(0.5 * f64::from(k))).collect();
    let mut all = near.clone();
    all.extend((0..50).map(|k| region((1e3 + 0.4 * f64::from(k), 0.0), 90.0, 2.0, 0.2, 100)));
    assert_eq!(walls(&near)[..], walls(&all)[..1]);
    assert_eq!(walls(&all).len(), 2);
}

#[test]
fn walls_meet_where_each_stands_before_the_other() {
    let (a, b) = (right(3.0, 0.0, 3.5), above(4.0, 0.0, 2.5));
    near(concave(&a, &b).unwrap(), (3.0, 4.0), 1e-9);
    // an edge, seen from outside: the one above goes on behind the one on the right
    assert_eq!(concave(&a, &above(4.0, 3.5, 6.0)), None);
    assert_eq!(concave(&right(3.0, 4.5, 6.0), &b), None);
    // 20° and 30° between them
    let slanted =
        |degrees: f64| Wall { normal: way(90.0 - degrees), offset: 1.0, extent: [0.0, 1.0], rcds: Vec::new() };
    let across = Wall { normal: Vector::new(0.0, 1.0), offset: 2.0, extent: [8.0, 9.0], rcds: Vec::new() };
    assert_eq!(concave(&across, &slanted(20.0)), None);
    assert!(concave(&across, &slanted(30.0)).is_some());
}

/// What is seen of the corner (3, 4) from (0.5, 0.5), ± so many degrees.
fn of_corner(turned: f64) -> Rcd {
    let (x, y) = (2.5, 3.5f64);
    region((0.5, 0.5), y.atan2(x).to_degrees() + turned, x.hypot(y), 0.1, 5)
}

#[test]
fn a_region_where_walls_meet_is_a_point_even_of_one_scan() {
    let mut rcds = vec![of_corner(0.0), of_corner(10.0), region((0.5, 0.5), 200.0, 4.3, 0.1, 5)];
    let found = points_at_corners(&mut rcds, &[right(3.0, 0.0, 3.5), above(4.0, 0.0, 2.5)]);
    // within 5 cm and 3 % of 4.3 m: 10° are 75 cm off
    assert_eq!(found, [0]);
    assert_eq!([rcds[0].source, rcds[1].source], [Source::Point, Source::Wall]);
    let points = point_features(&rcds, &found);
    assert_eq!(points.len(), 1);
    near(points[0].at, (3.0, 4.0), 1e-9);
    assert_eq!(point_features(&rcds, &[]), [], "one scan alone is none");
    // a region that one of the walls is made of is no point
    let own = Wall { rcds: vec![0], ..right(3.0, 0.0, 3.5) };
    assert_eq!(points_at_corners(&mut [of_corner(0.0)], &[own, above(4.0, 0.0, 2.5)]), [0usize; 0]);
}

#[test]
fn points_of_two_scans_within_15_cm_are_one() {
    let seen = |x: f64, scan: u64| point((x, 0.0), 90.0, 2.0, scan);
    let found =
        point_features(&[seen(0.0, 1), seen(0.14, 2), seen(0.6, 3), seen(0.76, 4), seen(2.0, 5), seen(2.1, 5)], &[]);
    assert_eq!(found.len(), 1, "0.16 m are too far, and a scan can't confirm itself");
    near(found[0].at, (0.07, 2.0), 1e-9);
    assert_eq!(found[0].rcds, [0, 1]);
}

#[test]
fn the_paper_s_rules_know_no_points_at_corners() {
    let rcds = || vec![region((0.0, 1.0), 0.0, 3.0, 0.3, 1), region((1.0, 0.0), 90.0, 4.0, 0.3, 2), of_corner(0.0)];
    let ours = find_features(&mut rcds(), &Rules::default());
    assert_eq!((ours.walls.len(), ours.points.len()), (2, 1));
    let paper = find_features(&mut rcds(), &Rules { paper: true, ..Rules::default() });
    assert_eq!((paper.walls.len(), paper.points.len()), (3, 0));
}
