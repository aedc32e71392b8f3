//! Logs in MATLAB's and Octave's files, with variables named by `--fields` or recognised by their names.

use super::array::Array;
use super::fields;
use super::scan_data::{HALF_WIDTH, ScanData};
use crate::log::format::{RecordQueue, ScanReader, Source};
use crate::log::input::Input;
use crate::log::mounting::MountedSensor;
use crate::log::problem::{BadLine, Problem};
use crate::log::scan::ScanHeader;
use crate::log::values::check_pose;
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Opens a log of these variables; `given`: the text of `--fields`.
///
/// # Errors
/// [`Error::Usage`] if `given` is wrong; [`Error::Input`] if the variables make no log.
pub(super) fn open(
    input: &Input,
    variables: &[(String, Array)],
    given: Option<&str>,
    kind: Option<Kind>,
) -> Result<Box<dyn Source>> {
    let (line, plain, note) = fields::guess(variables);
    let named = match (given, plain) {
        (Some(given), _) => fields::parse(given).map_err(|what| Error::Usage(format!("--fields {given}: {what}")))?,
        (None, true) => fields::parse(&line).map_err(|what| Error::input(input.path(), what))?,
        (None, false) => {
            return Err(Error::input(
                input.path(),
                format!(
                    "which of its variables are the poses and the scans isn't plain; it holds {}. Name them, such as --fields {line} \
                     (docs/formats.md)",
                    fields::list(variables)
                ),
            ));
        }
    };
    let data = ScanData::of(variables, &named).map_err(|what| {
        let how = if given.is_some() { String::new() } else { format!(" (--fields {line})") };
        Error::input(input.path(), format!("{what}{how}; it holds {}", fields::list(variables)))
    })?;
    let kind = kind.unwrap_or(Kind::Laser);
    let laser = Description {
        id: Some("laser".into()),
        kind: Some(kind),
        half_width: (kind == Kind::Laser).then(|| data.half_width().unwrap_or(HALF_WIDTH.to_radians())),
        r_max: data.r_max,
        x: data.mount.map(|mount| mount.x),
        y: data.mount.map(|mount| mount.y),
        axis: data.mount.map(|mount| mount.heading),
        ..Description::default()
    };
    let mut notes = Vec::new();
    if given.is_none() {
        notes.push(format!("its variables are read as --fields {line}"));
        notes.extend(note);
    }
    Ok(Box::new(NamedLog { input: input.clone(), data: Arc::new(data), sensors: vec![laser], notes }))
}

struct NamedLog {
    input: Input,
    data: Arc<ScanData>,
    sensors: Vec<Description>,
    notes: Vec<String>,
}

impl Source for NamedLog {
    fn sensors(&self) -> &[Description] {
        &self.sensors
    }

    fn has_beams(&self) -> bool {
        false
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[MountedSensor]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>> {
        Ok(Box::new(NamedReader { data: self.data.clone(), next: 0, sensors, ignored }))
    }
}

struct NamedReader {
    data: Arc<ScanData>,
    next: usize,
    sensors: Arc<[MountedSensor]>,
    ignored: Arc<AtomicU64>,
}

impl ScanReader for NamedReader {
    fn fill(&mut self, items: &mut RecordQueue) -> bool {
        let Some(robot) = self.data.poses.get(self.next) else { return false };
        let (number, line) = (self.next as u64, self.next as u64 + 1);
        let t = self.data.times.get(self.next).copied().unwrap_or(number as f64);
        let read = match check_pose("the robot's", robot) {
            Err(what) => Err(what),
            Ok(()) if !t.is_finite() => Err(format!("t is {t}")),
            Ok(()) => self.data.scan(self.next),
        };
        self.next += 1;
        let bad = |what: String| Err(Problem::Line(BadLine { line, what: format!("scan {line}: {what}") }));
        let readings = match read {
            Ok(readings) => readings,
            Err(what) => {
                items.push_back(bad(what));
                return true;
            }
        };
        if readings.is_empty() {
            self.ignored.fetch_add(1, Ordering::Relaxed);
        }
        let scan = ScanHeader { t, number, sensor: 0, robot: *robot, given: None, line };
        for (off, range, label) in readings {
            let label = match label {
                None => None,
                Some(label) if label.fract() == 0.0 && (1.0..65536.0).contains(&label) => Some(label as u16),
                Some(label) => {
                    items.push_back(bad(format!("label {label}: labels are whole numbers from 1")));
                    continue;
                }
            };
            if !off.is_finite() {
                items.push_back(bad("a point that is not finite".into()));
                continue;
            }
            scan.push(&self.sensors, off, range, items);
            if let (Some(Ok(record)), Some(_)) = (items.back_mut(), label) {
                record.label = label;
            }
        }
        true
    }
}
