//! Bad worlds: each error names the line and what to do.

use echogrid::world::{Rig, World};
use echogrid::{Error, ErrorKind};
use std::path::Path;

const ROOM: &str = "[[outline]]\npoints = [[0,0],[4,0],[4,3],[0,3],[0,0]]\n";
#[test]
fn files_that_are_no_worlds() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("odd.toml");
    std::fs::write(&file, b"name = 'x'\n\xff\n").unwrap();
    let said = |path: &Path| World::open(path).unwrap_err().to_string();
    assert!(said(&file).contains("odd.toml:2: is not UTF-8 text: give a world's TOML file"), "{}", said(&file));
    assert!(said(folder.path()).contains("give a world's TOML file"), "{}", said(folder.path()));
    assert!(said(&folder.path().join("none.toml")).contains("none.toml"));
    let huge = "[campus]\nwidth = 20000\nheight = 20000\n";
    if echogrid::support::memory::available().is_some_and(|free| free < 35 << 30) {
        assert_eq!(World::parse(Path::new("huge.toml"), huge).unwrap_err().kind(), ErrorKind::Resources);
    }
}

const PATH: &str = "[path]\nposes = [[1, 1]]\n";

#[test]
fn errors_name_line_and_remedy() {
    for (text, line, what) in [
        (format!("[[outline]]\nsurfaec = 'glass'\n{PATH}"), Some(2), "did you mean \"surface\"?"),
        (format!("{ROOM}surface = 'specluar'\n{PATH}"), Some(3), "did you mean \"specular\"?"),
        (format!("{ROOM}[pth]\n"), Some(3), "did you mean \"path\"?"),
        ("[[outline]]\npoints = [[0,0],[4,0],\n[4,3],\n[0,3]]\n".into(), Some(4), "repeat the first point"),
        ("[[outline]]\npoints = [[0,0],[4,0],\n[4,0],\n[0,3],[0,0]]\n".into(), Some(3), "zero length"),
        ("[[outline]]\npoints = [[0,0],[4,3],\n[4,0],[0,3],[0,0]]\n".into(), Some(3), "crosses itself"),
        ("[[wall]]\npoints = [[0,0],\n[nan,0]]\n".into(), Some(3), "finite"),
        ("[[wall]]\npoints = [[0,0],\n[1,2,3]]\n".into(), Some(3), "[x, y]"),
        ("[[wall]]\npoints = 3\n".into(), Some(2), "list"),
        ("[wall]\npoints = []\n".into(), Some(1), "[[wall]]"),
        (format!("{ROOM}[path]\npoints = [[1,1],\n[5,1]]\nstep = 0.3\n"), Some(5), "through the wall of line 2"),
        (format!("{ROOM}[path]\nposes = [[1,1],\n[5,1]]\n"), Some(5), "solid side of the shape of line 2"),
        (format!("{ROOM}[path]\nposes = [[10,1.5]]\n"), Some(4), "solid side"),
        (format!("{ROOM}[path]\npoints = [[10,1.5],[10,3]]\nstep = 1\n"), Some(4), "solid side"),
        (
            "[[circle]]\ncentre=[0,0]\nradius=3\nfree='inside'\n[path]\nposes = [[0,0],\n[9,0]]\n".into(),
            Some(7),
            "solid side",
        ),
        (format!("{ROOM}[path]\npoints = [[1,1],\n[1,1]]\nstep = 1\n"), Some(5), "twice in a row"),
        (
            format!("{ROOM}[[circle]]\ncentre=[2,1]\nradius=0.3\nfrom=0\nto=1\nfree='inside'\n{PATH}"),
            Some(8),
            "remove free",
        ),
        ("classes = ['x']\n[campus]\nwidth = 60\nheight = 40\n".into(), Some(2), "\"wall\" isn't in classes"),
        ("[[wall]]\npoints = [[.5,0],[1,0]]\n".into(), Some(2), "written like 0.5"),
        (format!("{ROOM}[path]\nposes = [[1,1],\n[0.005,1]]\n"), Some(5), "1 cm"),
        (format!("{ROOM}[[box]]\ncentre=[1,1]\nsize=[1,1]\n{PATH}"), Some(7), "solid side"),
        (format!("{ROOM}[path]\npoints = [[1,1],[2,1]]\n"), Some(3), "add step"),
        (format!("{ROOM}[path]\npoints = [[1,1],[2,1]]\nstep = 0\n"), Some(5), "more than 0"),
        (ROOM.to_string(), None, "[path]"),
        (PATH.to_string(), None, "empty"),
        (format!("{ROOM}{PATH}[rig]\nkind = 'dnse'\n"), Some(6), "did you mean \"dense\"?"),
        (format!("{ROOM}{PATH}[rig]\nbounces = 4\n"), Some(6), "1, 2 or 3"),
        (format!("{ROOM}{PATH}[[sensor]]\nhalf_width = '70deg'\n"), Some(6), "60deg"),
        (format!("{ROOM}{PATH}[[circle]]\ncentre = [2,2]\nradius = -1\n"), Some(7), "more than 0"),
        (format!("classes = ['wall']\n{ROOM}class = 'wal'\n{PATH}"), Some(4), "did you mean \"wall\"?"),
        ("[campus]\nwidth = 3\nheight = 100\n".into(), Some(2), "campus"),
        ("[[outline]\n".into(), Some(1), "TOML"),
        // along a wall, beside one, past its end, through a circle and beside it
        (
            format!("{ROOM}[[wall]]\npoints=[[2,1],[3,1]]\n[path]\npoints = [[1,1],[3.5,1]]\nstep=1\n"),
            Some(6),
            "line 4",
        ),
        (
            format!("{ROOM}[[wall]]\npoints=[[2,1],[3,1]]\n[path]\npoints = [[1,1.005],[3.5,1.005]]\nstep=1\n"),
            Some(6),
            "touches",
        ),
        (
            format!("{ROOM}[[wall]]\npoints=[[2,1],[2,2]]\n[path]\npoints = [[1,0.995],[3.5,0.995]]\nstep=1\n"),
            Some(6),
            "touches",
        ),
        (
            format!("{ROOM}[[circle]]\ncentre=[2,1]\nradius=0.3\n[path]\npoints = [[1,1],[3,1]]\nstep=1\n"),
            Some(7),
            "runs through the wall of line 3",
        ),
        (
            format!("{ROOM}[[circle]]\ncentre=[2,1]\nradius=0.3\n[path]\npoints = [[1,0.695],[3,0.695]]\nstep=1\n"),
            Some(7),
            "touches",
        ),
        (format!("{ROOM}[[circle]]\ncentre=[2,1]\nradius=0.3\nfrom=1\nto=1\n{PATH}"), Some(7), "less than 1 mm"),
        (format!("{ROOM}[path]\nposes=[[1,1]]\nstep=0.3\n"), Some(5), "step goes with points"),
        (format!("{ROOM}[path]\npoints=[[1,1],[2,1]]\nstep=0.3\nperiod=2\n"), Some(6), "period goes with poses"),
        (format!("{ROOM}[path]\npoints=[[1,1],[2,1]]\nstep=0.3\nspeed=1e-300\n"), Some(6), "speed = 1e-300"),
        (format!("{ROOM}[path]\npoints=[[1,1],[2,1]]\nstep=1e-8\n"), Some(5), "1e7 scans"),
        (
            "[[outline]]\npoints = [[0,0],[1,0],[2,0],[0,0]]\n[path]\nposes=[[5,5]]\n".into(),
            Some(1),
            "encloses nothing",
        ),
        (format!("classes = ['a', 'a']\n{ROOM}{PATH}"), Some(1), "twice"),
        (format!("{ROOM}class = ''\n{PATH}"), Some(3), "empty"),
        // the rig reaches through a wall
        (format!("{ROOM}[path]\nposes = [[0.1,1]]\n"), Some(3), "sensor \"dense\", 0.14 m off"),
        (format!("{ROOM}{PATH}[rig]\nkind = 'ring24'\nradius = 3\n"), Some(3), "stands between"),
        (format!("{ROOM}{PATH}[rig]\nradius = -0.1\n"), Some(6), "0 or more"),
        (format!("{ROOM}{PATH}[rig]\nkind = 'ring24'\nstep = '2deg'\n"), Some(7), "sensors that turn"),
        (format!("{ROOM}{PATH}[rig]\nflutter = 2\n"), Some(6), "0 to 1"),
    ] {
        match World::parse(Path::new("bad.toml"), &text).map(|w| w.name) {
            Err(Error::Input { line: at, what: said, .. }) => {
                assert!(said.contains(what), "{text}: {said}");
                assert!(line.is_none() || at == line, "{text}: line {at:?}: {said}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
    // none of these: beside arcs of which that part is missing, and in sight of tips and tangents
    for good in [
        format!("{ROOM}[[circle]]\ncentre=[2,1]\nradius=0.5\nfrom=0\nto='90deg'\n[path]\nposes = [[1.5,1]]\n"),
        "[[outline]]\nfree='outside'\npoints = [[2,0.5],[2.5,1],[2,1.5],[1.5,1],[2,0.5]]\n[path]\nposes = [[3,1.5]]\n"
            .into(),
        "[[circle]]\ncentre=[2.4,0]\nradius=0.4\n[path]\nposes = [[1.2,0.4]]\n".into(),
    ] {
        World::parse(Path::new("good.toml"), &good).unwrap();
    }
    assert_eq!(
        Rig::named("ring16").map(|r| (r.readings(), r.transducers[4].sensor.axis.to_degrees())).unwrap(),
        (16, 90.0)
    );
    assert_eq!(Rig::named("ring0").map(|r| r.name).unwrap_err().kind(), ErrorKind::Usage);
}
