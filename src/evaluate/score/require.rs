//! Conditions on a score, such as `danger<=0.02`, for CI.

use super::Score;
use crate::method::nearest;
use crate::{Error, Result};
use serde::Serialize;
use serde_json::Value;
use std::str::FromStr;

/// A condition: a name of the JSON, an operator, a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirement {
    /// The number's name: `danger`, `zones.z5` or `z5`, `levels.9`, `near.danger`, `near.z5` …
    pub name: String,
    /// `<=`, `>=`, `==`, `<` or `>`.
    pub operator: &'static str,
    /// The value that it is compared with.
    pub bound: f64,
}

/// The result of a condition on one map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// The condition.
    pub require: String,
    /// The map.
    pub path: String,
    /// The map's value; `None` where there is nothing to measure.
    pub value: Option<f64>,
    /// Whether it holds; without a value it does not.
    pub held: bool,
}

impl FromStr for Requirement {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = || Error::Usage(format!("--require \"{text}\" is no condition: write one like \"danger<=0.02\""));
        let operators = ["<=", ">=", "==", "<", ">"];
        let at = text.find(['<', '>', '=']).ok_or_else(wrong)?;
        let operator = operators.into_iter().find(|o| text[at..].starts_with(o)).ok_or_else(wrong)?;
        let (name, bound) = (text[..at].trim(), text[at + operator.len()..].trim());
        let bound = bound.parse::<f64>().ok().filter(|b| b.is_finite()).ok_or_else(wrong)?;
        if name.is_empty() {
            return Err(wrong());
        }
        Ok(Requirement { name: name.into(), operator, bound })
    }
}

impl Requirement {
    /// Checks the condition on a score.
    ///
    /// # Errors
    /// [`Error::Usage`] for an unknown name.
    pub fn check(&self, score: &Score) -> Result<Check> {
        let names = names(score);
        let found = names.iter().find(|(name, _)| *name == self.name);
        let Some(&(_, value)) = found else {
            if self.name.starts_with("near.") && score.near.is_none() {
                return Err(Error::Usage(format!(
                    "--require {}: only a world's score has near; a map's has none",
                    self
                )));
            }
            let known: Vec<&str> = names.iter().map(|n| n.0.as_str()).collect();
            return Err(Error::Usage(format!(
                "--require: there is no \"{}\"{}",
                self.name,
                nearest(&self.name, &known)
            )));
        };
        let holds = |v: f64| match self.operator {
            "<=" => v <= self.bound,
            ">=" => v >= self.bound,
            "<" => v < self.bound,
            ">" => v > self.bound,
            _ => v == self.bound,
        };
        Ok(Check { require: self.to_string(), path: score.path.clone(), value, held: value.is_some_and(holds) })
    }
}

impl std::fmt::Display for Requirement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}{}", self.name, self.operator, self.bound)
    }
}

/// Every number of a score by its name in the JSON; the zones also by their own names.
fn names(score: &Score) -> Vec<(String, Option<f64>)> {
    let mut all = Vec::new();
    if let Ok(value) = serde_json::to_value(score) {
        collect_numbers("", &value, &mut all);
    }
    all
}

/// Collects the numbers of a JSON value with their dotted names.
fn collect_numbers(name: &str, value: &Value, all: &mut Vec<(String, Option<f64>)>) {
    let inner = |key: &str| if name.is_empty() { key.to_string() } else { format!("{name}.{key}") };
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                if key == "zones" {
                    collect_numbers(name, value, all); // also `z5` for `zones.z5`, `near.z5` for `near.zones.z5`
                }
                collect_numbers(&inner(key), value, all);
            }
        }
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(k, v)| collect_numbers(&inner(&k.to_string()), v, all))
        }
        Value::Number(number) => all.push((name.into(), number.as_f64())),
        Value::Null if name != "near" => all.push((name.into(), None)),
        _ => {}
    }
}
