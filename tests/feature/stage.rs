//! The stage as a whole: when updates come out and in what order, and that nothing odd in a log harms it.

use crate::common::{BEARINGS, CIRCLE, Numbers, circle, gap, near, off, p, way};
use echogrid::feature::draw::Cells;
use echogrid::feature::rcd::Source;
use echogrid::feature::{Ping, Rules, Stage, Update};
use echogrid::geometry::plane::Point;

const CELLS: Cells = Cells { resolution: 0.1, epsilon: 0.05 };

/// What is heard at a bearing in a room from (0, 0) to (6, 4): a wall within 10° of its normal, else a corner within 8°.
fn room(centre: Point, degrees: f64) -> Option<f64> {
    let walls = [(0.0, 6.0 - centre.x), (90.0, 4.0 - centre.y), (180.0, centre.x), (270.0, centre.y)];
    let wall = walls.iter().find(|(normal, _)| off(degrees, *normal) <= 10.0);
    let z = wall.map(|(normal, d)| d - CIRCLE * off(degrees, *normal).to_radians().cos());
    let at = centre + CIRCLE * way(degrees);
    let corners = [p(0.0, 0.0), p(6.0, 0.0), p(6.0, 4.0), p(0.0, 4.0)];
    let seen = |c: &&Point| off((c.y - at.y).atan2(c.x - at.x).to_degrees(), degrees) <= 8.0;
    z.or_else(|| corners.iter().find(seen).map(|c| gap(*c, at))).filter(|z| *z <= 5.0)
}

/// A walk through the room there and back, 0.4 m a scan, moved by so much.
fn walk(scans: usize, moved: (f64, f64)) -> Vec<Vec<Ping>> {
    let place = |k: usize| {
        let s = (k as f64 * 0.4) % 8.0;
        p(1.0 + if s <= 4.0 { s } else { 8.0 - s }, 1.5 + 0.2 * (k % 5) as f64)
    };
    let scan = |k: usize| {
        let at = place(k);
        circle((at.x + moved.0, at.y + moved.1), k as u64, |h| room(at, h))
    };
    (0..scans).map(scan).collect()
}

/// The updates after each scan, and at the end.
fn run(scans: &[Vec<Ping>], rules: Rules) -> (Vec<Vec<Update>>, Stage) {
    let mut stage = Stage::new(rules, CELLS);
    let mut all = Vec::new();
    for scan in scans {
        let mut out = Vec::new();
        stage.scan(scan.clone(), &mut out);
        all.push(out);
    }
    let mut out = Vec::new();
    stage.finish(&mut out);
    all.push(out);
    (all, stage)
}

/// Whatever went in: in log order, each at most once, and only numbers.
fn sound(scans: &[Vec<Ping>]) -> Stage {
    let (all, stage) = run(scans, Rules::default());
    let numbers: Vec<u64> = all.iter().flatten().map(|u| u.number).collect();
    assert!(numbers.windows(2).all(|w| w[0] < w[1]), "in log order, once");
    let pings = scans.iter().map(Vec::len).sum::<usize>() as u64;
    assert_eq!(stage.counts.cases.iter().sum::<u64>(), pings, "each was decided once");
    for update in all.iter().flatten() {
        let parts = update.parts.iter().filter_map(|p| p.free.as_ref());
        let routine = update.routine.iter().flat_map(|r| [&r.free, &r.arc]).flatten();
        for v in parts.chain(routine).flat_map(|fan| &fan.vertices) {
            assert!(v.x.is_finite() && v.y.is_finite(), "{update:?}");
        }
        let ends = update.parts.iter().flat_map(|p| &p.occupied).flatten();
        assert!(ends.copied().all(|e| e.x.is_finite() && e.y.is_finite()));
        let weights = update.parts.iter().map(|p| p.weight).chain(update.routine.iter().map(|r| r.weight));
        assert!((weights.sum::<f64>() - 1.0).abs() < 1e-9, "{update:?}");
    }
    stage
}

#[test]
fn a_room_s_walls_and_corners_are_found() {
    let stage = sound(&walk(20, (0.0, 0.0)));
    let known = stage.feature_map();
    let sides = [(-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 1.0, 4.0), (1.0, 0.0, 6.0)];
    let mut seen = [false; 4];
    for wall in &known.features.walls {
        let is =
            |(x, y, offset): (f64, f64, f64)| gap(wall.normal, (x, y)) < 0.005 && (wall.offset - offset).abs() < 0.01;
        let side = sides.iter().position(|s| is(*s));
        seen[side.unwrap_or_else(|| panic!("no side of the room: {wall:?}"))] = true;
    }
    assert_eq!(seen, [true; 4]);
    assert_eq!(known.features.corners.len(), 4);
    for corner in &known.features.corners {
        let corners = [p(0.0, 0.0), p(6.0, 0.0), p(6.0, 4.0), p(0.0, 4.0)];
        let nearest = corners.iter().copied().min_by(|a, b| gap(*a, corner.at).total_cmp(&gap(*b, corner.at))).unwrap();
        near(corner.at, nearest, 0.01);
    }
    assert!(known.regions.iter().any(|r| r.source == Source::Point));
    assert!(known.features.members().all(|k| k < known.regions.len()));
    // most echoes are a feature's
    let [associated, outliers, behind, routine] = stage.counts.cases;
    assert!(associated > 1000 && outliers + behind > 0 && routine > 0, "{:?}", stage.counts);
}

#[test]
fn readings_are_held_for_5_m_and_let_go_half_a_metre_at_a_time() {
    let scans = walk(40, (0.0, 0.0));
    let (all, stage) = run(&scans, Rules::default());
    let centre = |k: usize| scans[k][0].centre();
    let mut travelled = vec![0.0];
    for k in 1..scans.len() {
        travelled.push(travelled[k - 1] + gap(centre(k - 1), centre(k)));
    }
    let first = all.iter().position(|out| !out.is_empty()).unwrap();
    assert!(travelled[first] >= 5.5 && travelled[first - 1] < 5.5);
    for (k, out) in all[..scans.len()].iter().enumerate() {
        for update in out {
            let own = update.number as usize / BEARINGS;
            assert!(travelled[k] - travelled[own] >= 5.0, "scan {own} came out after scan {k}");
        }
    }
    // at most 5.5 m and the scan that ends it are waiting
    let most = stage.counts.held as usize / BEARINGS;
    assert!((5.5 / 0.61) as usize <= most && most <= (5.5 / 0.4) as usize + 2, "{most}");
}

#[test]
fn without_a_hold_half_a_metre_is_enough() {
    let rules = Rules { hold: 0.0, ..Rules::default() };
    let (all, stage) = run(&walk(10, (0.0, 0.0)), rules);
    let first = all.iter().position(|out| !out.is_empty()).unwrap();
    assert!(first <= 2, "{first}");
    assert!(stage.counts.held <= 3 * BEARINGS as u64);
    let numbers: Vec<u64> = all.iter().flatten().map(|u| u.number).collect();
    assert!(numbers.windows(2).all(|w| w[0] < w[1]));
    assert_eq!(stage.counts.cases.iter().sum::<u64>(), 10 * BEARINGS as u64);
}

#[test]
fn a_robot_that_stands_fills_no_memory() {
    let mut numbers = Numbers(3);
    let mut stage = Stage::new(Rules::default(), CELLS);
    let (mut before, mut last) = (0u64, None);
    let mut out = Vec::new();
    for scan in 0..700 {
        let ranges: Vec<f64> = (0..BEARINGS).map(|_| 0.5 + 4.0 * numbers.next()).collect();
        stage.scan(circle((1.0, 1.0), scan, |h| Some(ranges[(h / 1.8).round() as usize])), &mut out);
        before += out.len() as u64;
        for update in out.drain(..) {
            assert!(last.replace(update.number).is_none_or(|l| l < update.number));
        }
    }
    // 140,000 readings without travel: half of the queue went each time it came to 65,536
    assert!(before > 90_000, "{before}");
    assert!(stage.counts.held <= 65_536 + BEARINGS as u64, "{}", stage.counts.held);
    stage.finish(&mut out);
    assert_eq!(stage.counts.cases.iter().sum::<u64>(), 140_000);
    assert!(out.iter().all(|u| last.replace(u.number).is_none_or(|l| l < u.number)));
}

#[test]
fn a_thousand_scans_of_one_place_tell_what_one_does() {
    let one = |k: u64| circle((2.0, 1.5), k, |h| room(p(2.0, 1.5), h));
    let stage = sound(&(0..1000).map(one).collect::<Vec<_>>());
    let (_, single) = run(&[one(0)], Rules::default());
    assert_eq!(stage.feature_map(), single.feature_map());
    assert!(stage.counts.regions >= 1000 * single.counts.regions);
}

#[test]
fn degenerate_scans_do_no_harm() {
    let at = |k: u64| (0.3 * k as f64, 0.1 * (k % 3) as f64);
    let scans = |one: &dyn Fn(u64) -> Vec<Ping>| (0..30).map(one).collect::<Vec<_>>();
    // no echo at all; one reading; nothing
    let silent = sound(&scans(&|k| circle(at(k), k, |_| None)));
    assert_eq!((silent.counts.regions, silent.feature_map().features.walls.len()), (0, 0));
    sound(&scans(&|k| circle(at(k), k, |_| Some(2.0)).drain(..1).collect()));
    sound(&[Vec::new(), Vec::new()]);
    // all ranges equal, and all but one; all at the sensor's nearest
    sound(&scans(&|k| circle(at(k), k, |_| Some(2.0))));
    sound(&scans(&|k| circle(at(k), k, |h| Some(if h == 90.0 { 1.0 } else { 2.0 }))));
    sound(&scans(&|k| circle(at(k), k, |_| Some(0.0))));
    // each bearing twice, and one bearing 200 times
    let doubled = |k: u64| {
        let mut all: Vec<Ping> = circle(at(k), k, |h| room(p(2.0, 2.0), h)).into_iter().flat_map(|p| [p, p]).collect();
        all.iter_mut().zip(k * 400..).for_each(|(p, n)| p.number = n);
        all
    };
    sound(&scans(&doubled));
    let same = |k: u64| {
        let mut all = vec![circle(at(k), k, |_| Some(2.0))[7]; 200];
        all.iter_mut().zip(k * 200..).for_each(|(p, n)| p.number = n);
        all
    };
    sound(&scans(&same));
}

#[test]
fn jumps_and_places_far_out_do_no_harm() {
    let far = |k: u64| [(0.0, 0.0), (1e6, -1e6), (-1e6, 3.0)][k as usize % 3];
    sound(&(0..30).map(|k| circle(far(k), k, |h| room(p(2.0, 2.0), h))).collect::<Vec<_>>());
    let stage = sound(&walk(20, (1e6, 1e6)));
    assert_eq!(stage.feature_map().features.corners.len(), 4);
    // readings of a few sensors, one a scan
    let ring = |k: u64| {
        let mut all = circle((0.1 * k as f64, 0.0), k, |h| room(p(2.0, 2.0), h));
        all.truncate(5);
        all.iter_mut().enumerate().for_each(|(s, p)| {
            (p.record.sensor, p.number) = (s as u32, 5 * k + s as u64);
        });
        all
    };
    sound(&(0..100).map(ring).collect::<Vec<_>>());
}

#[test]
fn what_is_far_away_changes_nothing_here() {
    let here = walk(20, (0.0, 0.0));
    let mut both = here.clone();
    both.extend(walk(20, (500.0, 300.0)));
    for (k, ping) in both[20..].iter_mut().flatten().enumerate() {
        (ping.number, ping.record.scan) = (4000 + k as u64, 20 + (k / BEARINGS) as u64);
    }
    let of = |scans: &[Vec<Ping>]| {
        let all: Vec<Update> = run(scans, Rules::default()).0.into_iter().flatten().collect();
        all.into_iter().filter(|u| u.number < 4000).collect::<Vec<_>>()
    };
    let (alone, with) = (of(&here), of(&both));
    assert_eq!(alone.len(), with.len());
    assert!(alone == with, "an update changed");
}

#[test]
fn the_same_log_gives_the_same_updates() {
    let scans = walk(30, (0.0, 0.0));
    assert!(run(&scans, Rules::default()).0 == run(&scans, Rules::default()).0);
}

#[test]
fn a_rule_turned_off_finds_nothing_of_its_kind() {
    let known = |rules: Rules| run(&walk(20, (0.0, 0.0)), rules).1.feature_map();
    let without = known(Rules { corners: false, ..Rules::default() });
    assert!(without.features.corners.is_empty() && !without.features.walls.is_empty());
    let without = known(Rules { points: false, ..Rules::default() });
    assert!(without.features.points.is_empty());
    let without = known(Rules { lines: false, ..Rules::default() });
    assert!(without.features.lines.is_empty());
    let paper = known(Rules { paper: true, ..Rules::default() });
    assert!(paper.regions.iter().all(|r| r.source == Source::Wall));
}
