//! Poses from a second file (`--poses`), which replace those of a log. Its rows are those of a ROS topic of poses, a TUM trajectory
//! (`t x y z qx qy qz qw`), `t x y heading`, or the columns of `--pose-columns`.

use super::format::{RecordQueue, ScanReader, Source};
use super::input::Input;
use super::mounting::MountedSensor;
use super::problem::Problem;
use super::track::PoseTrack;
use crate::log::reading::Pose;
use crate::sensor::Description;
use crate::{Error, Result};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

mod file;

/// A log whose readings get their poses from another file.
pub(super) struct PosedLog {
    source: Box<dyn Source>,
    input: Input,
    track: PoseTrack,
    notes: Vec<String>,
}

impl PosedLog {
    /// Reads the poses of `path`, and checks that their times overlap the log's.
    ///
    /// # Errors
    /// [`Error::Input`] if the file can't be read, holds no pose, or its times do not overlap the log's.
    pub fn of(
        source: Box<dyn Source>,
        sensors: &[MountedSensor],
        path: &Path,
        columns: Option<&str>,
    ) -> Result<PosedLog> {
        let input = Input::open(path, None)?;
        let (poses, mut notes) = file::read_poses(&input, columns)?;
        let track = PoseTrack::of(poses);
        let Some((first, last)) = track.span() else { return Err(Error::input(path, "holds no pose")) };
        let mut scans = source.scans(sensors.into(), Arc::default())?;
        let mut items = RecordQueue::new();
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
        Ok(PosedLog { source, input, track, notes })
    }
}

impl Source for PosedLog {
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

    fn no_return_note(&self, sensor: usize) -> Option<String> {
        self.source.no_return_note(sensor)
    }

    fn notes(&self) -> Vec<String> {
        let own = self.notes.iter().cloned().chain(self.track.note("readings"));
        self.source.notes().into_iter().chain(own).collect()
    }

    fn inputs(&self) -> Vec<&Input> {
        self.source.inputs().into_iter().chain([&self.input]).collect()
    }

    fn scans(&self, sensors: Arc<[MountedSensor]>, ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>> {
        let scans = self.source.scans(sensors, ignored.clone())?;
        Ok(Box::new(PosedReader { scans, track: self.track.clone(), inner: RecordQueue::new(), missed: 0, ignored }))
    }
}

struct PosedReader {
    scans: Box<dyn ScanReader>,
    track: PoseTrack,
    inner: RecordQueue,
    missed: u64,
    ignored: Arc<AtomicU64>,
}

impl ScanReader for PosedReader {
    fn fill(&mut self, items: &mut RecordQueue) -> bool {
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
            record.pose = carried_pose(&record.robot, &record.pose, &pose);
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

/// The sensor's pose when the robot moves from one pose to another.
fn carried_pose(from: &Pose, sensor: &Pose, to: &Pose) -> Pose {
    let (dx, dy) = (sensor.x - from.x, sensor.y - from.y);
    let (s, c) = from.heading.sin_cos();
    to.compose(c * dx + s * dy, c * dy - s * dx, sensor.heading - from.heading)
}
