//! Every format read back, by our own reader or byte by byte.

use crate::common::{EMPTY_ROW, OCCUPIED, info, layer, map, write};
use echogrid::ErrorKind;
use echogrid::grid::{Data, Map, Scale};
use echogrid::output::{Folder, read_map, read_ros, write_map, write_picture};
use std::collections::BTreeMap;
use std::path::Path;

#[test]
fn zarr_reads_back_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    let mut map = map(1500, 1100);
    let Data::F32(odds) = &mut map.layers[0].data else { unreachable!() };
    odds[5] = f32::NAN;
    odds[6] = -0.0;
    odds[1499] = f32::from_bits(1);
    *odds.last_mut().unwrap() = f32::INFINITY;
    map.layers[1].fill = f64::from(0.3f32);
    write(&dir.path().join("m"), &map, false);
    let stored = read_map(&dir.path().join("m")).unwrap();
    assert_eq!(stored.map.grid, map.grid);
    assert_eq!((stored.map.method.as_str(), stored.map.updates), ("bayes", 1234));
    assert_eq!(stored.attributes["parameters"]["max_occ"], 0.98);
    assert_eq!(stored.attributes["log_sha256"], "ab".repeat(32));
    assert_eq!(stored.report["cells"]["occupied"], 1);
    assert_eq!(stored.map.layers.len(), map.layers.len());
    for (found, wanted) in stored.map.layers.iter().zip(&map.layers) {
        assert_eq!((&found.name, found.fill, found.scale), (&wanted.name, wanted.fill, wanted.scale));
        let bits = |d: &Data| (0..d.len()).map(|k| d.get(k).to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found.data), bits(&wanted.data), "{}", found.name);
        assert_eq!(std::mem::discriminant(&found.data), std::mem::discriminant(&wanted.data));
    }
}

#[test]
fn chunks_of_the_fill_value_are_not_stored() {
    let dir = tempfile::tempdir().unwrap();
    write(&dir.path().join("m"), &map(3000, 2000), false);
    let layer = dir.path().join("m/map.zarr/log_odds/c");
    // The pattern lies in the bottom row of shards; the upper row is all fill.
    assert!(layer.join("0/0").is_file() && layer.join("0/2").is_file());
    assert!(!layer.join("1").exists());
}

#[test]
fn numpy_files_have_the_header_and_the_rows() {
    let dir = tempfile::tempdir().unwrap();
    let map = map(11, 8);
    write(&dir.path().join("m"), &map, true);
    let bytes = std::fs::read(dir.path().join("m/log_odds.npy")).unwrap();
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!(start % 64, 0);
    let header = std::str::from_utf8(&bytes[10..start]).unwrap();
    assert_eq!(header.trim_end(), "{'descr': '<f4', 'fortran_order': False, 'shape': (8, 11), }");
    assert!(header.ends_with('\n'));
    let values: Vec<f32> = bytes[start..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(Data::F32(values), map.layers[0].data);
    for (name, kind, size) in [("count", "<u4", 4), ("touched", "|u1", 1), ("class", "|i1", 1)] {
        let bytes = std::fs::read(dir.path().join(format!("m/{name}.npy"))).unwrap();
        assert!(String::from_utf8_lossy(&bytes[10..128]).contains(kind));
        assert_eq!(bytes.len(), 128 + 88 * size);
    }
}

/// Width, height and red, green, blue of every pixel, top row first.
fn pixels(path: &Path) -> (usize, usize, Vec<[u8; 3]>) {
    let picture = image::open(path).unwrap().to_rgb8();
    (picture.width() as usize, picture.height() as usize, picture.pixels().map(|p| p.0).collect())
}

const UNTOUCHED: [u8; 3] = [168, 180, 196];

#[test]
fn pictures_have_y_up_and_a_colour_for_the_untouched() {
    let dir = tempfile::tempdir().unwrap();
    write(&dir.path().join("m"), &map(11, 8), false);
    let (width, height, found) = pixels(&dir.path().join("m/log_odds.png"));
    assert_eq!((width, height), (11, 8));
    for (k, pixel) in found.iter().enumerate() {
        let (column, row) = (k % 11, 7 - k / 11);
        let wanted = match (column, row) {
            OCCUPIED => [255, 127, 127],
            (_, EMPTY_ROW) => [127, 127, 255],
            _ => UNTOUCHED,
        };
        assert_eq!(*pixel, wanted, "column {column}, row {row}");
    }
    let whole = std::fs::read(dir.path().join("m/log_odds.png")).unwrap();
    assert_eq!(whole, std::fs::read(dir.path().join("m/map.png")).unwrap());
    // `touched` itself shows both its values.
    let (_, _, touched) = pixels(&dir.path().join("m/touched.png"));
    assert_eq!(touched[11 + 2], [1, 1, 1]);
    assert_eq!(touched[0], [255, 255, 255]);
    let (_, _, p) = pixels(&dir.path().join("m/p_occ.png"));
    assert_eq!(p[11 + 2], [64, 64, 64]);
}

#[test]
fn a_wide_picture_is_reduced_and_keeps_the_strongest_cell() {
    let dir = tempfile::tempdir().unwrap();
    let (width, height) = (3 * 8192 - 1, 12);
    let mut map = map(width, height);
    let mut values = vec![0.5f32; width * height];
    values[4 * width + 100] = -3.0; // columns 96 to 103, rows 0 to 7: one pixel
    values[5 * width + 101] = 2.0;
    map.layers = vec![layer("wide", Data::F32(values), 0.0, Scale::Signed { limit: 3.0 })];
    write_picture(&dir.path().join("wide.png"), &map, &map.layers[0]).unwrap();
    let (w, h, found) = pixels(&dir.path().join("wide.png"));
    assert_eq!((w, h), (3072, 2));
    assert_eq!(found[3072 + 12], [1, 1, 255]);
    assert_eq!(found[0], found[3072 + 11]);
}

#[test]
fn nav2_map_has_the_origin_the_values_and_the_top_row_first() {
    let dir = tempfile::tempdir().unwrap();
    let map = map(11, 8);
    write(&dir.path().join("m"), &map, false);
    let pgm = std::fs::read(dir.path().join("m/map.pgm")).unwrap();
    let header = b"P5\n11 8\n255\n";
    assert_eq!(&pgm[..header.len()], header);
    let pixels = &pgm[header.len()..];
    assert_eq!(pixels.len(), 88);
    assert_eq!((pixels[11 + 2], pixels[0], pixels[6 * 11]), (0, 205, 254));
    let yaml = std::fs::read_to_string(dir.path().join("m/map.yaml")).unwrap();
    for line in ["image: map.pgm", "resolution: 0.5", "origin: [-2.0, 1.0, 0.0]", "negate: 0", "free_thresh: 0.196"] {
        assert!(yaml.lines().any(|l| l == line), "{line} in\n{yaml}");
    }
    let back = read_ros(&dir.path().join("m/map.yaml")).unwrap();
    assert_eq!(back.layer("class").unwrap().data, map.layer("class").unwrap().data);
    assert_eq!((back.grid.x0(), back.grid.y0()), (map.grid.x0(), map.grid.y0()));
}

#[test]
fn other_peoples_nav2_maps_are_read_or_refused_with_a_reason() {
    let dir = tempfile::tempdir().unwrap();
    let yaml = dir.path().join("a.yaml");
    let read = |text: &str, picture: &[u8]| {
        std::fs::write(&yaml, text).unwrap();
        std::fs::write(dir.path().join("a.pgm"), picture).unwrap();
        read_ros(&yaml)
    };
    let good = "image: \"a.pgm\" # ours\nresolution: 0.05\norigin: [-1, 2.5, 0.00]\nnegate: 0\noccupied_thresh: 0.65\n\
                free_thresh: 0.25\n";
    let picture = b"P5\n# made by hand\n3 1\n255\n\x00\xf0\xa0";
    let map = read(good, picture).unwrap();
    assert_eq!(map.layer("class").unwrap().data, Data::I8(vec![1, -1, 0]));
    let negated = read(&good.replace("negate: 0", "negate: 1"), picture).unwrap();
    assert_eq!(negated.layer("class").unwrap().data, Data::I8(vec![-1, 1, 0]));
    let refused = |text: &str, picture: &[u8], why: &str| {
        let error = read(text, picture).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Input);
        assert!(error.to_string().contains(why), "{error}");
    };
    refused(&good.replace("0.00]", "0.3]"), picture, "turned maps");
    refused(&good.replace("0.05", "-1"), picture, "resolution");
    refused("image: a.pgm\n", picture, "no \"resolution\"");
    refused(good, b"P4\n3 1\n\x00", "P5");
    refused(good, b"P5\n3 1\n255\n\x00", "ends after 1 of 3");
    refused(good, b"P5\n3", "header");
    refused(good, b"", "P5");
}

#[test]
fn the_report_counts_the_map() {
    let dir = tempfile::tempdir().unwrap();
    let report = write(&dir.path().join("m"), &map(11, 8), false);
    let text = std::fs::read_to_string(dir.path().join("m/report.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(serde_json::to_value(&report).unwrap(), json);
    let cells = &json["cells"];
    assert_eq!((&cells["x0"], &cells["y0"], &cells["width"]), (&(-2.0).into(), &1.0.into(), &11.into()));
    let counts = ["touched", "occupied", "empty", "unknown"].map(|k| cells[k].as_u64().unwrap());
    assert_eq!(counts, [12, 1, 11, 76]);
    assert_eq!(json["layers"]["log_odds"]["sum"], -15.0);
    assert_eq!(json["layers"]["count"]["max"], 70_000.0);
    assert_eq!(json["layers"]["log_odds"]["scale"]["signed"], 3.0);
    assert_eq!(json["readings"]["rejected"]["below_r_min"], 0);
    assert_eq!(json["bad_lines"]["count"], 1);
    assert!(json["seconds"]["write"].as_f64().unwrap() > 0.0);
    assert!(text.find("\"read\"").unwrap() < text.find("\"map\"").unwrap(), "stages in their order");
    assert_eq!(json["peak_memory"].is_u64(), cfg!(target_os = "linux"));
}

/// Every file of a folder by its path.
fn files(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![root.to_path_buf()];
    while let Some(dir) = open.pop() {
        for entry in std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()) {
            if entry.is_dir() {
                open.push(entry);
            } else {
                let name = entry.strip_prefix(root).unwrap().to_string_lossy().into_owned();
                found.insert(name, std::fs::read(&entry).unwrap());
            }
        }
    }
    found
}

#[test]
fn two_writes_give_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let mut map = map(2100, 1300);
    let Data::F32(odds) = &mut map.layers[0].data else { unreachable!() };
    for (k, v) in odds.iter_mut().enumerate() {
        *v = (k as f32 * 0.37).sin();
    }
    for name in ["a", "b"] {
        write(&dir.path().join(name), &map, true);
    }
    let (mut a, mut b) = (files(&dir.path().join("a")), files(&dir.path().join("b")));
    let (a_report, b_report) = (a.remove("report.json").unwrap(), b.remove("report.json").unwrap());
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    assert!(!a.keys().any(|k| k.starts_with(".echogrid")));
    for (name, bytes) in &a {
        assert!(*bytes == b[name], "{name} differs");
    }
    let same = |report: &[u8]| {
        let mut json: serde_json::Value = serde_json::from_slice(report).unwrap();
        json.as_object_mut().unwrap().retain(|k, _| k != "seconds" && k != "peak_memory");
        json
    };
    assert_eq!(same(&a_report), same(&b_report));
}

#[test]
fn a_map_that_breaks_the_contract_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Folder::prepare(&dir.path().join("m")).unwrap();
    let refused = |map: Map, why: &str| {
        let error = write_map(&folder, &map, &map.layers[0], &info(), false).unwrap_err();
        assert!(error.to_string().contains(why), "{error}");
    };
    let with = |change: fn(&mut Map)| {
        let mut map = map(11, 8);
        change(&mut map);
        map
    };
    refused(with(|m| m.layers[0].name = "../x".into()), "no layer name");
    refused(with(|m| m.layers[0].name = "y".into()), "no layer name");
    refused(with(|m| m.layers[0].data = Data::U8(vec![0])), "1 values for 88 cells");
    refused(with(|m| drop(m.layers.pop())), "no layer class");
}
