//! The `echogrid` command: parse, run, print an error once, exit with its code.

use echogrid::cli::{self, Arguments};
use std::io::Write;
use std::process::ExitCode;
use tempfile::TempDir;

#[global_allocator]
static GLOBAL: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let run = |arguments: Arguments| {
        // Removed when the command has ended.
        let _runtime = if arguments.seeks_adapters() { runtime_folder() } else { None };
        arguments.run()
    };
    match Arguments::of_program().and_then(|asked| asked.map_or(Ok(0), run)) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            // A closed pipe is no second error.
            let _ = writeln!(std::io::stderr(), "echogrid: {}", cli::with_flags(&error.to_string()));
            ExitCode::from(cli::exit_code(&error))
        }
    }
}

/// Sets `XDG_RUNTIME_DIR` to an empty folder with the user's permissions only, where the session has none: without it Mesa prints a
/// warning on standard error at each search for adapters.
#[cfg(all(unix, not(target_os = "macos")))]
fn runtime_folder() -> Option<TempDir> {
    use std::os::unix::fs::PermissionsExt;
    const NAME: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(NAME).is_some_and(|folder| std::path::Path::new(&folder).is_absolute()) {
        return None;
    }
    let private = std::fs::Permissions::from_mode(0o700);
    let folder = tempfile::Builder::new().prefix("echogrid-").permissions(private).tempdir().ok()?;
    cli::remove_if_interrupted(folder.path());
    // SAFETY: `main` calls this before it starts a thread, so that nobody reads the environment meanwhile.
    unsafe { std::env::set_var(NAME, folder.path()) };
    Some(folder)
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn runtime_folder() -> Option<TempDir> {
    None
}
