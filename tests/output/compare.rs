//! Comparing maps: a single bit is found, named and shown.

use crate::common::{map, write};
use echogrid::ErrorKind;
use echogrid::evaluate::compare::{Options, compare, write_pictures};
use echogrid::grid::{Data, GridSpec, Map};
use echogrid::output::read_map;

fn odds(map: &mut Map) -> &mut Vec<f32> {
    match &mut map.layers[0].data {
        Data::F32(v) => v,
        _ => unreachable!(),
    }
}

#[test]
fn a_map_equals_itself_stored_or_not() {
    let dir = tempfile::tempdir().unwrap();
    let mut a = map(11, 8);
    odds(&mut a)[3] = f32::NAN;
    write(&dir.path().join("m"), &a, false);
    let b = read_map(&dir.path().join("m")).unwrap().map;
    let found = compare(&a, &b, &Options::default()).unwrap();
    assert!(found.equal);
    assert_eq!(found.to_string().lines().last().unwrap(), "equal: 88 cells, to the bit");
    assert!(write_pictures(&a, &b, &found, &dir.path().join("p")).unwrap().is_empty());
}

#[test]
fn one_bit_is_found_and_tolerated_only_if_asked() {
    let (a, mut b) = (map(11, 8), map(11, 8));
    let cell = &mut odds(&mut b)[11 + 4];
    *cell = f32::from_bits(cell.to_bits() + 1);
    let found = compare(&a, &b, &Options::default()).unwrap();
    assert!(!found.equal);
    let layer = &found.layers[0];
    let worst = layer.worst.unwrap();
    assert_eq!((layer.differ, worst.column, worst.row, worst.x, worst.y), (1, 4, 1, 0.25, 1.75));
    assert!(layer.largest > 1e-7 && layer.largest < 2e-7);
    let options = Options { tolerance: 1e-6, common: false };
    assert!(compare(&a, &b, &options).unwrap().equal);
    odds(&mut b)[0] = -0.0;
    assert_eq!(compare(&a, &b, &Options::default()).unwrap().layers[0].differ, 2);
    odds(&mut b)[0] = f32::NAN;
    let found = compare(&a, &b, &options).unwrap();
    assert!(!found.equal && found.layers[0].largest.is_infinite());
    assert_eq!(serde_json::to_value(&found).unwrap()["layers"][0]["largest"], serde_json::Value::Null);
}

#[test]
fn classes_know_no_tolerance_and_the_pictures_show_them() {
    let dir = tempfile::tempdir().unwrap();
    let (a, mut b) = (map(11, 8), map(11, 8));
    let n = b.layers.len();
    if let Data::I8(class) = &mut b.layers[n - 1].data {
        class[0] = 1;
    }
    if let Data::U8(touched) = &mut b.layers[n - 2].data {
        touched[0] = 1;
    }
    let found = compare(&a, &b, &Options { tolerance: 100.0, common: false }).unwrap();
    assert_eq!((found.equal, found.class, found.touched), (false, 1, 1));
    let pictures = write_pictures(&a, &b, &found, &dir.path().join("p")).unwrap();
    let names: Vec<_> = pictures.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(
        names,
        [
            "touched.a.png",
            "touched.b.png",
            "touched.difference.png",
            "class.a.png",
            "class.b.png",
            "class.difference.png"
        ]
    );
    let picture = image::open(&pictures[5]).unwrap().to_rgb8();
    assert_eq!(picture.get_pixel(0, 7).0, [255, 1, 1]);
    assert_eq!(picture.get_pixel(1, 7).0, [255, 255, 255]);
}

#[test]
fn layers_of_one_side_and_other_types_are_named() {
    let (a, mut b) = (map(11, 8), map(11, 8));
    b.layers[1].name = "other".into();
    b.layers[2].data = Data::F32((0..88).map(|k| a.layers[2].data.get(k) as f32).collect());
    let found = compare(&a, &b, &Options::default()).unwrap();
    assert!(!found.equal);
    assert_eq!((found.only_a[0].as_str(), found.only_b[0].as_str()), ("p_occ", "other"));
    let text = found.to_string();
    assert!(text.contains("only in the second map: other") && text.contains("types uint32 and float32"), "{text}");
}

/// The part of a map that starts at a column and a row.
fn part(map: &Map, column: usize, row: usize, width: usize, height: usize) -> Map {
    let GridSpec { i0, j0, .. } = map.grid;
    let grid = GridSpec { i0: i0 + column as i64, j0: j0 + row as i64, width, height, ..map.grid };
    let mut part = Map { grid, ..map.clone() };
    for layer in &mut part.layers {
        let cells = (0..height).flat_map(|r| (0..width).map(move |c| (row + r) * map.grid.width + column + c));
        layer.data = match &layer.data {
            Data::F32(v) => Data::F32(cells.map(|k| v[k]).collect()),
            Data::U32(v) => Data::U32(cells.map(|k| v[k]).collect()),
            Data::U8(v) => Data::U8(cells.map(|k| v[k]).collect()),
            Data::I8(v) => Data::I8(cells.map(|k| v[k]).collect()),
        };
    }
    part
}

#[test]
fn common_cells_of_different_grids() {
    let dir = tempfile::tempdir().unwrap();
    let a = map(11, 8);
    let mut b = part(&a, 1, 1, 9, 7);
    let found = compare(&a, &b, &Options::default()).unwrap();
    assert!(!found.equal && found.grids.is_some() && found.layers.is_empty());
    let common = Options { tolerance: 0.0, common: true };
    let found = compare(&a, &b, &common).unwrap();
    assert_eq!((found.equal, found.cells), (true, 63));
    assert_eq!(compare(&b, &a, &common).unwrap().cells, 63);
    // The same cells from another anchor.
    b.grid = GridSpec { anchor: (b.grid.x0(), b.grid.y0()), i0: 0, j0: 0, ..b.grid };
    assert!(compare(&a, &b, &common).unwrap().equal);
    odds(&mut b)[5 * 9 + 1] = 9.0;
    let found = compare(&a, &b, &common).unwrap();
    let worst = found.layers[0].worst.unwrap();
    assert_eq!((worst.column, worst.row), (2, 6));
    assert_eq!(write_pictures(&a, &b, &found, dir.path()).unwrap().len(), 3);
    b.grid.anchor.0 += 0.1;
    assert_eq!(compare(&a, &b, &common).unwrap_err().kind(), ErrorKind::Usage);
    b.grid.anchor.0 += 1e6 * 0.5 - 0.1;
    assert!(compare(&a, &b, &common).unwrap_err().to_string().contains("no cell in common"));
    b.grid.resolution = 0.25;
    assert!(compare(&a, &b, &common).unwrap_err().to_string().contains("--resolution"));
}
