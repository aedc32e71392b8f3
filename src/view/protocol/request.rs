//! The JSON bodies that the page sends.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
#[cfg(test)]
use ts_rs::TS;

/// `api/go`: either `by` and `count`, or `to`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(TS))]
pub struct GoRequest {
    /// What is counted.
    #[cfg_attr(test, ts(optional))]
    pub by: Option<StepUnit>,
    /// How many, 1 if left out; negative: back.
    #[serde(default = "one")]
    #[cfg_attr(test, ts(optional, as = "Option<i64>"))]
    pub count: i64,
    /// A position, in items of the first lane.
    #[cfg_attr(test, ts(optional))]
    pub to: Option<usize>,
    /// Milliseconds after which the server stops; none: it goes all the way.
    #[cfg_attr(test, ts(optional))]
    pub budget_ms: Option<u64>,
    /// The version that the page shows: where the server's is another, all tiles count as changed.
    #[cfg_attr(test, ts(optional))]
    pub since: Option<u64>,
}

fn one() -> i64 {
    1
}

/// What a step is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(test, derive(TS))]
pub enum StepUnit {
    /// A reading.
    Reading,
    /// A scan.
    Scan,
}

/// `api/lanes`: the lanes that are to be made, one or two.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(TS))]
pub struct LanesRequest {
    /// The lanes.
    pub lanes: Vec<LaneSpec>,
}

/// A lane as it is asked for: a method, and the parameters that are set of it and of the sensors.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(TS))]
pub struct LaneSpec {
    /// The method's name.
    pub method: String,
    /// Keys and values, as in `--set`.
    #[serde(default)]
    pub set: BTreeMap<String, String>,
}
