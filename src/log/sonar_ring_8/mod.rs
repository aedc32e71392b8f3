//! `sonar_ring_8`: a folder with a file of readings (`sonar.txt` or `measurement.txt`; `laser.txt` for the laser) and a file
//! of poses (`od.txt` or `poses.txt`), one row a scan in both: `t_ms r1 … rn` in mm, and `t_ms x_mm y_mm theta` with theta
//! in 0.1°. The files carry no sensor description: presets do.

use super::format::{Format, LogPath, Probe, RecordQueue, ScanReader, Source};
use super::input::Input;
use super::mounting::MountedSensor;
use super::problem::{BadLine, Problem};
use super::values::check_pose;
use crate::log::reading::{Pose, Record};
use crate::sensor::{Description, Kind, preset};
use crate::{Error, Result};
use rows::{Row, RowMatch, RowReader};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

mod rows;

const SONAR: &[&str] = &["sonar.txt", "measurement.txt"];
const LASER: &[&str] = &["laser.txt"];
const POSES: &[&str] = &["od.txt", "poses.txt"];
/// The sonars' code for "no echo", mm.
const SONAR_NO_ECHO: f64 = 5110.0;
/// The laser's, mm.
const LASER_NO_RETURN: f64 = 81910.0;

/// The format.
pub(crate) struct SonarRing8;

impl Format for SonarRing8 {
    fn name(&self) -> &'static str {
        "sonar_ring_8"
    }

    fn describe(&self) -> &'static str {
        "a sonar_ring_8 folder (sonar.txt or measurement.txt or laser.txt, with od.txt or poses.txt)"
    }

    fn sniff(&self, probe: &Probe<'_>) -> bool {
        match probe {
            Probe::Folder(folder) => [SONAR, LASER, POSES].iter().any(|names| find(folder, names).is_some()),
            // A single file of such a log is recognised too, so that the message can ask for its folder.
            Probe::Text(text) => text.lines().next().is_some_and(|line| {
                let fields: Vec<&str> = line.split_ascii_whitespace().collect();
                matches!(fields.len(), 4 | 9 | 362) && fields.iter().all(|f| f.parse::<i64>().is_ok())
            }),
        }
    }

    fn open(&self, place: &LogPath, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let folder = match place {
            LogPath::Folder(folder) => folder,
            LogPath::File(input) => {
                let what = "one file of a sonar_ring_8 log: name the folder that holds it, with readings and poses; or, if it is \
                            another table, name its columns with --columns (docs/formats.md)";
                return Err(Error::input(input.path(), what));
            }
        };
        let open = |names: &[&str], what: &str| match find(folder, names) {
            Some(path) => Input::open(&path, None),
            None => {
                Err(Error::input(folder, format!("a sonar_ring_8 log without its {what}: no {}", names.join(" or "))))
            }
        };
        let laser = kind == Some(Kind::Laser);
        if kind.is_none() && find(folder, SONAR).is_none() && find(folder, LASER).is_some() {
            let what = "a sonar_ring_8 log without sonar.txt: say --sensor laser to map its laser.txt";
            return Err(Error::input(folder, what));
        }
        let readings = if laser { open(LASER, "laser readings")? } else { open(SONAR, "sonar readings")? };
        let poses = open(POSES, "poses")?;
        let sensors = preset(if laser { "sonar_ring_8.laser" } else { "sonar_ring_8" })?;
        Ok(Box::new(RingLog { readings, poses, sensors, laser }))
    }
}

fn find(folder: &Path, names: &[&str]) -> Option<std::path::PathBuf> {
    names.iter().map(|name| folder.join(name)).find(|path| path.is_file())
}

struct RingLog {
    readings: Input,
    poses: Input,
    sensors: Vec<Description>,
    laser: bool,
}

impl Source for RingLog {
    fn sensors(&self) -> &[Description] {
        &self.sensors
    }

    fn has_beams(&self) -> bool {
        self.laser
    }

    fn has_preset(&self) -> bool {
        true
    }

    fn notes(&self) -> Vec<String> {
        let growing = self.readings.grown() || self.poses.grown();
        growing
            .then(|| "rows at the end of one file that have no partner in the other yet are left out".into())
            .into_iter()
            .collect()
    }

    fn inputs(&self) -> Vec<&Input> {
        vec![&self.readings, &self.poses]
    }

    fn scans(&self, sensors: Arc<[MountedSensor]>, _ignored: Arc<AtomicU64>) -> Result<Box<dyn ScanReader>> {
        let columns = match sensors.first().and_then(|m| m.beams) {
            Some(beams) => beams.count as usize,
            None => sensors.len(),
        };
        let readings = RowReader::new(&self.readings, columns)?;
        let poses = RowReader::new(&self.poses, 3)?;
        Ok(Box::new(RingReader { sensors, readings, poses, scan: 0 }))
    }
}

struct RingReader {
    sensors: Arc<[MountedSensor]>,
    readings: RowReader,
    poses: RowReader,
    scan: u64,
}

impl ScanReader for RingReader {
    fn fill(&mut self, items: &mut RecordQueue) -> bool {
        let (readings, poses) = (&mut self.readings, &mut self.poses);
        if let Some(error) = readings.fatal().or_else(|| poses.fatal()) {
            items.push_back(Err(Problem::Fatal(error)));
            return true;
        }
        match rows::next_match(readings, poses) {
            RowMatch::End => return false,
            RowMatch::Unmatched(line, what) => items.push_back(Err(Problem::Line(BadLine { line, what }))),
            RowMatch::Pair(reading, pose) => {
                let made = match (&reading.values, &pose.values) {
                    (Err(what), _) => Err((reading.line, format!("{}: {what}", readings.name))),
                    (_, Err(what)) => Err((pose.line, format!("{}: {what}", poses.name))),
                    (Ok(ranges), Ok(at)) => scan(&self.sensors, self.scan, &reading, ranges, at, items)
                        .map_err(|what| (pose.line, format!("{}: {what}", poses.name))),
                };
                match made {
                    Ok(()) => self.scan += 1,
                    Err((line, what)) => items.push_back(Err(Problem::Line(BadLine { line, what }))),
                }
            }
        }
        true
    }
}

/// The records of one scan.
fn scan(
    sensors: &[MountedSensor],
    scan: u64,
    row: &Row,
    ranges: &[f64],
    at: &[f64],
    items: &mut RecordQueue,
) -> std::result::Result<(), String> {
    let at = |i: usize| at.get(i).copied().unwrap_or(f64::NAN);
    let robot = Pose { x: at(0) / 1000.0, y: at(1) / 1000.0, heading: (at(2) / 10.0).to_radians() };
    check_pose("the robot's", &robot)?;
    let laser = sensors.first().and_then(|m| m.beams);
    let none = if laser.is_some() { LASER_NO_RETURN } else { SONAR_NO_ECHO };
    for (k, mm) in ranges.iter().enumerate() {
        let (sensor, off) = match laser {
            Some(beams) => (0, beams.first + k as f64 * beams.step),
            None => (k, 0.0),
        };
        let Some(mounted) = sensors.get(sensor) else { break };
        items.push_back(Ok(Record {
            t: row.t / 1000.0,
            scan,
            sensor: sensor as u32,
            robot,
            pose: mounted.pose(&robot, None, off),
            range: if *mm == none { f64::INFINITY } else { mm / 1000.0 },
            label: None,
            line: row.line,
        }));
    }
    Ok(())
}
