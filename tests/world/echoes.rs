//! Every first echo of whole logs against `python/echoes.py`, which finds them anew from the equations of `worlds.md`.
//! It needs Python 3.11 or newer (tomllib) with numpy. `scripts/test` makes the environment; without one the tests say
//! so on standard error, and `ECHOGRID_REQUIRE_PYTHON=1` makes that an error.

use echogrid::world::rig::Noise;
use echogrid::world::{Rig, Simulation, World, simulate};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Thin walls (bent, a T, a partition out of a corner), a circle, an arc, soft and glass walls and a turned box.
const FURNISHED: &str = r#"
[[outline]]
points = [[0.02, 0.03], [5.02, 0.03], [5.02, 4.03], [0.02, 4.03], [0.02, 0.03]]

[[wall]]
points = [[3.5, 2.2], [3.5, 3.1], [2.6, 3.3]]

[[wall]]
points = [[1.2, 0.9], [2.6, 0.9]]

[[wall]]
points = [[1.9, 0.9], [1.9, 1.6]]

[[wall]]
points = [[0.02, 4.03], [0.9, 3.2]]

[[wall]]
points = [[0.5, 1.9], [0.5, 2.9]]
surface = "absorbing"

[[wall]]
points = [[2.9, 0.4], [3.6, 0.6]]
surface = "glass"

[[box]]
centre = [4.3, 3.2]
size = [0.5, "40cm"]
turn = "25deg"

[[circle]]
centre = [4.2, 1.1]
radius = 0.25

[[circle]]
centre = [2.2, 2.6]
radius = 0.5
from = "200deg"
to = "320deg"

[path]
poses = [[0.8, 0.6], [1.5, 1.3], [2.3, 1.2], [3.2, 1.6], [2.2, 2.7], [3.1, 2.8], [1.2, 3.4], [4.2, 2.2], [0.3, 2.4]]
"#;

/// Two corners of 60° and two of 120°.
const SLANTED: &str = r#"
[[outline]]
points = [[0, 0], [4, 0], [5.5, 2.598], [1.5, 2.598], [0, 0]]

[path]
poses = [[0.8, 0.45], [1.3, 0.6], [1.7, 1.9], [2.7, 1.3], [3.9, 0.6], [4.6, 2.0]]
"#;

/// A rough wall and a rough column.
const ROUGH: &str = r#"
[[outline]]
points = [[0.02, 0.03], [5.02, 0.03], [5.02, 4.03], [0.02, 4.03], [0.02, 0.03]]

[[wall]]
points = [[0.5, 3.0], [2.0, 3.3]]
surface = "diffuse"

[[circle]]
centre = [3.4, 2.2]
radius = 0.4
surface = "diffuse"

[path]
poses = [[1.0, 1.0], [2.6, 1.2], [4.2, 3.0], [1.0, 2.2], [2.2, 2.7]]
"#;

/// The interpreter of `ECHOGRID_PYTHON`, or else `python3`; it must have what the script needs.
fn interpreter() -> Result<PathBuf, String> {
    let named = std::env::var_os("ECHOGRID_PYTHON").map(PathBuf::from);
    let python = named.unwrap_or_else(|| PathBuf::from("python3"));
    let found = Command::new(&python).args(["-c", "import tomllib, numpy"]).output();
    match found {
        Ok(run) if run.status.success() => Ok(python),
        Ok(run) => Err(format!("{}: {}", python.display(), String::from_utf8_lossy(&run.stderr).trim_end())),
        Err(e) => Err(format!("{}: {e}", python.display())),
    }
}

/// The same, for a test that is skipped without one.
fn python(test: &str) -> Option<PathBuf> {
    let needs = "no Python 3.11 or newer (for tomllib) with numpy";
    match interpreter() {
        Ok(python) => Some(python),
        Err(why) if std::env::var_os("ECHOGRID_REQUIRE_PYTHON").is_some_and(|v| v == "1") => {
            panic!("{needs} (run scripts/test, or set ECHOGRID_PYTHON): {why}")
        }
        Err(why) => {
            // Not eprintln, which a passing test keeps to itself.
            let skipped = format!("SKIPPED {test}: {needs}: {why}\n");
            std::io::stderr().write_all(skipped.as_bytes()).unwrap();
            None
        }
    }
}

fn shipped(name: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("worlds").join(name)).unwrap()
}

/// Simulates a world as a dense sonar without false echoes, noise and flutter hears it.
fn log(world: &str, bounces: u8, path: &Path) {
    let mut rig = Rig::named("dense").unwrap();
    (rig.spurious, rig.cross_talk, rig.physics.flutter, rig.physics.bounces) = (0.0, 0.0, 0.0, bounces);
    rig.transducers.iter_mut().for_each(|t| t.noise = Noise { metres: 0.0, share: 0.0 });
    let world = World::parse(Path::new("world.toml"), world).unwrap();
    let file = BufWriter::new(File::create(path).unwrap());
    simulate(&Simulation { world: &world, rig: &rig, seed: 1, scans: None }, file, &|_| {}).unwrap();
}

/// What the script says of the log of one world, set against another: whether all readings agree, and its words.
fn agree(python: &Path, expected: (&str, u8), simulated: (&str, u8)) -> (bool, String) {
    let dir = tempfile::tempdir().unwrap();
    let [world, readings] = ["world.toml", "log.jsonl"].map(|name| dir.path().join(name));
    std::fs::write(&world, expected.0).unwrap();
    log(simulated.0, simulated.1, &readings);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/echoes.py");
    let run = Command::new(python).arg(script).args([&world, &readings]).arg(expected.1.to_string()).output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    // a script that broke off also fails, but says nothing of readings
    assert!(out.contains(" readings, "), "{out}\n{err}");
    (run.status.success(), out.into_owned())
}

#[test]
fn every_first_echo_is_the_one_that_the_equations_give() {
    let Some(python) = python("every_first_echo_is_the_one_that_the_equations_give") else { return };
    let files = ["room", "turned", "bend", "cartons"].map(|name| (name, shipped(&format!("{name}.toml"))));
    let made =
        [("furnished", FURNISHED), ("slanted", SLANTED), ("rough", ROUGH)].map(|(n, text)| (n, text.to_string()));
    for (name, text) in files.into_iter().chain(made) {
        for bounces in [3, 1] {
            let (equal, words) = agree(&python, (text.as_str(), bounces), (text.as_str(), bounces));
            assert!(equal, "{name}, bounces = {bounces}: {words}");
            // the log has echoes to compare, and readings without one
            let counts: Vec<u64> = words.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
            assert!(counts[1] > counts[0] / 10 && counts[2] > counts[0] / 10, "{name}: {words}");
        }
    }
}

#[test]
fn a_wrong_world_or_wrong_physics_are_found_out() {
    let Some(python) = python("a_wrong_world_or_wrong_physics_are_found_out") else { return };
    let room = shipped("room.toml");
    let moved = room.replace("4.62", "4.65"); // its right wall by 3 cm
    let soft = FURNISHED.replace("glass", "absorbing");
    let open = FURNISHED.replace("320deg", "290deg"); // a quarter off the arc
    assert!(moved != room && soft != FURNISHED && open != FURNISHED);
    let faults = [
        ("a wall moved", (room.as_str(), 3), (moved.as_str(), 3)),
        ("another surface", (FURNISHED, 3), (soft.as_str(), 3)),
        ("a shorter arc", (FURNISHED, 3), (open.as_str(), 3)),
        ("fewer bounces", (room.as_str(), 3), (room.as_str(), 1)),
    ];
    for (what, expected, simulated) in faults {
        let (equal, words) = agree(&python, expected, simulated);
        assert!(!equal && !words.contains(" 0 differ"), "{what} went unnoticed: {words}");
    }
}
