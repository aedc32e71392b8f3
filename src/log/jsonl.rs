//! echogrid's own log, JSON Lines: a header that describes the sensors, then a line a reading.
//!
//! JSON has no NaN and no infinity, so `"NaN"`, `"inf"` and `"-inf"` are taken as well: broken ranges are counted, not lost.

use super::fields::{Builder, Fields, NAMES, SensorName};
use super::format::{Format, Items, Mounted, Place, Probe, Scans, Source, quote};
use super::input::Input;
use super::lines::Lines;
use super::{BadLine, Problem};
use crate::sensor::{Description, Kind, SensorKey, Value, similar};
use crate::{Error, Result};
use serde::{Deserialize, Deserializer, de};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The format.
pub(crate) struct JsonLines;

impl Format for JsonLines {
    fn name(&self) -> &'static str {
        "echogrid-jsonl"
    }

    fn looks(&self) -> &'static str {
        "echogrid's JSON Lines (first line {\"echogrid_log\":1,\"sensors\":[…]})"
    }

    fn claims(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        text.lines().map(str::trim_start).find(|line| !passed_over(line)).is_some_and(|line| line.starts_with('{'))
    }

    fn open(&self, place: &Place, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let Place::File(input) = place else { return Err(Error::Usage("a JSON Lines log is a file".into())) };
        let mut lines = input.lines()?;
        let line = loop {
            match lines.next() {
                None => return Err(Error::input(input.path(), "is empty")),
                Some(Ok(line)) if passed_over(line.trim()) => {}
                Some(Ok(line)) => break line.to_string(),
                Some(Err(Problem::Line(bad))) => return Err(Error::at(input.path(), bad.line, bad.what)),
                Some(Err(Problem::Fatal(error))) => return Err(error),
            }
        };
        let at = lines.number();
        let header = Preamble::parse(&line).map_err(|what| Error::at(input.path(), at, what))?;
        header.offers(kind).map_err(|what| Error::at(input.path(), at, what))?;
        Ok(Box::new(JsonLog { input: input.clone(), header, line: at, kind }))
    }
}

/// Whether a line before the header is empty or a comment.
fn passed_over(line: &str) -> bool {
    line.is_empty() || line.starts_with('#')
}

/// The header of echogrid's own log, in JSON Lines and in CSV.
pub(super) struct Preamble {
    /// The sensors, as described.
    pub sensors: Vec<Description>,
    /// The class names.
    pub classes: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawPreamble {
    echogrid_log: serde_json::Value,
    sensors: Vec<BTreeMap<SensorKey, Value>>,
    #[serde(default)]
    classes: Option<Vec<String>>,
}

impl Preamble {
    /// Parses a header line.
    pub fn parse(line: &str) -> std::result::Result<Preamble, String> {
        Preamble::read(line).map_err(|what| format!("{what}; the line is {}", quote(line.trim())))
    }

    fn read(line: &str) -> std::result::Result<Preamble, String> {
        let raw: RawPreamble = serde_json::from_str(line).map_err(|e| {
            let what = match serde_json::from_str::<BTreeMap<String, serde_json::Value>>(line) {
                Ok(keys) if !keys.contains_key("echogrid_log") => {
                    "it has no \"echogrid_log\"; a log of another kind needs this header put before it, and a line a reading".into()
                }
                _ => explain(&e, &["echogrid_log", "sensors", "classes"]),
            };
            format!("the first line must be the header {{\"echogrid_log\":1,\"sensors\":[…]}}: {what}")
        })?;
        if raw.echogrid_log != serde_json::json!(1) {
            return Err(format!("echogrid_log is {}: this program reads version 1", raw.echogrid_log));
        }
        if raw.sensors.is_empty() {
            return Err("the header lists no sensors".into());
        }
        let mut sensors = Vec::with_capacity(raw.sensors.len());
        for (i, table) in raw.sensors.iter().enumerate() {
            let mut sensor = Description { id: Some(i.to_string()), ..Description::default() };
            for (key, value) in table {
                if matches!(key.0, "beams" | "first" | "step") {
                    return Err(format!("sensor {i}: {} has no place here: each reading carries its heading", key.0));
                }
                sensor.set(key.0, value).map_err(|what| format!("sensor {i}: {what}"))?;
            }
            if sensors.iter().any(|s: &Description| s.id == sensor.id) {
                return Err(format!("two sensors are called {:?}", sensor.id.unwrap_or_default()));
            }
            sensors.push(sensor);
        }
        Ok(Preamble { sensors, classes: raw.classes.unwrap_or_default() })
    }

    /// Whether there is a sensor of the wanted kind.
    pub fn offers(&self, kind: Option<Kind>) -> std::result::Result<(), String> {
        match kind {
            Some(kind) if self.sensors.iter().all(|s| s.kind.unwrap_or(Kind::Sonar) != kind) => Err(match kind {
                Kind::Sonar => "the log has no sonar sensor, only lasers: leave out --sensor sonar",
                Kind::Laser => {
                    "the log has no laser sensor, only sonars: leave out --sensor laser (method truth needs a laser log)"
                }
            }
            .into()),
            _ => Ok(()),
        }
    }
}

struct JsonLog {
    input: Input,
    header: Preamble,
    line: u64,
    kind: Option<Kind>,
}

impl Source for JsonLog {
    fn sensors(&self) -> &[Description] {
        &self.header.sensors
    }

    fn sensor_line(&self) -> Option<u64> {
        Some(self.line)
    }

    fn has_beams(&self) -> bool {
        false
    }

    fn classes(&self) -> &[String] {
        &self.header.classes
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[Mounted]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn Scans>> {
        let builder = Builder::new(sensors, self.header.classes.len(), self.kind);
        Ok(Box::new(Pass { lines: self.input.lines()?, header: self.line, builder, ignored }))
    }
}

struct Pass {
    lines: Lines,
    header: u64,
    builder: Builder,
    ignored: Arc<AtomicU64>,
}

impl Scans for Pass {
    fn fill(&mut self, items: &mut Items) -> bool {
        let number = self.lines.number() + 1;
        let made = match self.lines.next() {
            None => return false,
            Some(Err(problem)) => {
                items.push_back(Err(problem));
                return true;
            }
            Some(Ok(line)) if number <= self.header || line.trim().is_empty() => return true,
            Some(Ok(line)) => parse(line).and_then(|fields| self.builder.record(&fields, number)),
        };
        match made {
            Ok(Some(record)) => items.push_back(Ok(record)),
            Ok(None) => {
                self.ignored.fetch_add(1, Ordering::Relaxed);
            }
            Err(what) => items.push_back(Err(Problem::Line(BadLine { line: number, what }))),
        }
        true
    }
}

/// The fields of a line.
fn parse(line: &str) -> std::result::Result<Fields<'_>, String> {
    let raw: Raw<'_> = serde_json::from_str(line).map_err(|e| {
        // Some writers put these down bare, which is not JSON.
        let bare = [":NaN", ": NaN", ":Inf", ": Inf", ":-Inf", ": -Inf"].iter().any(|word| line.contains(word));
        let hint = if bare { "; JSON has no bare NaN or Infinity: write \"NaN\", or null for no echo" } else { "" };
        explain(&e, &NAMES) + hint
    })?;
    let value = |n: Option<Number>| n.map(|n| n.0);
    Ok(Fields {
        t: value(raw.t),
        scan: raw.scan,
        sensor: raw.sensor,
        robot: [value(raw.px), value(raw.py), value(raw.ph)],
        pose: [value(raw.x), value(raw.y), value(raw.h)],
        z: raw.z.map(|z| z.map_or(f64::INFINITY, |n| n.0)),
        label: raw.label,
    })
}

/// serde's message, with the nearest known name instead of the whole list, and the column without the line.
fn explain(error: &serde_json::Error, known: &[&str]) -> String {
    let text = error.to_string();
    let text = text.split(" at line ").next().unwrap_or_default();
    let text = match text.strip_prefix("unknown field `").and_then(|rest| rest.split_once('`')) {
        Some((name, _)) => format!("unknown key {name:?}{}", similar(name, known)),
        None => text.to_string(),
    };
    if error.column() > 0 { format!("{text} (column {})", error.column()) } else { text }
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

fn given<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Option<Option<Number>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

/// A number, or the text of one that JSON can't write.
struct Number(f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Number;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, \"NaN\", \"inf\" or \"-inf\"")
            }
            fn visit_f64<E>(self, v: f64) -> std::result::Result<Number, E> {
                Ok(Number(v))
            }
            fn visit_i64<E>(self, v: i64) -> std::result::Result<Number, E> {
                Ok(Number(v as f64))
            }
            fn visit_u64<E>(self, v: u64) -> std::result::Result<Number, E> {
                Ok(Number(v as f64))
            }
            fn visit_str<E: de::Error>(self, v: &str) -> std::result::Result<Number, E> {
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
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = SensorName<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a sensor's id or its index")
            }
            fn visit_u64<E>(self, v: u64) -> std::result::Result<SensorName<'de>, E> {
                Ok(SensorName::Index(v))
            }
            fn visit_borrowed_str<E>(self, v: &'de str) -> std::result::Result<SensorName<'de>, E> {
                Ok(SensorName::Id(Cow::Borrowed(v)))
            }
            fn visit_str<E>(self, v: &str) -> std::result::Result<SensorName<'de>, E> {
                Ok(SensorName::Id(Cow::Owned(v.into())))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}
