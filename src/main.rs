//! The `echogrid` command: parse, run, print an error once, exit with its code.

use echogrid::cli::Arguments;
use std::io::Write;
use std::process::ExitCode;

#[global_allocator]
static GLOBAL: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    match Arguments::of_program().and_then(|asked| asked.map_or(Ok(0), Arguments::run)) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            // A reader that went away is no second error.
            let _ = writeln!(std::io::stderr(), "echogrid: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
