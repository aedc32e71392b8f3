//! The four cases of a reading, from a sensor at the origin that looks up the y axis.

use crate::common::{above, equal, gap, near, p, ping, way};
use echogrid::feature::decide::{Case, Decision, decide};
use echogrid::feature::limit::Obstacles;
use echogrid::feature::{Corner, Features, PointFeature, Rules, Wall};

fn decided(features: &Features, range: Option<f64>) -> Decision {
    let obstacles = Obstacles::near(features, p(0.0, 0.0), 6.0, 0.1);
    decide(&ping((0.0, 0.0), 90.0, range), features, &obstacles, &Rules::default())
}

fn case(features: &Features, range: Option<f64>) -> Case {
    decided(features, range).case
}

fn of(walls: Vec<Wall>) -> Features {
    Features { walls, ..Features::default() }
}

#[test]
fn on_before_and_behind_a_wall() {
    let wall = of(vec![above(2.0, -3.0, 3.0)]);
    // P is ½ at 5.9 cm
    for (z, expected) in [
        (2.0, Case::Associated),
        (1.95, Case::Associated),
        (2.05, Case::Associated),
        (1.94, Case::Routine),
        (1.0, Case::Routine),
        (2.06, Case::Routine),
        (2.14, Case::Routine),
        (2.16, Case::Outlier),
        (4.9, Case::Outlier),
    ] {
        assert_eq!(case(&wall, Some(z)), expected, "{z}");
    }
}

#[test]
fn what_is_associated_but_hidden_is_an_outlier() {
    let two = of(vec![above(3.0, -3.0, 3.0), above(2.0, -0.5, 0.5)]);
    let decision = decided(&two, Some(3.0));
    assert_eq!(decision.case, Case::Outlier);
    equal(decision.association.best(), 1.0);
    // by a leg, too
    let mut leg = of(vec![above(3.0, -3.0, 3.0)]);
    let across = Some([p(-0.5, 2.0), p(0.5, 2.0)]);
    leg.corners.push(Corner { at: p(-0.5, 2.0), walls: [0, 0], probability: 1.0, extrapolated_walls: [across, None] });
    assert_eq!(case(&leg, Some(3.0)), Case::Outlier);
    // hidden beside the axis is not hidden
    assert_eq!(case(&of(vec![above(3.0, -3.0, 3.0), above(2.0, 0.1, 0.5)]), Some(3.0)), Case::Associated);
}

#[test]
fn behind_a_safe_line_or_a_single_end() {
    let gapped = of(vec![above(2.0, -3.0, -0.3), above(2.0, 0.3, 3.0)]);
    assert_eq!(case(&gapped, Some(3.0)), Case::Behind);
    assert_eq!(case(&gapped, Some(2.14)), Case::Routine);
    assert_eq!(case(&gapped, Some(1.0)), Case::Routine);
    let one = of(vec![above(2.0, 0.3, 3.0)]);
    assert_eq!(case(&one, Some(3.0)), Case::Behind);
    // what comes from a feature behind a line is believed
    let mut seen = gapped;
    seen.points.push(PointFeature { at: p(0.0, 3.0), rcds: Vec::new() });
    assert_eq!(case(&seen, Some(3.0)), Case::Associated);
}

#[test]
fn without_features_all_is_routine() {
    let nothing = decided(&Features::default(), Some(3.0));
    assert_eq!(nothing.case, Case::Routine);
    assert!(nothing.limits.iter().chain(&nothing.free).all(|f| *f == f64::INFINITY));
}

#[test]
fn a_missing_echo_behind_a_wall_is_an_outlier_else_it_says_nothing() {
    assert_eq!(case(&of(vec![above(2.0, -3.0, 3.0)]), None), Case::Outlier);
    assert_eq!(case(&of(vec![above(4.9, -3.0, 3.0)]), None), Case::Routine, "it would come from 5 m");
    assert_eq!(case(&of(vec![above(2.0, -3.0, -0.3), above(2.0, 0.3, 3.0)]), None), Case::Routine);
    let none = decided(&Features::default(), None);
    assert_eq!(none.case, Case::Routine);
    equal(none.association.other(), 1.0);
}

#[test]
fn the_rays_are_21_from_the_right_edge_to_the_left_with_the_limit_of_each() {
    let decision = decided(&of(vec![above(2.0, -3.0, 0.1)]), Some(2.0));
    for (k, degrees) in [(0, 75.0), (5, 82.5), (10, 90.0), (20, 105.0)] {
        near(decision.rays[k], way(degrees), 1e-12);
    }
    // up to 2.86° to the right the wall is met; farther right its one end ends it, 2.0025 m away or its prolongation
    for k in 0..21 {
        let cos = decision.rays[k].y;
        let expected = if k >= 9 { 2.0 / cos } else { gap((0.0, 0.0), (0.1, 2.0)).min(2.0 / cos) };
        equal(decision.limits[k], expected);
        assert!(decision.free[k] < decision.limits[k]);
    }
}
