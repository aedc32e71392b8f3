//! Maps that are damaged: what is whole is shown, the rest says what is wrong.

use crate::common::Place;
use crate::pictures::{ask, json, open, tile};
use crate::web::Web;
use echogrid::Error;
use echogrid::view::Limits;
use echogrid::view::map::MapView;
use std::path::Path;
use std::sync::Arc;

const SHARD: &str = "m/map.zarr/p_occ/c/0/0";

fn made() -> Place {
    let place = Place::new();
    place.map("m", &["-r", "0.005"]);
    place
}

#[track_caller]
fn refused(view: &MapView, name: &str, at: &Path) {
    let query = format!("source=0&view={name}&level=0&column=0&row=0");
    for (path, query) in [("api/tile", query.as_str()), ("api/cell", "column=100&row=100")] {
        match ask(view, path, query) {
            Err(Error::Input { path, what, .. }) => {
                assert_eq!(path, at);
                assert!(what.starts_with("it is damaged") && what.contains("echogrid check"), "{what}");
            }
            other => panic!("{path}: {other:?}"),
        }
    }
}

#[test]
fn a_shard_that_was_changed_cut_off_or_emptied() {
    let place = made();
    let whole = std::fs::read(place.path(SHARD)).unwrap();
    let end = whole.len();
    let changed = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        bytes
    };
    let mut beyond = whole.clone();
    beyond.drain(..1000);
    // in a piece, in its checksum's place, in the index, in the index's checksum
    let cases =
        [changed(100), changed(3), changed(end - 100), changed(end - 2), whole[..end / 2].to_vec(), Vec::new(), beyond];
    for bytes in cases {
        std::fs::write(place.path(SHARD), bytes).unwrap();
        let view = open(&place.path("m"));
        refused(&view, "p_occ", &place.path(SHARD));
        // the other layers are shown
        assert!(tile(&view, "0", "combined", [0, 0, 0]).is_some());
        assert!(tile(&view, "0", "log_odds", [0, 0, 0]).is_some());
        // mended: shown too, without starting anew
        std::fs::write(place.path(SHARD), &whole).unwrap();
        assert!(tile(&view, "0", "p_occ", [0, 0, 0]).is_some());
    }
}

#[test]
fn the_server_says_so_and_lives() {
    let place = made();
    let mut bytes = std::fs::read(place.path(SHARD)).unwrap();
    bytes[100] ^= 1;
    std::fs::write(place.path(SHARD), bytes).unwrap();
    let web = Web::of(Arc::new(open(&place.path("m"))), Limits::default());
    for _ in 0..3 {
        let reply = web.get("api/tile?source=0&view=p_occ&level=1&column=0&row=0");
        assert_eq!(reply.status, 422);
        assert!(reply.json()["error"].as_str().unwrap().contains("p_occ"), "{reply:?}");
        assert_eq!(web.get("api/tile?source=0&view=combined&level=1&column=0&row=0").status, 200);
        assert_eq!(web.get("api/session").json()["mode"], "map");
    }
    assert_eq!(web.get("api/tile?source=0&view=none&level=1&column=0&row=0").status, 400);
}

#[test]
fn what_describes_it_is_damaged() {
    for (file, at) in [
        ("m/report.json", "m/report.json"),
        ("m/map.zarr/zarr.json", "m/map.zarr"),
        ("m/map.zarr/class/zarr.json", "m/map.zarr"),
        ("m/map.zarr/overview/1/zarr.json", "m/map.zarr"),
        ("m/map.zarr/overview/zarr.json", "m/map.zarr"),
    ] {
        let place = made();
        let whole = std::fs::read(place.path(file)).unwrap();
        std::fs::write(place.path(file), &whole[..whole.len() / 2]).unwrap();
        match MapView::open(&place.path("m"), &Default::default()).map(|_| ()) {
            Err(Error::Input { path, what, .. }) => {
                assert_eq!(path, place.path(at), "{file}");
                assert!(what.contains("map the log anew"), "{file}: {what}");
            }
            other => panic!("{file}: {other:?}"),
        }
    }
    // a grid that is another one
    let place = made();
    let path = place.path("m/map.zarr/zarr.json");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    value["attributes"]["size"] = serde_json::json!([0, 0]);
    std::fs::write(&path, value.to_string()).unwrap();
    assert!(MapView::open(&place.path("m"), &Default::default()).is_err());
}

#[test]
fn a_shard_that_is_gone_is_fill() {
    let place = made();
    std::fs::remove_file(place.path(SHARD)).unwrap();
    let view = open(&place.path("m"));
    let cell = json(&view, "api/cell", "column=100&row=100");
    assert_eq!(cell["sources"][0]["values"][1], serde_json::json!(["p_occ", 0.5]));
}
