//! A ROS map made by hand, its readings in every mode, and what the command says of one.

use echogrid::ErrorKind;
use echogrid::grid::{Data, Map};
use echogrid::output::{RosMap, read_ros};
use std::path::Path;
use std::process::Command;

/// The picture's rows, the top first.
pub const PIXELS: [u8; 12] = [0, 254, 254, 100, 254, 254, 0, 90, 205, 205, 254, 89];
/// What the pixels mean with the usual thresholds; the bottom row first.
pub const CLASSES: [i8; 12] = [0, 0, -1, 1, -1, -1, 1, 0, 1, -1, -1, 0];
pub const YAML: &str = "image: a.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n\
                        free_thresh: 0.196\n";

/// A folder with the picture.
pub fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.pgm"), [&b"P5\n# by hand\n4 3\n255\n"[..], &PIXELS].concat()).unwrap();
    folder
}

/// Opens a map of that text.
pub fn open(folder: &Path, text: impl AsRef<[u8]>) -> echogrid::Result<RosMap> {
    std::fs::write(folder.join("m.yaml"), text).unwrap();
    RosMap::open(&folder.join("m.yaml"))
}

pub fn classes(map: &Map) -> Vec<i8> {
    let Data::I8(class) = &map.layer("class").unwrap().data else { panic!("class is no i8") };
    class.clone()
}

/// How occupied each cell is, in percent; −1 unknown, as in a nav_msgs/OccupancyGrid.
fn percent(map: &Map) -> Vec<i32> {
    let [p, touched] = ["p_occ", "touched"].map(|name| &map.layer(name).unwrap().data);
    (0..p.len()).map(|k| if touched.get(k) == 0.0 { -1 } else { (p.get(k) * 100.0).round() as i32 }).collect()
}

#[test]
fn modes_in_any_case() {
    let place = place();
    let of = |more: &str| {
        let ros = open(place.path(), format!("{YAML}{more}")).unwrap();
        assert_eq!(ros.notes, Vec::<String>::new(), "{more}");
        ros.map
    };
    for mode in ["trinary", "Trinary", "TRINARY", "\"trinary\""] {
        let map = of(&format!("mode: {mode}\n"));
        assert_eq!((classes(&map), map.layer("p_occ")), (CLASSES.to_vec(), None), "{mode}");
    }
    for mode in ["scale", "Scale", "'SCALE'"] {
        let map = of(&format!("mode: {mode}\n"));
        // (1 − v/255 − .196)/(.65 − .196): 100, 90 and 205 lie between the thresholds, 205 so near that it is free
        assert_eq!(classes(&map), [-1, -1, -1, 1, -1, -1, 1, 0, 1, -1, -1, 0], "{mode}");
        assert_eq!(percent(&map), [0, 0, 0, 100, 0, 0, 100, 99, 100, 0, 0, 91], "{mode}");
        assert_eq!(map.layer("touched").unwrap().data, Data::U8(vec![1; 12]));
    }
    for mode in ["raw", "Raw", "RAW"] {
        let map = of(&format!("mode: {mode}\n"));
        assert_eq!(percent(&map), [-1, -1, -1, 89, -1, -1, 0, 90, 0, -1, -1, 100], "{mode}");
        assert_eq!(classes(&map), [0, 0, 0, 1, 0, 0, -1, 1, -1, 0, 0, 1], "{mode}");
    }
    // raw takes the pixel as it is, whatever negate says: that is noted
    let ros = open(place.path(), format!("{YAML}mode: raw\n").replace("negate: 0", "negate: yes")).unwrap();
    assert_eq!(percent(&ros.map)[3], 89);
    assert!(ros.notes.len() == 1 && ros.notes[0].contains("m.yaml:4: negate"), "{:?}", ros.notes);
}

#[test]
fn thresholds_decide_and_may_be_left_out() {
    let place = place();
    let text = YAML.replace("0.65", "0.6").replace("0.196", "0.25");
    // 205 is .196: free now; 100 is .608, 90 is .647: occupied now
    let ros = open(place.path(), &text).unwrap();
    assert_eq!(classes(&ros.map), [-1, -1, -1, 1, -1, -1, 1, 1, 1, -1, -1, 1]);
    let short = "image: a.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\n";
    assert_eq!(classes(&open(place.path(), short).unwrap().map), CLASSES);
}

/// Where the map's cells of class 1 lie: x, y of their centres, in cells of 0.05 m.
fn occupied(map: &Map) -> Vec<(i64, i64)> {
    let class = classes(map);
    let cell = |k: usize| {
        let (x, y) = map.grid.centre(k % map.grid.width, k / map.grid.width);
        ((x / 0.05).floor() as i64, (y / 0.05).floor() as i64)
    };
    let mut found: Vec<_> = (0..class.len()).filter(|k| class[*k] == 1).map(cell).collect();
    found.sort_unstable();
    found
}

#[test]
fn a_yaw_of_whole_quarters_turns_the_map_about_its_origin() {
    let place = place();
    let with = |yaw: &str| open(place.path(), YAML.replace("0.0]", &format!("{yaw}]")));
    // columns and rows from the origin, which lies at cell −20, −40
    let upright = [(0, 2), (2, 1), (3, 0)];
    let at = |turn: fn((i64, i64)) -> (i64, i64)| {
        let mut all: Vec<_> = upright.iter().map(|c| turn(*c)).map(|(x, y)| (x - 20, y - 40)).collect();
        all.sort_unstable();
        all
    };
    let upside: fn((i64, i64)) -> (i64, i64) = |(x, y)| (-1 - x, -1 - y);
    for (yaw, cells) in [
        ("0", at(|c| c)),
        ("1e-9", at(|c| c)),
        ("1.5707963", at(|(x, y)| (-1 - y, x))),
        ("1.5708", at(|(x, y)| (-1 - y, x))),
        ("3.14159", at(upside)),
        ("-3.14159", at(upside)),
        ("-1.5707963", at(|(x, y)| (y, -1 - x))),
        ("4.712389", at(|(x, y)| (y, -1 - x))),
        ("6.2831853", at(|c| c)),
    ] {
        let map = with(yaw).unwrap().map;
        assert_eq!(occupied(&map), cells, "{yaw}");
        let known = classes(&map).iter().filter(|c| **c == 0).count();
        assert_eq!(known, 4, "{yaw}");
    }
    for yaw in ["0.3", "-0.1", "0.7853982", "90", "1.7"] {
        let error = with(yaw).unwrap_err();
        let text = error.to_string();
        assert_eq!(error.kind(), ErrorKind::Input);
        assert!(text.contains("m.yaml:3: origin: ") && text.contains("turned maps can't be read"), "{text}");
        assert!(text.contains(&format!("yaw {yaw}")) && text.contains("radians") == (yaw == "90"), "{text}");
    }
}

#[test]
fn images_are_found_from_the_yaml_files_folder_or_by_their_path() {
    let place = place();
    let maps = place.path().join("maps");
    std::fs::create_dir(&maps).unwrap();
    let absolute = place.path().join("a.pgm").display().to_string();
    for image in ["../a.pgm", "./../a.pgm", absolute.as_str(), "'../a.pgm'"] {
        std::fs::write(maps.join("m.yaml"), YAML.replace("a.pgm", image)).unwrap();
        assert_eq!(classes(&read_ros(&maps.join("m.yaml")).unwrap()), CLASSES, "{image}");
    }
    std::fs::copy(place.path().join("a.pgm"), maps.join("my map #2.pgm")).unwrap();
    std::fs::write(maps.join("m.yaml"), YAML.replace("a.pgm", "my map #2.pgm")).unwrap();
    let error = read_ros(&maps.join("m.yaml")).unwrap_err().to_string();
    assert!(error.contains("my map: can't be read"), "a comment begins at #: {error}");
    std::fs::write(maps.join("m.yaml"), YAML.replace("a.pgm", "\"my map #2.pgm\"")).unwrap();
    assert_eq!(classes(&read_ros(&maps.join("m.yaml")).unwrap()), CLASSES);
    for (image, why) in [("gone.pgm", "m.yaml names it as its image"), ("../maps", "it is no file")] {
        std::fs::write(maps.join("m.yaml"), YAML.replace("a.pgm", image)).unwrap();
        let error = read_ros(&maps.join("m.yaml")).unwrap_err();
        assert!(error.kind() == ErrorKind::Input && error.to_string().contains(why), "{error}");
    }
}

#[test]
fn the_command_reads_maps_as_others_write_them_and_passes_the_notes_on() {
    let place = place();
    let run = |truth: &str, map: &str| {
        std::fs::write(place.path().join("truth.yaml"), truth).unwrap();
        std::fs::write(place.path().join("m.yaml"), map).unwrap();
        let arguments = ["score", "m.yaml", "--truth", "truth.yaml", "--require", "accuracy>=1"];
        let ran =
            Command::new(env!("CARGO_BIN_EXE_echogrid")).current_dir(place.path()).args(arguments).output().unwrap();
        (ran.status.code().unwrap(), String::from_utf8(ran.stderr).unwrap())
    };
    assert_eq!(run(YAML, &format!("---\n{{{}}}\n", YAML.trim().replace('\n', ", "))), (0, String::new()));
    assert_eq!(run(&YAML.replace("0\nocc", "yes\nocc"), &YAML.replace("0\nocc", "TRUE\nocc")), (0, String::new()));
    // walls and floor are swapped: seen, not said to be right
    assert_eq!(run(&YAML.replace("0\nocc", "on\nocc"), YAML).0, 1);
    let (code, said) = run(&format!("{YAML}negated: 1\n"), &format!("{YAML}frame_id: map\n"));
    assert_eq!(code, 0, "{said}");
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(
        lines,
        [
            "echogrid: truth.yaml:7: the key \"negated\" isn't read; did you mean \"negate\"?",
            "echogrid: m.yaml:7: the key \"frame_id\" isn't read; the keys are image, resolution, origin, negate, \
             occupied_thresh, free_thresh, mode",
        ]
    );
    let (code, said) = run(YAML, &YAML.replace("-2.0", "-2.0m"));
    assert!(
        code == 3 && said.starts_with("echogrid: m.yaml:3: origin: \"-2.0m\" isn't understood: write [x, y"),
        "{said}"
    );
}
