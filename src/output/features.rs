//! The features of the feature stage: `features.geojson` for programs, `features.svg` as a picture. Each file is written whole or not at
//! all.

mod picture;

use super::names::{FEATURES, FEATURES_PARTIAL, FEATURES_PICTURE, FEATURES_PICTURE_PARTIAL, FileName, PICTURE};
use super::unwritable;
use crate::Result;
use crate::feature::{FeatureMap, Rcd};
use crate::geometry::plane::Point;
use crate::grid::GridSpec;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// The frame of the positions; GeoJSON's default is degrees.
const FRAME: &str =
    "metres in the log's world frame, x right, y up, rounded to 0.1 mm: not WGS84 longitude and latitude";

/// Writes `features.geojson` and `features.svg` into the folder of a map on `grid`. The picture is drawn over `map.png`, if that exists.
///
/// # Errors
/// [`Error::Resources`](crate::Error::Resources) if one can't be written.
pub fn write_features(folder: &Path, known: &FeatureMap, grid: &GridSpec) -> Result<()> {
    let drawn_over = PICTURE.at(folder).is_file();
    save(folder, [FEATURES, FEATURES_PARTIAL], &geojson(known))?;
    save(folder, [FEATURES_PICTURE, FEATURES_PICTURE_PARTIAL], &picture::svg(known, grid, drawn_over))
}

fn save(folder: &Path, names: [FileName; 2], text: &str) -> Result<()> {
    let [path, partial] = names.map(|name| name.at(folder));
    std::fs::write(&partial, text).and_then(|()| std::fs::rename(&partial, &path)).map_err(|e| {
        let _ = std::fs::remove_file(&partial);
        unwritable(&path, e)
    })
}

/// The text of the GeoJSON file, one feature per line: walls, then corners, then points, each in the stage's order.
fn geojson(known: &FeatureMap) -> String {
    let features = &known.features;
    let walls = features.walls.iter().map(|wall| {
        let normal = [wall.normal.x, wall.normal.y].map(|v| rounded(v, 1e6));
        let own = json!({ "kind": "wall", "normal": normal });
        feature("LineString", json!(wall.ends().map(place)), own, seen(known, wall.rcds.iter()))
    });
    let corners = features.corners.iter().map(|corner| {
        let extrapolated_walls = corner.extrapolated_walls.map(|leg| leg.map(|ends| ends.map(place)));
        let probability = rounded(corner.probability, 1e4);
        let own =
            json!({ "kind": "corner", "probability": probability, "walls": corner.walls, "legs": extrapolated_walls });
        let members = corner.walls.iter().filter_map(|k| features.walls.get(*k)).flat_map(|w| &w.rcds);
        feature("Point", json!(place(corner.at)), own, seen(known, members))
    });
    let spots = features
        .points
        .iter()
        .map(|spot| feature("Point", json!(place(spot.at)), json!({ "kind": "point" }), seen(known, spot.rcds.iter())));
    let mut text = format!("{{\"type\": \"FeatureCollection\", \"frame\": {}, \"features\": [", json!(FRAME));
    for (k, feature) in walls.chain(corners).chain(spots).enumerate() {
        text += if k == 0 { "\n" } else { ",\n" };
        text += &feature.to_string();
    }
    text + "\n]}\n"
}

fn feature(geometry: &str, coordinates: Value, mut own: Value, seen: Value) -> Value {
    if let (Some(properties), Value::Object(seen)) = (own.as_object_mut(), seen) {
        properties.extend(seen);
    }
    json!({ "type": "Feature", "geometry": { "type": geometry, "coordinates": coordinates }, "properties": own })
}

/// The observations of a feature: the numbers of scans, regions and readings, and the lines of the log of each region.
fn seen<'a>(known: &'a FeatureMap, rcds: impl Iterator<Item = &'a usize>) -> Value {
    let places: BTreeSet<usize> = rcds.copied().collect();
    let regions: Vec<&Rcd> = places.iter().filter_map(|k| known.regions.get(*k)).collect();
    let scans: BTreeSet<u64> = regions.iter().map(|r| r.scan).collect();
    let lines: BTreeSet<[u64; 2]> = regions.iter().map(|r| r.lines).collect();
    let readings: u64 = regions.iter().map(|r| u64::from(r.count)).sum();
    json!({ "scans": scans.len(), "regions": regions.len(), "readings": readings, "lines": lines })
}

fn place(at: Point) -> [f64; 2] {
    [at.x, at.y].map(|v| rounded(v, 1e4))
}

/// Rounds to so many steps per unit; never −0.
fn rounded(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps + 0.0
}
