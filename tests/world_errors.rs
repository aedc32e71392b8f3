//! Bad worlds: each error names the line and what to do.

use echogrid::Error;
use echogrid::world::{Rig, World};
use std::path::Path;

const ROOM: &str = "[[outline]]\npoints = [[0,0],[4,0],[4,3],[0,3],[0,0]]\n";
const PATH: &str = "[path]\nposes = [[1, 1]]\n";

#[test]
fn errors_name_line_and_remedy() {
    for (text, line, what) in [
        (format!("[[outline]]\nsurfaec = 'glass'\n{PATH}"), Some(2), "did you mean \"surface\"?"),
        (format!("{ROOM}surface = 'specluar'\n{PATH}"), Some(3), "did you mean \"specular\"?"),
        (format!("{ROOM}[pth]\n"), Some(3), "did you mean \"path\"?"),
        ("[[outline]]\npoints = [[0,0],[4,0],\n[4,3],\n[0,3]]\n".into(), Some(4), "repeat the first point"),
        ("[[outline]]\npoints = [[0,0],[4,0],\n[4,0],\n[0,3],[0,0]]\n".into(), Some(3), "zero length"),
        ("[[outline]]\npoints = [[0,0],[4,3],\n[4,0],[0,3],[0,0]]\n".into(), None, "crosses itself"),
        ("[[wall]]\npoints = [[0,0],\n[nan,0]]\n".into(), Some(3), "finite"),
        ("[[wall]]\npoints = [[0,0],\n[1,2,3]]\n".into(), Some(3), "[x, y]"),
        ("[[wall]]\npoints = 3\n".into(), Some(2), "list"),
        ("[wall]\npoints = []\n".into(), Some(1), "[[wall]]"),
        (format!("{ROOM}[path]\npoints = [[1,1],\n[5,1]]\nstep = 0.3\n"), Some(5), "through the wall of line 2"),
        (format!("{ROOM}[path]\nposes = [[1,1],\n[5,1]]\n"), Some(5), "solid side"),
        (format!("{ROOM}[path]\nposes = [[1,1],\n[0.005,1]]\n"), Some(5), "1 cm"),
        (format!("{ROOM}[[box]]\ncentre=[1,1]\nsize=[1,1]\n{PATH}"), None, "solid side"),
        (format!("{ROOM}[path]\npoints = [[1,1],[2,1]]\n"), None, "add step"),
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
    ] {
        match World::parse(Path::new("bad.toml"), &text).map(|w| w.name) {
            Err(Error::Input { line: at, what: said, .. }) => {
                assert!(said.contains(what), "{text}: {said}");
                assert!(line.is_none() || at == line, "{text}: line {at:?}: {said}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
    assert_eq!(Rig::named("ring9").map(|r| r.name).unwrap_err().exit_code(), 2);
}
