//! The command line, one file a subcommand. Exit codes: 0 done · 1 differs · 2 bad usage · 3 bad input · 4 no adapter ·
//! 5 out of memory or space, or output not writable · 6 done, but some lines were bad · 130, 143 ended by Ctrl-C or SIGTERM.

mod bench;
mod check;
mod common;
mod compare;
mod demo;
mod doctor;
mod generate;
mod interrupt;
mod map;
mod offered;
mod out;
mod parameters;
mod plan;
mod score;
mod simulate;
mod summary;
mod truth;
mod verify;
mod view;

pub use interrupt::removes as remove_if_interrupted;

use crate::Result;
use clap::{Parser, Subcommand};

/// Prints a line on standard output.
macro_rules! say {
    ($($text:tt)*) => { $crate::cli::out::line(format_args!($($text)*)) };
}
use say;

/// Prints a line for people on standard error, with the program's name.
macro_rules! note {
    ($($text:tt)*) => {{
        use std::io::Write;
        let text = format!($($text)*);
        $crate::cli::interrupt::aside(|| {
            let _ = writeln!(std::io::stderr(), "echogrid: {text}");
        });
    }};
}
use note;

const AFTER: &str = "Exit codes: 0 done · 1 differs · 2 bad usage or parameter · 3 bad input · 4 no adapter · \
5 out of memory or space, or output not writable · 6 done, but some lines of the log were bad (--strict: 3, nothing written) · \
130 ended by Ctrl-C, 143 by SIGTERM: an unfinished map stays for --resume

Start with `echogrid demo`, then `echogrid map LOG -o DIR`.";

/// Sonar and laser logs to occupancy grids, on any GPU and on the CPU with the same result.
#[derive(Debug, Parser)]
#[command(name = "echogrid", version, after_help = AFTER, max_term_width = 100)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Map a log: a folder with the layers, pictures, a ROS map and a report
    Map(map::Map),
    /// Prove on a log that oracle, cpu and gpu agree; exit code 1 if they do not
    Verify(verify::Verify),
    /// Compare two saved maps, layer by layer; exit code 1 if they differ
    Compare(compare::Compare),
    /// Look at a log, reading by reading, or at a saved map, in a browser
    View(view::Command),
    /// Score maps against the truth, side by side; exit code 1 if a --require does not hold
    Score(score::Command),
    /// Read a stored map through: checksums, and sums against its report; exit code 1 if it is damaged
    Check(check::Command),
    /// Say what mapping a log would take, without doing it
    Plan(plan::Plan),
    /// Simulate a world: a log of what its sonars and lasers would report
    Simulate(simulate::Simulate),
    /// Draw a world's true map: what an ideal sensor on its path would know
    Truth(truth::Command),
    /// List the GPU adapters and what each method will use; how to install a software adapter
    Doctor(doctor::Doctor),
    /// Simulate a sonar in a bent corridor, map it by every method and score the maps against the truth
    Demo(demo::Demo),
    /// Measure kernel throughput: cell updates and readings a second
    Bench(bench::Bench),
    /// Print shell completions: `echogrid completions bash > /etc/bash_completion.d/echogrid`
    Completions(generate::Completions),
    /// Write the man pages into a folder
    Man(generate::Man),
}

impl Arguments {
    /// The program's own arguments; `None`: help or the version was asked for, and printed.
    ///
    /// # Errors
    /// [`Error::Resources`](crate::Error::Resources) if that can't be printed. Wrong arguments end the program with exit code 2.
    pub fn of_program() -> Result<Option<Arguments>> {
        match Arguments::try_parse() {
            Ok(arguments) => Ok(Some(arguments)),
            Err(wrong) if wrong.use_stderr() => wrong.exit(),
            Err(asked) => {
                out::keep(asked.print());
                out::finish().map(|()| None)
            }
        }
    }

    /// Whether the command looks for GPU adapters.
    pub fn seeks_adapters(&self) -> bool {
        use Command::{Bench, Demo, Doctor, Map, Plan, Verify};
        matches!(self.command, Map(_) | Verify(_) | Plan(_) | Doctor(_) | Demo(_) | Bench(_))
    }

    /// Runs the command; the exit code where it did what it could. From its start on SIGINT and SIGTERM end the process.
    ///
    /// # Errors
    /// The command's; [`Error::Resources`](crate::Error::Resources) if what it printed can't be written.
    pub fn run(self) -> Result<u8> {
        // To `view` Ctrl-C is the way to end it.
        if !matches!(self.command, Command::View(_)) {
            interrupt::listen();
        }
        let code = self.command.run()?;
        out::finish().map(|()| code)
    }
}

impl Command {
    fn run(self) -> Result<u8> {
        match self {
            Command::Map(c) => c.run(),
            Command::Verify(c) => c.run(),
            Command::Compare(c) => c.run(),
            Command::View(c) => c.run(),
            Command::Score(c) => c.run(),
            Command::Check(c) => c.run(),
            Command::Plan(c) => c.run(),
            Command::Simulate(c) => c.run(),
            Command::Truth(c) => c.run(),
            Command::Doctor(c) => c.run(),
            Command::Demo(c) => c.run(),
            Command::Bench(c) => c.run(),
            Command::Completions(c) => c.run(),
            Command::Man(c) => c.run(),
        }
    }
}
