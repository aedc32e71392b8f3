//! `echogrid score`.

use super::exit::DIFFERS;
use super::{print_line, print_note};
use crate::evaluate::score::{
    Check, Options, Requirement, Score, Truth, open_map_with_notes, score, table, write_report,
};
use crate::{Error, Result};
use clap::ValueHint;
use serde_json::json;
use std::path::{Path, PathBuf};

/// The widest tolerance, cells.
const MAX_TOLERANCE: u64 = 50;

/// Arguments of `score`.
#[derive(Debug, clap::Args)]
pub struct ScoreArguments {
    /// Maps: folders that `echogrid map` wrote, or ROS maps by their .yaml file
    #[arg(required = true, value_name = "MAP", value_hint = ValueHint::AnyPath)]
    maps: Vec<PathBuf>,
    /// What is true: a world (a built-in one, such as room, or its .toml), or a map, such as the laser map of the same run (--method truth)
    #[arg(short, long, value_name = "WORLD|MAP", value_hint = ValueHint::AnyPath)]
    truth: PathBuf,
    /// Demand something of every map, such as "danger<=0.02", as often as needed; exit code 1 if it does not hold
    #[arg(long, value_name = "EXPR")]
    require: Vec<Requirement>,
    /// Cells by which an occupied cell may lie beside a true one; 1: the eight neighbours
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=MAX_TOLERANCE))]
    tolerance: u64,
    /// Decide cells by their probability, occupied above the first, empty below the second, not by the method's rule
    #[arg(long, value_name = "HIGH,LOW", value_delimiter = ',', num_args = 1)]
    decide: Option<Vec<f64>>,
    /// Write error plots, histograms of error levels and an HTML report into this folder
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    output: Option<PathBuf>,
    /// How far is seen in a world, metres [default: the farthest range of its sonars, or lasers]
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    r_max: Option<f64>,
    /// Print the scores as JSON
    #[arg(long)]
    json: bool,
}

impl ScoreArguments {
    /// Scores the maps; exit code 1 if a requirement does not hold.
    pub fn run(self) -> Result<u8> {
        let options = Options { tolerance: self.tolerance as usize, decide: self.decide()? };
        self.output.as_deref().map_or(Ok(()), check_folder)?;
        let truth = Truth::open_with_notes(&self.truth, self.r_max, &mut |what| print_note!("{what}"))?;
        let mut scores: Vec<Score> = Vec::new();
        for path in &self.maps {
            let name = path.display().to_string();
            let map = open_map_with_notes(path, &mut |what| print_note!("{what}"))?;
            scores.push(score(&name, &map, &truth, &options).map_err(|e| name_map(&name, e))?);
        }
        let mut checks: Vec<Check> = Vec::new();
        for requirement in &self.require {
            for score in &scores {
                checks.push(requirement.check(score)?);
            }
        }
        let name = self.truth.display().to_string();
        if self.json {
            let all = json!({
                "truth": {"path": name, "kind": truth.kind(), "r_max": truth.r_max()},
                "tolerance": options.tolerance,
                "decide": options.decide,
                "maps": scores,
                "require": checks,
            });
            print_line!("{}", serde_json::to_string_pretty(&all).unwrap_or_default());
        } else {
            print_line!("truth: {}\n{}", truth.describe(&name), table(&scores));
        }
        if let Some(folder) = &self.output {
            print_note!("see {}", write_report(folder, &truth.describe(&name), &scores, &checks)?.display());
        }
        for Check { require, path, value, .. } in checks.iter().filter(|c| !c.held) {
            let value = value.map_or("there is nothing to measure".into(), |v| format!("it is {v:.6}"));
            print_note!("{path}: {require} does not hold: {value}");
        }
        Ok(if checks.iter().all(|c| c.held) { 0 } else { DIFFERS })
    }

    fn decide(&self) -> Result<Option<(f64, f64)>> {
        match self.decide.as_deref() {
            None => Ok(None),
            Some(&[high, low]) if 0.0 <= low && low <= high && high <= 1.0 => Ok(Some((high, low))),
            Some(_) => Err(Error::Usage("--decide takes HIGH,LOW, such as 0.6,0.4: 0 <= LOW <= HIGH <= 1".into())),
        }
    }
}

/// Refuses a folder with files of a report's names that no report wrote: they would be overwritten.
fn check_folder(folder: &Path) -> Result<()> {
    let page = std::fs::read_to_string(folder.join("score.html"));
    if page.is_ok_and(|page| page.contains("<title>echogrid score</title>")) {
        return Ok(());
    }
    let ours = |name: &str| name == "score.html" || name.ends_with(".errors.png") || name.ends_with(".levels.svg");
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten();
    match names.filter_map(|entry| entry.file_name().into_string().ok()).find(|name| ours(name)) {
        None => Ok(()),
        Some(name) => Err(Error::Resources(format!(
            "{} holds {name}, which isn't an earlier score's: give another folder with -o",
            folder.display()
        ))),
    }
}

/// Adds the map to an error about its cells.
fn name_map(map: &str, error: Error) -> Error {
    match error {
        Error::Usage(what) => Error::Usage(format!("{map}: {what}")),
        other => other,
    }
}
