//! `compare`: equal maps, and where others differ.

use crate::common::Place;

/// Two maps: Max_occ 0.98 and 0.9; the arcs differ.
fn two() -> Place {
    let place = Place::new();
    place.map("a", &[]);
    place.map("b", &["--set", "max_occ=0.9"]);
    place
}

#[test]
fn a_map_equals_itself() {
    let place = two();
    let ran = place.does(&["compare", "a", "a"]);
    assert_eq!(
        ran.out,
        "layer        cells differ      largest  worst cell
log_odds                0            0
p_occ                   0            0
p_emp                   0            0
touched                 0            0
class                   0            0
equal: 1900 cells, to the bit
"
    );
    let ran = place.does(&["compare", "a", "a", "--json", "--pictures", "pictures"]);
    assert_eq!((&ran.json()["equal"], &ran.json()["cells"]), (&true.into(), &1900.into()));
    assert!(!place.path("pictures").exists());
}

#[test]
fn another_parameter_is_a_difference_with_its_worst_cell() {
    let place = two();
    let ran = place.run(&["compare", "a", "b"]);
    assert_eq!(ran.code, 1);
    let row = ran.out.lines().find(|l| l.starts_with("log_odds")).unwrap();
    let worst = row.split_once("  (").unwrap().1;
    let (at, values) = worst.split_once(" m: ").unwrap();
    let (a, b) = values.split_once(" and ").unwrap();
    assert!(at.contains(") at ") && row.chars().count() <= 100, "{row}");
    assert!(a.parse::<f64>().unwrap() > b.parse::<f64>().unwrap(), "{row}: a smaller Max_occ occupies less");
    let verdict = ran.out.lines().last().unwrap();
    assert!(verdict.starts_with("different: of 1900 cells 0 touched by one map only, "), "{verdict}");
    // The same in JSON, and both name the same cell.
    let found = place.run(&["compare", "a", "b", "--json"]);
    assert_eq!(found.code, 1);
    let layer = &found.json()["layers"][0];
    assert_eq!(layer["name"], "log_odds");
    let place_of = format!("{}, {})", layer["worst"]["column"], layer["worst"]["row"]);
    assert!(at.starts_with(&place_of), "{at} and {place_of}");
}

#[test]
fn another_method_is_a_difference() {
    let place = two();
    place.map("himm", &["--method", "himm"]);
    let ran = place.run(&["compare", "a", "himm"]);
    assert_eq!(ran.code, 1);
    let end: Vec<&str> = ran.out.lines().rev().take(3).collect();
    assert!(end[0].starts_with("different: of 1900 cells "), "{}", ran.out);
    assert_eq!(end[1..], ["only in the second map: count", "only in the first map: log_odds, p_occ, p_emp"]);
}

#[test]
fn a_tolerance_is_for_values_not_for_classes() {
    let place = two();
    let classes = place.run(&["compare", "a", "b", "--tol", "1", "--json"]);
    assert_eq!(classes.code, 1);
    let json = classes.json();
    assert!(json["class"].as_u64().unwrap() > 0);
    assert!(json["layers"].as_array().unwrap().iter().all(|l| l["name"] == "class" || l["differ"] == 0), "{json}");
    // Where no class differs, the tolerance decides.
    place.map("c", &["--set", "max_occ=0.979"]);
    assert_eq!(place.run(&["compare", "a", "c"]).code, 1);
    let ran = place.does(&["compare", "a", "c", "--tol", "0.1"]);
    assert!(ran.out.ends_with("equal: 1900 cells, within 0.1\n"), "{}", ran.out);
    place.refuses(&["compare", "a", "b", "--tol", "-1"], 2, "echogrid: --tol -1 is no tolerance: give 0 or more");
    place.refuses(&["compare", "a", "b", "--tol", "nan"], 2, "echogrid: --tol NaN is no tolerance: give 0 or more");
}

#[test]
fn other_bounds_are_a_difference_unless_the_common_cells_are_asked_for() {
    let place = two();
    place.map("window", &["--bounds", "-1,-1,2,2"]);
    let ran = place.run(&["compare", "a", "window"]);
    assert_eq!(ran.code, 1);
    assert!(ran.out.starts_with("grids differ: 50 × 38 cells of 0.05 m from (0, -0.45"), "{}", ran.out);
    assert!(ran.out.ends_with(") and 60 × 60 cells of 0.05 m from (-1, -1)\ndifferent\n"), "{}", ran.out);
    let ran = place.does(&["compare", "a", "window", "--common"]);
    assert!(ran.out.ends_with("equal: 1520 cells, to the bit\n"), "{}", ran.out);
    place.map("coarse", &["--resolution", "0.1"]);
    let ran = place.run(&["compare", "a", "coarse", "--common"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.ends_with("can't be compared cell by cell: make both with one --resolution\n"), "{}", ran.err);
}

#[test]
fn pictures_of_what_differs() {
    let place = two();
    let ran = place.run(&["compare", "a", "b", "--pictures", "deep/pictures"]);
    assert_eq!(ran.code, 1);
    let wanted: Vec<String> = ["class", "log_odds", "p_emp", "p_occ"]
        .iter()
        .flat_map(|layer| ["a", "b", "difference"].map(|side| format!("{layer}.{side}.png")))
        .collect();
    assert_eq!(place.names("deep/pictures"), wanted);
    let seen: Vec<&str> = ran.err.lines().collect();
    assert_eq!(seen.len(), wanted.len());
    assert_eq!(seen[0], "echogrid: see deep/pictures/log_odds.a.png");
    #[cfg(unix)]
    {
        let ran = place.run(&["compare", "a", "b", "--pictures", "log.jsonl"]);
        assert_eq!(
            (ran.code, ran.err.as_str()),
            (5, "echogrid: log.jsonl can't be made: File exists (os error 17); give another folder\n")
        );
    }
}

#[test]
fn what_is_no_map() {
    let place = two();
    for folder in ["nosuch", "run", "log.jsonl"] {
        place.refuses(
            &["compare", "a", folder],
            3,
            &format!("echogrid: {folder}: it is no echogrid map: a folder with report.json and map.zarr is wanted"),
        );
    }
}
