//! `echogrid check`.

use super::exit::DIFFERS;
use super::progress::spinner;
use super::text::count;
use super::{print_line, print_note};
use crate::Result;
use crate::output::check;
use crate::support::memory::format_size;
use clap::ValueHint;
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct CheckArguments {
    /// The map's folder
    #[arg(value_hint = ValueHint::DirPath)]
    map: PathBuf,
    /// Print what was found as JSON
    #[arg(long)]
    json: bool,
}

impl CheckArguments {
    /// Reads a stored map through; exit code 1 if it is damaged.
    pub fn run(self) -> Result<u8> {
        let progress = spinner("checking", self.json);
        let found = check(&self.map, &|| {})?;
        drop(progress);
        let whole = found.problems.is_empty();
        if self.json {
            let all = json!({
                "layers": found.layers, "shards": found.shards, "bytes": found.bytes, "whole": whole, "problems": found.problems,
            });
            print_line!("{}", serde_json::to_string_pretty(&all).unwrap_or_default());
        } else {
            print_line!(
                "{}, {}, {}: {}",
                count(found.layers as u64, "layer"),
                count(found.shards, "stored piece"),
                format_size(found.bytes),
                if whole { "whole" } else { "damaged" }
            );
        }
        for problem in &found.problems {
            print_note!("{}: {problem}", self.map.display());
        }
        Ok(if whole { 0 } else { DIFFERS })
    }
}
