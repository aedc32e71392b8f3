//! `echogrid completions` and `echogrid man`.

use super::{Arguments, say};
use crate::{Error, Result};
use clap::{CommandFactory, ValueHint};
use std::path::PathBuf;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// The shell
    shell: clap_complete::Shell,
}

impl Completions {
    /// Prints the completions.
    pub fn run(self) -> Result<u8> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::command(), "echogrid", &mut text);
        say!("{}", String::from_utf8_lossy(&text).trim_end());
        Ok(0)
    }
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub struct Man {
    /// The folder, such as /usr/local/share/man/man1
    #[arg(value_hint = ValueHint::DirPath)]
    folder: PathBuf,
}

impl Man {
    /// Writes echogrid.1 and a page a subcommand, and says where to start.
    pub fn run(self) -> Result<u8> {
        let unwritable = |e: std::io::Error| {
            Error::Resources(format!("{} can't be written: {e}; give another folder", self.folder.display()))
        };
        std::fs::create_dir_all(&self.folder).map_err(unwritable)?;
        clap_mangen::generate_to(Arguments::command(), &self.folder).map_err(unwritable)?;
        say!("{}", self.folder.join("echogrid.1").display());
        Ok(0)
    }
}
