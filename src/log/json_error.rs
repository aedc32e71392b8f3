//! Messages about bad JSON, from serde's.

use crate::support::suggest::similar;

/// The message of a JSON error: an unknown key is named with the most similar known one, and the place is a column of the line.
pub(super) fn explain(error: &serde_json::Error, known: &[&str]) -> String {
    let text = error.to_string();
    let text = text.split(" at line ").next().unwrap_or_default();
    let text = match text.strip_prefix("unknown field `").and_then(|rest| rest.split_once('`')) {
        Some((name, _)) => format!("unknown key {name:?}{}", similar(name, known)),
        None => text.to_string(),
    };
    if error.column() > 0 { format!("{text} (column {})", error.column()) } else { text }
}
