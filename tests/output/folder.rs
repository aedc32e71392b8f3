//! The folder's promise: the old map or the new one, never half; and nothing of anyone else's is touched.

use crate::common::{info, map, write};
use echogrid::ErrorKind;
use echogrid::output::{Folder, read_map, write_map};
use std::fs;
use std::path::Path;
use std::process::Command;

fn names(dir: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn refused(path: &Path, why: &str) {
    let error = Folder::prepare(path).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Resources);
    assert!(error.to_string().contains(why), "{error}");
}

#[test]
fn a_map_replaces_a_map_and_leaves_nothing_beside() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("deep/down/m");
    write(&path, &map(11, 8), true);
    write(&path, &map(12, 9), false);
    assert_eq!(read_map(&path).unwrap().map.grid.width, 12);
    assert!(!path.join("class.npy").exists(), "the old map's files are gone");
    assert_eq!(names(path.parent().unwrap()), ["m"]);
    assert_eq!(names(&path).first().unwrap(), "class.png", "no marker is left");
}

#[test]
fn an_empty_folder_is_taken() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m");
    fs::create_dir(&path).unwrap();
    write(&path, &map(11, 8), false);
    read_map(&path).unwrap();
}

#[test]
fn an_error_on_the_way_leaves_the_old_map_and_no_partial() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m");
    write(&path, &map(11, 8), false);
    let folder = Folder::prepare(&path).unwrap();
    assert_eq!(names(dir.path()), ["m", "m.partial"]);
    drop(folder);
    assert_eq!(names(dir.path()), ["m"]);
    assert_eq!(read_map(&path).unwrap().map.grid.width, 11);
}

/// Not a test of its own: the process that the next test lets die halfway.
#[test]
fn dies_halfway() {
    let Some(path) = std::env::var_os("ECHOGRID_TEST_DIES_IN") else { return };
    let folder = Folder::prepare(Path::new(&path)).unwrap();
    write_map(&folder, &map(12, 9), &map(12, 9).layers[0], &info(), false).unwrap();
    std::process::abort();
}

#[test]
fn a_killed_run_leaves_the_old_map_and_the_next_run_cleans_up() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m");
    write(&path, &map(11, 8), false);
    let test = std::env::current_exe().unwrap();
    let run = Command::new(test).args(["--exact", "folder::dies_halfway"]).env("ECHOGRID_TEST_DIES_IN", &path).output();
    assert!(!run.unwrap().status.success());
    assert_eq!(names(dir.path()), ["m", "m.partial"]);
    assert_eq!(read_map(&path).unwrap().map.grid.width, 11);
    write(&path, &map(13, 9), false);
    assert_eq!(read_map(&path).unwrap().map.grid.width, 13);
    assert_eq!(names(dir.path()), ["m"]);
}

#[test]
fn a_run_killed_between_the_renames_is_mended() {
    let dir = tempfile::tempdir().unwrap();
    let (path, old) = (dir.path().join("m"), dir.path().join("m.old-77"));
    write(&path, &map(11, 8), false);
    fs::write(path.join(".echogrid-partial"), "").unwrap();
    fs::rename(&path, &old).unwrap();
    let error = read_map(&path).unwrap_err().to_string();
    assert!(error.contains("m.old-77"), "{error}");
    drop(Folder::prepare(&path).unwrap());
    assert_eq!(read_map(&path).unwrap().map.grid.width, 11);
    assert_eq!(names(dir.path()), ["m"]);
}

#[test]
fn an_old_map_of_a_run_killed_after_the_renames_goes() {
    let dir = tempfile::tempdir().unwrap();
    let (path, old) = (dir.path().join("m"), dir.path().join("m.old-77"));
    write(&path, &map(11, 8), false);
    fs::create_dir(&old).unwrap();
    fs::write(old.join(".echogrid-partial"), "").unwrap();
    // The user's own copy has no marker.
    fs::create_dir(dir.path().join("m.old-2024")).unwrap();
    drop(Folder::prepare(&path).unwrap());
    assert_eq!(names(dir.path()), ["m", "m.old-2024"]);
}

#[test]
fn two_runs_at_once_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Folder::prepare(&dir.path().join("m")).unwrap();
    refused(&dir.path().join("m"), "another run");
    drop(folder);
}

#[test]
fn what_is_not_ours_stays() {
    let dir = tempfile::tempdir().unwrap();
    let foreign = dir.path().join("photos");
    fs::create_dir(&foreign).unwrap();
    fs::write(foreign.join("report.json"), "{\"method\": 1}").unwrap();
    refused(&foreign, "no echogrid map");
    let file = dir.path().join("file");
    fs::write(&file, "text").unwrap();
    refused(&file, "it is a file");
    refused(&file.join("m"), "can't be the output");
    fs::create_dir(dir.path().join("new.partial")).unwrap();
    fs::write(dir.path().join("new.partial/notes.txt"), "mine").unwrap();
    refused(&dir.path().join("new"), "in the way");
    assert_eq!(fs::read_to_string(&file).unwrap(), "text");
    assert!(dir.path().join("new.partial/notes.txt").exists());
    #[cfg(target_os = "linux")]
    refused(Path::new("/proc/echogrid/m"), "can't be the output");
    refused(Path::new("/"), "can't be the output");
}

#[test]
fn files_that_appear_during_the_run_are_not_overwritten() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m");
    let folder = Folder::prepare(&path).unwrap();
    write_map(&folder, &map(11, 8), &map(11, 8).layers[0], &info(), false).unwrap();
    fs::create_dir(&path).unwrap();
    fs::write(path.join("notes.txt"), "mine").unwrap();
    let error = folder.finish().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Resources);
    assert_eq!(names(&path), ["notes.txt"]);
    // What was computed isn't lost, and no later run removes it.
    assert!(
        error.to_string().contains("the new map is whole and lies in ") && error.to_string().contains("m.new-1"),
        "{error}"
    );
    assert_eq!(names(dir.path()), ["m", "m.new-1"]);
    assert_eq!(read_map(&dir.path().join("m.new-1")).unwrap().map.grid.width, 11);
    refused(&path, "no echogrid map");
    assert!(!names(&dir.path().join("m.new-1")).contains(&".echogrid-partial".into()));
}

#[test]
fn files_that_come_into_a_map_during_the_run_keep_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m");
    write(&path, &map(11, 8), false);
    let folder = Folder::prepare(&path).unwrap();
    write_map(&folder, &map(12, 9), &map(12, 9).layers[0], &info(), false).unwrap();
    fs::write(path.join("map.zarr/class/notes.txt"), "mine").unwrap();
    let error = folder.finish().unwrap_err().to_string();
    assert!(error.contains("it holds map.zarr/class/notes.txt; move what is yours"), "{error}");
    assert_eq!(names(dir.path()), ["m", "m.new-1"]);
    assert_eq!(read_map(&path).unwrap().map.grid.width, 11);
    assert_eq!(fs::read_to_string(path.join("map.zarr/class/notes.txt")).unwrap(), "mine");
    assert_eq!(read_map(&dir.path().join("m.new-1")).unwrap().map.grid.width, 12);
    assert_eq!(Folder::check(&path).unwrap_err().kind(), ErrorKind::Resources);
    fs::remove_file(path.join("map.zarr/class/notes.txt")).unwrap();
    Folder::check(&path).unwrap();
}

#[test]
fn what_is_the_user_s_beside_the_folder_stays() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m");
    write(&path, &map(11, 8), false);
    // In a folder that a killed run left.
    let partial = dir.path().join("m.partial");
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join(".echogrid-partial"), "").unwrap();
    fs::write(partial.join("notes.txt"), "mine").unwrap();
    refused(&path, "it holds notes.txt, which is no file of a map");
    assert_eq!(names(&partial), [".echogrid-partial", "notes.txt"]);
    fs::remove_dir_all(&partial).unwrap();
    // In an old map that stepped aside.
    let old = dir.path().join("m.old-77");
    write(&old, &map(11, 8), false);
    fs::write(old.join(".echogrid-partial"), "").unwrap();
    fs::create_dir(old.join("photos")).unwrap();
    refused(&path, "m.old-77, which holds photos/, not the map's");
    assert!(old.join("photos").is_dir() && read_map(&old).is_ok());
    fs::remove_dir(old.join("photos")).unwrap();
    drop(Folder::prepare(&path).unwrap());
    assert_eq!(names(dir.path()), ["m"]);
    // What comes into the folder under way when the run fails.
    let folder = Folder::prepare(&path).unwrap();
    write_map(&folder, &map(12, 9), &map(12, 9).layers[0], &info(), true).unwrap();
    fs::write(folder.path().join("map.zarr/notes.txt"), "mine").unwrap();
    drop(folder);
    assert_eq!(
        (names(&partial), names(&partial.join("map.zarr"))),
        (vec!["map.zarr".into()], vec!["notes.txt".into()])
    );
    refused(&path, "in the way");
}

#[cfg(unix)]
#[test]
fn a_link_is_followed() {
    let dir = tempfile::tempdir().unwrap();
    let (real, link) = (dir.path().join("real"), dir.path().join("link"));
    write(&real, &map(11, 8), false);
    std::os::unix::fs::symlink(&real, &link).unwrap();
    write(&link, &map(12, 9), false);
    assert_eq!(read_map(&real).unwrap().map.grid.width, 12);
    assert!(link.is_symlink());
}

#[test]
fn what_is_no_map_can_not_be_read() {
    let dir = tempfile::tempdir().unwrap();
    let error = read_map(dir.path()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Input);
    let path = dir.path().join("m");
    write(&path, &map(11, 8), false);
    fs::remove_dir_all(path.join("map.zarr/class")).unwrap();
    let error = read_map(&path).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Input);
    write(&path, &map(11, 8), false);
    let chunk = path.join("map.zarr/class/c/0/0");
    let mut bytes = fs::read(&chunk).unwrap();
    bytes[10] ^= 0x40;
    fs::write(&chunk, bytes).unwrap();
    assert_eq!(read_map(&path).unwrap_err().kind(), ErrorKind::Input, "the checksum finds a flipped bit");
}
