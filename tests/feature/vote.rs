//! Wall or point, by what regions say of each other. At 2 m two feet within 11 cm are the same place.

use crate::common::{point, region};
use echogrid::feature::Rcd;
use echogrid::feature::rcd::Source;
use echogrid::feature::vote::{same_place, vote};

fn voted(mut rcds: Vec<Rcd>) -> Vec<Source> {
    vote(&mut rcds);
    rcds.iter().map(|r| r.source).collect()
}

/// What is seen at (0, 2) from a place 2 m away, along a bearing in degrees.
fn of_one_place(degrees: f64) -> Rcd {
    let (sin, cos) = f64::to_radians(degrees).sin_cos();
    region((-2.0 * cos, 2.0 - 2.0 * sin), degrees, 2.0, 0.1, degrees as u64)
}

use Source::{Point, Wall};

#[test]
fn one_place_from_two_sides_is_a_point() {
    assert_eq!(voted(vec![of_one_place(90.0), of_one_place(110.0)]), [Point, Point]);
    // and one who says nothing else of it, far away, is asked nothing
    let far = region((9.0, 0.0), 90.0, 2.0, 0.1, 1);
    assert_eq!(voted(vec![of_one_place(90.0), far, of_one_place(110.0)]), [Point, Wall, Point]);
}

#[test]
fn two_places_on_one_line_are_a_wall() {
    // even if they were taken for points
    let (a, b) = (point((0.0, 0.0), 90.0, 2.0, 0), point((0.5, 0.0), 90.0, 2.0, 1));
    assert_eq!(voted(vec![a, b]), [Wall, Wall]);
}

#[test]
fn more_votes_win_and_a_draw_is_a_wall() {
    // a wall's region at (0, 2), and another that is on its line: one vote each way for the first
    let beside = region((0.5, 0.0), 90.0, 2.0, 0.1, 9);
    assert_eq!(voted(vec![of_one_place(90.0), of_one_place(110.0), beside.clone()]), [Wall, Point, Wall]);
    // 70° and 110° are 40° apart and both more than 6° from 90°: two votes against one
    let all = vec![of_one_place(90.0), of_one_place(110.0), of_one_place(70.0), beside];
    assert_eq!(voted(all), [Point, Point, Point, Wall]);
}

#[test]
fn a_place_says_nothing_of_itself_nor_of_what_is_far() {
    // scans 10 cm apart
    let (a, b) = (region((0.0, 0.0), 90.0, 2.0, 0.1, 0), region((0.1, 0.0), 90.0, 2.0, 0.1, 1));
    let mut two = vec![Rcd { source: Point, ..a }, b];
    vote(&mut two);
    assert_eq!(two[0].source, Wall, "without votes it is a wall");
    // scans 14 cm apart don't see that it is one place, those 16 cm apart do
    for (apart, source) in [(0.14, Wall), (0.16, Point)] {
        let rcds = vec![region((0.0, 0.0), 90.0, 0.5, 0.1, 0), region((apart, 0.0), 90.0 + 115.0 * apart, 0.5, 0.1, 1)];
        assert_eq!(voted(rcds), [source; 2], "{apart}");
    }
}

#[test]
fn who_knows_keeps_it_and_still_has_a_vote() {
    let known = Rcd { fitted: true, source: Wall, ..of_one_place(90.0) };
    assert_eq!(voted(vec![known, of_one_place(110.0)]), [Wall, Point]);
}

#[test]
fn the_order_does_not_matter() {
    let mut all: Vec<Rcd> = [90.0, 110.0, 70.0].map(of_one_place).to_vec();
    all.extend((1..6).map(|k| region((0.3 * f64::from(k), 0.0), 90.0, 2.0, 0.1, 20 + k as u64)));
    let straight = voted(all.clone());
    assert!(straight.contains(&Point) && straight.contains(&Wall));
    all.reverse();
    let mut back = voted(all);
    back.reverse();
    assert_eq!(straight, back);
}

#[test]
fn the_same_place_grows_with_the_range() {
    assert!((same_place(2.0) - 0.11).abs() < 1e-12);
}
