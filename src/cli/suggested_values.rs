//! Values that shell completion suggests for an option. The option takes any text: the command itself refuses a wrong one, with a
//! suggestion.

use crate::method::REGISTRY;
use crate::method::settings::Settings;
use crate::sensor::{OVERRIDE_KEYS, ParameterDoc};
use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use std::collections::BTreeSet;
use std::ffi::OsStr;

/// A parser that takes any text, and lists values for shell completion.
#[derive(Clone)]
pub struct SuggestedValues(pub fn() -> Vec<String>);

impl TypedValueParser for SuggestedValues {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new((self.0)().into_iter().map(PossibleValue::new)))
    }
}

/// Every method's name.
pub fn methods() -> Vec<String> {
    REGISTRY.iter().map(|e| e.name.to_string()).collect()
}

/// Every key of `--set`, as `key=value` for each value that is a word, else as `key=`.
pub fn settings() -> Vec<String> {
    let of_methods = REGISTRY.iter().filter_map(|e| Settings::of(e.name)).flat_map(|s| s.keys());
    let all: BTreeSet<String> = OVERRIDE_KEYS.iter().chain(of_methods).flat_map(values).collect();
    all.into_iter().collect()
}

fn values(key: &ParameterDoc) -> Vec<String> {
    let word = |text: &str| text.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
    match key.values.split('|').collect::<Vec<_>>() {
        words if words.len() > 1 && words.iter().all(|w| word(w)) => {
            words.iter().map(|w| format!("{}={w}", key.name)).collect()
        }
        _ => vec![format!("{}=", key.name)],
    }
}
