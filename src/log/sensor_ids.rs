//! The ids of sensors that a table only names.

/// The largest number of sensors of a log; a damaged log might name more.
pub(super) const MAX_SENSORS: usize = 4096;

/// The ids of all sensors. Where every id is a plain number, the ids are indices: sensor 7 alone means that there are eight.
pub(super) fn expand_indices(ids: Vec<String>) -> Vec<String> {
    let indices: Option<Vec<usize>> = ids.iter().map(|id| id.parse().ok().filter(|i| *i < MAX_SENSORS)).collect();
    match indices {
        Some(indices) => (0..=indices.into_iter().max().unwrap_or(0)).map(|i| i.to_string()).collect(),
        None => ids,
    }
}
