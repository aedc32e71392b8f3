//! Rows of a ROS topic as text: `rostopic echo -p` (CSV with a header `%time,field.…`), what bag converters write (the same names without
//! `field.`), and `ros2 topic echo --csv` (no header). LaserScan and Range are read; they carry no robot's pose, which `--poses` brings.

use super::cells::split_cells;
use super::format::{Format, LogPath, Probe, RecordQueue, Source};
use super::mounting::MountedSensor;
use super::opening::{lasers_only, require_file};
use super::scan::ScanHeader;
use super::text::{LineParser, TextLog, for_each_line};
use super::values::{parse_real, quote};
use crate::log::reading::Pose;
use crate::sensor::Kind;
use crate::{Error, Result};
use row::{Body, TopicLayout, cell};
use sensors::{TopicSensors, angles, describe, frame, ranges};
use std::collections::HashMap;
use std::sync::Arc;

pub(super) mod row;
mod sensors;

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
                        found.add(layout, line);
                    }
                }
                Some(layout) => found.add(layout, line),
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

/// The first line that is not empty.
pub(super) fn first_line(text: &str) -> Option<&str> {
    text.lines().find(|line| !line.trim().is_empty())
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
        let cells = split_cells(line, b',');
        if let Some(width) = self.layout.width.filter(|width| *width != cells.len()) {
            return Err(format!("expected {width} cells, found {}", cells.len()));
        }
        let t = self.layout.time(&cells)?;
        let name = frame(&self.layout, &cells);
        let Some(sensor) = self.frames.get(name).copied() else {
            // No valid row described this sensor, or it is of another kind.
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
