//! The free limit of a sensor at the origin that looks up the y axis, on cells of 0.1 m: a line at rest passes through cells up to
//! half a cell before it, and 0.01 m more is left.

use crate::common::{above, equal, p, right, way};
use echogrid::feature::limit::{Limit, LimitKind, Obstacles};
use echogrid::feature::{Corner, Features, PointFeature, Wall};
use echogrid::geometry::plane::{Point, Vector};

const UP: Vector = Vector::new(0.0, 1.0);

/// The limit so many degrees to the left of the axis; ends count up to 90° off it.
fn limit(features: &Features, degrees: f64) -> Limit {
    let obstacles = Obstacles::near(features, p(0.0, 0.0), 9.0, 0.1);
    let sector = obstacles.sector((p(0.0, 0.0), UP), 15f64.to_radians(), std::f64::consts::FRAC_PI_2, |_| true);
    sector.limit(way(90.0 + degrees), degrees.to_radians().sin())
}

fn of(walls: Vec<Wall>) -> Features {
    Features { walls, ..Features::default() }
}

fn points(at: &[Point]) -> Features {
    let points = at.iter().map(|at| PointFeature { at: *at, rcds: Vec::new() }).collect();
    Features { points, ..Features::default() }
}

#[test]
fn a_wall_ends_it_before_the_cells_that_it_passes_through() {
    let wall = of(vec![above(2.0, -3.0, 3.0)]);
    let straight = limit(&wall, 0.0);
    assert_eq!(straight.kind, LimitKind::Wall);
    equal(straight.distance, 2.0);
    equal(straight.free, 2.0 - 0.06);
    let slanted = limit(&wall, 10.0);
    let cos = 10f64.to_radians().cos();
    equal(slanted.distance, 2.0 / cos);
    equal(slanted.free, 1.94 / cos);
    // a diagonal one passes through cells farther from it: ½ · (0.6 + 0.8) of a cell
    let diagonal = of(vec![Wall { normal: Vector::new(0.6, 0.8), offset: 1.6, extent: [-3.0, 3.0], rcds: Vec::new() }]);
    equal(limit(&diagonal, 0.0).distance, 2.0);
    equal(limit(&diagonal, 0.0).free, 2.0 - 0.08 / 0.8);
    // either face
    let back = of(vec![Wall { normal: Vector::new(0.0, -1.0), offset: -2.0, extent: [-3.0, 3.0], rcds: Vec::new() }]);
    assert_eq!((limit(&back, 0.0).kind, limit(&back, 0.0).distance), (LimitKind::Wall, 2.0));
}

#[test]
fn the_nearest_wall_or_leg_counts() {
    let mut two = of(vec![above(3.0, -3.0, 3.0), above(2.0, -0.2, 3.0)]);
    equal(limit(&two, 0.0).distance, 2.0);
    equal(limit(&two, 15.0).distance, 3.0 / 15f64.to_radians().cos());
    let leg = Some([p(-1.0, 1.5), p(1.0, 1.5)]);
    two.corners.push(Corner { at: p(-1.0, 1.5), walls: [0, 1], probability: 1.0, extrapolated_walls: [leg, None] });
    assert_eq!((limit(&two, 0.0).kind, limit(&two, 0.0).distance), (LimitKind::Wall, 1.5));
    let obstacles = Obstacles::near(&two, p(0.0, 0.0), 9.0, 0.1);
    assert_eq!(obstacles.first_wall(p(0.0, 0.0), UP), Some(1.5));
    assert_eq!(obstacles.first_wall(p(0.0, 0.0), -UP), None);
}

#[test]
fn between_two_ends_it_is_the_safe_line() {
    let gapped = of(vec![above(2.0, -3.0, -0.4), above(2.0, 0.4, 3.0)]);
    let line = limit(&gapped, 0.0);
    assert_eq!(line.kind, LimitKind::SafeLine);
    equal(line.distance, 2.0);
    equal(line.free, 1.94);
    equal(line.length, 0.8);
    assert_eq!(limit(&gapped, 14.0).kind, LimitKind::Wall, "tan 14° · 2 m = 0.5 m is on the wall");
    // ends at unequal distances: the line from (−0.4, 2) to (0.4, 3) meets the axis at 2.5
    let slanted = points(&[p(-0.4, 2.0), p(0.4, 3.0)]);
    equal(limit(&slanted, 0.0).distance, 2.5);
}

#[test]
fn a_safe_line_before_a_wall_is_short_and_both_its_ends_are_nearer() {
    let door = |half: f64, wall: f64| {
        let mut all = points(&[p(-half, 2.0), p(half, 2.0)]);
        all.walls.push(above(wall, -9.0, 9.0));
        limit(&all, 0.0)
    };
    assert_eq!((door(0.5, 3.0).kind, door(0.5, 3.0).distance), (LimitKind::SafeLine, 2.0));
    assert_eq!((door(0.61, 3.0).kind, door(0.61, 3.0).distance), (LimitKind::Wall, 3.0), "1.22 m");
    // its ends are √4.25 = 2.06 m away
    assert_eq!(door(0.5, 2.05).kind, LimitKind::Wall);
    assert_eq!(door(0.5, 2.07).kind, LimitKind::SafeLine);
}

#[test]
fn a_line_of_the_features_ends_it() {
    let mut all = of(vec![above(3.0, -9.0, 9.0)]);
    all.lines.push([p(-0.3, 1.0), p(0.3, 1.0)]);
    assert_eq!((limit(&all, 0.0).kind, limit(&all, 0.0).distance), (LimitKind::SafeLine, 1.0));
    equal(limit(&all, 0.0).free, 0.94);
    all.walls.push(above(0.5, -1.0, 1.0));
    assert_eq!((limit(&all, 0.0).kind, limit(&all, 0.0).distance), (LimitKind::Wall, 0.5));
}

#[test]
fn with_one_end_alone_it_is_its_distance_or_its_wall_s_prolongation() {
    let one = limit(&points(&[p(0.3, 2.0)]), 0.0);
    assert_eq!((one.kind, one.length), (LimitKind::SafeLine, f64::INFINITY));
    equal(one.distance, 0.3f64.hypot(2.0));
    equal(one.free, one.distance - 0.06);
    // the wall would go on at y = 2; its other end, below the sensor's front, isn't seen
    let wall = of(vec![above(2.0, 0.3, 3.0)]);
    equal(limit(&wall, 0.0).distance, 2.0);
    // where the prolongation is farther than the end, the end counts
    equal(limit(&wall, 13.0).distance, 0.3f64.hypot(2.0));
    // a wall along the way has two ends on one side: the nearer in bearing counts, and its prolongation lies on the other side
    let side = of(vec![right(0.3, 2.0, 2.5)]);
    equal(limit(&side, 10.0).distance, 0.3f64.hypot(2.5));
}

#[test]
fn with_nothing_there_is_no_limit() {
    let none = limit(&Features::default(), 0.0);
    assert_eq!((none.kind, none.distance, none.free), (LimitKind::Unlimited, f64::INFINITY, f64::INFINITY));
    assert_eq!(limit(&points(&[p(0.3, -2.0)]), 0.0).kind, LimitKind::Unlimited, "behind the sensor");
    assert_eq!(limit(&points(&[p(0.3, 20.0)]), 0.0).kind, LimitKind::Unlimited, "out of reach");
}

#[test]
fn ends_that_are_hidden_or_too_far_aside_do_not_count() {
    // a wall hides the left end by more than 10 cm: the right one is alone
    let mut all = points(&[p(-0.4, 2.0), p(0.4, 2.0)]);
    all.walls.push(above(1.5, -0.4, -0.2));
    // now the left end of the pair is the nearest wall's right end (−0.2, 1.5): the line to (0.4, 2) meets x = 0 at 1.667
    equal(limit(&all, 0.0).distance, 1.5 + 0.5 / 3.0);
    all.walls[0] = above(1.95, -0.4, -0.38);
    let line = limit(&all, 0.0);
    assert!(line.distance > 1.94, "what is nearer by 5 cm hides nothing: {line:?}");
    let obstacles = Obstacles::near(&all, p(0.0, 0.0), 9.0, 0.1);
    let narrow = obstacles.sector((p(0.0, 0.0), UP), 5f64.to_radians(), 5f64.to_radians(), |_| true);
    assert_eq!(narrow.limit(UP, 0.0).kind, LimitKind::Unlimited, "11° off the axis");
    let chosen = obstacles.sector((p(0.0, 0.0), UP), 15f64.to_radians(), 1.5, |end| end.point == Some(1));
    equal(chosen.limit(UP, 0.0).distance, 0.4f64.hypot(2.0));
}

#[test]
fn a_limit_never_lies_behind_the_sensor() {
    let close = of(vec![above(0.01, -3.0, 3.0)]);
    assert_eq!(limit(&close, 0.0).free, 0.0);
    let end = points(&[p(0.001, 0.03)]);
    assert_eq!(limit(&end, 0.0).free, 0.0);
}
