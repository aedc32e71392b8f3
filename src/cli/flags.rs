//! Options and parameters in messages. The library names them in backticks, as in "give a coarser `resolution`"; the command prints
//! the flag, as in "give a coarser --resolution".

use super::Arguments;
use crate::method::REGISTRY;
use crate::method::settings::Settings;
use crate::sensor::OVERRIDE_KEYS;
use clap::{Arg, CommandFactory};
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// The words that stand for flags.
struct Words {
    /// Long names of options.
    options: BTreeSet<String>,
    /// Keys of `--set`.
    keys: BTreeSet<&'static str>,
}

impl Words {
    fn get() -> &'static Words {
        static WORDS: OnceLock<Words> = OnceLock::new();
        WORDS.get_or_init(|| {
            let command = Arguments::command();
            let options = command.get_subcommands().flat_map(|c| c.get_arguments()).filter_map(Arg::get_long);
            let of_methods = REGISTRY.iter().filter_map(|e| Settings::of(e.name)).flat_map(|s| s.keys());
            let keys = OVERRIDE_KEYS.iter().chain(of_methods).map(|key| key.name);
            Words { options: options.map(String::from).collect(), keys: keys.collect() }
        })
    }

    /// The flag of a text in backticks: an option with or without a value after a space, or a parameter with or without a value after
    /// an equals sign.
    fn flag(&self, text: &str) -> Option<String> {
        let option = text.split(' ').next().unwrap_or(text);
        let key = text.split('=').next().unwrap_or(text);
        match (self.options.contains(option), self.keys.contains(key)) {
            (true, _) => Some(format!("--{text}")),
            (_, true) => Some(format!("--set {text}")),
            _ => None,
        }
    }
}

/// Writes the options and parameters that a message names as flags; other text in backticks stays.
pub fn with_flags(message: &str) -> String {
    let (mut text, mut rest) = (String::new(), message);
    while let Some((before, after)) = rest.split_once('`') {
        text += before;
        match after.split_once('`').and_then(|(inner, rest)| Some((Words::get().flag(inner)?, rest))) {
            Some((flag, behind)) => (text, rest) = (text + &flag, behind),
            None => (text, rest) = (text + "`", after),
        }
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::with_flags;

    #[test]
    fn options_and_parameters_become_flags() {
        for (message, wanted) in [
            (
                "give a coarser `resolution` or a smaller `r_max`",
                "give a coarser --resolution or a smaller --set r_max",
            ),
            ("`rho=2`: rho takes 0..1", "--set rho=2: rho takes 0..1"),
            ("leave out `sensor laser`", "leave out --sensor laser"),
            ("use `echogrid map`, or `backend cpu`", "use `echogrid map`, or --backend cpu"),
            ("a`b: give `bounds`", "a`b: give --bounds"),
            ("no option at all", "no option at all"),
        ] {
            assert_eq!(with_flags(message), wanted);
        }
    }
}
