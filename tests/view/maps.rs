//! What is shown of saved maps is what is stored.

use crate::common::Place;
use crate::pictures::{decode, json, level, open, stored, tile};
use echogrid::output::read_map;
use echogrid::view::View;
use echogrid::view::map::{Companions, MapView};
use serde_json::{Value, json};
use std::path::Path;
use std::time::{Duration, Instant};

/// The small log in cells of 5 mm: some tiles across.
fn fine(place: &Place, folder: &str, more: &[&str]) {
    place.map(folder, &[&["-r", "0.005"], more].concat());
}

#[test]
fn level_0_is_the_layers_picture() {
    let place = Place::new();
    for (method, folder) in [("bayes", "b"), ("certainty", "c"), ("dempster-shafer", "d")] {
        fine(&place, folder, &["-m", method]);
        let view = open(&place.path(folder));
        let session = json(&view, "api/session", "");
        assert_eq!(session["levels"], 2);
        for named in session["sources"][0]["views"].as_array().unwrap() {
            let name = named["name"].as_str().unwrap();
            let file = match name {
                "combined" => "map",
                "map" => continue, // its picture is the combined layer's
                other => other,
            };
            let wanted = decode(&std::fs::read(place.path(folder).join(format!("{file}.png"))).unwrap());
            let (extent, entries) = level(&view, "0", name, 0);
            assert_eq!(extent, wanted.extent, "{method} {name}");
            for (k, entry) in entries.iter().enumerate() {
                let wanted = wanted.at(k % extent[0], k / extent[0]);
                // Of `touched` the picture shows 0 as white; what was not reached is shown as such here.
                let wanted = if name == "touched" && wanted == 1 { 0 } else { wanted };
                assert_eq!(*entry, wanted, "{method} {name}, cell {k}");
            }
            let palette = tile(&view, "0", name, [0, 0, 0]).unwrap().palette;
            assert_eq!(palette, wanted.palette, "{method} {name}");
            let legend = &named["legend"];
            let [r, g, b] = palette[..3] else { panic!("no palette") };
            assert_eq!(legend["untouched"], format!("#{r:02x}{g:02x}{b:02x}"));
            let [r, g, b] = palette[765..] else { panic!("no palette") };
            assert_eq!(legend["stops"].as_array().unwrap().last().unwrap()[1], format!("#{r:02x}{g:02x}{b:02x}"));
            assert!(!named["about"].as_str().unwrap().is_empty(), "{named}");
        }
    }
}

#[test]
fn every_level_is_the_stored_one_and_the_last_is_one_tile() {
    let place = Place::new();
    place.map("m", &["-r", "0.002"]);
    let view = open(&place.path("m"));
    let levels = json(&view, "api/session", "")["levels"].as_u64().unwrap() as usize;
    let mut compared = 0;
    for k in 0..levels {
        let (extent, entries) = level(&view, "0", "combined", k);
        if place.path(&format!("m/map.zarr/overview/{k}")).exists() {
            assert!(entries == stored(&place.path("m"), k), "level {k}");
            compared += 1;
        }
        assert_eq!(k + 1 == levels, extent.iter().all(|n| *n <= 256), "level {k}: {extent:?}");
    }
    assert!(compared >= 3, "{compared}");
    // a layer, from its cells, is reduced as far
    let (_, odds) = level(&view, "0", "log_odds", levels - 1);
    let (_, combined) = level(&view, "0", "combined", levels - 1);
    assert!(odds.iter().zip(&combined).all(|(o, c)| (*o == 0) == (*c == 0)));
}

/// A grid that is a little larger than a power of two of tiles has a level more than its overview.
#[test]
fn a_level_above_the_stored_ones() {
    let place = Place::new();
    place.map("m", &["-r", "0.01", "--bounds", "-1,-1,4.13,4"]); // 513 × 500: level 1 has 257 × 250 and is the last stored
    let view = open(&place.path("m"));
    assert_eq!(json(&view, "api/session", "")["levels"], 3);
    assert!(!place.path("m/map.zarr/overview/2").exists());
    let below = stored(&place.path("m"), 1);
    let ([width, height], top) = level(&view, "0", "combined", 2);
    assert_eq!([width, height], [129, 125]);
    for (k, entry) in top.iter().enumerate() {
        let block = (0..4).filter_map(|n| {
            let (column, row) = (2 * (k % width) + n % 2, 2 * (k / width) + n / 2);
            (column < 257 && row < 250).then(|| below[row * 257 + column])
        });
        let strength = |e: &u8| (if *e == 0 { -1 } else { (i16::from(*e) - 128).abs() }, *e);
        assert_eq!(*entry, block.max_by_key(strength).unwrap(), "pixel {k}");
    }
}

#[test]
fn a_cell_is_told_as_it_is_stored() {
    let place = Place::new();
    for (method, folder) in [("dempster-shafer", "d"), ("himm", "h"), ("bayes", "b")] {
        fine(&place, folder, &["-m", method]);
        let view = open(&place.path(folder));
        let map = read_map(&place.path(folder)).unwrap().map;
        let (width, height) = (map.grid.width, map.grid.height);
        for k in (0..map.grid.cells()).step_by(997).chain([0, width - 1, map.grid.cells() - 1]) {
            let (column, row) = (k % width, k / width);
            let cell = json(&view, "api/cell", &format!("column={column}&row={row}"));
            let (x, y) = map.grid.centre(column, row);
            assert!((cell["x"].as_f64().unwrap() - x).abs() < 1e-9 && (cell["y"].as_f64().unwrap() - y).abs() < 1e-9);
            let told = &cell["sources"][0];
            let value = |name: &str| map.layer(name).unwrap().data.get(k);
            assert_eq!(told["touched"], value("touched") != 0.0, "{method} {k}");
            let class = ["empty", "unknown", "occupied"][(value("class") + 1.0) as usize];
            assert_eq!(told["class"], class, "{method} {k}");
            let values = told["values"].as_array().unwrap();
            assert_eq!(values.len(), map.layers.len() - 2);
            for pair in values {
                let wanted = value(pair[0].as_str().unwrap());
                assert_eq!(pair[1].as_f64().map(|v| v as f32), Some(wanted as f32), "{method} {k} {pair}");
            }
        }
        let outside = crate::pictures::ask(&view, "api/cell", &format!("column={width}&row={height}"));
        assert!(matches!(outside, Err(echogrid::Error::Usage(_))), "{outside:?}");
    }
}

fn beside(path: &Path, with: &Path) -> MapView {
    MapView::open(path, &Companions { with: Some(with), ..Companions::default() }).unwrap()
}

#[test]
fn another_map_lies_where_it_belongs_and_the_difference_is_between_the_same_places() {
    let place = Place::new();
    fine(&place, "a", &[]);
    fine(&place, "b", &["--until", "2"]); // the same anchor, another extent
    fine(&place, "c", &["--until", "3", "--bounds", "-0.35,-0.57,2.5,1.8"]); // another anchor, whole cells away
    let a = read_map(&place.path("a")).unwrap().map;
    for other in ["b", "c"] {
        let b = read_map(&place.path(other)).unwrap().map;
        let first =
            [(b.grid.x0() - a.grid.x0()) / 0.005, (b.grid.y0() - a.grid.y0()) / 0.005].map(|n| n.round() as i64);
        let view = beside(&place.path("a"), &place.path(other));
        let session = json(&view, "api/session", "");
        assert_eq!(session["sources"][1]["name"], other);
        assert!(session["difference"].is_object());
        let (entries_a, entries_b) = (stored(&place.path("a"), 0), stored(&place.path(other), 0));
        let ([width, _], shown) = level(&view, "1", "combined", 0);
        let (_, difference) = level(&view, "difference", "combined", 0);
        let mut differing = 0;
        for k in 0..a.grid.cells() {
            let (column, row) = ((k % width) as i64 - first[0], (k / width) as i64 - first[1]);
            let inside = (0..b.grid.width as i64).contains(&column) && (0..b.grid.height as i64).contains(&row);
            let there = if inside { entries_b[row as usize * b.grid.width + column as usize] } else { 0 };
            assert_eq!(shown[k], there, "{other} {k}");
            let value = |e: u8| if e == 0 { 0 } else { i32::from(e) - 128 };
            let wanted = match (entries_a[k], there) {
                (0, 0) => 0,
                (a, b) => 128 + (value(b) - value(a)).clamp(-127, 127),
            };
            assert!((i32::from(difference[k]) - wanted).abs() <= i32::from(wanted != 0), "{other} {k}: {wanted}");
            differing += usize::from(wanted != 0 && wanted != 128);
        }
        assert!(differing > 1000, "{differing}");
        // the cell's values are the other map's, at the same place in the world
        let [c, r] = [150, 150].map(|n: i64| n);
        let cell = json(&view, "api/cell", &format!("column={}&row={}", c + first[0], r + first[1]));
        let wanted = b.layer("log_odds").unwrap().data.get((r as usize) * b.grid.width + c as usize) as f32;
        let told = cell["sources"][1]["values"][0][1].as_f64().unwrap() as f32;
        assert_eq!(told, wanted, "{cell}");
    }
    // half a cell away: shown, but there is no difference
    fine(&place, "half", &["--bounds", "-0.3525,-0.57,2.5,1.8"]);
    let view = beside(&place.path("a"), &place.path("half"));
    let session = json(&view, "api/session", "");
    assert_eq!((&session["difference"], &session["sources"][1]["aligned"]), (&Value::Null, &json!(false)));
    assert!(level(&view, "1", "combined", 0).1.iter().any(|e| *e > 0));
    let asked = crate::pictures::ask(&view, "api/tile", "source=difference&view=combined&level=0&column=0&row=0");
    assert!(matches!(asked, Err(echogrid::Error::Usage(_))));
}

#[test]
fn error_levels_are_those_of_the_score() {
    let place = Place::new();
    let world = Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds/bend.toml");
    let world = world.to_str().unwrap();
    place.does(&["simulate", world, "-o", "bend.jsonl", "--seed", "1"]);
    // as wide as the truth, so that every cell that is compared is shown
    place.does(&["truth", world, "-o", "t", "-r", "0.05"]);
    let box_ = &place.report("t")["cells"];
    let [x0, y0] = ["x0", "y0"].map(|k| box_[k].as_f64().unwrap());
    let [w, h] = ["width", "height"].map(|k| box_[k].as_f64().unwrap() * 0.05);
    let bounds = format!("--bounds={:.1},{:.1},{:.1},{:.1}", x0 - 0.5, y0 - 0.3, x0 + w + 0.2, y0 + h + 0.4);
    place.does(&["map", "bend.jsonl", "-o", "m", "-r", "0.05", &bounds, "--backend", "cpu"]);
    for truth in [world, "t"] {
        let score = place.does(&["score", "m", "--truth", truth, "--json"]).json();
        let at = if truth == "t" { place.path("t") } else { truth.into() };
        let view = MapView::open(&place.path("m"), &Companions { truth: Some(&at), ..Companions::default() }).unwrap();
        let session = json(&view, "api/session", "");
        for key in ["cells", "levels", "zones", "danger", "auc", "near", "method"] {
            assert_eq!(session["score"][key], score["maps"][0][key], "{key}");
        }
        let views = session["sources"][0]["views"].as_array().unwrap();
        let shown = views.iter().find(|v| v["name"] == "levels").unwrap();
        assert_eq!(
            (&shown["group"], &shown["legend"]["entries"][0]),
            (&json!("main"), &json!(["0 right (Z1)", "#ffffff"]))
        );
        assert_eq!(shown["legend"]["entries"][9][1], "#320008");
        let (_, entries) = level(&view, "0", "levels", 0);
        // an entry is its label + 1, a label 10 less its level
        let count = |k: u8| entries.iter().filter(|e| **e == 11 - k).count();
        let counts: Vec<usize> = (0..10).map(count).collect();
        assert_eq!(json!(counts), score["maps"][0]["levels"], "{truth}");
        // reduced, the most dangerous shows
        let (_, top) = level(&view, "0", "levels", 1);
        assert_eq!(top.iter().filter(|e| **e > 0).min(), entries.iter().filter(|e| **e > 0).min());
        let last = session["sources"].as_array().unwrap().last().unwrap();
        assert_eq!((&last["kind"], &last["views"][0]["name"]), (&json!("truth"), &json!("class")));
        let (_, class) = level(&view, "1", "class", 0);
        let occupied = class.iter().filter(|e| **e == 255).count() as u64;
        assert_eq!(json!(occupied), place.report("t")["cells"]["occupied"], "{truth}");
        let k = entries.iter().position(|e| *e == 11 - 3).unwrap(); // free, and left unknown
        let width = session["grid"]["width"].as_u64().unwrap() as usize;
        let cell = json(&view, "api/cell", &format!("column={}&row={}", k % width, k / width));
        assert_eq!(cell["sources"][0]["values"].as_array().unwrap().last().unwrap(), &json!(["error_level", 3]));
        let truth = &cell["sources"][1];
        assert_eq!((&truth["class"], &truth["touched"]), (&json!("empty"), &json!(true)));
    }
}

#[test]
fn a_map_without_an_overview_is_shown_all_the_same() {
    let place = Place::new();
    fine(&place, "m", &[]);
    let whole = level(&open(&place.path("m")), "0", "combined", 0);
    std::fs::remove_dir_all(place.path("m/map.zarr/overview")).unwrap();
    let view = open(&place.path("m"));
    let (extent, without) = level(&view, "0", "combined", 0);
    assert_eq!(extent, whole.0);
    assert!(without.iter().zip(&whole.1).all(|(a, b)| a.abs_diff(*b) <= 1));
    assert!(level(&view, "0", "combined", 1).1.iter().any(|e| *e > 128));
}

#[test]
fn questions_that_make_no_sense() {
    let place = Place::new();
    fine(&place, "m", &[]);
    let view = open(&place.path("m"));
    let asked = |path: &str, query: &str| crate::pictures::ask(&view, path, query);
    for query in [
        "",
        "source=0",
        "source=0&view=combined",
        "source=1&view=combined&level=0&column=0&row=0",
        "source=0&view=none&level=0&column=0&row=0",
        "source=-1&view=combined&level=0&column=0&row=0",
        "source=0&view=combined&level=9&column=0&row=0",
        "source=0&view=combined&level=0&column=99&row=0",
        "source=0&view=combined&level=0&column=0&row=x",
        "source=0&view=combined&level=99999999999&column=0&row=0",
        "source=0&view=combined&level=4294967295&column=0&row=0",
        "source=difference&view=combined&level=0&column=0&row=0",
        "source=0&view=../class&level=0&column=0&row=0",
    ] {
        assert!(
            matches!(asked("api/tile", query), Err(echogrid::Error::Usage(_))),
            "{query}: {:?}",
            asked("api/tile", query)
        );
    }
    for path in ["api/go", "api/working", "api/gpu/plan", "api/x"] {
        assert_eq!(asked(path, "").unwrap(), echogrid::view::Response::NotFound, "{path}");
    }
    let session = json(&view, "api/session", "");
    assert_eq!(session["mode"], "map");
    assert_eq!(session["report"], place.report("m"));
    assert_eq!(session["grid"]["x0"], place.report("m")["cells"]["x0"]);
    assert_eq!((&session["difference"], session.get("score")), (&Value::Null, None));
    let names: Vec<&str> =
        session["sources"][0]["views"].as_array().unwrap().iter().map(|v| v["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["combined", "log_odds", "p_occ", "p_emp", "touched", "class"]);
}

/// A log that covers little of a large grid: opened and shown in no time.
#[test]
fn a_large_sparse_map_is_there_at_once() {
    let place = Place::new();
    place.map("m", &["-r", "0.01", "--bounds=-60,-60,60,60"]); // 12,000 × 12,000 cells
    let started = Instant::now();
    let view = open(&place.path("m"));
    let levels = json(&view, "api/session", "")["levels"].as_u64().unwrap() as usize;
    assert!(tile(&view, "0", "combined", [levels - 1, 0, 0]).is_some());
    let opened = started.elapsed();
    assert!(tile(&view, "0", "log_odds", [levels - 1, 0, 0]).is_some());
    let layer = started.elapsed() - opened;
    assert!(tile(&view, "0", "combined", [0, 0, 0]).is_none());
    assert!(opened < Duration::from_secs(1), "{opened:?}");
    assert!(layer < Duration::from_secs(5), "{layer:?}");
    let _: &dyn View = &view;
}
