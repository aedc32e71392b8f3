//! Poses from a second file (`--poses`): the robot's way by time, laid under a log's readings. Its rows are those of a ROS topic of
//! poses, a TUM trajectory (`t x y z qx qy qz qw`), `t x y heading`, or what `--pose-columns` names.

use super::Problem;
use super::format::{Items, Mounted, Scans, Source, check_pose, quote};
use super::input::Input;
use super::rostopic::Layout;
use super::table::{Columns, Rows, suggest};
use super::text::look;
use super::track::{Track, yaw};
use crate::log::reading::Pose;
use crate::sensor::Description;
use crate::{Error, Result};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A log whose readings get their poses from another file.
pub(super) struct Posed {
    source: Box<dyn Source>,
    input: Input,
    track: Track,
    notes: Vec<String>,
}

impl Posed {
    /// Reads the poses of `path`, and sees that its times are those of the log.
    pub fn of(source: Box<dyn Source>, sensors: &[Mounted], path: &Path, columns: Option<&str>) -> Result<Posed> {
        let input = Input::open(path, None)?;
        let (poses, mut notes) = read(&input, columns)?;
        let track = Track::of(poses);
        let Some((first, last)) = track.span() else { return Err(Error::input(path, "holds no pose")) };
        let mut scans = source.scans(sensors.into(), Arc::default())?;
        let mut items = Items::new();
        let (mut from, mut to, mut met) = (f64::INFINITY, f64::NEG_INFINITY, false);
        while !met && scans.fill(&mut items) {
            for item in items.drain(..) {
                match item {
                    Ok(record) => {
                        (from, to) = (from.min(record.t), to.max(record.t));
                        met |= track.at(record.t).is_some();
                    }
                    Err(Problem::Fatal(error)) => return Err(error),
                    Err(Problem::Line(_)) => {}
                }
            }
        }
        if from.is_finite() && !met {
            let what = format!(
                "its times and the log's don't meet: poses from {first:.3} to {last:.3} s, readings from {from:.3} to {to:.3} s; \
                 both must be of one clock, in seconds (name other units with --columns t:ms,… or --pose-columns t:ns,…)"
            );
            return Err(Error::input(path, what));
        }
        if source.has_poses() {
            notes.push(format!("the log's own poses are not used: {} gives them", path.display()));
        }
        Ok(Posed { source, input, track, notes })
    }
}

impl Source for Posed {
    fn sensors(&self) -> &[Description] {
        self.source.sensors()
    }

    fn sensor_line(&self) -> Option<u64> {
        self.source.sensor_line()
    }

    fn has_beams(&self) -> bool {
        self.source.has_beams()
    }

    fn has_preset(&self) -> bool {
        self.source.has_preset()
    }

    fn classes(&self) -> &[String] {
        self.source.classes()
    }

    fn beams_origin(&self, sensor: usize) -> Option<(String, bool)> {
        self.source.beams_origin(sensor)
    }

    fn silence(&self, sensor: usize) -> Option<String> {
        self.source.silence(sensor)
    }

    fn notes(&self) -> Vec<String> {
        let own = self.notes.iter().cloned().chain(self.track.note("readings"));
        self.source.notes().into_iter().chain(own).collect()
    }

    fn inputs(&self) -> Vec<&Input> {
        self.source.inputs().into_iter().chain([&self.input]).collect()
    }

    fn scans(&self, sensors: Arc<[Mounted]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn Scans>> {
        let scans = self.source.scans(sensors, ignored.clone())?;
        Ok(Box::new(Pass { scans, track: self.track.clone(), inner: Items::new(), missed: 0, ignored }))
    }
}

struct Pass {
    scans: Box<dyn Scans>,
    track: Track,
    inner: Items,
    missed: u64,
    ignored: Arc<AtomicU64>,
}

impl Scans for Pass {
    fn fill(&mut self, items: &mut Items) -> bool {
        let more = self.scans.fill(&mut self.inner);
        let (mut last, mut robot) = (f64::NAN, None);
        let before = self.missed;
        for item in self.inner.drain(..) {
            let mut record = match item {
                Ok(record) => record,
                Err(problem) => {
                    items.push_back(Err(problem));
                    continue;
                }
            };
            if record.t != last {
                (last, robot) = (record.t, self.track.at(record.t));
            }
            let Some(pose) = robot else {
                self.missed += 1;
                continue;
            };
            record.pose = carried(&record.robot, &record.pose, &pose);
            record.robot = pose;
            items.push_back(Ok(record));
        }
        if self.missed > before {
            self.track.count_missed(self.missed);
            self.ignored.fetch_add(1, Ordering::Relaxed);
        }
        more
    }
}

/// Where a sensor comes to be when its robot is put elsewhere.
fn carried(from: &Pose, sensor: &Pose, to: &Pose) -> Pose {
    let (dx, dy) = (sensor.x - from.x, sensor.y - from.y);
    let (s, c) = from.heading.sin_cos();
    to.compose(c * dx + s * dy, c * dy - s * dx, sensor.heading - from.heading)
}

/// Times beyond this are nanoseconds: in seconds they would be three thousand million years.
const NANOSECONDS: f64 = 1e17;

/// How a row gives its pose.
enum Way {
    Topic(Layout),
    /// t x y z and a quaternion; of how many the quaternion tips the robot over.
    Tum(u64),
    Columns(Columns, Rows),
}

/// Poses with their times, seconds, and what to say of them.
type Read = (Vec<(f64, Pose)>, Vec<String>);

/// All poses of a file.
fn read(input: &Input, columns: Option<&str>) -> Result<Read> {
    let mut poses = Vec::new();
    let (mut bad, mut first_bad) = (0u64, String::new());
    let mut way: Option<Way> = None;
    let mut fault = None;
    let mut notes = Vec::new();
    look(input, |line, number| {
        let text = line.trim();
        if text.is_empty() || text.starts_with('#') {
            return true;
        }
        if way.is_none() {
            match begin(text, columns) {
                Ok((found, named)) => {
                    let header = match &found {
                        Way::Topic(layout) => layout.header,
                        Way::Tum(_) => false,
                        Way::Columns(..) => named,
                    };
                    if let (Way::Columns(columns, _), None) = (&found, columns) {
                        notes.push(format!("its columns are taken to be {columns} (--pose-columns says otherwise)"));
                    }
                    way = Some(found);
                    if header {
                        return true;
                    }
                }
                Err(what) => {
                    fault = Some(Error::at(input.path(), number, what));
                    return false;
                }
            }
        }
        let Some(way) = &mut way else { return true };
        match pose(way, text).and_then(|(t, pose)| check_pose("the robot's", &pose).map(|()| (t, pose))) {
            Ok(found) => poses.push(found),
            Err(what) => {
                bad += 1;
                if first_bad.is_empty() {
                    first_bad = format!("line {number}: {what}");
                }
            }
        }
        true
    })?;
    if let Some(error) = fault {
        return Err(error);
    }
    if poses.is_empty() {
        let what = if bad > 0 { format!("holds no pose: {first_bad}") } else { "holds no pose".into() };
        return Err(Error::input(input.path(), what));
    }
    if let Some(Way::Tum(tipped)) = way
        && 4 * tipped > poses.len() as u64
    {
        notes.push(format!(
            "{tipped} of its {} quaternions tip the robot over: TUM's order is qx qy qz qw; where w stands first, move it to the end",
            poses.len()
        ));
    }
    let name = input.path().display();
    let mut all: Vec<String> = notes.into_iter().map(|note| format!("{name}: {note}")).collect();
    if bad > 0 {
        all.push(format!("{name}: {bad} lines are no poses and were left out; the first is {first_bad}"));
    }
    Ok((poses, all))
}

/// What the first line tells; `true` with it: that line is one of names.
fn begin(line: &str, columns: Option<&str>) -> std::result::Result<(Way, bool), String> {
    if let Some(spec) = columns {
        let columns = Columns::parse(spec)?;
        columns.gives_poses()?;
        let rows = Rows::of(line);
        let named = rows.is_header(line, &columns);
        return Ok((Way::Columns(columns, rows), named));
    }
    if let Some(layout) = Layout::of(line) {
        return match layout.pose(&[]) {
            Some(_) => Ok((Way::Topic(layout), false)),
            None => Err("is a topic of readings, not of poses: record the robot's poses (such as /odom) too".into()),
        };
    }
    let rows = Rows::of(line);
    let cells = rows.split(line);
    let named = cells.iter().any(|cell| super::text::real(cell).is_none());
    let spec = match (named, cells.len()) {
        (false, 8) => return Ok((Way::Tum(0), false)),
        (false, 4) => "t,x,y,heading".to_string(),
        (true, _) => suggest::spec(&cells),
        (false, n) => {
            return Err(format!(
                "{n} columns: what they are isn't known; name them with --pose-columns, such as t,x,y,heading:deg"
            ));
        }
    };
    match Columns::parse(&spec).and_then(|columns| columns.gives_poses().map(|()| columns)) {
        Ok(columns) => Ok((Way::Columns(columns, rows), named)),
        Err(_) => Err(format!(
            "{} is no row of poses that is known; name its columns: --pose-columns {spec} (it needs t, x, y and heading)",
            quote(line)
        )),
    }
}

fn pose(way: &mut Way, line: &str) -> std::result::Result<(f64, Pose), String> {
    match way {
        Way::Topic(layout) => {
            let cells: Vec<&str> = line.split(',').map(|cell| cell.trim().trim_matches('"')).collect();
            let pose = layout.pose(&cells).ok_or("no pose")??;
            Ok((layout.time(&cells)?, pose))
        }
        Way::Tum(tipped) => {
            let cells = line.split(|c: char| c == ',' || c.is_whitespace()).filter(|cell| !cell.is_empty());
            let values: Option<Vec<f64>> = cells.map(super::text::real).collect();
            match values.as_deref() {
                Some([t, x, y, _, qx, qy, qz, qw]) if t.is_finite() => {
                    *tipped += u64::from(qx * qx + qy * qy > qz * qz + qw * qw);
                    let seconds = if *t > NANOSECONDS { t / 1e9 } else { *t };
                    Ok((seconds, Pose { x: *x, y: *y, heading: yaw(*qx, *qy, *qz, *qw) }))
                }
                _ => Err("expected t x y z qx qy qz qw".into()),
            }
        }
        Way::Columns(columns, rows) => rows.pose(line, columns),
    }
}
