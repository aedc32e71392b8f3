//! A reading's line in JSON Lines, parsed to its fields.
//!
//! JSON has no NaN and no infinity, so `"NaN"`, `"inf"` and `"-inf"` are accepted as text: invalid ranges are counted, not lost.

use super::fields::{FIELD_NAMES, ReadingFields, SensorName};
use super::json_error::explain;
use serde::{Deserialize, Deserializer, de};
use std::borrow::Cow;
use std::fmt;

/// The fields of a line.
pub(super) fn parse(line: &str) -> Result<ReadingFields<'_>, String> {
    let raw: Raw<'_> = serde_json::from_str(line).map_err(|e| {
        // Some writers put these down bare, which is not JSON.
        let bare = [":NaN", ": NaN", ":Inf", ": Inf", ":-Inf", ": -Inf"].iter().any(|word| line.contains(word));
        let hint = if bare { "; JSON has no bare NaN or Infinity: write \"NaN\", or null for no echo" } else { "" };
        explain(&e, &FIELD_NAMES) + hint
    })?;
    let value = |n: Option<Number>| n.map(|n| n.0);
    Ok(ReadingFields {
        t: value(raw.t),
        scan: raw.scan,
        sensor: raw.sensor,
        robot: [value(raw.px), value(raw.py), value(raw.ph)],
        pose: [value(raw.x), value(raw.y), value(raw.h)],
        z: raw.z.map(|z| z.map_or(f64::INFINITY, |n| n.0)),
        label: raw.label,
    })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw<'a> {
    t: Option<Number>,
    scan: Option<u64>,
    #[serde(borrow)]
    sensor: Option<SensorName<'a>>,
    px: Option<Number>,
    py: Option<Number>,
    ph: Option<Number>,
    x: Option<Number>,
    y: Option<Number>,
    h: Option<Number>,
    // null is an answer here (no echo), a missing key is not.
    #[serde(default, deserialize_with = "given")]
    z: Option<Option<Number>>,
    label: Option<u64>,
}

fn given<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Option<Number>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

/// A number, or the text of one that JSON can't write.
struct Number(f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Number;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, \"NaN\", \"inf\" or \"-inf\"")
            }
            fn visit_f64<E>(self, v: f64) -> Result<Number, E> {
                Ok(Number(v))
            }
            fn visit_i64<E>(self, v: i64) -> Result<Number, E> {
                Ok(Number(v as f64))
            }
            fn visit_u64<E>(self, v: u64) -> Result<Number, E> {
                Ok(Number(v as f64))
            }
            fn visit_str<E: de::Error>(self, v: &str) -> Result<Number, E> {
                match v {
                    "NaN" | "nan" => Ok(Number(f64::NAN)),
                    "inf" | "Infinity" => Ok(Number(f64::INFINITY)),
                    "-inf" | "-Infinity" => Ok(Number(f64::NEG_INFINITY)),
                    _ => Err(E::invalid_value(de::Unexpected::Str(v), &self)),
                }
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

impl<'de: 'a, 'a> Deserialize<'de> for SensorName<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = SensorName<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a sensor's id or its index")
            }
            fn visit_u64<E>(self, v: u64) -> Result<SensorName<'de>, E> {
                Ok(SensorName::Index(v))
            }
            fn visit_borrowed_str<E>(self, v: &'de str) -> Result<SensorName<'de>, E> {
                Ok(SensorName::Id(Cow::Borrowed(v)))
            }
            fn visit_str<E>(self, v: &str) -> Result<SensorName<'de>, E> {
                Ok(SensorName::Id(Cow::Owned(v.into())))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}
