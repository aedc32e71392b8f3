//! The checks of a run that resumes an earlier one.

use crate::output::names::{PROGRESS, RUN, TOTALS};
use crate::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// Whether a partial folder holds work that `--resume` goes on with: finished chunks, or the totals of the first rounds.
pub fn begun(partial: &Path) -> bool {
    let finished = std::fs::metadata(PROGRESS.at(partial)).is_ok_and(|file| file.len() > 0);
    RUN.at(partial).exists() && (finished || TOTALS.at(partial).exists())
}

/// Checks that the run in a folder is the present one, by the descriptions of both.
///
/// # Errors
/// [`Error::Usage`] with the first difference.
pub(super) fn same_run(folder: &Path, before: &Value, now: &Value) -> Result<()> {
    // The user's choices first: the rest follows from them.
    let first = ["method", "parameters", "log_sha256"].map(String::from);
    let keys = now.as_object().into_iter().chain(before.as_object()).flat_map(|o| o.keys());
    let differs = |key: &&String| before.get(key.as_str()) != now.get(key.as_str());
    let Some(key) = first.iter().chain(keys).find(differs) else { return Ok(()) };
    let of = |v: &Value| v.get(key).map_or("nothing".into(), |v| v.to_string());
    let (mut was, mut is) = (of(before), of(now));
    let mut name = key.clone();
    if let (Some(a), Some(b)) = (before[key].as_object(), now[key].as_object())
        && let Some(inner) = a.keys().chain(b.keys()).find(|k| a.get(*k) != b.get(*k))
    {
        let of = |o: &serde_json::Map<String, Value>| o.get(inner).map_or("nothing".into(), |v| v.to_string());
        (was, is, name) = (of(a), of(b), inner.clone());
    }
    Err(Error::Usage(format!(
        "{} holds an unfinished map of another run: its {name} is {was}, now it is {is}; resume with the same, or remove it",
        folder.display()
    )))
}
