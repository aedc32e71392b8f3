//! Regions of constant depth of circular scans. At 2 m one surface is heard 9.2° to each side and 4 readings suffice; at 0.5 m 13°
//! and 5 are wanted. Readings differ by at most 4 cm at 2 m.

use crate::common::{CIRCLE, circle, near, plane, way};
use echogrid::feature::rcd::{Source, regions};
use echogrid::geometry::plane::Point;

const CENTRE: Point = Point::new(3.0, -1.0);

#[test]
fn a_plane_s_foot_and_normal() {
    for degrees in [36.0, 90.0, 133.2, 225.0, 306.0] {
        let found = regions(&circle(CENTRE, 4, |h| plane(h, degrees, 2.0, 9.0)));
        assert_eq!(found.len(), 1);
        let (rcd, normal) = (&found[0], way(degrees));
        near(rcd.foot, CENTRE + 2.0 * normal, 1e-3);
        near(rcd.normal, normal, 1e-9);
        assert!((rcd.range - 2.0).abs() < 1e-9 && (rcd.half - 2.0 * 9f64.to_radians().sin()).abs() < 1e-9);
        assert_eq!((rcd.count, rcd.scan, rcd.source, rcd.centre), (11, 4, Source::Wall, CENTRE));
        // 800 readings stand before this scan
        let first = 801 + ((degrees - 9.0) / 1.8).round() as u64;
        assert_eq!(rcd.lines, [first, first + 10]);
    }
}

#[test]
fn a_run_goes_on_over_the_circle_s_start() {
    for degrees in [0.0, 3.6, 356.4] {
        let found = regions(&circle(CENTRE, 0, |h| plane(h, degrees, 2.0, 9.0)));
        assert_eq!(found.len(), 1, "{degrees}");
        near(found[0].normal, way(degrees), 1e-9);
        assert_eq!(found[0].count, 11);
    }
}

#[test]
fn the_order_of_the_readings_does_not_matter() {
    let scan = circle(CENTRE, 0, |h| plane(h, 90.0, 2.0, 9.0).or(plane(h, 180.0, 1.5, 9.0)));
    let mut turned = scan.clone();
    turned.reverse();
    turned.rotate_left(71);
    assert_eq!(regions(&scan).len(), 2);
    assert_eq!(regions(&scan), regions(&turned));
}

/// A plane at a bearing, with other readings in place of some.
fn with(degrees: f64, others: &[(usize, Option<f64>)]) -> Vec<(u32, f64)> {
    let first = ((degrees - 10.8) / 1.8).round() as i64;
    let range = |h: f64| {
        let place = ((h / 1.8).round() as i64 - first).rem_euclid(200);
        let other = others.iter().find(|(k, _)| *k as i64 == place);
        other.map_or(plane(h, degrees, 2.0, 10.8), |(_, range)| *range)
    };
    let found = regions(&circle(CENTRE, 0, range));
    found.iter().map(|r| (r.count, r.range)).collect()
}

#[test]
fn strays_and_drop_outs_do_not_part_a_run_wherever_it_lies() {
    // 13 readings; at 0° the circle begins in the middle of them, and with something wrong it is cut there
    for degrees in [90.0, 0.0, 7.2, 352.8] {
        for others in [
            &[(6, None)][..],
            &[(6, Some(1.0))],
            &[(5, None), (6, None), (7, None)],
            &[(4, Some(1.0)), (8, Some(1.0))],
            &[(4, Some(1.0)), (8, None)],
            &[(3, Some(3.0)), (6, Some(1.0)), (9, Some(3.0))],
        ] {
            let found = with(degrees, others);
            assert_eq!(found.len(), 1, "{degrees}° {others:?}: {found:?}");
            assert_eq!(found[0].0 as usize, 13 - others.len(), "{degrees}° {others:?}");
            assert!((found[0].1 - 2.0).abs() < 1e-3, "{degrees}° {others:?}");
        }
    }
}

#[test]
fn four_missing_echoes_end_a_run() {
    let found = with(90.0, &[(5, None), (6, None), (7, None), (8, None)]);
    assert_eq!(found.iter().map(|r| r.0).collect::<Vec<_>>(), [5, 4]);
}

#[test]
fn surfaces_at_other_ranges_are_not_one() {
    // 3 cm are ¾ of what readings may differ: a step of 2.5 cm is of one surface, one of 5 cm isn't
    let step = |by: f64| {
        let range = |h: f64| plane(h, 90.0, 2.0, 10.8).map(|z| if h > 90.5 { z + by } else { z });
        regions(&circle(CENTRE, 0, range)).iter().map(|r| r.count).collect::<Vec<_>>()
    };
    assert_eq!(step(0.025), [13]);
    assert_eq!(step(0.05), [7, 6]);
}

#[test]
fn too_short_a_run_is_none() {
    let run = |d: f64, many: usize| {
        let last = 90.0 + 1.8 * (many - 1) as f64;
        let range = |h: f64| (h > 89.5 && h < last + 0.5).then_some(d);
        regions(&circle(CENTRE, 0, range)).len()
    };
    assert_eq!([run(2.0, 3), run(2.0, 4)], [0, 1]);
    assert_eq!([run(0.5, 4), run(0.5, 5)], [0, 1]);
}

#[test]
fn a_run_wider_than_one_surface_is_heard_gives_two() {
    // 10.14° with the loudest echo: up to 23.9° are one region; 36° are two of the 20.3° at their ends
    let run = |many: usize| {
        let last = 90.0 + 1.8 * (many - 1) as f64;
        regions(&circle(CENTRE, 0, |h| (h > 89.5 && h < last + 0.5).then_some(2.0)))
    };
    assert_eq!(run(14).len(), 1);
    assert_eq!(run(15).len(), 2);
    let two = run(21);
    assert_eq!(two.iter().map(|r| r.count).collect::<Vec<_>>(), [12, 12]);
    near(two[0].normal, way(99.9), 1e-9);
    near(two[1].normal, way(116.1), 1e-9);
    assert!(two.iter().all(|r| (r.range - 2.0 - CIRCLE).abs() < 1e-3));
}

#[test]
fn bearings_too_far_apart_are_no_run() {
    // every other one: 3.6°
    let scan = circle(CENTRE, 0, |h| plane(h, 90.0, 1.0, 20.0));
    let sparse: Vec<_> = scan.iter().copied().step_by(2).collect();
    assert_eq!(regions(&sparse), []);
    // a scan with a hole: the runs on both sides are of two surfaces, though nothing stands between
    let range = |h: f64| plane(h, 90.0, 2.0, 9.0).or(plane(h, 180.0, 2.0, 9.0));
    let all = circle(CENTRE, 0, range);
    let holed: Vec<_> = all.into_iter().filter(|p| p.range.is_some()).collect();
    assert_eq!(regions(&holed).iter().map(|r| r.count).collect::<Vec<_>>(), [11, 11]);
}

#[test]
fn nothing_comes_of_nothing() {
    assert_eq!(regions(&[]), []);
    assert_eq!(regions(&circle(CENTRE, 0, |_| None)), []);
    assert_eq!(regions(&circle(CENTRE, 0, |h| (h == 90.0).then_some(2.0))), []);
    // the middle of a round room: no bearing stands out
    assert_eq!(regions(&circle(CENTRE, 0, |_| Some(2.0))), []);
}
