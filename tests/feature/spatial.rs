//! A list by position: the items in the squares of 2 m that a box meets, in the order of insertion.

use crate::common::{Numbers, p};
use echogrid::feature::spatial::SpatialList;

#[test]
fn a_box_gives_all_within_it_in_the_order_they_came_and_little_else() {
    let mut numbers = Numbers(1);
    let mut things = SpatialList::default();
    assert!(things.is_empty() && things.within([f64::NEG_INFINITY, -1.0, f64::INFINITY, 1.0]).is_empty());
    let places: Vec<_> = (0..2000).map(|_| p(100.0 * numbers.next() - 50.0, 100.0 * numbers.next() - 50.0)).collect();
    places.iter().enumerate().for_each(|(k, at)| things.push(*at, k));
    assert_eq!((things.len(), things.all().len()), (2000, 2000));
    for _ in 0..50 {
        let (x, y, w, h) = (90.0 * numbers.next() - 50.0, 90.0 * numbers.next() - 50.0, numbers.next(), numbers.next());
        let inside = |k: &usize, rim: f64| {
            let at = places[*k];
            at.x >= x - rim && at.x <= x + 9.0 * w + rim && at.y >= y - rim && at.y <= y + 9.0 * h + rim
        };
        let found = things.within([x, y, x + 9.0 * w, y + 9.0 * h]);
        let found: Vec<usize> = found.iter().map(|k| things.all()[*k as usize]).collect();
        assert!(found.windows(2).all(|w| w[0] < w[1]));
        assert!((0..2000).filter(|k| inside(k, 0.0)).all(|k| found.binary_search(&k).is_ok()));
        assert!(found.iter().all(|k| inside(k, 2.0)), "no more than a square around it");
    }
}

#[test]
fn a_box_without_end_gives_everything_and_far_places_are_places() {
    let mut things = SpatialList::default();
    for (k, at) in [p(0.0, 0.0), p(1e6, -1e6), p(-1e12, 1e12), p(1e300, 0.0)].into_iter().enumerate() {
        things.push(at, k);
    }
    let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
    assert_eq!(things.within([low, low, high, high]), [0, 1, 2, 3]);
    assert_eq!(things.within([1e6 - 1.0, -1e6 - 1.0, 1e6 + 1.0, -1e6 + 1.0]), [1]);
    assert_eq!(things.within([-1.0, -1.0, 1e7, 1.0]), [0]);
}

#[test]
fn the_squares_on_the_rim_of_a_box_count_as_a_whole_up_to_their_upper_sides() {
    let mut things = SpatialList::default();
    for (k, x) in [-0.1, 0.0, 1.9, 2.0, 3.999, 4.0].into_iter().enumerate() {
        things.push(p(x, 1.0), k);
        things.push(p(1.0, x), k);
    }
    // the box from 1 to 3 meets the squares from 0 to 2 and from 2 to 4
    assert_eq!(things.within([1.0, 1.0, 3.0, 3.0]), [2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(things.within([1.0, 1.0, 1.5, 1.5]), [2, 3, 4, 5]);
}
