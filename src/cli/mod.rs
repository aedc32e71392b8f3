//! The command line, one file a subcommand. What commands share: the arguments of a log (`log_arguments`, `set`, `values`), warnings
//! about it (`warnings`), progress (`progress`), printed text (`stdout`, `text`, `flags`), exit codes (`exit`) and signals
//! (`interrupt`).

mod bench;
mod check;
mod compare;
mod demo;
mod doctor;
mod exit;
mod flags;
mod generate;
mod interrupt;
mod log_arguments;
mod map;
mod plan;
mod progress;
mod score;
mod set;
mod simulate;
mod stdout;
mod suggested_values;
mod summary;
mod text;
mod truth;
mod values;
mod verify;
#[cfg(feature = "view")]
mod view;
mod warnings;

pub use exit::exit_code;
pub use flags::with_flags;
pub use interrupt::register_temporary as remove_if_interrupted;

use crate::Result;
use clap::{Parser, Subcommand};

/// Prints a line on standard output; errors are kept for the end of the command.
macro_rules! print_line {
    ($($text:tt)*) => { $crate::cli::stdout::print_line(format_args!($($text)*)) };
}
use print_line;

/// Prints a line on standard error, with the program's name.
macro_rules! print_note {
    ($($text:tt)*) => {{
        use std::io::Write;
        let text = $crate::cli::with_flags(&format!($($text)*));
        $crate::cli::interrupt::suspend_bar(|| {
            let _ = writeln!(std::io::stderr(), "echogrid: {text}");
        });
    }};
}
use print_note;

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
    Map(map::MapArguments),
    /// Prove on a log that oracle, cpu and gpu agree; exit code 1 if they do not
    Verify(verify::VerifyArguments),
    /// Compare two saved maps, layer by layer; exit code 1 if they differ
    Compare(compare::CompareArguments),
    /// Look at a log, reading by reading, or at a saved map, in a browser
    #[cfg(feature = "view")]
    View(view::ViewArguments),
    /// Score maps against the truth, side by side; exit code 1 if a --require does not hold
    Score(score::ScoreArguments),
    /// Read a stored map through: checksums, and sums against its report; exit code 1 if it is damaged
    Check(check::CheckArguments),
    /// Say what mapping a log would take, without doing it
    Plan(plan::PlanArguments),
    /// Simulate a world: a log of what its sonars and lasers would report
    Simulate(simulate::SimulateArguments),
    /// Draw a world's true map: what an ideal sensor on its path would know
    Truth(truth::TruthArguments),
    /// List the GPU adapters and what each method will use; how to install a software adapter
    Doctor(doctor::DoctorArguments),
    /// Simulate a sonar in a bent corridor, map it by every method and score the maps against the truth
    Demo(demo::DemoArguments),
    /// Measure kernel throughput: cell updates and readings a second
    Bench(bench::BenchArguments),
    /// Print shell completions: `echogrid completions bash > /etc/bash_completion.d/echogrid`
    Completions(generate::CompletionsArguments),
    /// Write the man pages into a folder
    Man(generate::ManArguments),
}

impl Arguments {
    /// Parses the program's arguments; `None`: help or the version was asked for, and printed.
    ///
    /// # Errors
    /// [`Error::Resources`](crate::Error::Resources) if that can't be printed. Wrong arguments end the program with exit code 2.
    pub fn of_program() -> Result<Option<Arguments>> {
        match Arguments::try_parse() {
            Ok(arguments) => Ok(Some(arguments)),
            Err(wrong) if wrong.use_stderr() => wrong.exit(),
            Err(asked) => {
                stdout::record(asked.print());
                stdout::finish().map(|()| None)
            }
        }
    }

    /// Whether the command searches for GPU adapters.
    pub fn seeks_adapters(&self) -> bool {
        use Command::{Bench, Demo, Doctor, Map, Plan, Verify};
        cfg!(feature = "gpu") && matches!(self.command, Map(_) | Verify(_) | Plan(_) | Doctor(_) | Demo(_) | Bench(_))
    }

    /// Runs the command; its exit code. Meanwhile SIGINT and SIGTERM end the process.
    ///
    /// # Errors
    /// The command's; [`Error::Resources`](crate::Error::Resources) if what it printed can't be written.
    pub fn run(self) -> Result<u8> {
        if !self.command.ends_by_signal() {
            interrupt::listen();
        }
        let code = self.command.run()?;
        stdout::finish().map(|()| code)
    }
}

impl Command {
    /// Whether Ctrl-C is the usual way to end it: then it handles the signal itself.
    fn ends_by_signal(&self) -> bool {
        #[cfg(feature = "view")]
        return matches!(self, Command::View(_));
        #[cfg(not(feature = "view"))]
        return false;
    }

    fn run(self) -> Result<u8> {
        match self {
            Command::Map(c) => c.run(),
            Command::Verify(c) => c.run(),
            Command::Compare(c) => c.run(),
            #[cfg(feature = "view")]
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
