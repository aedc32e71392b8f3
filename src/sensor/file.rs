//! Sensor descriptions in TOML: `--sensor-file`, and the presets that come with the program, read by the same code.
//!
//! `[[sensor]]` tables in the log's order; an `[all]` table holds what every sensor shares.

use super::description::Description;
use super::value::{SensorKey, SensorValue};
use crate::{Error, Result};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// The presets, by the name of the log format they serve.
const PRESETS: &[(&str, &str)] = &[
    ("sonar_ring_8", include_str!("../../sensors/sonar_ring_8.toml")),
    ("sonar_ring_8.laser", include_str!("../../sensors/sonar_ring_8.laser.toml")),
];

/// A parsed sensor file.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorFile {
    /// Its path, for messages.
    pub path: PathBuf,
    /// Its sensors, in the log's order.
    pub sensors: Vec<Description>,
}

type Table = BTreeMap<SensorKey, Spanned<SensorValue>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    #[serde(default)]
    all: Table,
    #[serde(default)]
    sensor: Vec<Table>,
}

impl SensorFile {
    /// Reads a sensor file.
    ///
    /// # Errors
    /// [`Error::Input`] with the line: unreadable, not TOML, an unknown key, a value out of range, no sensor.
    pub fn open(path: &Path) -> Result<SensorFile> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::caused(path, format!("sensor file: {e}"), e))?;
        SensorFile::parse(path, &text)
    }

    /// The same from its text; `path` is for messages.
    ///
    /// # Errors
    /// As [`SensorFile::open`].
    pub fn parse(path: &Path, text: &str) -> Result<SensorFile> {
        let line = |at: usize| text.bytes().take(at).filter(|b| *b == b'\n').count() as u64 + 1;
        let tables: Tables = toml::from_str(text).map_err(|e| Error::toml(path, text, &e))?;
        let describe = |table: &Table| -> Result<Description> {
            let mut description = Description::default();
            for (key, value) in table {
                description
                    .set(key.0, value.get_ref())
                    .map_err(|what| Error::at(path, line(value.span().start), what))?;
            }
            Ok(description)
        };
        let all = describe(&tables.all)?;
        let mut sensors = Vec::with_capacity(tables.sensor.len());
        for table in &tables.sensor {
            let mut sensor = all.clone();
            sensor.merge(&describe(table)?);
            sensors.push(sensor);
        }
        if sensors.is_empty() {
            return Err(Error::input(path, "no [[sensor]] table: a sensor file has one for each sensor of the log"));
        }
        Ok(SensorFile { path: path.into(), sensors })
    }
}

/// The sensors of a preset that comes with the program: `sonar_ring_8` or `sonar_ring_8.laser`.
///
/// # Errors
/// [`Error::Usage`] if there is no such preset.
pub fn preset(name: &str) -> Result<Vec<Description>> {
    let text = PRESETS.iter().find(|p| p.0 == name).map(|p| p.1);
    let text = text.ok_or_else(|| Error::Usage(format!("no sensor preset is called {name}")))?;
    Ok(SensorFile::parse(Path::new(name), text)?.sensors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Kind;

    fn parse(text: &str) -> Result<SensorFile> {
        SensorFile::parse(Path::new("ring.toml"), text)
    }

    #[test]
    fn the_ring_of_eight() {
        let ring = preset("sonar_ring_8").unwrap();
        assert_eq!(ring.len(), 8);
        let axes = [-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0_f64];
        let out = [0.18, 0.06, 0.025, 0.015, 0.015, 0.025, 0.06, 0.18];
        for (i, description) in ring.iter().enumerate() {
            let s = description.complete(i).unwrap();
            let a = axes[i].to_radians();
            assert_eq!((s.kind, s.axis, s.x, s.y), (Kind::Sonar, a, out[i] * a.cos(), out[i] * a.sin()));
            assert_eq!((s.half_width, s.r_min, s.r_max), (12.5_f64.to_radians(), 0.17, 5.0));
            assert_eq!((s.hit_range, s.no_echo_range, s.epsilon), (2.0, 1.25, None));
        }
        let laser = preset("sonar_ring_8.laser").unwrap()[0].complete(0).unwrap();
        assert_eq!((laser.kind, laser.r_min, laser.r_max, laser.hit_range), (Kind::Laser, 0.05, 80.0, 80.0));
        assert_eq!((laser.half_width, laser.no_echo_range), (0.25_f64.to_radians(), 0.0));
    }

    #[test]
    fn units_all_and_defaults() {
        let file = parse(
            "[all]\nkind='laser'\nr_max='80m'\n[[sensor]]\nid=7\nx='18cm'\naxis='90deg'\nstep='0.5deg'\nbeams=361\n",
        );
        let s = &file.unwrap().sensors[0];
        assert_eq!((s.id.as_deref(), s.x, s.axis), (Some("7"), Some(0.18), Some(90_f64.to_radians())));
        let s = s.complete(0).unwrap();
        assert_eq!((s.kind, s.half_width, s.hit_range), (Kind::Laser, 0.25_f64.to_radians(), 80.0));
    }

    #[test]
    fn errors_name_line_and_what_to_do() {
        for (text, line, what) in [
            ("[[sensor]]\nid='a'\nhalf_witdh=0.2\n", Some(3), "did you mean \"half_width\"?"),
            ("[[sensor]]\nx='18 inch'\n", Some(2), "mm, cm or m"),
            ("[[sensor]]\n\nhalf_width='70deg'\n", Some(3), "0 to 60deg"),
            ("[[sensor]]\nr_max=nan\n", Some(2), "metres"),
            ("[[sensor]]\nkind='radar'\n", Some(2), "\"sonar\" or \"laser\""),
            ("[[sensor]]\nkind=['sonar']\n", Some(2), "a number or a text"),
            ("[[sensor]\n", Some(1), ""),
            ("[[sensors]]\n", Some(1), "sensors"),
            ("", None, "[[sensor]]"),
        ] {
            match parse(text).unwrap_err() {
                Error::Input { line: at, what: said, .. } => {
                    assert_eq!(at, line, "{text:?}: {said}");
                    assert!(said.contains(what), "{text:?}: {said}");
                }
                other => panic!("{other}"),
            }
        }
    }

    #[test]
    fn layers() {
        let mut s = preset("sonar_ring_8").unwrap().remove(0);
        let lower = Description { r_max: Some(1.0), ..Description::default() };
        s.merge(&lower);
        let sensor = s.complete(0).unwrap();
        assert_eq!((sensor.r_max, sensor.hit_range, sensor.no_echo_range), (1.0, 1.0, 1.0));
        s.merge(&Description { x: Some(0.5), ..Description::default() });
        assert_eq!((s.complete(0).unwrap().x, s.complete(0).unwrap().y), (0.5, 0.0));
        s.merge(&Description { hit_range: Some(2.0), ..Description::default() });
        assert!(s.complete(0).unwrap_err().contains("hit_range 2 m must not exceed r_max 1 m"));
    }
}
