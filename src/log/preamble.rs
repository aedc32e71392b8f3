//! The header line of echogrid's own log, in JSON Lines and in CSV.

use super::json_error::explain;
use super::values::quote;
use crate::sensor::{Description, Kind, SensorKey, SensorValue};
use serde::Deserialize;
use std::collections::BTreeMap;

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
    sensors: Vec<BTreeMap<SensorKey, SensorValue>>,
    #[serde(default)]
    classes: Option<Vec<String>>,
}

impl Preamble {
    /// Parses a header line.
    ///
    /// # Errors
    /// A text that says what is wrong, with the line.
    pub fn parse(line: &str) -> Result<Preamble, String> {
        Preamble::read(line).map_err(|what| format!("{what}; the line is {}", quote(line.trim())))
    }

    fn read(line: &str) -> Result<Preamble, String> {
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

    /// Checks that there is a sensor of the wanted kind.
    ///
    /// # Errors
    /// A text that says which kind there is.
    pub fn offers(&self, kind: Option<Kind>) -> Result<(), String> {
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
