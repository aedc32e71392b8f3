//! Updates of decided readings: fans and lines, from a sensor at the origin that looks up the y axis, on cells of 0.1 m, ε 0.05 m.

use crate::common::{Numbers, above, equal, gap, near, p, ping, right, way};
use echogrid::feature::decide::{Case, Decision, decide};
use echogrid::feature::draw::{Cells, draw};
use echogrid::feature::limit::Obstacles;
use echogrid::feature::{Corner, Fan, Features, Ping, PointFeature, Rules, Update, Wall};
use echogrid::geometry::plane::{Point, intersect_ray};

const CELLS: Cells = Cells { resolution: 0.1, epsilon: 0.05 };

fn drawn(features: &Features, ping: &Ping) -> (Decision, Option<Update>) {
    let obstacles = Obstacles::near(features, ping.at, 7.0, CELLS.resolution);
    let decision = decide(ping, features, &obstacles, &Rules::default());
    let update = draw(ping, &decision, features, CELLS);
    (decision, update)
}

fn up(features: &Features, z: f64) -> (Decision, Update) {
    let (decision, update) = drawn(features, &ping((0.0, 0.0), 90.0, Some(z)));
    (decision, update.unwrap())
}

fn of(walls: Vec<Wall>) -> Features {
    Features { walls, ..Features::default() }
}

/// How far sides may leave what they stand for: 1/20 cell.
const STRAIGHT: f64 = 0.005;

/// How far a fan reaches from a sensor at each of its 21 bearings.
fn far(fan: &Fan, ping: &Ping) -> Vec<f64> {
    let sides: Vec<_> = fan.vertices.windows(2).map(|s| [s[0], s[1]]).collect();
    let heading = ping.record.pose.heading.to_degrees();
    let at = |k: usize| {
        // a hair inside the edges, where rounding may miss the outermost sides
        let ray = way(heading + (1.5 * k as f64 - 15.0) * (1.0 - 1e-9));
        // where rounding misses both of a vertex's sides it is the vertex
        let on = |v: &&Point| (**v - ping.at).perp(&ray).abs() < 1e-6;
        let vertices = fan.vertices.iter().filter(on).map(|v| gap(*v, ping.at));
        sides.iter().filter_map(|s| intersect_ray(ping.at, ray, *s)).chain(vertices).fold(f64::NAN, f64::max)
    };
    (0..21).map(at).collect()
}

/// The same from the origin, upwards.
fn reaches(fan: &Option<Fan>) -> Vec<f64> {
    far(fan.as_ref().unwrap(), &ping((0.0, 0.0), 90.0, None))
}

#[test]
fn a_wall_is_occupied_between_the_feet_of_the_cone_s_front() {
    let (_, update) = up(&of(vec![above(2.0, -3.0, 3.0)]), 2.0);
    let part = &update.parts[0];
    let foot = 2.0 * 15f64.to_radians().sin();
    assert_eq!((update.parts.len(), part.occupied.len()), (1, 1));
    near(part.occupied[0][0], (foot, 2.0), 1e-9);
    near(part.occupied[0][1], (-foot, 2.0), 1e-9);
    // free up to half a cell, and for the limit's sake 1 cm more, before it: all along
    for v in &part.free.as_ref().unwrap().vertices {
        equal(v.y, 1.94);
    }
}

#[test]
fn it_is_clipped_to_what_is_known_of_it_and_15_cm() {
    let (_, update) = up(&of(vec![above(2.0, -0.1, 0.2)]), 2.0);
    near(update.parts[0].occupied[0][0], (0.35, 2.0), 1e-9);
    near(update.parts[0].occupied[0][1], (-0.25, 2.0), 1e-9);
    // the rays at 15° meet the line at ± 0.54: no farther than z − ε there
    let free = reaches(&update.parts[0].free);
    assert!(free[0] <= 1.95 + 1e-9 && free[20] <= 1.95 + 1e-9, "{free:?}");
}

#[test]
fn the_weights_are_the_probabilities_and_sum_to_1() {
    let (_, exact) = up(&of(vec![above(2.0, -3.0, 3.0)]), 2.0);
    equal(exact.parts[0].weight, 1.0);
    equal(exact.routine.unwrap().weight, 0.0);
    let (_, off) = up(&of(vec![above(2.0, -3.0, 3.0)]), 1.95);
    equal(off.parts[0].weight, (-0.5f64).exp());
    equal(off.routine.unwrap().weight, 1.0 - (-0.5f64).exp());
}

#[test]
fn a_corner_is_half_a_metre_of_both_its_walls() {
    // walls up and to the right of the cone's middle, which looks at their corner 45° up
    let corner = Corner { at: p(2.0, 2.0), walls: [0, 1], probability: 1.0, extrapolated_walls: [None; 2] };
    let features = Features { corners: vec![corner], ..of(vec![right(2.0, -1.0, 2.0), above(2.0, -1.0, 2.0)]) };
    let (_, update) = drawn(&features, &ping((0.0, 0.0), 45.0, Some(8f64.sqrt())));
    let update = update.unwrap();
    // the wall's part comes first
    assert_eq!(update.parts.len(), 2);
    let part = &update.parts[1];
    for (line, end) in part.occupied.iter().zip([p(2.0, 1.5), p(1.5, 2.0)]) {
        near(line[0], (2.0, 2.0), 1e-9);
        near(line[1], end, 1e-9);
    }
    for v in &part.free.as_ref().unwrap().vertices {
        assert!(v.x < 1.95 && v.y < 1.95, "in front of both: {v:?}");
    }
    // near kind, the cone's front ends sooner than half a metre from it
    let (_, update) = drawn(&features, &ping((1.5, 1.5), 45.0, Some(0.5f64.sqrt())));
    let foot = 1.5 + 0.5f64.sqrt() * 30f64.to_radians().sin();
    let line = update.unwrap().parts[1].occupied[0];
    near(line[1], (2.0, foot), 1e-9);
}

#[test]
fn a_point_is_occupied_where_it_is_and_free_before() {
    let features = Features { points: vec![PointFeature { at: p(0.0, 2.0), rcds: Vec::new() }], ..Features::default() };
    let (_, update) = up(&features, 1.98);
    assert_eq!(update.parts[0].occupied, [[p(0.0, 2.0); 2]]);
    let free = reaches(&update.parts[0].free);
    // a single end: free up to 0.06 m before it, or to z − ε
    assert!(free.iter().all(|f| (f - 1.93).abs() < STRAIGHT), "{free:?}");
    assert!(update.parts[0].free.as_ref().unwrap().vertices.len() < 8, "an arc takes few sides");
}

#[test]
fn an_outlier_only_frees_up_to_the_limit_and_elsewhere_to_the_least() {
    // a wall across the right half of the cone, the other half open to a wall end alone
    let (decision, update) = up(&of(vec![above(2.0, -3.0, 3.0)]), 4.0);
    assert_eq!(decision.case, Case::Outlier);
    let routine = update.routine.unwrap();
    assert!(update.parts.is_empty() && !routine.occupies && routine.arc.is_none() && routine.weight == 1.0);
    for v in &routine.free.unwrap().vertices {
        equal(v.y, 1.94);
    }
    let mut open = decision;
    (open.limits[0], open.free[0]) = (f64::INFINITY, f64::INFINITY);
    let update = draw(&ping((0.0, 0.0), 90.0, Some(4.0)), &open, &Features::default(), CELLS).unwrap();
    equal(reaches(&update.routine.unwrap().free)[0], 1.94);
}

#[test]
fn a_routine_reading_has_fans_only_where_a_limit_is_near() {
    let (_, update) = up(&Features::default(), 2.0);
    let routine = update.routine.unwrap();
    assert!(routine.occupies && routine.free.is_none() && routine.arc.is_none() && routine.weight == 1.0);
    // a wall 0.5 m behind the echo is none of its business, one 0.2 m behind is
    assert!(up(&of(vec![above(2.5, -3.0, 3.0)]), 2.0).1.routine.unwrap().free.is_none());
    let routine = up(&of(vec![above(2.2, -3.0, 3.0)]), 2.0).1.routine.unwrap();
    equal(reaches(&routine.free)[10], 2.14);
    equal(reaches(&routine.arc)[10], 2.2);
}

#[test]
fn a_missing_echo_frees_only_before_a_wall() {
    assert_eq!(drawn(&Features::default(), &ping((0.0, 0.0), 90.0, None)).1, None);
    let (_, update) = drawn(&of(vec![above(2.0, -3.0, 3.0)]), &ping((0.0, 0.0), 90.0, None));
    let update = update.unwrap();
    assert_eq!(update.reading.range, 5.0);
    equal(reaches(&update.routine.unwrap().free)[10], 1.94);
}

#[test]
fn a_quarter_of_a_cell_is_free_whatever_a_limit_says() {
    let (_, update) = up(&of(vec![above(0.01, -3.0, 3.0)]), 3.0);
    assert!(reaches(&update.routine.unwrap().free).iter().all(|f| (f - 0.025).abs() < STRAIGHT));
}

/// What holds of every update, whatever the features.
fn lawful(ping: &Ping, decision: &Decision, update: &Update, features: &Features) {
    let most = ping.range.unwrap_or(ping.reach) + 1.0;
    let fan = |fan: &Fan, limits: &[f64; 21]| {
        assert!((2..=21).contains(&fan.vertices.len()));
        for (far, limit) in far(fan, ping).into_iter().zip(limits) {
            assert!(far > 0.0 && far <= most + 1e-9, "{far}");
            assert!(far <= limit.max(0.025) + STRAIGHT, "{far} is beyond {limit}");
        }
        for (k, v) in fan.vertices.iter().enumerate() {
            let (x, y) = (v.x - ping.at.x, v.y - ping.at.y);
            let next = fan.vertices.get(k + 1).map(|n| x * (n.y - ping.at.y) - y * (n.x - ping.at.x));
            assert!(next.is_none_or(|cross| cross > 0.0), "clockwise at {k}");
        }
    };
    for part in &update.parts {
        part.free.iter().for_each(|f| fan(f, &decision.free));
        for end in part.occupied.iter().flatten() {
            assert!(end.x.is_finite() && end.y.is_finite());
        }
    }
    if let Some(routine) = &update.routine {
        routine.free.iter().for_each(|f| fan(f, &decision.free.map(|b| b.min(most))));
        routine.arc.iter().for_each(|f| fan(f, &decision.limits));
    }
    if let (Some((k, _)), Some(line)) =
        (decision.association.wall, update.parts.first().and_then(|p| p.occupied.first()))
    {
        let wall = &features.walls[k];
        assert!(line.iter().all(|e| wall.beyond(wall.place(*e)) <= 0.15 + 1e-9 && wall.front(*e).abs() < 1e-9));
    }
    let weights = update.parts.iter().map(|p| p.weight).chain(update.routine.iter().map(|r| r.weight));
    equal(weights.sum::<f64>(), 1.0);
    assert!(update.parts.len() <= 2);
}

#[test]
fn every_update_of_a_thousand_places_is_lawful() {
    let mut numbers = Numbers(7);
    let mut cases = [0; 4];
    let mut metre = |low: f64, high: f64| low + (high - low) * numbers.next();
    for _ in 0..1000 {
        let mut features = Features::default();
        for _ in 0..metre(0.0, 5.0) as usize {
            let (s, long) = (metre(-3.0, 3.0), metre(0.05, 3.0));
            let (normal, offset) = (way(metre(0.0, 360.0)), metre(0.0, 4.0));
            features.walls.push(Wall { normal, offset, extent: [s, s + long], rcds: Vec::new() });
        }
        for _ in 0..metre(0.0, 3.0) as usize {
            features.points.push(PointFeature { at: p(metre(-3.0, 3.0), metre(-3.0, 3.0)), rcds: Vec::new() });
        }
        features.lines.push([p(metre(-3.0, 3.0), metre(-3.0, 3.0)), p(metre(-3.0, 3.0), metre(-3.0, 3.0))]);
        if features.walls.len() > 1 {
            let at = p(metre(-3.0, 3.0), metre(-3.0, 3.0));
            let leg = Some([at, features.walls[0].ends()[0]]);
            features.corners.push(Corner { at, walls: [0, 1], probability: 0.9, extrapolated_walls: [leg, None] });
        }
        for _ in 0..20 {
            let range = (metre(0.0, 1.0) < 0.9).then(|| metre(0.2, 5.0));
            let ping = ping((metre(-0.5, 0.5), metre(-0.5, 0.5)), metre(0.0, 360.0), range);
            let (decision, update) = drawn(&features, &ping);
            cases[decision.case as usize] += 1;
            if let Some(update) = update {
                lawful(&ping, &decision, &update, &features);
            }
        }
    }
    assert!(cases.iter().all(|n| *n > 100), "every case is tried: {cases:?}");
}
