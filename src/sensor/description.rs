//! A partial description of a sensor: every field may be missing. Descriptions are merged (preset, log's header, sensor file,
//! `--set`) and then completed to a [`Sensor`] with the defaults of its kind.

use super::limits::{FULL_CIRCLE, MAX_HALF_WIDTH, check_limit};
use super::model::{AtMax, Kind, Sensor};
use super::quantity::{angle, length};
use super::value::{KEYS, SensorValue};

/// Half width of a sonar without a description, radians (15°).
const DEFAULT_SONAR_HALF_WIDTH: f64 = 15.0 * std::f64::consts::PI / 180.0;
/// Half width of a laser without a known beam spacing, radians (0.25°: the commonest spacing is 0.5°).
const DEFAULT_LASER_HALF_WIDTH: f64 = 0.25 * std::f64::consts::PI / 180.0;
/// A partial description of a sensor. Units and frames are those of [`Sensor`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Description {
    /// Its name in the log.
    pub id: Option<String>,
    /// Sonar or laser.
    pub kind: Option<Kind>,
    /// Metres forward of the robot's centre.
    pub x: Option<f64>,
    /// Metres to the left of the robot's centre.
    pub y: Option<f64>,
    /// Instead of `x` and `y`: metres from the robot's centre along the sensor's own axis.
    pub displacement: Option<f64>,
    /// Bearing in the robot's frame, radians.
    pub axis: Option<f64>,
    /// Half the beam's width β, radians.
    pub half_width: Option<f64>,
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
    /// Lasers: the number of beams of a scan.
    pub beams: Option<u32>,
    /// Lasers: bearing of the first beam from the sensor's axis, radians.
    pub first: Option<f64>,
    /// Lasers: angle from one beam to the next, radians.
    pub step: Option<f64>,
}

impl Description {
    /// Sets one key from its value.
    ///
    /// # Errors
    /// A text that says which values the key takes.
    pub(crate) fn set(&mut self, key: &str, value: &SensorValue) -> Result<(), String> {
        let wrong = |what: String| format!("{key} = {value}: {key} {what}");
        match (key, value) {
            (_, SensorValue::Null) => return Ok(()),
            ("id", SensorValue::Text(text)) => self.id = Some(text.clone()),
            ("id", SensorValue::Number(number)) => self.id = Some(number.to_string()),
            ("kind", SensorValue::Text(text)) if text == "sonar" => self.kind = Some(Kind::Sonar),
            ("kind", SensorValue::Text(text)) if text == "laser" => self.kind = Some(Kind::Laser),
            ("kind", _) => return Err(wrong("takes \"sonar\" or \"laser\"".into())),
            ("at_r_max", SensorValue::Text(text)) => self.at_r_max = Some(AtMax::parse(text).map_err(wrong)?),
            ("at_r_max", _) => return Err(wrong("takes \"hit\" or \"no_echo\"".into())),
            ("beams", SensorValue::Number(n)) if n.fract() == 0.0 && (2.0..=1e6).contains(n) => {
                self.beams = Some(*n as u32)
            }
            ("beams", _) => return Err(wrong("takes a whole number from 2".into())),
            _ => {
                let angles = matches!(key, "axis" | "half_width" | "first" | "step");
                let read = if angles { angle } else { length };
                let number = match value {
                    // A plain 90 is most likely meant in degrees.
                    SensorValue::Number(number) if angles && number.is_finite() && number.abs() > FULL_CIRCLE => {
                        return Err(wrong(format!("is in radians: write \"{number}deg\"")));
                    }
                    SensorValue::Number(number) if number.is_finite() => *number,
                    SensorValue::Number(number) => read(&number.to_string()).map_err(wrong)?,
                    SensorValue::Text(text) => read(text).map_err(wrong)?,
                    SensorValue::Null => return Ok(()),
                };
                check_limit(key, number).map_err(wrong)?;
                *self.slot(key).ok_or_else(|| format!("unknown key {key}"))? = Some(number);
            }
        }
        Ok(())
    }

    fn slot(&mut self, key: &str) -> Option<&mut Option<f64>> {
        Some(match key {
            "x" => &mut self.x,
            "y" => &mut self.y,
            "displacement" => &mut self.displacement,
            "axis" => &mut self.axis,
            "half_width" => &mut self.half_width,
            "r_min" => &mut self.r_min,
            "r_max" => &mut self.r_max,
            "hit_range" => &mut self.hit_range,
            "no_echo_range" => &mut self.no_echo_range,
            "epsilon" => &mut self.epsilon,
            "first" => &mut self.first,
            "step" => &mut self.step,
            _ => return None,
        })
    }

    /// Overrides this description by `upper`, field by field. A lower `r_max` also lowers `hit_range` and `no_echo_range`, unless
    /// `upper` sets them too.
    pub fn merge(&mut self, upper: &Description) {
        if upper.x.is_some() || upper.y.is_some() {
            self.displacement = None;
        }
        if upper.displacement.is_some() {
            (self.x, self.y) = (None, None);
        }
        if let Some(r_max) = upper.r_max {
            self.hit_range = self.hit_range.map(|r| r.min(r_max));
            self.no_echo_range = self.no_echo_range.map(|r| r.min(r_max));
        }
        fn put<T: Clone>(mine: &mut Option<T>, theirs: &Option<T>) {
            if theirs.is_some() {
                mine.clone_from(theirs);
            }
        }
        put(&mut self.id, &upper.id);
        put(&mut self.kind, &upper.kind);
        put(&mut self.at_r_max, &upper.at_r_max);
        put(&mut self.beams, &upper.beams);
        for key in KEYS {
            let theirs = upper.clone().slot(key).and_then(|s| *s);
            if let (Some(mine), Some(value)) = (self.slot(key), theirs) {
                *mine = Some(value);
            }
        }
    }

    /// Whether this description gives the sensor's position or bearing.
    pub(crate) fn has_pose(&self) -> bool {
        [self.x, self.y, self.displacement, self.axis].iter().any(Option::is_some)
    }

    /// The complete sensor: missing fields take the defaults of its kind. Sonar: β 15°, r_min 0.15 m, r_max 5 m; laser:
    /// β half the beam spacing (0.25° if unknown), r_min 0.05 m, r_max 80 m; both: at the robot's centre, looking
    /// forward, hit_range r_max, no_echo_range 0.
    ///
    /// # Errors
    /// A text that names the two values that don't go together.
    pub fn complete(&self, index: usize) -> Result<Sensor, String> {
        let kind = self.kind.unwrap_or(Kind::Sonar);
        let (half_width, r_min, r_max) = match kind {
            Kind::Sonar => (DEFAULT_SONAR_HALF_WIDTH, 0.15, 5.0),
            Kind::Laser => {
                (self.step.map_or(DEFAULT_LASER_HALF_WIDTH, |s| (s.abs() / 2.0).min(MAX_HALF_WIDTH)), 0.05, 80.0)
            }
        };
        let axis = self.axis.unwrap_or(0.0);
        let (x, y) = match self.displacement {
            Some(d) => (d * axis.cos(), d * axis.sin()),
            None => (self.x.unwrap_or(0.0), self.y.unwrap_or(0.0)),
        };
        let r_max = self.r_max.unwrap_or(r_max);
        let sensor = Sensor {
            id: self.id.clone().unwrap_or_else(|| index.to_string()),
            kind,
            x,
            y,
            axis,
            half_width: self.half_width.unwrap_or(half_width),
            r_min: self.r_min.unwrap_or(r_min),
            r_max,
            at_r_max: self.at_r_max.unwrap_or_default(),
            hit_range: self.hit_range.unwrap_or(r_max),
            no_echo_range: self.no_echo_range.unwrap_or(0.0),
            epsilon: self.epsilon,
        };
        self.check(&sensor)?;
        Ok(sensor)
    }

    fn check(&self, s: &Sensor) -> Result<(), String> {
        let fail = |what: String| Err(format!("sensor {}: {what}", s.id));
        if self.displacement.is_some() && (self.x.is_some() || self.y.is_some()) {
            return fail("give either displacement or x and y, not both".into());
        }
        if s.r_min >= s.r_max {
            return fail(format!("r_min {} m must be below r_max {} m", s.r_min, s.r_max));
        }
        if s.hit_range > s.r_max {
            return fail(format!("hit_range {} m must not exceed r_max {} m", s.hit_range, s.r_max));
        }
        if s.hit_range < s.r_min {
            return fail(format!("hit_range {} m must not be below r_min {} m", s.hit_range, s.r_min));
        }
        // A range beyond r_max counts as no echo: freeing past r_max would free through the very thing that answered.
        if s.no_echo_range > s.r_max {
            return fail(format!("no_echo_range {} m must not exceed r_max {} m", s.no_echo_range, s.r_max));
        }
        if s.kind == Kind::Sonar && (self.beams.is_some() || self.first.is_some() || self.step.is_some()) {
            return fail("beams, first and step are for lasers; a sonar is one beam".into());
        }
        Ok(())
    }
}
