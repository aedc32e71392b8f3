//! Logs of Player's writelog driver: a message a line, `time host robot interface index type subtype …` (Player 2 and 3) or with the
//! data's time in place of type and subtype (Player 1). Lasers, sonars and rangers are read; poses come from position2d, taken at each
//! scan's time.

use super::format::{Format, Items, Mounted, Place, Probe, Source, check_pose};
use super::input::Input;
use super::text::{Parse, Scan, TextLog, file_of, look, sick_code};
use super::track::Track;
use crate::log::reading::Pose;
use crate::sensor::{Description, Kind};
use crate::{Error, Result};
use message::{Layout, Message, What};
use std::collections::BTreeMap;
use std::sync::Arc;

mod message;

/// No log has more sensors; a damaged one might.
const MOST_SENSORS: usize = 256;
/// A ranger of more elements is a laser.
const MOST_SONARS: usize = 32;
/// Half the width of a sonar's beam, radians (Pioneer's: 15°).
const HALF_WIDTH: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// The format.
pub(crate) struct Player;

impl Format for Player {
    fn name(&self) -> &'static str {
        "player"
    }

    fn looks(&self) -> &'static str {
        "a Player log (writelog: time host robot interface index …)"
    }

    fn claims(&self, probe: &Probe<'_>) -> bool {
        let Probe::Text(text) = probe else { return false };
        let first = text.lines().map(|l| l.trim_start_matches('#').trim()).find(|l| !l.is_empty()).unwrap_or_default();
        first.starts_with("Player version")
            || first.starts_with("Player log")
            || text.lines().filter(|line| !line.starts_with('#')).take(16).any(message::looks)
    }

    fn open(&self, place: &Place, kind: Option<Kind>) -> Result<Box<dyn Source>> {
        let input = file_of(place, "Player")?;
        let survey = Survey::of(input, kind)?;
        let (position, poses) = match survey.positions.into_iter().next() {
            Some((index, poses)) => (Some(index), poses),
            None => (None, Vec::new()),
        };
        if survey.sensors.is_empty() {
            let what = match kind {
                Some(Kind::Laser) => "a Player log without a laser's scans: leave out --sensor laser",
                Some(Kind::Sonar) => "a Player log without sonars that say where they sit: leave out --sensor sonar",
                None => {
                    "a Player log without laser, sonar or ranger messages that say where their beams look: nothing to map"
                }
            };
            return Err(Error::input(input.path(), what));
        }
        let mut notes = survey.notes;
        if let (Some(index), true) = (position, survey.several) {
            notes.push(format!("it has several position2d devices: poses are those of the first, position2d:{index}"));
        }
        Ok(Box::new(TextLog {
            input: input.clone(),
            sensors: survey.sensors.iter().map(|(device, count, d)| named(device, *count, d)).collect(),
            beams: survey.sensors.iter().any(|(_, _, d)| d.beams.is_some()),
            posed: position.is_some() || survey.scan_poses,
            notes,
            parse: Lines {
                devices: survey.sensors.iter().map(|(device, _, _)| device.clone()).collect(),
                robot: survey.robot,
                track: position.map(|_| Track::of(poses)),
                posed: survey.scan_poses,
                missed: 0,
                scan: 0,
            },
        }))
    }
}

/// A device whose messages are read.
#[derive(Debug, Clone, PartialEq)]
enum Device {
    /// A laser by its index and layout.
    Laser(u32, Layout),
    /// One of a ring's sonars: index, which, of how many.
    Sonar(u32, usize, usize),
    /// A ranger that is a laser.
    RangerLaser(u32, usize),
    /// An element of a ranger.
    Ranger(u32, usize, usize),
}

fn named(device: &Device, count: usize, description: &Description) -> Description {
    let id = match device {
        Device::Laser(index, layout) if count > 1 => format!("laser:{index}/{}", layout.count),
        Device::Laser(index, _) => format!("laser:{index}"),
        Device::Sonar(index, k, _) => format!("sonar:{index}/{k}"),
        Device::RangerLaser(index, _) => format!("ranger:{index}"),
        Device::Ranger(index, k, _) => format!("ranger:{index}/{k}"),
    };
    Description { id: Some(id), ..description.clone() }
}

/// What a first pass found.
struct Survey {
    /// The robot whose messages come first.
    robot: Option<(String, String)>,
    positions: BTreeMap<u32, Vec<(f64, Pose)>>,
    /// More than one position device.
    several: bool,
    /// Scans that carry the robot's pose.
    scan_poses: bool,
    /// Each sensor, and how many layouts its laser has.
    sensors: Vec<(Device, usize, Description)>,
    notes: Vec<String>,
}

impl Survey {
    fn of(input: &Input, kind: Option<Kind>) -> Result<Survey> {
        let mut robot = None;
        let mut positions: BTreeMap<u32, Vec<(f64, Pose)>> = BTreeMap::new();
        let mut lasers: Vec<(u32, Layout, f64)> = Vec::new();
        let mut places: BTreeMap<u32, Pose> = BTreeMap::new();
        let (mut rings, mut ring_places) = (BTreeMap::<u32, usize>::new(), BTreeMap::<u32, Vec<Pose>>::new());
        let (mut rangers, mut ranger_places) = (BTreeMap::<u32, usize>::new(), BTreeMap::new());
        let mut configs = BTreeMap::new();
        let (mut others, mut scan_poses) = (0u64, false);
        look(input, |line, _| {
            let Ok(Some(Message { t, robot: from, index, what })) = message(line) else { return true };
            if *robot.get_or_insert_with(|| from.clone()) != from {
                others += 1;
                return true;
            }
            match what {
                What::Position(pose) if check_pose("", &pose).is_ok() => {
                    positions.entry(index).or_default().push((t, pose));
                }
                What::Laser(layout, pose, ranges) => {
                    scan_poses |= pose.is_some();
                    let largest = ranges.iter().copied().filter(|z| z.is_finite()).fold(0.0, f64::max);
                    match lasers.iter().position(|(i, l, _)| *i == index && *l == layout) {
                        Some(at) => lasers[at].2 = lasers[at].2.max(largest),
                        None if lasers.len() < MOST_SENSORS => lasers.push((index, layout, largest)),
                        None => {}
                    }
                }
                What::LaserPlace(place) => drop(places.insert(index, place)),
                What::Sonar(ranges) => drop(rings.entry(index).or_insert(ranges.len())),
                What::SonarPlaces(all) => drop(ring_places.insert(index, all)),
                What::Ranger(ranges) => drop(rangers.entry(index).or_insert(ranges.len())),
                What::RangerPlaces(base, all) => drop(ranger_places.insert(index, (base, all))),
                What::RangerConfig(angles, low, high) => drop(configs.insert(index, (angles, low, high))),
                _ => {}
            }
            true
        })?;
        let mut sensors = Vec::new();
        let mut notes = Vec::new();
        let wanted = |k| kind.is_none_or(|kind| kind == k);
        if others > 0 {
            notes.push(format!("{others} messages of other robots were left out: a map is of one robot"));
        }
        for (index, layout, largest) in lasers.iter().filter(|_| wanted(Kind::Laser)) {
            let code = [1000.0, 100.0].iter().find_map(|per| Some(sick_code((largest * per).round())? / per));
            let d = laser(places.get(index).copied().unwrap_or_default(), layout.cap.or(code), layout);
            let layouts = lasers.iter().filter(|(i, ..)| i == index).count();
            sensors.push((Device::Laser(*index, *layout), layouts, d));
        }
        for (index, count) in rings.iter().filter(|_| wanted(Kind::Sonar)) {
            match ring_places.get(index) {
                Some(all) if all.len() == *count && sensors.len() + count <= MOST_SENSORS => {
                    for (k, place) in all.iter().enumerate() {
                        sensors.push((Device::Sonar(*index, k, *count), 1, sonar(*place)));
                    }
                }
                _ => notes
                    .push(format!("sonar:{index} is left out: the log has no geometry message for its {count} sonars")),
            }
        }
        for (index, count) in &rangers {
            let (base, elements) = ranger_places.get(index).cloned().unwrap_or_default();
            let place = |element: &Pose| base.compose(element.x, element.y, element.heading);
            match configs.get(index) {
                Some((angles, low, high)) if *count > 1 && (elements.len() != *count || *count > MOST_SONARS) => {
                    let step = (angles[1] - angles[0]) / (*count as f64 - 1.0);
                    let layout = Layout { count: *count as u32, first: angles[0], step, cap: Some(*high) };
                    let at = elements.first().filter(|_| elements.len() == 1).map_or(base, place);
                    let mut d = laser(at, layout.cap.filter(|cap| *cap > 0.1), &layout);
                    d.r_min = Some(*low).filter(|low| *low > 0.0 && low < high);
                    if wanted(Kind::Laser) && step != 0.0 && step.is_finite() {
                        sensors.push((Device::RangerLaser(*index, *count), 1, d));
                    }
                }
                config if elements.len() == *count && *count <= MOST_SONARS => {
                    for (k, element) in elements.iter().enumerate().filter(|_| wanted(Kind::Sonar)) {
                        let mut d = sonar(place(element));
                        d.r_max = config.map(|(_, _, high)| *high).filter(|high| *high > 0.2);
                        sensors.push((Device::Ranger(*index, k, *count), 1, d));
                    }
                }
                _ => notes
                    .push(format!("ranger:{index} is left out: nothing in the log says where its {count} beams look")),
            }
        }
        let several = positions.len() > 1;
        Ok(Survey { robot, positions, several, scan_poses, sensors, notes })
    }
}

fn laser(place: Pose, r_max: Option<f64>, layout: &Layout) -> Description {
    Description {
        kind: Some(Kind::Laser),
        x: Some(place.x),
        y: Some(place.y),
        axis: Some(place.heading),
        r_max,
        beams: Some(layout.count.max(2)),
        first: Some(layout.first),
        step: Some(layout.step),
        ..Description::default()
    }
}

fn sonar(place: Pose) -> Description {
    Description {
        kind: Some(Kind::Sonar),
        x: Some(place.x),
        y: Some(place.y),
        axis: Some(place.heading),
        half_width: Some(HALF_WIDTH),
        ..Description::default()
    }
}

/// A line's message; `None`: a comment.
fn message(line: &str) -> std::result::Result<Option<Message>, String> {
    match line.trim() {
        "" => Ok(None),
        text if text.starts_with('#') => Ok(None),
        text => message::parse(text).map(Some),
    }
}

#[derive(Clone)]
struct Lines {
    devices: Arc<[Device]>,
    robot: Option<(String, String)>,
    track: Option<Track>,
    /// Scans carry the robot's pose.
    posed: bool,
    missed: u64,
    scan: u64,
}

impl Parse for Lines {
    fn line(
        &mut self,
        line: &str,
        at: u64,
        sensors: &[Mounted],
        items: &mut Items,
    ) -> std::result::Result<bool, String> {
        let Some(Message { t, robot: from, index, what }) = message(line)? else { return Ok(true) };
        if self.robot.as_ref() != Some(&from) {
            return Ok(false);
        }
        let find = |wanted: &Device| self.devices.iter().position(|device| device == wanted);
        let (sensor, own, ranges) = match what {
            What::Laser(layout, pose, ranges) => (find(&Device::Laser(index, layout)), pose, ranges),
            What::Sonar(ranges) => (find(&Device::Sonar(index, 0, ranges.len())), None, ranges),
            What::Ranger(ranges) => {
                let laser = find(&Device::RangerLaser(index, ranges.len()));
                (laser.or_else(|| find(&Device::Ranger(index, 0, ranges.len()))), None, ranges)
            }
            What::Position(pose) => {
                check_pose("the robot's", &pose)?;
                return Ok(false);
            }
            _ => return Ok(false),
        };
        let Some(sensor) = sensor else { return Ok(false) };
        let robot = match (own, &self.track) {
            (Some(pose), _) => Some(pose),
            (None, Some(track)) => track.at(t),
            (None, None) if self.posed => return Err("a scan without a pose, in a log whose scans carry theirs".into()),
            (None, None) => Some(Pose::default()),
        };
        let Some(robot) = robot else {
            self.missed += 1;
            if let Some(track) = &self.track {
                track.count_missed(self.missed);
            }
            return Ok(false);
        };
        check_pose("the robot's", &robot)?;
        let scan = |sensor| Scan { t, number: self.scan, sensor, robot, given: None, line: at };
        match sensors.get(sensor).and_then(|m| m.beams) {
            Some(beams) => {
                let scan = scan(sensor);
                for (k, z) in ranges.iter().enumerate() {
                    scan.push(sensors, beams.first + k as f64 * beams.step, *z, items);
                }
            }
            None => {
                for (k, z) in ranges.iter().enumerate() {
                    scan(sensor + k).push(sensors, 0.0, *z, items);
                }
            }
        }
        self.scan += 1;
        Ok(true)
    }

    fn notes(&self) -> Vec<String> {
        self.track.iter().filter_map(|track| track.note("scans")).collect()
    }
}
