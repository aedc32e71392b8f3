//! Sensor parameters of `--set`, for every sensor of a log. They override the sensor file, the log's header and the preset.

use super::description::Description;
use super::limits::check_limit;
use super::model::AtMax;
use super::parameter::ParameterDoc;
use super::quantity::{angle, length};
use crate::{Error, Result};

/// The source of sensors' poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mounts {
    /// Their description, or the sensor poses in the log (default).
    #[default]
    Preset,
    /// All at the robot's centre, each with its own axis.
    None,
}

/// Parameters for every sensor; `None` keeps the description's value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Overrides {
    /// Half the beam's width β, radians.
    pub beta: Option<f64>,
    /// Ranges below this are rejected, metres.
    pub r_min: Option<f64>,
    /// Ranges above this are no echo, metres.
    pub r_max: Option<f64>,
    /// The meaning of a range of exactly `r_max`.
    pub at_r_max: Option<AtMax>,
    /// Echoes from beyond this are rejected, metres.
    pub hit_range: Option<f64>,
    /// The range up to which a missing echo frees the cone, metres.
    pub no_echo_range: Option<f64>,
    /// Half the depth of the arc ε, metres.
    pub epsilon: Option<f64>,
    /// Lasers with a fixed beam layout: the angle from the first beam to the last, radians.
    pub fov: Option<f64>,
    /// Lasers with a fixed beam layout: the bearing of the first beam from the sensor's axis, radians. Default with `fov`: −`fov` / 2.
    pub first_beam: Option<f64>,
    /// The source of the sensors' poses.
    pub mounts: Option<Mounts>,
}

/// The keys that [`Overrides::set`] takes, for help and errors.
pub const OVERRIDE_KEYS: &[ParameterDoc] = &[
    ParameterDoc::new("beta", "0..60deg", "the sensor's", "half the beam's width"),
    ParameterDoc::new("r_min", "length, 0 or more", "the sensor's", "ranges below this are rejected"),
    ParameterDoc::new("r_max", "length, above 0", "the sensor's", "ranges above this are no echo"),
    ParameterDoc::new("at_r_max", "no_echo|hit", "the sensor's", "what a range of just r_max is"),
    ParameterDoc::new(
        "hit_range",
        "length, above 0, up to r_max",
        "the sensor's",
        "echoes from beyond this are rejected",
    ),
    ParameterDoc::new(
        "no_echo_range",
        "length, 0 to r_max",
        "the sensor's",
        "how far a missing echo frees the cone; 0: not at all",
    ),
    ParameterDoc::new("epsilon", "length, above 0", "by kind and resolution", "half the depth of the arc"),
    ParameterDoc::new(
        "fov",
        "angle, above 0, up to 360deg",
        "the log's",
        "lasers of CARMEN logs and the like: angle from the first beam to the last",
    ),
    ParameterDoc::new(
        "first_beam",
        "-360..360deg",
        "the log's; -fov/2 with fov",
        "such lasers: bearing of the first beam from the axis",
    ),
    ParameterDoc::new(
        "mounts",
        "preset|none",
        "preset",
        "none: every sensor sits at the robot's centre, with its own axis",
    ),
];

impl Overrides {
    /// Sets one key from its text. `Ok(false)`: there is no such key here.
    ///
    /// # Errors
    /// [`Error::Usage`] that names the key, the value and what is allowed.
    pub fn set(&mut self, name: &str, value: &str) -> Result<bool> {
        let slot = match name {
            "beta" => &mut self.beta,
            "r_min" => &mut self.r_min,
            "r_max" => &mut self.r_max,
            "hit_range" => &mut self.hit_range,
            "no_echo_range" => &mut self.no_echo_range,
            "epsilon" => &mut self.epsilon,
            "fov" => &mut self.fov,
            "first_beam" => &mut self.first_beam,
            "at_r_max" => {
                let wrong = |what| Error::Usage(format!("--set at_r_max={value}: at_r_max {what}"));
                self.at_r_max = Some(AtMax::parse(value).map_err(wrong)?);
                return Ok(true);
            }
            "mounts" => {
                self.mounts = Some(match value {
                    "preset" => Mounts::Preset,
                    "none" => Mounts::None,
                    _ => return Err(Error::Usage(format!("--set mounts={value}: mounts takes preset or none"))),
                });
                return Ok(true);
            }
            _ => return Ok(false),
        };
        let wrong = |what: String| Error::Usage(format!("--set {name}={value}: {name} {what}"));
        let number =
            if matches!(name, "beta" | "fov" | "first_beam") { angle(value) } else { length(value) }.map_err(wrong)?;
        check_limit(name, number).map_err(wrong)?;
        *slot = Some(number);
        Ok(true)
    }

    /// Whether anything is changed.
    pub fn is_empty(&self) -> bool {
        *self == Overrides::default()
    }

    /// The overrides as a description, to be merged into a sensor's.
    pub(crate) fn description(&self) -> Description {
        Description {
            half_width: self.beta,
            r_min: self.r_min,
            r_max: self.r_max,
            at_r_max: self.at_r_max,
            hit_range: self.hit_range,
            no_echo_range: self.no_echo_range,
            epsilon: self.epsilon,
            ..Description::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_documented_key_is_taken() {
        let mut o = Overrides::default();
        for (key, value) in
            OVERRIDE_KEYS.iter().zip(["15deg", "170mm", "5", "hit", "3m", "1.5", "5cm", "100deg", "-50deg", "none"])
        {
            assert!(o.set(key.name, value).unwrap(), "{}", key.name);
        }
        assert_eq!((o.fov, o.first_beam), (Some(100_f64.to_radians()), Some(-50_f64.to_radians())));
        let all = (o.beta, o.r_min, o.r_max, o.hit_range, o.no_echo_range, o.epsilon, o.mounts);
        let some = (Some(15_f64.to_radians()), Some(0.17), Some(5.0), Some(3.0), Some(1.5), Some(0.05));
        assert_eq!(all, (some.0, some.1, some.2, some.3, some.4, some.5, Some(Mounts::None)));
        assert!(!o.set("order", "batch").unwrap());
    }

    #[test]
    fn refusals_name_key_value_and_what_is_allowed() {
        for (name, value, allowed) in [
            ("beta", "61deg", "0 to 60deg"),
            ("beta", "-1deg", "0 to 60deg"),
            ("beta", "nan", "radians"),
            ("r_max", "inf", "mm, cm or m"),
            ("r_max", "0", "more than 0"),
            ("r_min", "-0.1", "0 to 1e6"),
            ("epsilon", "0", "more than 0"),
            ("hit_range", "far", "mm, cm or m"),
            ("fov", "0", "up to 360deg"),
            ("first_beam", "-370deg", "-360deg to 360deg"),
            ("at_r_max", "far", "\"hit\" or \"no_echo\""),
            ("mounts", "some", "preset or none"),
        ] {
            let error = Overrides::default().set(name, value).unwrap_err();
            assert_eq!(error.kind(), crate::ErrorKind::Usage);
            let text = error.to_string();
            assert!(text.contains(&format!("{name}={value}")) && text.contains(allowed), "{text}");
        }
    }
}
