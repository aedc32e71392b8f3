//! Features beside a map: the places in the files are those of the walls, whatever the picture's scale.

use crate::common::{map, write};
use echogrid::ErrorKind;
use echogrid::feature::rcd::{Rcd, Source};
use echogrid::feature::{Corner, FeatureMap, Features, PointFeature, Wall};
use echogrid::geometry::plane::{Point, Vector};
use echogrid::grid::GridSpec;
use echogrid::output::write_features;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn region(scan: u64, count: u32, lines: [u64; 2]) -> Rcd {
    let (centre, foot, normal) = (Point::origin(), Point::new(1.0, 0.0), Vector::x());
    let (source, fitted, clear) = (Source::Wall, false, true);
    Rcd { centre, foot, normal, range: 1.0, half: 0.2, scan, source, fitted, clear, lines, count }
}

/// Two walls that meet at (3, 4): x = 3 from y = 1.25 to 4, y = 4 from x = −1 to 2.5, so that it is extrapolated; and a point.
fn known() -> FeatureMap {
    let walls = vec![
        Wall { normal: Vector::x(), offset: 3.0, extent: [1.25, 4.0], rcds: vec![0, 1] },
        // along is (−1, 0): positions grow to the left
        Wall { normal: Vector::y(), offset: 4.0, extent: [-2.5, 1.0], rcds: vec![3] },
    ];
    let corners = vec![Corner {
        at: Point::new(3.0, 4.0),
        walls: [0, 1],
        probability: 0.876_543,
        extrapolated_walls: [None, Some([Point::new(3.0, 4.0), Point::new(2.5, 4.0)])],
    }];
    let points = vec![PointFeature { at: Point::new(-0.000_01, 1.234_56), rcds: vec![2] }];
    let regions = vec![region(7, 12, [40, 51]), region(7, 9, [20, 28]), region(8, 5, [60, 64]), region(9, 4, [90, 93])];
    FeatureMap { features: Features { walls, points, corners, lines: Vec::new() }, regions }
}

/// 11 × 8 cells of 0.5 m from (−2, 1) to (3.5, 5).
fn grid() -> GridSpec {
    map(11, 8).grid
}

fn written(known: &FeatureMap, grid: &GridSpec) -> (Value, String) {
    let dir = tempfile::tempdir().unwrap();
    write_features(dir.path(), known, grid).unwrap();
    let names = fs::read_dir(dir.path()).unwrap().count();
    assert_eq!(names, 2, "nothing half-written stays");
    let text = fs::read_to_string(dir.path().join("features.geojson")).unwrap();
    (serde_json::from_str(&text).unwrap(), fs::read_to_string(dir.path().join("features.svg")).unwrap())
}

#[test]
fn geojson_holds_the_places_and_what_saw_them() {
    let (all, _) = written(&known(), &grid());
    assert_eq!(all["type"], "FeatureCollection");
    assert!(all["frame"].as_str().unwrap().contains("not WGS84"));
    let features = all["features"].as_array().unwrap();
    assert_eq!(features.len(), 4);
    assert!(features.iter().all(|f| f["type"] == "Feature"));
    let geometry = |k: usize| &features[k]["geometry"];
    let properties = |k: usize| &features[k]["properties"];
    assert_eq!(*geometry(0), json!({ "type": "LineString", "coordinates": [[3.0, 1.25], [3.0, 4.0]] }));
    assert_eq!(*geometry(1), json!({ "type": "LineString", "coordinates": [[2.5, 4.0], [-1.0, 4.0]] }));
    assert_eq!(*geometry(2), json!({ "type": "Point", "coordinates": [3.0, 4.0] }));
    assert_eq!(*geometry(3), json!({ "type": "Point", "coordinates": [0.0, 1.2346] }));
    assert_eq!(
        *properties(0),
        json!({ "kind": "wall", "normal": [1.0, 0.0], "scans": 1, "regions": 2, "readings": 21, "lines": [[20, 28], [40, 51]] })
    );
    assert_eq!(
        *properties(2),
        json!({
            "kind": "corner", "probability": 0.8765, "walls": [0, 1], "legs": [null, [[3.0, 4.0], [2.5, 4.0]]],
            "scans": 2, "regions": 3, "readings": 25, "lines": [[20, 28], [40, 51], [90, 93]]
        })
    );
    assert_eq!(
        *properties(3),
        json!({ "kind": "point", "scans": 1, "regions": 1, "readings": 5, "lines": [[60, 64]] })
    );
}

#[test]
fn a_feature_a_line_the_same_every_time_and_no_negative_zero() {
    let dir = tempfile::tempdir().unwrap();
    let text = || {
        write_features(dir.path(), &known(), &grid()).unwrap();
        fs::read_to_string(dir.path().join("features.geojson")).unwrap()
    };
    let first = text();
    assert_eq!(first, text());
    assert_eq!(first.lines().count(), 4 + 2);
    assert!(!first.contains("-0.0,") && !first.contains("-0.0]"), "{first}");
}

/// The numbers of every path or circle of a class.
fn drawn(svg: &str, class: &str) -> Vec<Vec<f64>> {
    let marks = svg.split('<').filter(|m| m.contains(&format!("class=\"{class}\"")));
    let numbers = |mark: &str| {
        let shape = mark.split(" stroke=").next().unwrap().split("class=").nth(1).unwrap();
        let parts = shape.split(|c: char| !c.is_ascii_digit() && c != '.' && c != '-');
        parts.filter_map(|n| n.parse().ok()).collect()
    };
    marks.map(numbers).collect()
}

#[test]
fn the_picture_has_y_up_and_its_scale_in_metres() {
    let (_, svg) = written(&known(), &grid());
    // 5.5 m are 1200 pixels, and the upper left corner (−2, 5) lies at (24, 24)
    let scale = 1200.0 / 5.5;
    let at = |x: f64, y: f64| [24.0 + (x + 2.0) * scale, 24.0 + (5.0 - y) * scale];
    let near = |a: &[f64], b: &[f64]| {
        assert!(a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.006), "{a:?} is not {b:?}");
    };
    let walls = drawn(&svg, "wall");
    assert_eq!(walls.len(), 2);
    near(&walls[0], &[at(3.0, 1.25), at(3.0, 4.0)].concat());
    assert!(walls[0][1] > walls[0][3], "the upper end is further up");
    near(&drawn(&svg, "corner")[0], &[&at(3.0, 4.0)[..], &[6.0]].concat());
    near(&drawn(&svg, "leg")[0], &[at(3.0, 4.0), at(2.5, 4.0)].concat());
    let point = &drawn(&svg, "point")[0];
    let [x, y] = at(0.0, 1.234_56);
    near(&[(point[0] + point[2]) / 2.0, (point[1] + point[3]) / 2.0], &[x, y]);
    for what in ["2 walls", "1 corner:", "1 point:", ">1 m<"] {
        assert!(svg.contains(what), "{what}");
    }
    // a third of 5.5 m is 1.83: the bar has 1 m
    assert!(svg.contains(&format!("v6h{scale:.2}v-6")), "{svg}");
}

#[test]
fn a_wall_s_tick_points_along_its_normal() {
    let (_, svg) = written(&known(), &grid());
    // the first wall looks to the right: its tick is 7 pixels to the right of its middle, at the same height
    let tick = svg.split("<path").find(|p| p.contains("stroke-width=\"1\"")).unwrap();
    let shape = tick.split('"').nth(1).unwrap();
    let numbers: Vec<f64> = shape.split(['M', 'L', ' ']).filter_map(|n| n.parse().ok()).collect();
    assert!((numbers[2] - numbers[0] - 7.0).abs() < 0.011, "{shape}");
    assert!((numbers[3] - numbers[1]).abs() < 0.011, "{shape}");
}

#[test]
fn the_map_s_picture_lies_behind_where_there_is_one() {
    let (_, svg) = written(&known(), &grid());
    assert!(!svg.contains("<image"));
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m");
    write(&path, &map(11, 8), false);
    write_features(&path, &known(), &grid()).unwrap();
    let svg = fs::read_to_string(path.join("features.svg")).unwrap();
    let image = svg.split("<image").nth(1).unwrap();
    assert!(image.contains("href=\"map.png\"") && image.contains("image-rendering:pixelated"), "{image}");
    // 8 of 11 cells' height
    assert!(image.contains("width=\"1200.0\" height=\"872.7\""), "{image}");
}

#[test]
fn a_reduced_picture_reaches_beyond_the_grid() {
    // 8191 columns are shown two by two in 4096: half a pixel more than the map, to the right; 3 rows in 2, at the top
    let grid = GridSpec { anchor: (0.0, 0.0), resolution: 0.1, i0: 0, j0: 0, width: 8191, height: 3 };
    let spot = PointFeature { at: Point::new(819.2, 0.0), rcds: Vec::new() };
    let features = Features { points: vec![spot], ..Features::default() };
    let (_, svg) = written(&FeatureMap { features, regions: Vec::new() }, &grid);
    let point = &drawn(&svg, "point")[0];
    // the picture's right edge and its bottom: 0.4 m below its top
    assert!(((point[0] + point[2]) / 2.0 - 1224.0).abs() < 0.01, "{point:?}");
    assert!(((point[1] + point[3]) / 2.0 - (24.0 + 0.4 * 1200.0 / 819.2)).abs() < 0.01, "{point:?}");
}

#[test]
fn nothing_known_is_an_empty_collection() {
    let (all, svg) = written(&FeatureMap::default(), &grid());
    assert_eq!(all["features"], json!([]));
    assert!(svg.contains("0 walls") && svg.contains("0 corners") && svg.contains("0 points"));
}

#[test]
fn a_thousand_walls() {
    let wall =
        |k: usize| Wall { normal: Vector::new(0.6, 0.8), offset: k as f64 * 0.1, extent: [0.0, 1.0], rcds: vec![k] };
    let features = Features { walls: (0..1000).map(wall).collect(), ..Features::default() };
    let regions = (0..1000).map(|k| region(k, 4, [k + 1, k + 4])).collect();
    let (all, svg) = written(&FeatureMap { features, regions }, &grid());
    let walls = all["features"].as_array().unwrap();
    assert_eq!(walls.len(), 1000);
    // 50 m along the normal, then 1 m to its left
    assert_eq!(walls[500]["geometry"]["coordinates"], json!([[30.0, 40.0], [29.2, 40.6]]));
    assert_eq!(walls[500]["properties"]["normal"], json!([0.6, 0.8]));
    assert_eq!(drawn(&svg, "wall").len(), 1000);
    assert!(svg.contains("1000 walls"));
}

#[test]
fn an_error_names_the_file() {
    let error = write_features(Path::new("/nowhere/at/all"), &known(), &grid()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Resources);
    assert!(error.to_string().contains("features.geojson"), "{error}");
}
