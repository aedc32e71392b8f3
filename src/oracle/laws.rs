//! Laws that the reference obeys on random readings.

use super::vectors::{reading, sonar};
use super::{OracleMap, map, updated_cells};
use crate::grid::GridSpec;
use crate::log::reading::{Outcome, Reading};
use crate::method::settings::Settings;
use proptest::prelude::*;

const RESOLUTION: f64 = 0.125;

fn grid() -> GridSpec {
    GridSpec { anchor: (0.0, 0.0), resolution: RESOLUTION, i0: -40, j0: -40, width: 80, height: 80 }
}

fn any_reading() -> impl Strategy<Value = Reading> {
    (-4.0..4.0, -4.0..4.0, -7.0..7.0, 0.0..4.0, 0..4u8).prop_map(|(x, y, heading, range, echo)| {
        reading(x, y, heading, range, if echo == 0 { Outcome::NoEcho } else { Outcome::Hit })
    })
}

fn any_readings() -> impl Strategy<Value = Vec<Reading>> {
    prop::collection::vec(any_reading(), 1..30)
}

fn run(grid: &GridSpec, readings: &[Reading], method: &str) -> OracleMap {
    map(grid, &[sonar(13.0)], readings, &Settings::of(method).unwrap(), None).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whole_cells_translate(readings in any_readings(), di in -9i64..9, dj in -9i64..9) {
        let moved_grid = GridSpec { i0: grid().i0 + di, j0: grid().j0 + dj, ..grid() };
        let moved: Vec<Reading> = readings.iter().map(|r| {
            let mut r = *r;
            // sixteenths of a metre move without rounding once a pose is a multiple of 2⁻³⁰
            let snap = |v: f64| (v * 1e6).round() / 1e6;
            r.record.pose.x = snap(r.record.pose.x) + di as f64 * RESOLUTION;
            r.record.pose.y = snap(r.record.pose.y) + dj as f64 * RESOLUTION;
            r
        }).collect();
        let still: Vec<Reading> = moved.iter().map(|r| {
            let mut r = *r;
            r.record.pose.x -= di as f64 * RESOLUTION;
            r.record.pose.y -= dj as f64 * RESOLUTION;
            r
        }).collect();
        for method in ["certainty", "dempster-shafer", "bayes", "himm"] {
            let (a, b) = (run(&grid(), &still, method), run(&moved_grid, &moved, method));
            prop_assert_eq!(&a.class, &b.class);
            prop_assert_eq!(&a.layers, &b.layers);
            prop_assert_eq!((a.updates, a.outside, a.empty_arc), (b.updates, b.outside, b.empty_arc));
        }
    }

    #[test]
    fn dempster_shafer_is_free_of_order(readings in any_readings()) {
        let a = run(&grid(), &readings, "dempster-shafer");
        let backwards: Vec<Reading> = readings.iter().rev().copied().collect();
        let b = run(&grid(), &backwards, "dempster-shafer");
        for (a, b) in a.layers.iter().zip(&b.layers) {
            for (x, y) in a.values.iter().zip(&b.values) {
                prop_assert!((x - y).abs() <= 1e-12);
            }
        }
    }

    #[test]
    fn masses_and_evidence_stay_in_range(readings in any_readings()) {
        let ds = run(&grid(), &readings, "dempster-shafer");
        for k in 0..grid().cells() {
            let m: Vec<f64> = ds.layers.iter().map(|l| l.values[k]).collect();
            prop_assert!(m[..3].iter().all(|v| (0.0..=1.0).contains(v)) && m[3] >= -1e-12);
            prop_assert!((m[0] + m[1] + m[2] - 1.0).abs() <= 1e-12);
        }
        let c = run(&grid(), &readings, "certainty");
        for layer in &c.layers[..2] {
            prop_assert!(layer.values.iter().all(|v| (0.0..=1.0 + 1e-12).contains(v)));
        }
        for map in [&ds, &c] {
            prop_assert!(map.layers.iter().all(|l| l.bound.iter().all(|b| b.is_finite() && *b >= 0.0)));
        }
    }

    #[test]
    fn every_update_is_counted_once(readings in any_readings()) {
        let settings = Settings::of("bayes").unwrap();
        let map = run(&grid(), &readings, "bayes");
        let each: u64 = readings.iter()
            .map(|r| updated_cells(&grid(), &sonar(13.0), r, &settings, None).unwrap().len() as u64)
            .sum();
        let total: u64 = map.interior.iter().chain(&map.arc).map(|c| u64::from(*c)).sum();
        prop_assert_eq!((map.updates, total), (each, each));
    }

    #[test]
    fn spans_miss_no_cell(r in any_reading(), half_width in 0.0..60.0f64, laser in any::<bool>()) {
        // a reading's cells are the same whether its rows are scanned in a large grid or cell by cell in grids of one
        let mut sensor = sonar(half_width);
        if laser {
            sensor.kind = crate::sensor::Kind::Laser;
        }
        for method in ["bayes", "himm"] {
            let settings = Settings::of(method).unwrap();
            let whole = updated_cells(&grid(), &sensor, &r, &settings, None).unwrap();
            let mut single = 0;
            for row in 0..80 {
                for column in 0..80 {
                    let one = GridSpec { i0: column - 40, j0: row - 40, width: 1, height: 1, ..grid() };
                    let found = updated_cells(&one, &sensor, &r, &settings, None).unwrap();
                    single += found.len();
                    let listed = whole.iter().any(|c| (c.column as i64, c.row as i64) == (column, row));
                    prop_assert_eq!(listed, found.len() == 1);
                }
            }
            prop_assert_eq!(single, whole.len());
        }
    }
}
