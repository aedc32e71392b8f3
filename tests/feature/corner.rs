//! Concave corners of the walls x = 3 and y = 4, at (3, 4).

use crate::common::{above, equal, gap, near, p, point, region, right};
use echogrid::feature::corner::{corners, cut};
use echogrid::feature::rcd::Source;
use echogrid::feature::{Corner, Features, PointFeature, Rcd, Rules, Wall};
use echogrid::geometry::plane::{Point, Vector};
use nalgebra::{Isometry2, UnitComplex};

const AT: Point = Point::new(3.0, 4.0);

/// The walls, up to so far from where they meet; made of no region.
fn walls(beside: f64, below: f64) -> Features {
    let walls = vec![right(3.0, 0.0, 4.0 - below), above(4.0, -1.0, 3.0 - beside)];
    Features { walls, ..Features::default() }
}

/// A region of a point, seen from (0.5, 0.5), so much farther away than the corner.
fn answer(farther: f64) -> Rcd {
    let (x, y) = (2.5, 3.5f64);
    point((0.5, 0.5), y.atan2(x).to_degrees(), x.hypot(y) + farther, 1)
}

fn found(features: &Features, rcds: &[Rcd], path: &[[Point; 2]]) -> Vec<Corner> {
    corners(features, rcds, path, &Rules::default())
}

#[test]
fn a_corner_that_answers_is_found_with_its_legs() {
    let all = found(&walls(0.5, 1.0), &[answer(0.0)], &[]);
    assert_eq!(all.len(), 1);
    near(all[0].at, AT, 1e-9);
    assert_eq!(all[0].walls, [0, 1]);
    equal(all[0].probability, 1.0);
    let extrapolated_walls = all[0].extrapolated_walls.map(Option::unwrap);
    near(extrapolated_walls[0][0], AT, 1e-9);
    near(extrapolated_walls[0][1], (3.0, 3.0), 1e-9);
    near(extrapolated_walls[1][1], (2.5, 4.0), 1e-9);
    // no leg along a wall that reaches it
    let all = found(&walls(0.5, -0.1), &[answer(0.0)], &[]);
    assert_eq!(all[0].extrapolated_walls[0], None);
}

#[test]
fn what_does_not_answer_from_there_is_none() {
    assert_eq!(found(&walls(0.5, 1.0), &[], &[]), []);
    // 4.3 m away ranges may differ by 6.3 cm; 3 cm more are a bell's flank: e^−½ = 0.61, 4 cm: 0.41
    let tolerance = 5.0 * (0.004 + 0.002 * (gap((0.5, 0.5), AT) + 0.09));
    let all = found(&walls(0.5, 1.0), &[answer(0.09)], &[]);
    let rest: f64 = 0.09 - tolerance;
    equal(all[0].probability, (-rest * rest / (2.0 * 0.03 * 0.03)).exp());
    assert_eq!(found(&walls(0.5, 1.0), &[answer(0.11)], &[]), []);
    // a wall's region there is no point
    assert_eq!(found(&walls(0.5, 1.0), &[Rcd { source: Source::Wall, ..answer(0.0) }], &[]), []);
    // but where points aren't told from walls any region but the walls' own is
    let rules = Rules { points: false, ..Rules::default() };
    assert_eq!(corners(&walls(0.5, 1.0), &[Rcd { source: Source::Wall, ..answer(0.0) }], &[], &rules).len(), 1);
}

#[test]
fn walls_seen_three_times_that_nearly_meet_do() {
    let seen = |many: usize, features: &mut Features| {
        let from = |k: usize| region((0.0, 1.0 + 0.2 * k as f64), 0.0, 3.0, 0.2, k as u64);
        let below = |k: usize| region((0.2 * k as f64, 0.0), 90.0, 4.0, 0.2, k as u64);
        features.walls[0].rcds = (0..many).collect();
        features.walls[1].rcds = (many..2 * many).collect();
        (0..many).map(from).chain((0..many).map(below)).collect::<Vec<_>>()
    };
    for (beyond, many, corners) in [(0.29, 3, 1), (0.31, 3, 0), (0.29, 2, 0)] {
        let mut features = walls(beyond, beyond);
        let rcds = seen(many, &mut features);
        assert_eq!(found(&features, &rcds, &[]).len(), corners, "{beyond} {many}");
    }
}

#[test]
fn a_convex_edge_is_none() {
    let edge = Features { walls: vec![right(3.0, 0.0, 4.0), above(4.0, 3.0, 6.0)], ..Features::default() };
    assert_eq!(found(&edge, &[answer(0.0)], &[]), []);
}

#[test]
fn a_corner_lies_at_the_walls_ends() {
    assert_eq!(found(&walls(-0.55, 0.5), &[answer(0.0)], &[]).len(), 1, "55 cm inside one");
    assert_eq!(found(&walls(-0.65, 0.5), &[answer(0.0)], &[]), []);
    // 4.5 m beyond an end, then a bell's side of 0.6 m: 0.7 m more are 0.506, 0.75 m 0.458
    let far = |beyond: f64| {
        let walls = vec![right(3.0, -9.0, 4.0 - beyond), above(4.0, 0.0, 2.9)];
        found(&Features { walls, ..Features::default() }, &[answer(0.0)], &[])
    };
    equal(far(5.2)[0].probability, (-0.7f64 * 0.7 / 0.72).exp());
    assert_eq!(far(5.25), []);
}

#[test]
fn nothing_crosses_its_legs() {
    let features = walls(2.0, 1.0);
    // the leg along y = 4 goes from x = 3 to 1
    assert_eq!(found(&features, &[answer(0.0)], &[[p(2.0, 3.5), p(2.0, 4.5)]]), [], "the robot went through");
    assert_eq!(found(&features, &[answer(0.0)], &[[p(0.5, 3.5), p(0.5, 4.5)], [p(2.0, 3.0), p(2.0, 3.9)]]).len(), 1);
    let mut with = features.clone();
    with.walls.push(Wall { normal: Vector::new(1.0, 0.0), offset: 2.0, extent: [3.5, 4.5], rcds: Vec::new() });
    assert_eq!(found(&with, &[answer(0.0)], &[]).len(), 0, "a wall stands across");
    // sightings of another wall through the leg: as many as answer from the corner are let be
    let beyond = |x: f64| region((x, 3.0), 90.0, 3.0, 0.2, 5);
    let mut with = features;
    with.walls.push(Wall { rcds: vec![1], ..above(6.0, 1.5, 2.5) });
    assert_eq!(found(&with, &[answer(0.0), beyond(2.0)], &[]).len(), 1);
    with.walls[2].rcds = vec![1, 2];
    assert_eq!(found(&with, &[answer(0.0), beyond(2.0), beyond(1.8)], &[]).len(), 0);
}

#[test]
fn of_corners_within_20_cm_the_likeliest_stays() {
    let mut features = walls(0.5, 1.0);
    // another wall 10 cm to the right: its corner is at (3.1, 4)
    features.walls.push(right(3.1, 0.0, 3.0));
    let all = found(&features, &[answer(0.0)], &[]);
    assert_eq!(all.len(), 1);
    near(all[0].at, AT, 1e-9);
}

#[test]
fn a_wall_that_overshoots_is_cut_and_a_point_there_is_the_corner() {
    let mut features = walls(-0.3, 0.5);
    features.corners = found(&features, &[answer(0.0)], &[]);
    features.points = [p(3.1, 4.1), p(2.0, 2.0)].map(|at| PointFeature { at, rcds: Vec::new() }).to_vec();
    cut(&mut features);
    let ends = features.walls[1].ends();
    near(ends[0], AT, 1e-9);
    near(ends[1], (-1.0, 4.0), 1e-9);
    near(features.walls[0].ends()[1], (3.0, 3.5), 1e-9);
    assert_eq!(features.points.iter().map(|s| s.at).collect::<Vec<_>>(), [p(2.0, 2.0)]);
}

#[test]
fn the_frame_does_not_matter() {
    // all of it turned by 37° and moved
    let turn = UnitComplex::new(37f64.to_radians());
    let moved = Isometry2::from_parts(Vector::new(20.0, -7.0).into(), turn);
    let mut features = walls(0.5, 1.0);
    for wall in &mut features.walls {
        let ends = wall.ends().map(|end| moved * end);
        wall.normal = turn * wall.normal;
        wall.offset = wall.normal.dot(&ends[0].coords);
        wall.extent = ends.map(|e| wall.place(e));
    }
    let rcd = answer(0.0);
    let rcd = Rcd { centre: moved * rcd.centre, foot: moved * rcd.foot, normal: turn * rcd.normal, ..rcd };
    let all = found(&features, &[rcd], &[]);
    assert_eq!(all.len(), 1);
    near(all[0].at, moved * AT, 1e-9);
}
