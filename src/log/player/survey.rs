//! The first pass over a Player log: the robot's poses, its sensors, and what is left out.

use super::message::{Payload, PlayerMessage, ScanLayout, parse_line};
use crate::Result;
use crate::log::input::Input;
use crate::log::reading::Pose;
use crate::log::sick::no_return_code;
use crate::log::text::for_each_line;
use crate::log::values::check_pose;
use crate::sensor::{Description, Kind};
use std::collections::BTreeMap;

/// The largest number of sensors of a log; a damaged log might name more.
const MAX_SENSORS: usize = 256;
/// A ranger with more elements than this is a laser.
const MAX_SONARS: usize = 32;
/// Half the width of a sonar's beam, radians (Pioneer's: 15°).
const HALF_WIDTH: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// A device whose messages are read.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Device {
    /// A laser, by its index and beam layout.
    Laser(u32, ScanLayout),
    /// A sonar of a ring: the ring's index, the sonar's number, and the number of sonars.
    Sonar(u32, usize, usize),
    /// A ranger that is a laser.
    RangerLaser(u32, usize),
    /// An element of a ranger.
    Ranger(u32, usize, usize),
}

pub(super) fn with_id(device: &Device, count: usize, description: &Description) -> Description {
    let id = match device {
        Device::Laser(index, layout) if count > 1 => format!("laser:{index}/{}", layout.count),
        Device::Laser(index, _) => format!("laser:{index}"),
        Device::Sonar(index, k, _) => format!("sonar:{index}/{k}"),
        Device::RangerLaser(index, _) => format!("ranger:{index}"),
        Device::Ranger(index, k, _) => format!("ranger:{index}/{k}"),
    };
    Description { id: Some(id), ..description.clone() }
}

/// The result of a first pass.
pub(super) struct PlayerSurvey {
    /// The robot whose messages come first.
    pub robot: Option<(String, String)>,
    pub positions: BTreeMap<u32, Vec<(f64, Pose)>>,
    /// Whether there are several position devices.
    pub several: bool,
    /// Whether scans carry the robot's pose.
    pub scan_poses: bool,
    /// Each sensor's device, the number of beam layouts of its laser, and its description.
    pub sensors: Vec<(Device, usize, Description)>,
    pub notes: Vec<String>,
}

impl PlayerSurvey {
    /// Reads the log through. `kind`: which sensors are wanted.
    pub fn of(input: &Input, kind: Option<Kind>) -> Result<PlayerSurvey> {
        let mut robot = None;
        let mut positions: BTreeMap<u32, Vec<(f64, Pose)>> = BTreeMap::new();
        let mut lasers: Vec<(u32, ScanLayout, f64)> = Vec::new();
        let mut places: BTreeMap<u32, Pose> = BTreeMap::new();
        let (mut rings, mut ring_places) = (BTreeMap::<u32, usize>::new(), BTreeMap::<u32, Vec<Pose>>::new());
        let (mut rangers, mut ranger_places) = (BTreeMap::<u32, usize>::new(), BTreeMap::new());
        let mut configs = BTreeMap::new();
        let (mut others, mut scan_poses) = (0u64, false);
        for_each_line(input, |line, _| {
            let Ok(Some(PlayerMessage { t, robot: from, index, what })) = parse_line(line) else { return true };
            if *robot.get_or_insert_with(|| from.clone()) != from {
                others += 1;
                return true;
            }
            match what {
                Payload::Position(pose) if check_pose("", &pose).is_ok() => {
                    positions.entry(index).or_default().push((t, pose));
                }
                Payload::Laser(layout, pose, ranges) => {
                    scan_poses |= pose.is_some();
                    let largest = ranges.iter().copied().filter(|z| z.is_finite()).fold(0.0, f64::max);
                    match lasers.iter().position(|(i, l, _)| *i == index && *l == layout) {
                        Some(at) => lasers[at].2 = lasers[at].2.max(largest),
                        None if lasers.len() < MAX_SENSORS => lasers.push((index, layout, largest)),
                        None => {}
                    }
                }
                Payload::LaserMount(place) => drop(places.insert(index, place)),
                Payload::Sonar(ranges) => drop(rings.entry(index).or_insert(ranges.len())),
                Payload::SonarMounts(all) => drop(ring_places.insert(index, all)),
                Payload::Ranger(ranges) => drop(rangers.entry(index).or_insert(ranges.len())),
                Payload::RangerMounts(base, all) => drop(ranger_places.insert(index, (base, all))),
                Payload::RangerConfig(angles, low, high) => drop(configs.insert(index, (angles, low, high))),
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
            let code = [1000.0, 100.0].iter().find_map(|per| Some(no_return_code((largest * per).round())? / per));
            let d = laser(places.get(index).copied().unwrap_or_default(), layout.cap.or(code), layout);
            let layouts = lasers.iter().filter(|(i, ..)| i == index).count();
            sensors.push((Device::Laser(*index, *layout), layouts, d));
        }
        for (index, count) in rings.iter().filter(|_| wanted(Kind::Sonar)) {
            match ring_places.get(index) {
                Some(all) if all.len() == *count && sensors.len() + count <= MAX_SENSORS => {
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
                Some((angles, low, high)) if *count > 1 && (elements.len() != *count || *count > MAX_SONARS) => {
                    let step = (angles[1] - angles[0]) / (*count as f64 - 1.0);
                    let layout = ScanLayout { count: *count as u32, first: angles[0], step, cap: Some(*high) };
                    let at = elements.first().filter(|_| elements.len() == 1).map_or(base, place);
                    let mut d = laser(at, layout.cap.filter(|cap| *cap > 0.1), &layout);
                    d.r_min = Some(*low).filter(|low| *low > 0.0 && low < high);
                    if wanted(Kind::Laser) && step != 0.0 && step.is_finite() {
                        sensors.push((Device::RangerLaser(*index, *count), 1, d));
                    }
                }
                config if elements.len() == *count && *count <= MAX_SONARS => {
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
        Ok(PlayerSurvey { robot, positions, several, scan_poses, sensors, notes })
    }
}

fn laser(place: Pose, r_max: Option<f64>, layout: &ScanLayout) -> Description {
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
