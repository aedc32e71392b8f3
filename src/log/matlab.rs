//! MATLAB's `.mat` files, version 5, with laser scans as hit points: `robotPose`, a struct of x, y and h, a number a scan;
//! `laserScan`, a cell a scan, of 2 × N hit points in the robot's frame, or 3 × N with class labels in the third row.
//!
//! Files with other variables are read by `--fields` (`fields`, `plot`, `named`), and so are Octave's text files (`octave`).
//! A "line" of such a log is a scan, counted from 1.

use super::format::{Format, Items, Mounted, Place, Probe, Scans, Source, check_pose, lasers_only, quote};
use super::input::Input;
use super::lines::unreadable;
use super::text::file_of;
use super::{BadLine, Problem};
use crate::log::classes::Classes;
use crate::log::reading::{Pose, Record};
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use array::{Array, Variables};
use std::io::Read;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

mod array;
mod bytes;
mod fields;
mod named;
mod octave;
mod plot;

/// Half the usual beam spacing of such lasers, degrees.
const HALF_WIDTH: f64 = 0.5;

/// The format.
pub(crate) struct Matlab;

impl Format for Matlab {
    fn name(&self) -> &'static str {
        "matlab"
    }

    fn looks(&self) -> &'static str {
        "a MATLAB .mat file (version 5 to 7) of poses and scans"
    }

    fn claims(&self, probe: &Probe<'_>) -> bool {
        matches!(probe, Probe::Text(text) if text.starts_with("MATLAB 5.0 MAT-file") || text.starts_with("MATLAB 7.3 MAT-file"))
    }

    fn open(&self, place: &Place, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = file_of(place, ".mat")?;
        let bytes = whole(input)?;
        let fail = |what: String| Error::input(input.path(), what);
        let found = array::read(&bytes, &["robotPose", "laserScan"]).map_err(fail)?;
        if found.wanted.is_empty() && !found.names.is_empty() {
            return named::open(input, &array::read_all(&bytes).map_err(fail)?, None, kind);
        }
        lasers_only(input, kind, self.name())?;
        Ok(Box::new(MatLog::of(input, found).map_err(fail)?))
    }
}

/// The format of Octave's text files.
pub(crate) struct Octave;

impl Format for Octave {
    fn name(&self) -> &'static str {
        "octave"
    }

    fn looks(&self) -> &'static str {
        "an Octave text file (save -text) of poses and scans"
    }

    fn claims(&self, probe: &Probe<'_>) -> bool {
        matches!(probe, Probe::Text(text) if octave::looks(text))
    }

    fn open(&self, place: &Place, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = file_of(place, "Octave")?;
        named::open(input, &variables(input)?, None, kind)
    }
}

/// Opens a MATLAB or Octave file whose variables are named by `--fields`; gives the format's name too.
pub(super) fn open_fields(place: &Place, text: &str, kind: Option<Kind>) -> Result<(&'static str, Box<dyn Source>)> {
    let input = file_of(place, ".mat")?;
    let head = input.head()?;
    let head = String::from_utf8_lossy(&head);
    let probe = Probe::Text(&head);
    let format: &dyn Format = if Octave.claims(&probe) { &Octave } else { &Matlab };
    if !format.claims(&probe) {
        let what = format!(
            "--fields {text}: {} is no MATLAB or Octave file; of a table, --columns names the columns",
            input.path().display()
        );
        return Err(Error::Usage(what));
    }
    Ok((format.name(), named::open(input, &variables(input)?, Some(text), kind)?))
}

/// All variables of a MATLAB or Octave file.
fn variables(input: &Input) -> Result<Vec<(String, Array)>> {
    let bytes = whole(input)?;
    let fail = |what: String| Error::input(input.path(), what);
    match bytes.starts_with(b"MATLAB") {
        true => array::read_all(&bytes).map_err(fail),
        false => {
            if bytes.len() as u64 > array::LARGEST {
                return Err(fail("is more than 512 MiB to read: save fewer scans in a file".into()));
            }
            let text = std::str::from_utf8(&bytes).map_err(|e| fail(format!("is not UTF-8 text: {e}")))?;
            octave::read(text).map_err(fail)
        }
    }
}

/// A file's bytes, up to what is read at most.
fn whole(input: &Input) -> Result<Vec<u8>> {
    let fail = |what: String| Error::input(input.path(), what);
    let mut bytes = Vec::new();
    let read = input.reader()?.take(array::LARGEST + 1).read_to_end(&mut bytes);
    read.map_err(|e| unreadable(input.path(), None, &e))?;
    if bytes.starts_with(b"MATLAB 7.3") {
        let what = "is a version 7.3 file (HDF5): load it in MATLAB and save it with save(name, '-v7')";
        return Err(fail(what.into()));
    }
    Ok(bytes)
}

/// A scan: the robot's pose, and the points that it hit, with labels.
type Points = (Pose, Array);

struct MatLog {
    input: Input,
    scans: Arc<Vec<Points>>,
    sensors: Vec<Description>,
    classes: Vec<String>,
}

impl MatLog {
    fn of(input: &Input, found: Variables) -> std::result::Result<MatLog, String> {
        let Variables { mut wanted, names } = found;
        let asked =
            [("robotPose", "a struct of x, y and h"), ("laserScan", "a cell of 2 × N or 3 × N points for each scan")];
        let missing: Vec<String> = asked
            .iter()
            .filter(|(name, _)| !wanted.contains_key(*name))
            .map(|(name, what)| format!("{name} ({what})"))
            .collect();
        let (Some(pose), Some(scans)) = (wanted.remove("robotPose"), wanted.remove("laserScan")) else {
            return Err(format!("has no variable {}; it holds {}", missing.join(" and no "), list(&names)));
        };
        let Array::Struct(fields) = pose else {
            return Err(format!("robotPose is {pose}, not a struct of x, y and h"));
        };
        let missing: Vec<&str> =
            ["x", "y", "h"].into_iter().filter(|name| fields.iter().all(|(n, _)| n != name)).collect();
        if !missing.is_empty() {
            let there: Vec<String> = fields.iter().map(|(n, _)| n.clone()).collect();
            return Err(format!("robotPose has no field {}; it has {}", missing.join(" and no "), list(&there)));
        }
        let column = |name: &str| match fields.iter().find(|(n, _)| n == name) {
            Some((_, Array::Numbers { values, .. })) => Ok(values),
            Some((_, other)) => Err(format!("robotPose.{name} is {other}, not numbers")),
            None => Err(format!("robotPose has no field {name}")),
        };
        let (x, y, h) = (column("x")?, column("y")?, column("h")?);
        let Array::Cells(cells) = scans else { return Err(format!("laserScan is {scans}, not a cell of scans")) };
        if [x.len(), y.len(), h.len()] != [cells.len(); 3] {
            let (x, y, h, n) = (x.len(), y.len(), h.len(), cells.len());
            return Err(format!("robotPose has {x} x, {y} y and {h} h for {n} scans in laserScan: as many are wanted"));
        }
        let labelled = cells.iter().any(|c| matches!(c, Array::Numbers { rows: 3, .. }));
        let rooms = Classes::rooms().map_err(|e| e.to_string())?;
        let classes = if labelled { rooms.names[..rooms.count()].to_vec() } else { Vec::new() };
        let poses = x.iter().zip(y).zip(h).map(|((x, y), h)| Pose { x: *x, y: *y, heading: *h });
        let laser = Description {
            id: Some("laser".into()),
            kind: Some(Kind::Laser),
            half_width: Some(HALF_WIDTH.to_radians()),
            ..Description::default()
        };
        Ok(MatLog { input: input.clone(), scans: Arc::new(poses.zip(cells).collect()), sensors: vec![laser], classes })
    }
}

/// Names as a file has them, for a message.
fn list(names: &[String]) -> String {
    const SHOWN: usize = 16;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|n| quote(n)).collect();
    match names.len() {
        0 => "nothing".into(),
        n if n > SHOWN => format!("{} and {} more", shown.join(", "), n - SHOWN),
        _ => shown.join(", "),
    }
}

impl Source for MatLog {
    fn sensors(&self) -> &[Description] {
        &self.sensors
    }

    fn has_beams(&self) -> bool {
        false
    }

    fn classes(&self) -> &[String] {
        &self.classes
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.input]
    }

    fn scans(&self, sensors: Arc<[Mounted]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn Scans>> {
        Ok(Box::new(Pass { scans: self.scans.clone(), next: 0, sensors, ignored }))
    }
}

struct Pass {
    scans: Arc<Vec<Points>>,
    next: usize,
    sensors: Arc<[Mounted]>,
    ignored: Arc<AtomicU64>,
}

impl Scans for Pass {
    fn fill(&mut self, items: &mut Items) -> bool {
        let Some((robot, points)) = self.scans.get(self.next) else { return false };
        let (scan, line) = (self.next as u64, self.next as u64 + 1);
        self.next += 1;
        let bad = |what: String| Err(Problem::Line(BadLine { line, what: format!("scan {line}: {what}") }));
        if let Err(what) = check_pose("the robot's", robot) {
            items.push_back(bad(what));
            return true;
        }
        match points {
            // A scan without a beam says nothing.
            Array::Numbers { values, .. } if values.is_empty() => {
                self.ignored.fetch_add(1, Ordering::Relaxed);
            }
            Array::Numbers { rows: rows @ (2 | 3), values } => {
                for (beam, point) in values.chunks_exact(*rows).enumerate() {
                    match record(&self.sensors, robot, point, scan) {
                        Ok(record) => items.push_back(Ok(record)),
                        Err(what) => items.push_back(bad(format!("beam {}: {what}", beam + 1))),
                    }
                }
            }
            other => items.push_back(bad(format!("{other}, not 2 × N or 3 × N points"))),
        }
        true
    }
}

fn record(sensors: &[Mounted], robot: &Pose, point: &[f64], scan: u64) -> std::result::Result<Record, String> {
    let label = match point.get(2) {
        None => None,
        Some(label) if label.fract() == 0.0 && (1.0..65536.0).contains(label) => Some(*label as u16),
        Some(label) => return Err(format!("label {label}: labels are whole numbers from 1")),
    };
    if !(point[0].is_finite() && point[1].is_finite()) {
        return Err(format!("({}, {}) is no point", point[0], point[1]));
    }
    let mounted = sensors.first().ok_or("no sensor")?;
    let off = point[1].atan2(point[0]);
    let given = Pose { heading: robot.heading + off, ..*robot };
    Ok(Record {
        t: scan as f64,
        scan,
        sensor: 0,
        robot: *robot,
        pose: mounted.pose(robot, Some(given), if mounted.placed { off } else { 0.0 }),
        range: point[0].hypot(point[1]),
        label,
        line: scan + 1,
    })
}
