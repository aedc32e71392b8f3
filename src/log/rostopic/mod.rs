//! Rows of a ROS topic as text: `rostopic echo -p` (CSV with a header `%time,field.…`), what bag converters write (the same names without
//! `field.`), and `ros2 topic echo --csv` (no header). LaserScan and Range are read; they carry no robot's pose, which `--poses` brings.

use super::format::{Format, LogPath, Probe, RecordQueue, Source};
use super::mounting::MountedSensor;
use super::opening::{lasers_only, require_file};
use super::scan::ScanHeader;
use super::text::{LineParser, TextLog, for_each_line};
use super::values::{parse_real, quote};
use crate::log::reading::Pose;
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use row::{Body, TopicLayout, cell};
use std::collections::HashMap;
use std::sync::Arc;

pub(super) mod row;

/// No log has more sensors; a damaged one might.
const MAX_SENSORS: usize = 256;

/// The format.
pub(crate) struct RosTopic;

impl Format for RosTopic {
    fn name(&self) -> &'static str {
        "rostopic"
    }

    fn describe(&self) -> &'static str {
        "a ROS topic as CSV (rostopic echo -p, ros2 topic echo --csv: LaserScan or Range, with --poses)"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        matches!(probe, Probe::Text(text) if first_line(text).and_then(TopicLayout::of).is_some())
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = require_file(place, "ROS topic")?;
        let fail = |what: &str| Error::input(input.path(), what);
        let mut layout = None;
        let mut found = TopicSensors::default();
        for_each_line(input, |line, _| {
            if line.trim().is_empty() {
                return true;
            }
            match &layout {
                None => {
                    layout = TopicLayout::of(line);
                    if let Some(layout) = layout.as_ref().filter(|layout| !layout.header) {
                        found.row(layout, line);
                    }
                }
                Some(layout) => found.row(layout, line),
            }
            layout.is_some()
        })?;
        let layout = layout.ok_or_else(|| fail("no row of a ROS topic"))?;
        match layout.body {
            Body::Pose(_) => {
                let what =
                    "holds poses, no ranges: map the file of the scans (or ranges), and give this one with --poses";
                return Err(fail(what));
            }
            Body::Scan(..) | Body::OpenScan(..) => lasers_only(input, kind, "LaserScan")?,
            Body::Range(..) => {}
        }
        if found.sensors.is_empty() {
            return Err(fail("has no row with readings"));
        }
        if let Some(kind) = kind {
            found.sensors.retain(|(_, d)| d.kind == Some(kind));
            if found.sensors.is_empty() {
                return Err(fail("holds no readings of this kind: leave out --sensor"));
            }
        }
        let beams = !matches!(layout.body, Body::Range(..));
        let names: Vec<&str> = found.sensors.iter().map(|(name, _)| name.as_str()).collect();
        let note = format!(
            "the file doesn't say where its sensors sit ({}): they are taken to be at the robot's centre, looking forward; a \
             sensor file says otherwise (--sensor-file)",
            names.join(", ")
        );
        Ok(Box::new(TextLog {
            input: input.clone(),
            beams,
            posed: false,
            notes: vec![note],
            parser: TopicParser {
                layout: Arc::new(layout),
                frames: Arc::new((0..).zip(&found.sensors).map(|(i, (name, _))| (name.clone(), i)).collect()),
                begun: false,
                scan: 0,
            },
            sensors: found.sensors.into_iter().map(|(_, description)| description).collect(),
        }))
    }
}

/// The first line that holds something.
pub(super) fn first_line(text: &str) -> Option<&str> {
    text.lines().find(|line| !line.trim().is_empty())
}

fn split(line: &str) -> Vec<&str> {
    line.split(',').map(|cell| cell.trim().trim_matches('"')).collect()
}

/// The name of a row's frame.
fn frame<'a>(layout: &TopicLayout, cells: &[&'a str]) -> &'a str {
    match layout.frame.and_then(|i| cells.get(i)) {
        Some(name) if !name.is_empty() => name,
        _ => "sensor",
    }
}

/// The sensors, by their frames, as their first rows describe them.
#[derive(Default)]
struct TopicSensors {
    sensors: Vec<(String, Description)>,
}

impl TopicSensors {
    fn row(&mut self, layout: &TopicLayout, line: &str) {
        let cells = split(line);
        let name = frame(layout, &cells);
        if self.sensors.iter().any(|(known, _)| known == name) || self.sensors.len() >= MAX_SENSORS {
            return;
        }
        if let Ok(description) = describe(layout, &cells, name) {
            self.sensors.push((name.into(), description));
        }
    }
}

fn describe(layout: &TopicLayout, cells: &[&str], name: &str) -> std::result::Result<Description, String> {
    let limits = |low: f64, high: f64| {
        let fine = low >= 0.0 && high > low && high < 1e6;
        (Some(low).filter(|low| fine && *low > 0.0), Some(high).filter(|_| fine))
    };
    let id = Some(name.to_string());
    match &layout.body {
        Body::Scan(head, _) | Body::OpenScan(head, _) => {
            let [first, step, low, high] = angles(cells, head)?;
            let (r_min, r_max) = limits(low, high);
            let count = ranges(layout, cells)?.len() as u32;
            let (beams, first, step) = (Some(count.max(2)), Some(first), Some(step));
            Ok(Description { id, kind: Some(Kind::Laser), r_min, r_max, beams, first, step, ..Description::default() })
        }
        Body::Range([fov, low, high, z], radiation) => {
            cell(cells, *z, "the range")?;
            let infrared = radiation.is_some_and(|i| cell(cells, i, "radiation_type") == Ok(1.0));
            let (r_min, r_max) = limits(cell(cells, *low, "min_range")?, cell(cells, *high, "max_range")?);
            let half_width = Some(cell(cells, *fov, "field_of_view")? / 2.0).filter(|w| (0.001..=1.04).contains(w));
            let kind = Some(if infrared { Kind::Laser } else { Kind::Sonar });
            Ok(Description { id, kind, r_min, r_max, half_width, ..Description::default() })
        }
        Body::Pose(_) => Err("a pose".into()),
    }
}

fn angles(cells: &[&str], head: &[usize; 4]) -> std::result::Result<[f64; 4], String> {
    let names = ["angle_min", "angle_increment", "range_min", "range_max"];
    let mut values = [0.0; 4];
    for ((value, i), name) in values.iter_mut().zip(head).zip(names) {
        *value = cell(cells, *i, name)?;
    }
    if !(values[0].is_finite() && values[1].is_finite() && values[1] != 0.0) {
        return Err(format!("angle_min {} or angle_increment {} is no angle", values[0], values[1]));
    }
    Ok(values)
}

/// The cells of a row that are its ranges.
fn ranges<'a, 'b>(layout: &TopicLayout, cells: &'b [&'a str]) -> std::result::Result<&'b [&'a str], String> {
    match &layout.body {
        Body::Scan(_, range) => cells.get(range.clone()).ok_or_else(|| "ends before its last range".to_string()),
        Body::OpenScan([first, step, ..], from) => {
            // angle_max stands between the two.
            let [a, b, s] = [*first, first + 1, *step].map(|i| cell(cells, i, "the angles"));
            let count = ((b? - a?) / s?).round() + 1.0;
            let rest = cells.get(*from..).unwrap_or_default();
            let fits = |found: usize| (found as f64 - count).abs() <= 1.0;
            match rest.len() {
                found if fits(found) => Ok(rest),
                found if found.is_multiple_of(2) && fits(found / 2) => Ok(&rest[..found / 2]),
                found => Err(format!(
                    "expected about {count} ranges as its angles say, and as many intensities or none, found {found} cells"
                )),
            }
        }
        _ => Ok(&[]),
    }
}

#[derive(Clone)]
struct TopicParser {
    layout: Arc<TopicLayout>,
    frames: Arc<HashMap<String, usize>>,
    begun: bool,
    scan: u64,
}

impl LineParser for TopicParser {
    fn parse_line(
        &mut self,
        line: &str,
        at: u64,
        sensors: &[MountedSensor],
        items: &mut RecordQueue,
    ) -> std::result::Result<bool, String> {
        if line.trim().is_empty() {
            return Ok(true);
        }
        let header = self.layout.header && (!self.begun || line.trim_start().starts_with("%time"));
        self.begun = true;
        if header {
            return Ok(true);
        }
        let cells = split(line);
        if let Some(width) = self.layout.width.filter(|width| *width != cells.len()) {
            return Err(format!("expected {width} cells, found {}", cells.len()));
        }
        let t = self.layout.time(&cells)?;
        let name = frame(&self.layout, &cells);
        let Some(sensor) = self.frames.get(name).copied() else {
            // Its first row was no better; or it is of the other kind.
            describe(&self.layout, &cells, name)?;
            return Ok(false);
        };
        let scan = ScanHeader { t, number: self.scan, sensor, robot: Pose::default(), given: None, line: at };
        match &self.layout.body {
            Body::Scan(head, _) | Body::OpenScan(head, _) => {
                let [mut first, mut step, ..] = angles(&cells, head)?;
                // A sensor file may lay out the beams otherwise than the first row did.
                if let Some(beams) = sensors.get(sensor).filter(|m| m.placed).and_then(|m| m.beams) {
                    (first, step) = (beams.first, beams.step);
                }
                for (k, text) in ranges(&self.layout, &cells)?.iter().enumerate() {
                    let range =
                        parse_real(text).ok_or_else(|| format!("range {k} is {}, not a number", quote(text)))?;
                    scan.push(sensors, first + k as f64 * step, range, items);
                }
            }
            Body::Range([.., z], _) => scan.push(sensors, 0.0, cell(&cells, *z, "the range")?, items),
            Body::Pose(_) => return Ok(false),
        }
        self.scan += 1;
        Ok(true)
    }
}
