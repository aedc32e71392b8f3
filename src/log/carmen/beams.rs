//! The beam layout of lasers whose messages lack it (`FLASER`, `RLASER`, `LASER_READING`, `LASER1`): from the log's parameters, or from
//! the number of beams.

use super::message::LaserLayout;
use crate::log::mounting::Beams;
use std::f64::consts::PI;

/// The log's `PARAM` values of the front or the rear laser.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LaserParameters {
    /// The maximum range, metres.
    pub cap: Option<f64>,
    /// The field of view and the resolution, radians.
    fov: Option<f64>,
    resolution: Option<f64>,
    /// The laser's position in the robot's frame, metres forward and to the left.
    pub offset: (f64, f64),
}

/// Known lasers: the number of beams, degrees from beam to beam, and the bearing of the first beam, degrees. The first six are SICK's with
/// the layout of CARMEN's own reader; then a SICK S300, Hokuyo's URG and UTM, centred on the axis.
const KNOWN_LASERS: [(u32, f64, f64); 13] = [
    (180, 1.0, -90.0),
    (181, 1.0, -90.0),
    (360, 0.5, -90.0),
    (361, 0.5, -90.0),
    (400, 0.25, -90.0),
    (401, 0.25, -90.0),
    (540, 0.5, -135.0),
    (541, 0.5, -135.0),
    (682, 360.0 / 1024.0, -681.0 * 180.0 / 1024.0),
    (683, 360.0 / 1024.0, -682.0 * 180.0 / 1024.0),
    (769, 360.0 / 1024.0, -768.0 * 180.0 / 1024.0),
    (1080, 0.25, -135.0),
    (1081, 0.25, -135.0),
];

impl LaserParameters {
    /// Reads a `PARAM` line into the front laser's values, [0], or the rear one's, [1].
    pub fn read(all: &mut [LaserParameters; 2], line: &str) {
        let mut fields = line.split_ascii_whitespace();
        if fields.next() != Some("PARAM") {
            return;
        }
        let (Some(name), Some(Ok(value))) = (fields.next(), fields.next().map(str::parse::<f64>)) else { return };
        let [front, rear] = all;
        let (which, key) = match name {
            _ if name.contains("_front") => (front, name.replacen("_front", "", 1)),
            _ if name.contains("_rear") => (rear, name.replacen("_rear", "", 1)),
            _ => return,
        };
        let positive = Some(value).filter(|v| v.is_finite() && *v > 0.0);
        match key.as_str() {
            "robot_laser_max" => which.cap = positive,
            // No laser sees 7 rad around, none has 0.04° from beam to beam or 0.04 rad.
            "laser_laser_fov" => which.fov = positive.map(|v| if v > 7.0 { v.to_radians() } else { v }),
            "laser_laser_resolution" => which.resolution = positive.map(|v| if v > 0.04 { v.to_radians() } else { v }),
            "robotlaser_offset" | "robot_laser_offset" if value.abs() < 10.0 => which.offset.0 = value,
            "robotlaser_side_offset" | "robot_laser_side_offset" if value.abs() < 10.0 => which.offset.1 = value,
            _ => {}
        }
    }

    /// The angle from beam to beam, radians, and its source; `Err`: the values contradict each other or the number of beams.
    fn step(&self, count: u32) -> Result<Option<(f64, &'static str)>, ()> {
        let gaps = f64::from(count - 1);
        let around = 2.0 * PI + 1e-3;
        match (self.fov, self.resolution) {
            (None, None) => Ok(None),
            (Some(fov), Some(step)) if (step * gaps - fov).abs() <= 1.01 * step && fov <= around => {
                Ok(Some((step, "the log's PARAM laser_…_fov and laser_…_resolution")))
            }
            (None, Some(step)) if step * gaps <= around => Ok(Some((step, "the log's PARAM laser_…_resolution"))),
            (Some(fov), None) if fov <= around => {
                let whole = |step: f64| (step.to_degrees() * 8.0 - (step.to_degrees() * 8.0).round()).abs() < 0.01;
                let step = if count % 2 == 1 || whole(fov / gaps) { fov / gaps } else { fov / f64::from(count) };
                Ok(Some((step, "the log's PARAM laser_…_fov")))
            }
            _ => Err(()),
        }
    }
}

/// The beams of a layout, and a text about their source.
pub(super) fn resolve_beams(layout: &LaserLayout, parameters: &LaserParameters) -> (Beams, String) {
    let count = layout.count;
    if let Some((first, step)) = layout.beams {
        return (Beams { count, first, step }, "its messages".into());
    }
    let said = parameters.step(count);
    let known = KNOWN_LASERS.iter().find(|k| k.0 == count);
    let contradiction = match said {
        Err(()) => "; its PARAM laser_…_fov or laser_…_resolution doesn't fit that number",
        _ => "",
    };
    let (first, step, origin) = match (said, known) {
        (Ok(Some((step, origin))), _) => {
            let span = step * f64::from(count - 1);
            // The last beam may be missing.
            let whole = if count.is_multiple_of(2) { span + step } else { span };
            let first = if span > PI + step / 2.0 { -whole.min(2.0 * PI) / 2.0 } else { -PI / 2.0 };
            (first, step, origin.to_string())
        }
        (_, Some((_, step, first))) => {
            (first.to_radians(), step.to_radians(), format!("the number of beams{contradiction}"))
        }
        _ => {
            let gaps = if count.is_multiple_of(2) { count } else { count - 1 };
            let origin = format!("the assumption that so many fill 180°{contradiction}");
            (-PI / 2.0, PI / f64::from(gaps), origin)
        }
    };
    let gaps = if count.is_multiple_of(2) { count } else { count - 1 };
    let sure = (step * f64::from(gaps)).to_degrees() > 170.0;
    let ahead = (step * f64::from(count - 1)).to_degrees() / 2.0;
    let ahead = (ahead * 1e4).round() / 1e4;
    let doubt = format!("; if the laser looks straight ahead, --set first_beam=-{ahead}deg");
    (Beams { count, first, step }, if sure { origin } else { origin + &doubt })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::carmen::tag::Tag;

    fn beams(count: u32, lines: &[&str]) -> (f64, f64) {
        let mut all = [LaserParameters::default(); 2];
        lines.iter().for_each(|line| LaserParameters::read(&mut all, line));
        let tag = Tag::of("FLASER").unwrap();
        let (beams, _) = resolve_beams(&LaserLayout { tag, count, beams: None, cap: None, posed: true }, &all[0]);
        let round = |v: f64| (v.to_degrees() * 1e4).round() / 1e4;
        (round(beams.first), round(beams.step))
    }

    #[test]
    fn by_number() {
        for (count, first, step) in [
            (4, -90.0, 45.0),
            (5, -90.0, 45.0),
            (180, -90.0, 1.0),
            (181, -90.0, 1.0),
            (360, -90.0, 0.5),
            (361, -90.0, 0.5),
            (400, -90.0, 0.25),
            (401, -90.0, 0.25),
            (541, -135.0, 0.5),
            (683, -119.8828, 0.3516),
            (1081, -135.0, 0.25),
        ] {
            assert_eq!(beams(count, &[]), (first, step), "{count}");
        }
    }

    #[test]
    fn by_parameters() {
        let fov = |v: &str| format!("PARAM laser_front_laser_fov {v} nohost 0");
        let resolution = |v: &str| format!("PARAM laser_front_laser_resolution {v} nohost 0");
        for (count, fov, resolution, first, step) in [
            (401, fov("1.745329"), resolution("0.25"), -90.0, 0.25),
            (101, fov("100"), String::new(), -90.0, 1.0),
            (201, fov("100.0"), resolution("0.008726646"), -90.0, 0.5),
            (361, String::new(), resolution("0.5"), -90.0, 0.5),
            (360, fov("180"), String::new(), -90.0, 0.5),
            (726, fov("4.712389"), String::new(), -135.0, 0.3719),
            (1081, fov("270"), resolution("0.25"), -135.0, 0.25),
            // What doesn't fit the number of beams is not taken: 361 at 1° is half of what 180° would be.
            (361, fov("180"), resolution("1.0"), -90.0, 0.5),
        ] {
            let (first_is, step_is) = beams(count, &[&fov, &resolution]);
            assert!((first_is - first).abs() < 0.4 && (step_is - step).abs() < 1e-3, "{count}: {first_is} {step_is}");
        }
    }
}
