//! simulate, truth, and score against a world, as a user runs them.

use crate::common::Place;
use std::path::Path;

fn world(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds").join(name).display().to_string()
}

#[test]
fn a_simulated_log_is_a_log_like_any_other() {
    let (place, bend) = (Place::new(), world("bend.toml"));
    let ran = place.does(&["simulate", &bend, "-o", "bend.jsonl", "--seed", "4", "--rig", "ring24"]);
    let lines: Vec<&str> = ran.out.lines().collect();
    assert!(lines[0].starts_with("bend: 576 readings (ring24) in 24 scans, "), "{}", ran.out);
    assert!(lines[0].contains(" % without an echo; ") && lines[0].ends_with(" readings/s"), "{}", ran.out);
    assert_eq!(lines[1], "Next: echogrid map bend.jsonl -o DIR");
    assert_eq!(place.names(""), ["bend.jsonl", "log.jsonl", "run"]);
    let report = place.does(&["map", "bend.jsonl", "-o", "map", "--backend", "cpu", "--json"]).json();
    assert_eq!((&report["readings"]["read"], &report["bad_lines"]["count"]), (&576.into(), &0.into()));
    // what a laser that looks ahead sees, mapped as the truth, is the world
    place.does(&["simulate", &bend, "-o", "laser.jsonl", "--rig", "laser", "--quiet"]);
    place.does(&["map", "laser.jsonl", "-o", "seen", "-m", "truth", "--backend", "cpu", "--quiet"]);
    let seen = place.does(&["score", "seen", "--truth", &bend, "--json"]).json()["maps"][0].clone();
    let number = |name: &str| seen[name].as_f64().unwrap();
    assert!(number("precision_tolerant") > 0.99 && number("recall_tolerant") > 0.8, "{seen}");
    assert!(number("accuracy") > 0.98, "{seen}");
}

#[test]
fn a_seed_decides_every_byte() {
    let (place, room) = (Place::new(), world("turned.toml"));
    let log = |more: &[&str]| {
        place.does(&[&["simulate", &room, "-o", "a.jsonl", "--quiet"], more].concat());
        std::fs::read(place.path("a.jsonl")).unwrap()
    };
    let one = log(&["--seed", "5", "--scans", "40"]);
    assert_eq!(one.iter().filter(|b| **b == b'\n').count(), 1 + 40 * 200);
    assert_eq!(log(&["--seed", "5", "--scans", "40", "--threads", "1"]), one);
    assert!(log(&["--seed", "6", "--scans", "40"]) != one);
    // a shorter log is the longer one's beginning
    let short = log(&["--seed", "5", "--scans", "3"]);
    assert!(one.starts_with(&short) && short.len() < one.len());
    let ran = place.does(&["simulate", &room, "-o", "-", "--seed", "5", "--scans", "3"]);
    assert_eq!(ran.out.as_bytes(), short);
    assert!(log(&["--seed", "5", "--scans", "3", "--bounces", "1"]) != short);
    // with no mirrors hardly an echo is missing
    let missing = |log: &[u8]| String::from_utf8_lossy(log).matches("\"z\":null").count();
    let direct = log(&["--seed", "5", "--scans", "3", "--no-specular"]);
    assert!(missing(&short) > 300 && missing(&direct) < 60, "{} and {}", missing(&short), missing(&direct));
}

#[test]
fn a_refused_world_leaves_the_old_log() {
    let place = Place::new();
    place.write("open.toml", "[[outline]]\npoints = [[0,0],[4,0],\n[4,3],\n[0,3]]\n[path]\nposes = [[1,1]]\n");
    place.refuses(
        &["simulate", "open.toml", "-o", "log.jsonl"],
        3,
        "echogrid: open.toml:4: the outline is open: it begins at [0, 0] and ends at [0, 3]; repeat the first point at \
         the end, or make it a [[wall]]",
    );
    for arguments in [&["truth", "open.toml", "-o", "map"][..], &["score", "map", "--truth", "open.toml"]] {
        let ran = place.run(arguments);
        assert!(ran.code == 3 && ran.err.contains("open.toml:4: the outline is open"), "{ran:?}");
    }
    assert_eq!(std::fs::read(place.path("log.jsonl")).unwrap(), crate::common::SMALL.as_bytes());
    let room = world("room.toml");
    for (output, why) in [("run", "run is a folder"), ("no/such/log.jsonl", "no/such/log.jsonl can't be written")] {
        let before = place.names("");
        let ran = place.run(&["simulate", &room, "-o", output]);
        assert!(ran.code == 5 && ran.err.contains(why), "{ran:?}");
        assert_eq!(place.names(""), before);
    }
    let ran = place.run(&["simulate", "none.toml", "-o", "x"]);
    assert!(ran.code == 3 && ran.err.starts_with("echogrid: none.toml"), "{ran:?}");
    for bad in [&["--scans", "0"][..], &["--bounces", "4"], &["--rig", "rign9"], &["--rig", "ring361"]] {
        assert_eq!(place.run(&[&["simulate", &room, "-o", "x"], bad].concat()).code, 2, "{bad:?}");
    }
}

#[test]
fn a_true_map_is_a_map_and_a_truth() {
    let (place, room) = (Place::new(), world("room.toml"));
    let ran = place.does(&["truth", &room, "-o", "truth", "-r", "10cm"]);
    // the room's 4.6 × 3.4 m lie off the grid: 47 × 35 cells with a wall or free, all of them in sight
    assert!(
        ran.out.starts_with(
            "room, seen from 2 places up to 5 m: 147 × 135 cells of 0.1 m; 160 occupied, 1485 empty, 18200 unknown"
        ),
        "{}",
        ran.out
    );
    let perfect = |truth: &str, more: &[&str]| {
        let json = place.does(&[&["score", "truth", "--truth", truth, "--json"], more].concat()).json();
        let n = json["maps"][0].clone();
        assert_eq!(
            (&n["danger"], &n["accuracy"], &n["occupied_found"]),
            (&0.0.into(), &1.0.into(), &160.into()),
            "{n}"
        );
        assert_eq!(n["levels"][0], n["cells"]);
    };
    perfect(&room, &["--require", "danger<=0", "--require", "near.accuracy>=1"]);
    perfect("truth", &[]);
    perfect("truth/map.yaml", &[]);
    // the true map scores others as the world itself does, over the cells that both know
    place.does(&["simulate", &room, "-o", "room.jsonl", "--quiet"]);
    place.does(&["map", "room.jsonl", "-o", "map", "-r", "10cm", "--backend", "cpu", "--quiet"]);
    let danger =
        |truth: &str| place.does(&["score", "map", "--truth", truth, "--json"]).json()["maps"][0]["danger"].clone();
    assert!(danger(&room).as_f64().unwrap() > 0.1);
    assert_eq!((danger(&room), danger(&room)), (danger("truth"), danger("truth/map.yaml")));
    // other bounds and another range
    place.does(&["truth", &room, "-o", "part", "-b", "0,0,2,2", "--r-max", "1", "-q"]);
    let json = place.does(&["score", "part", "--truth", &room, "--r-max", "1", "--json"]).json();
    assert!(json["maps"][0]["o_to_e"] == 0 && json["maps"][0]["unknown"].as_f64().unwrap() > 0.1, "{json}");

    place.refuses(
        &["truth", &room, "-o", "x", "--r-max", "-1"],
        2,
        "echogrid: --r-max -1 is no range: give metres, more than 0",
    );
    place.refuses(
        &["truth", &room, "-o", "x", "-b", "0,0,1"],
        2,
        "echogrid: --bounds takes x0,y0,x1,y1, four numbers; here are 3",
    );
    let ran = place.run(&["truth", &world("campus.toml"), "-o", "x", "-r", "1mm"]);
    assert!(ran.code == 5 && ran.err.contains("GiB") && ran.err.contains("--resolution"), "{ran:?}");
}

#[test]
fn built_in_worlds_need_no_file() {
    let place = Place::new();
    let listed = place.does(&["simulate", "--list"]).out;
    let names: Vec<&str> = listed.lines().filter_map(|l| l.split_whitespace().next()).collect();
    assert_eq!(names, ["room", "turned", "bend", "cartons", "floor", "campus"]);
    assert!(listed.lines().all(|l| l.len() > 50), "each is explained: {listed}");
    // one of each file in worlds/
    let mut files: Vec<String> = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds"))
        .unwrap()
        .map(|e| e.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    files.sort();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    assert_eq!(files, sorted);

    place.does(&["simulate", "room", "-o", "named.jsonl", "--seed", "1"]);
    place.does(&["simulate", &world("room.toml"), "-o", "file.jsonl", "--seed", "1", "--quiet"]);
    assert_eq!(std::fs::read(place.path("named.jsonl")).unwrap(), std::fs::read(place.path("file.jsonl")).unwrap());
    place.does(&["map", "named.jsonl", "-o", "map", "--backend", "cpu", "--quiet"]);
    let score = |truth: &str| place.does(&["score", "map", "--truth", truth, "--json"]).json()["maps"][0].clone();
    assert_eq!(score("room"), score(&world("room.toml")));
    place.does(&["truth", "room", "-o", "true", "-q"]);
    assert_eq!(score("true")["danger"], score("room")["danger"]);

    // what is called so in the folder isn't meant, and that is said
    place.does(&["map", "named.jsonl", "-o", "room", "--backend", "cpu", "--quiet"]);
    let note = "echogrid: room is the built-in world; for what is called so in this folder write ./room\n";
    let ran = place.run(&["score", "map", "--truth", "room", "--json"]);
    assert_eq!((ran.code, ran.err.as_str(), &ran.json()["maps"][0]), (0, note, &score("room")));
    let own = place.run(&["score", "map", "--truth", "./room", "--json"]);
    assert_eq!((own.err.as_str(), &own.json()["maps"][0]["accuracy"]), ("", &1.0.into()));
    for arguments in [&["simulate", "room", "-o", "x.jsonl", "--quiet"][..], &["truth", "room", "-o", "x", "-q"]] {
        let ran = place.run(arguments);
        assert_eq!((ran.code, ran.err.as_str()), (0, note), "{arguments:?}");
    }
    // without --list a world and a place for the log are needed
    for arguments in
        [&["simulate"][..], &["simulate", "room"], &["simulate", "-o", "x"], &["simulate", "--list", "room"]]
    {
        assert_eq!(place.run(arguments).code, 2, "{arguments:?}");
    }
}

#[test]
fn an_unknown_world_names_the_nearest() {
    let place = Place::new();
    let meant =
        |name: &str| format!("echogrid: {name}: there is no such file; did you mean \"room\", a built-in world?");
    for name in ["rom", "Room", "rooms", "worlds/room.toml", "room.toml"] {
        place.refuses(&["simulate", name, "-o", "x.jsonl"], 3, &meant(name));
        place.refuses(&["truth", name, "-o", "x"], 3, &meant(name));
    }
    let all = "the built-in worlds are room, turned, bend, cartons, floor, campus";
    place.refuses(&["simulate", "xyz", "-o", "x"], 3, &format!("echogrid: xyz: there is no such file; {all}"));
    place.does(&["map", "log.jsonl", "-o", "map", "--backend", "cpu", "--quiet"]);
    place.refuses(
        &["score", "map", "--truth", "benf"],
        3,
        "echogrid: benf: there is no such map, nor such a world; did you mean \"bend\", a built-in world?",
    );
    place.refuses(
        &["score", "map", "--truth", "bent.toml"],
        3,
        "echogrid: bent.toml: there is no such file; did you mean \"bend\", a built-in world?",
    );
}
