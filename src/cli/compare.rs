//! `echogrid compare`.

use super::exit::DIFFERS;
use super::{print_line, print_note};
use crate::evaluate::compare::{Options, compare, write_pictures};
use crate::output::read_map;
use crate::{Error, Result};
use clap::ValueHint;
use std::path::PathBuf;

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArguments {
    /// A map's folder
    #[arg(value_hint = ValueHint::DirPath)]
    a: PathBuf,
    /// Another's
    #[arg(value_hint = ValueHint::DirPath)]
    b: PathBuf,
    /// Let values differ by so much
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    tol: f64,
    /// Compare only the cells that both maps have
    #[arg(long)]
    common: bool,
    /// If they differ, write the pictures of both and of the difference here
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pictures: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl CompareArguments {
    /// Compares the maps; exit code 1 if they differ.
    pub fn run(self) -> Result<u8> {
        if !(self.tol >= 0.0 && self.tol.is_finite()) {
            return Err(Error::Usage(format!("--tol {} is no tolerance: give 0 or more", self.tol)));
        }
        let (a, b) = (read_map(&self.a)?, read_map(&self.b)?);
        let comparison = compare(&a.map, &b.map, &Options { tolerance: self.tol, common: self.common })?;
        if self.json {
            print_line!("{}", serde_json::to_string_pretty(&comparison).unwrap_or_default());
        } else {
            print_line!("{comparison}");
        }
        if let (false, Some(folder)) = (comparison.equal, &self.pictures) {
            for path in write_pictures(&a.map, &b.map, &comparison, folder)? {
                print_note!("see {}", path.display());
            }
        }
        Ok(if comparison.equal { 0 } else { DIFFERS })
    }
}
