//! The `echogrid` command: parse, run, print an error once, exit with its code.

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

#[global_allocator]
static GLOBAL: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let arguments = echogrid::cli::Arguments::parse();
    match arguments.run() {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            // A reader that went away is no second error.
            let _ = writeln!(std::io::stderr(), "echogrid: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
