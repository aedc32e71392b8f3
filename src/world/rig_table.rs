//! Reads the rig of a world's file: `[rig]` and `[[sensor]]`.

use super::rig::{Noise, Rig, Transducer, fixed};
use super::text::Table;
use crate::Result;
use crate::sensor::{Description, Sensor};
use std::f64::consts::{PI, TAU};

/// The keys of `[[sensor]]`.
const SENSOR_KEYS: [&str; 15] = [
    "id",
    "kind",
    "x",
    "y",
    "displacement",
    "axis",
    "half_width",
    "r_min",
    "r_max",
    "hit_range",
    "no_echo_range",
    "beams",
    "step",
    "noise",
    "noise_share",
];
/// The keys of `[rig]`.
const RIG_KEYS: [&str; 15] = [
    "kind",
    "radius",
    "step",
    "half_width",
    "r_min",
    "r_max",
    "hit_range",
    "no_echo_range",
    "noise",
    "noise_share",
    "bounces",
    "specular",
    "spurious",
    "cross_talk",
    "flutter",
];

impl Rig {
    /// Reads `[rig]` and `[[sensor]]`; without either it is the dense scan.
    pub(crate) fn read(table: Option<&Table<'_>>, sensors: &[Table<'_>]) -> Result<Rig> {
        let mut rig = Rig::named("dense")?;
        if let Some(table) = table {
            table.check(&RIG_KEYS)?;
            if let Some(name) = table.string("kind")? {
                rig = Rig::named(name.get_ref()).map_err(|e| table.fail("kind", format!("kind: {e}")))?;
            }
        }
        if !sensors.is_empty() {
            rig.name = "sensors".into();
            rig.transducers.clear();
            for table in sensors {
                let next = read_sensor(table, rig.transducers.len())?;
                if rig.transducers.iter().any(|t| t.sensor.id == next.sensor.id) {
                    return Err(table
                        .text
                        .fail(&table.span, format!("two sensors are called {:?}: give each its id", next.sensor.id)));
                }
                rig.transducers.push(next);
            }
        }
        if let Some(table) = table {
            rig.adjust(table)?;
        }
        Ok(rig)
    }

    /// Applies the values of `[rig]` to every sensor.
    fn adjust(&mut self, table: &Table<'_>) -> Result<()> {
        if let Some(bounces) = table.count("bounces")? {
            if !(1..=3).contains(&bounces) {
                return Err(table.fail("bounces", format!("bounces = {bounces}: takes 1, 2 or 3")));
            }
            self.physics.bounces = bounces as u8;
        }
        self.physics.specular = table.flag("specular")?.unwrap_or(self.physics.specular);
        for (key, slot, most) in [
            ("spurious", &mut self.spurious, 0.5),
            ("cross_talk", &mut self.cross_talk, 0.5),
            ("flutter", &mut self.physics.flutter, 1.0),
        ] {
            if let Some(share) = table.length(key)? {
                if !(0.0..=most).contains(&share) {
                    return Err(table.fail(key, format!("{key} = {share}: takes 0 to {most}")));
                }
                *slot = share;
            }
        }
        let radius = table.length("radius")?;
        if let Some(r) = radius.filter(|r| *r < 0.0) {
            return Err(table.fail("radius", format!("radius = {r:?}: takes 0 or more")));
        }
        let step = table.angle("step")?;
        if step.is_some() && self.transducers.iter().all(|t| t.beams == 1) {
            let what = format!("step is for sensors that turn, as in dense and laser; those of {} do not", self.name);
            return Err(table.fail("step", what));
        }
        for t in &mut self.transducers {
            if let Some(r) = radius {
                (t.sensor.x, t.sensor.y) = (r * t.sensor.axis.cos(), r * t.sensor.axis.sin());
            }
            if let Some(step) = step.filter(|_| t.beams > 1) {
                if !(1e-4..=1.0).contains(&step) {
                    return Err(table.fail("step", "step takes 0.006deg to 57deg"));
                }
                t.beams = if t.circles { (TAU / step).round() as u32 } else { (PI / step).round() as u32 + 1 };
                t.step = step;
            }
            let mut upper = Description::default();
            for key in ["half_width", "r_min", "r_max", "hit_range", "no_echo_range"] {
                if let Some(value) = table.value(key)? {
                    upper.set(key, &value).map_err(|what| table.fail(key, what))?;
                }
            }
            t.sensor = with_overrides(&t.sensor, &upper).map_err(|what| table.text.fail(&table.span, what))?;
            noise(table, &mut t.noise)?;
        }
        Ok(())
    }
}

/// A sensor with some of its values replaced.
fn with_overrides(s: &Sensor, upper: &Description) -> std::result::Result<Sensor, String> {
    let mut d = Description {
        id: Some(s.id.clone()),
        kind: Some(s.kind),
        x: Some(s.x),
        y: Some(s.y),
        axis: Some(s.axis),
        half_width: Some(s.half_width),
        r_min: Some(s.r_min),
        r_max: Some(s.r_max),
        at_r_max: Some(s.at_r_max),
        hit_range: Some(s.hit_range).filter(|h| *h != s.r_max),
        no_echo_range: Some(s.no_echo_range),
        ..Description::default()
    };
    d.merge(upper);
    d.complete(0)
}

/// Reads one `[[sensor]]`.
fn read_sensor(table: &Table<'_>, index: usize) -> Result<Transducer> {
    table.check(&SENSOR_KEYS)?;
    let mut d = Description::default();
    for key in SENSOR_KEYS.iter().filter(|k| !k.starts_with("noise")) {
        if let Some(value) = table.value(key)? {
            d.set(key, &value).map_err(|what| table.fail(key, what))?;
        }
    }
    let sensor = d.complete(index).map_err(|what| table.text.fail(&table.span, what))?;
    let mut t = fixed(sensor);
    if let Some(beams) = d.beams {
        t.beams = beams;
        t.step = table.need("step", d.step, "\"0.5deg\"")?;
    }
    noise(table, &mut t.noise)?;
    Ok(t)
}

/// Reads the keys of the noise.
fn noise(table: &Table<'_>, noise: &mut Noise) -> Result<()> {
    for (key, slot) in [("noise", &mut noise.metres), ("noise_share", &mut noise.share)] {
        if let Some(v) = table.length(key)? {
            if !(0.0..=1.0).contains(&v) {
                return Err(table.fail(key, format!("{key} = {v}: takes 0 to 1")));
            }
            *slot = v;
        }
    }
    Ok(())
}
