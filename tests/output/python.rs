//! `map.zarr` as Python sees it, through zarr-python 3 and xarray. `scripts/test` makes the environment; without one the
//! test says so on standard error, and `ECHOGRID_REQUIRE_PYTHON=1` makes that an error.

use crate::common::{map, write};
use std::io::Write;
use std::path::PathBuf;
use std::process::Command;

/// The interpreter of `ECHOGRID_PYTHON`, or of the environment that `scripts/test` makes; it must have the packages.
fn python() -> Result<PathBuf, String> {
    let named = std::env::var_os("ECHOGRID_PYTHON").map(PathBuf::from);
    let python = named.unwrap_or_else(|| PathBuf::from("python3"));
    let found = Command::new(&python).args(["-c", "import zarr, xarray, numpy"]).output();
    match found {
        Ok(run) if run.status.success() => Ok(python),
        Ok(run) => Err(format!("{}: {}", python.display(), String::from_utf8_lossy(&run.stderr).trim_end())),
        Err(e) => Err(format!("{}: {e}", python.display())),
    }
}

#[test]
fn xarray_selects_cells_by_metres() {
    let python = match python() {
        Ok(python) => python,
        Err(why) if std::env::var_os("ECHOGRID_REQUIRE_PYTHON").is_some_and(|v| v == "1") => {
            panic!("no Python with zarr, xarray and numpy (run scripts/test, or set ECHOGRID_PYTHON): {why}")
        }
        Err(why) => {
            // Not eprintln, which a passing test keeps to itself.
            let skipped = "SKIPPED xarray_selects_cells_by_metres: no Python with zarr and xarray";
            writeln!(std::io::stderr(), "{skipped}: {why}").unwrap();
            return;
        }
    };
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m");
    write(&path, &map(1500, 1100), true);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/read_map.py");
    let run = Command::new(python).arg(script).arg(&path).output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{out}\n{err}");
    assert_eq!(out.trim_end(), "read_map.py: all right");
}
