//! `echogrid check`.

use super::common::{count, spinner};
use super::{note, say};
use crate::Result;
use crate::output::check;
use crate::support::memory::show;
use clap::ValueHint;
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct Command {
    /// The map's folder
    #[arg(value_hint = ValueHint::DirPath)]
    map: PathBuf,
    /// Print what was found as JSON
    #[arg(long)]
    json: bool,
}

impl Command {
    /// Reads a stored map through; 1 if it is damaged.
    pub fn run(self) -> Result<u8> {
        let sign = spinner("checking", self.json);
        let found = check(&self.map, &|| {})?;
        drop(sign);
        let whole = found.problems.is_empty();
        if self.json {
            let all = json!({
                "layers": found.layers, "shards": found.shards, "bytes": found.bytes, "whole": whole, "problems": found.problems,
            });
            say!("{}", serde_json::to_string_pretty(&all).unwrap_or_default());
        } else {
            say!(
                "{}, {}, {}: {}",
                count(found.layers as u64, "layer"),
                count(found.shards, "stored piece"),
                show(found.bytes),
                if whole { "whole" } else { "damaged" }
            );
        }
        for problem in &found.problems {
            note!("{}: {problem}", self.map.display());
        }
        Ok(u8::from(!whole))
    }
}
