//! The option `--set`: its help, and messages about keys that a method doesn't have or doesn't use.

use crate::method::settings::{FreeRule, Likelihood, MassModel, Settings};
use crate::method::{self, REGISTRY};
use crate::sensor::{OVERRIDE_KEYS, ParameterDoc};

/// The help of `--set`: every key, by method.
pub(super) fn set_help() -> String {
    let keys = |keys: &[ParameterDoc]| -> String {
        keys.iter().map(|k| format!("\n    {}={} [{}]  {}", k.name, k.values, k.default, k.about)).collect()
    };
    let mut help = String::from("Set a parameter, as often as needed.\n\n  every method:");
    help += &keys(OVERRIDE_KEYS);
    for entry in REGISTRY {
        if let Some(settings) = Settings::of(entry.name)
            && !settings.keys().is_empty()
        {
            help += &format!("\n  {}:{}", entry.name, keys(settings.keys()));
        }
    }
    help
}

/// The message about a key that the method doesn't have.
pub(super) fn unknown_key(method: &str, settings: &Settings, key: &str) -> String {
    let has = |name: &&str| Settings::of(name).is_some_and(|s| s.keys().iter().any(|k| k.name == key));
    let others: Vec<&str> = REGISTRY.iter().map(|e| e.name).filter(has).collect();
    let known: Vec<&str> = settings.keys().iter().chain(OVERRIDE_KEYS).map(|k| k.name).collect();
    let hint = match others.is_empty() {
        true => method::nearest(key, &known),
        false => format!(
            ", {} {}; there are {}",
            others.join(" and "),
            if others.len() > 1 { "have" } else { "has" },
            known.join(", ")
        ),
    };
    format!("{method} has no parameter \"{key}\"{hint}")
}

/// The parameters given by `--set` that have no effect, each with the method or parameter that makes it so.
pub(super) fn without_effect(settings: &Settings, set: &[String]) -> Vec<(&'static str, &'static str)> {
    const SCANS: &str = "a counting sensor model: it takes the nearest beam";
    let keys: &[(&'static str, &'static str)] = match settings {
        Settings::Bayes(b) if b.likelihood() == Likelihood::Murphy => {
            &[("p_hit", "model=murphy"), ("p_miss", "model=murphy")]
        }
        Settings::Bayes(_) => &[
            ("max_occ", "model=constant"),
            ("region_one_floor", "model=constant"),
            ("region_two_floor", "model=constant"),
        ],
        Settings::DempsterShafer(d) if d.model == MassModel::Murphy => &[("rho", "model=murphy")],
        Settings::DempsterShafer(_) => &[("max_occ", "model=pagac")],
        Settings::Himm(_) => &[("beta", "method himm: it takes the cells on the axis")],
        Settings::Truth => &[("epsilon", "method truth: a hit is ¾ cell deep")],
        Settings::Csm(c) if c.continuous && c.free == FreeRule::Projection => {
            &[("beta", SCANS), ("step", "free=projection")]
        }
        Settings::Csm(c) if c.continuous && c.free == FreeRule::Clamp => &[("beta", SCANS), ("step", "free=clamp")],
        Settings::Csm(_) => &[("beta", SCANS)],
        Settings::Certainty(_) | Settings::Features(_) => &[],
    };
    let given = |key: &str| set.iter().any(|text| text.split_once('=').is_some_and(|(k, _)| k == key));
    keys.iter().filter(|(key, _)| given(key)).copied().collect()
}
