//! `echogrid completions` and `echogrid man`.

use super::{Arguments, print_line};
use crate::{Error, Result};
use clap::{CommandFactory, ValueHint};
use std::path::PathBuf;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArguments {
    /// The shell
    shell: clap_complete::Shell,
}

impl CompletionsArguments {
    /// Prints the completions.
    pub fn run(self) -> Result<u8> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::command(), "echogrid", &mut text);
        print_line!("{}", String::from_utf8_lossy(&text).trim_end());
        Ok(0)
    }
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub struct ManArguments {
    /// The folder, such as /usr/local/share/man/man1
    #[arg(value_hint = ValueHint::DirPath)]
    folder: PathBuf,
}

impl ManArguments {
    /// Writes echogrid.1 and a page a subcommand, and prints the path of the first.
    pub fn run(self) -> Result<u8> {
        let unwritable = |e: std::io::Error| {
            Error::Resources(format!("{} can't be written: {e}; give another folder", self.folder.display()))
        };
        std::fs::create_dir_all(&self.folder).map_err(unwritable)?;
        clap_mangen::generate_to(Arguments::command(), &self.folder).map_err(unwritable)?;
        print_line!("{}", self.folder.join("echogrid.1").display());
        Ok(0)
    }
}
