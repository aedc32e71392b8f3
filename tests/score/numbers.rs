//! Measures of probabilities, requirements, the table.

use crate::common::*;
use echogrid::ErrorKind;
use echogrid::evaluate::score::{Options, Quality, Requirement, Score, Truth, probabilities, score, table};
use echogrid::grid::Data;

fn close(found: Option<f64>, expected: f64) {
    assert!((found.unwrap() - expected).abs() < 1e-6, "{found:?}, not {expected}");
}

#[test]
fn probabilities_by_hand() {
    // Brier (.01 + .16 + .16 + .25 + .25)/5; log loss −(ln .9 + ln .6 + ln .6 + ln .5 + ln .5)/5.
    let cells = vec![(0.9, true), (0.6, true), (0.4, false), (0.5, true), (0.5, false)];
    let q = Quality::of(cells);
    close(q.brier, 0.83 / 5.0);
    close(q.log_loss, -(0.9f64.ln() + 2.0 * 0.6f64.ln() + 2.0 * 0.5f64.ln()) / 5.0);
    // Of six pairs five are in order and one is a tie.
    close(q.auc, 5.5 / 6.0);
    // Bins: .9 off by .1, .6 by .4, .4 by .4, the two of .5 by none.
    close(q.ece, (0.1 + 0.4 + 0.4) / 5.0);
    assert_eq!(Quality::of(Vec::new()), Quality::default());
    assert_eq!(Quality::of(vec![(1.0, true)]).auc, None);
    // The log loss of a certain error is finite; 1 lies in the last bin.
    close(Quality::of(vec![(1.0, false)]).log_loss, -(1e-6f64.ln()));
    close(Quality::of(vec![(1.0, true), (0.95, false)]).ece, 0.95 / 2.0);
    // All tied: no better than chance.
    close(Quality::of(vec![(0.3, true), (0.3, false), (0.3, false)]).auc, 0.5);
}

#[test]
fn each_methods_probability() {
    let f = |v: [f32; 2]| Data::F32(v.to_vec());
    let of = |layers: &[(&str, [f32; 2])], touched: [u8; 2]| {
        let mut map = map_at(0, 0, 2, &[E, O]);
        map.layers[0].data = Data::U8(touched.to_vec());
        map.layers.extend(layers.iter().map(|(name, v)| layer(name, f(*v))));
        probabilities(&map)
    };
    assert_eq!(of(&[("log_odds", [0.0, 1.0]), ("p_occ", [0.25, 0.75])], [1, 1]), [0.25, 0.75]);
    assert_eq!(of(&[("emp", [0.5, 0.0]), ("occ", [0.0, 1.0]), ("map", [-0.5, 1.0])], [1, 1]), [0.25, 1.0]);
    assert_eq!(of(&[("empty", [0.5, 0.0]), ("full", [0.25, 0.5]), ("unknown", [0.25, 0.5])], [1, 1]), [0.375, 0.75]);
    assert_eq!(of(&[("count", [0.0, 15.0])], [0, 1]), [0.5, 1.0]);
    assert_eq!(of(&[("hits", [0.0, 3.0]), ("passes", [0.0, 1.0])], [1, 1]), [0.5, 0.75]);
    assert_eq!(of(&[], [1, 1]), [0.0, 1.0]);
}

#[test]
fn decided_by_probability_if_asked() {
    let mut shown = map_at(0, 0, 4, &[E; 4]);
    shown.layers.push(layer("p_occ", Data::F32(vec![0.61, 0.6, 0.39, 0.9])));
    shown.layers[0].data = Data::U8(vec![1, 1, 1, 0]);
    let truth = Truth::World { bounds: [0.0, 0.0, 0.4, 0.1], r_max: 0.0, draw: Box::new(|_| Ok(vec![O, U, E, U])) };
    let options = Options { tolerance: 1, decide: Some((0.6, 0.4)) };
    assert_eq!(score("m", &shown, &truth, &options).unwrap().numbers.levels[0], 4);
}

#[test]
fn requirements() {
    let truth = five(E, O, None);
    let score = scored(&map(&truth), &world(&truth));
    let check = |text: &str| text.parse::<Requirement>().unwrap().check(&score);
    for (text, held) in [
        ("danger<=0", true),
        ("danger < 0", false),
        ("accuracy == 1", true),
        ("levels.0>=25", true),
        ("zones.z5>0", false),
        ("z5==0", true),
        ("near.z1>=25", true),
        ("near.zones.z1>25", false),
        ("near.auc>0.9", true),
        ("occupied_found==1", true),
    ] {
        assert_eq!(check(text).unwrap().held, held, "{text}");
    }
    let error = check("dangr<1").unwrap_err();
    assert!(error.to_string().contains("did you mean \"danger\"") && error.kind() == ErrorKind::Usage, "{error}");
    for text in ["danger", "<1", "danger<=", "danger<=x", "danger=1", "danger<=nan", "a!b"] {
        assert!(text.parse::<Requirement>().is_err(), "{text}");
    }
    // What has no value holds nothing.
    let empty = scored(&map(&[E; 25]), &world(&[E; 25]));
    let check = |text: &str| text.parse::<Requirement>().unwrap().check(&empty).unwrap();
    assert_eq!((check("danger<=1").held, check("danger<=1").value), (false, None));
    let against_map = scored(&map(&truth), &Truth::Map(map(&truth)));
    let near = "near.danger<1".parse::<Requirement>().unwrap().check(&against_map).unwrap_err();
    assert!(near.to_string().contains("only a world"), "{near}");
}

#[test]
fn the_table_marks_the_best() {
    let truth = five(E, O, None);
    let good = scored(&map(&truth), &world(&truth));
    let bad = Score { path: "runs/b/".into(), ..scored(&map(&five(E, E, None)), &world(&truth)) };
    let table = table(&[good, bad]);
    let line = |name: &str| table.lines().find(|l| l.starts_with(name)).unwrap().split_whitespace().collect::<Vec<_>>();
    assert_eq!(table.lines().next().unwrap().split_whitespace().collect::<Vec<_>>(), ["m", "b"]);
    assert_eq!(line("danger  "), ["danger", "0.000", "*", "1.000"]);
    assert_eq!(line("left unknown"), ["left", "unknown", "0.0", "%", "0.0", "%"]);
    assert_eq!(line("near: Z5 cells"), ["near:", "Z5", "cells", "0", "*", "1"]);
}
