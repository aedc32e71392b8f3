//! The logs of real robots, where they are at hand: `$ECHOGRID_DATA`, or `../shared/data` beside the repository.

use std::io::Write;
use std::path::{Path, PathBuf};

/// The path of a real log; `None` where it is absent, said aloud in the line that `scripts/skipped` counts by its test.
pub fn data(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("ECHOGRID_DATA").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"));
    let path = folder.join(name);
    if path.exists() {
        return std::path::absolute(path).ok();
    }
    let thread = std::thread::current();
    let test = format!("{}::{}", env!("CARGO_CRATE_NAME"), thread.name().unwrap_or("?"));
    let line = format!("SKIPPED {test}: no {} (set ECHOGRID_DATA to the folder of real logs)\n", path.display());
    // Straight to the stream: the harness would swallow a print of a test that passes.
    let _ = std::io::stderr().write_all(line.as_bytes());
    None
}
