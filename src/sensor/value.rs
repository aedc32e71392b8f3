//! The keys and values of a sensor table, in a TOML file or in a log's header.

use crate::support::suggest::similar;
use serde::{Deserialize, Deserializer, de};
use std::fmt;

/// The keys of a sensor table.
pub(super) const KEYS: [&str; 16] = [
    "id",
    "kind",
    "x",
    "y",
    "displacement",
    "axis",
    "half_width",
    "r_min",
    "r_max",
    "at_r_max",
    "hit_range",
    "no_echo_range",
    "epsilon",
    "beams",
    "first",
    "step",
];

/// A value in a sensor table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum SensorValue {
    /// A plain number: metres or radians.
    Number(f64),
    /// A name, or a number with its unit.
    Text(String),
    /// No value: the key counts as missing.
    Null,
}

impl fmt::Display for SensorValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SensorValue::Number(number) => write!(f, "{number}"),
            SensorValue::Text(text) => write!(f, "{text:?}"),
            SensorValue::Null => write!(f, "null"),
        }
    }
}

impl<'de> Deserialize<'de> for SensorValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = SensorValue;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a text")
            }
            fn visit_f64<E>(self, v: f64) -> Result<SensorValue, E> {
                Ok(SensorValue::Number(v))
            }
            fn visit_i64<E>(self, v: i64) -> Result<SensorValue, E> {
                Ok(SensorValue::Number(v as f64))
            }
            fn visit_u64<E>(self, v: u64) -> Result<SensorValue, E> {
                Ok(SensorValue::Number(v as f64))
            }
            fn visit_str<E>(self, v: &str) -> Result<SensorValue, E> {
                Ok(SensorValue::Text(v.into()))
            }
            fn visit_unit<E>(self) -> Result<SensorValue, E> {
                Ok(SensorValue::Null)
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// A key of a sensor table. An unknown key is an error that names the most similar known one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct SensorKey(pub &'static str);

impl<'de> Deserialize<'de> for SensorKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        match KEYS.iter().find(|k| **k == name) {
            Some(key) => Ok(SensorKey(key)),
            None => Err(de::Error::custom(format!("unknown key {name:?}{}", similar(&name, &KEYS)))),
        }
    }
}
