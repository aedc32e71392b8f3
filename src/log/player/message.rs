//! One line of a Player log: its device, its time and its data.

use crate::log::reading::Pose;
use crate::log::track::yaw;
use crate::log::values::{parse_number, quote};

/// The beam layout of a laser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ScanLayout {
    pub count: u32,
    /// Bearing of the first beam and from one to the next, radians.
    pub first: f64,
    pub step: f64,
    /// The declared maximum range, metres.
    pub cap: Option<f64>,
}

/// The data of a message.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Payload {
    /// The robot's pose.
    Position(Pose),
    /// A laser's scan, with the robot's pose if it carries it.
    Laser(ScanLayout, Option<Pose>, Vec<f64>),
    /// A laser's pose on the robot.
    LaserMount(Pose),
    /// The ranges of a ring of sonars.
    Sonar(Vec<f64>),
    /// The poses of a ring's sonars on the robot.
    SonarMounts(Vec<Pose>),
    /// The ranges of a ranger, Player 3's interface for lasers and sonars.
    Ranger(Vec<f64>),
    /// The poses of a ranger and of its elements.
    RangerMounts(Pose, Vec<Pose>),
    /// First and last bearing, step, smallest and largest range of a ranger.
    RangerConfig([f64; 3], f64, f64),
    /// Anything else.
    Other,
}

/// A message.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlayerMessage {
    /// Seconds.
    pub t: f64,
    /// The host and robot it comes from.
    pub robot: (String, String),
    /// The device's index among those of its interface.
    pub index: u32,
    pub what: Payload,
}

/// Whether a line begins like a message of a Player log.
pub(super) fn is_player_line(line: &str) -> bool {
    let fields: Vec<&str> = line.split_ascii_whitespace().take(6).collect();
    let kinds =
        ["position2d", "position", "laser", "sonar", "ranger", "localize", "power", "wifi", "gps", "blobfinder"];
    matches!(fields[..], [time, _, _, interface, index, _]
        if time.parse::<f64>().is_ok() && kinds.contains(&interface) && index.parse::<u32>().is_ok())
}

/// A line's message; `None`: a comment.
pub(super) fn parse_line(line: &str) -> Result<Option<PlayerMessage>, String> {
    match line.trim() {
        "" => Ok(None),
        text if text.starts_with('#') => Ok(None),
        text => parse(text).map(Some),
    }
}

/// Parses a line that is no comment.
fn parse(line: &str) -> Result<PlayerMessage, String> {
    let fields: Vec<&str> = line.split_ascii_whitespace().collect();
    let [time, host, robot, interface, index, rest @ ..] = &fields[..] else {
        return Err("expected time, host, robot, interface and index".into());
    };
    let index = index.parse().map_err(|_| format!("field 5 is {}, not an index", quote(index)))?;
    let mut t = parse_number(1, time)?;
    // Player 1 has the time of the data where later ones have the message's type and subtype.
    let old = rest.first().is_some_and(|field| field.contains('.'));
    let (kind, payload) = match (old, rest) {
        (true, [data, payload @ ..]) => {
            t = parse_number(6, data)?;
            ((1, 1), payload)
        }
        (false, [kind, subtype, payload @ ..]) => match (kind.parse::<u32>(), subtype.parse::<u32>()) {
            (Ok(kind), Ok(subtype)) => ((kind, subtype), payload),
            _ => return Err(format!("{} {} is no type and subtype", quote(kind), quote(subtype))),
        },
        _ => return Err("ends before its type and subtype".into()),
    };
    if !t.is_finite() {
        return Err(format!("the time stamp is {t}"));
    }
    let known = matches!(*interface, "position2d" | "position" | "laser" | "sonar" | "ranger");
    let what = match known {
        false => Payload::Other,
        true => {
            let first = if old { 7 } else { 8 };
            let values = payload.iter().enumerate().map(|(i, field)| parse_number(first + i, field));
            what(interface, kind, old, &values.collect::<Result<Vec<f64>, String>>()?)?
        }
    };
    Ok(PlayerMessage { t, robot: (host.to_string(), robot.to_string()), index, what })
}

fn what(interface: &str, kind: (u32, u32), old: bool, v: &[f64]) -> Result<Payload, String> {
    let short = || format!("a {interface} message with only {} numbers", v.len());
    let pose = |v: &[f64]| match v {
        [x, y, heading, ..] => Ok(Pose { x: *x, y: *y, heading: *heading }),
        _ => Err(short()),
    };
    Ok(match (interface, kind) {
        ("position2d" | "position", (1, 1)) => Payload::Position(pose(v)?),
        ("laser", (1, 1)) => laser(v, 0)?,
        ("laser", (1, 2)) => match (laser(v, 3)?, pose(v.get(1..).unwrap_or_default())?) {
            (Payload::Laser(layout, _, ranges), pose) => Payload::Laser(layout, Some(pose), ranges),
            (other, _) => other,
        },
        ("laser", (4, 1)) => Payload::LaserMount(pose(v)?),
        // Player 1 writes its sonars in several ways.
        ("sonar", (1, 1)) if old => Payload::Other,
        ("sonar", (1, 1)) => Payload::Sonar(counted(v, 1)?.concat()),
        ("sonar", (1, 2) | (4, 1)) => {
            // Player 3 gives places in space: x y z and three angles.
            let width = if v.len() > 1 && (v.len() - 1) as f64 == 6.0 * v[0] { 6 } else { 3 };
            Payload::SonarMounts(counted(v, width)?.iter().map(|place| space(place)).collect())
        }
        ("ranger", (1, 1 | 2)) => {
            let count = *v.first().ok_or_else(short)? as usize;
            Payload::Ranger(v.get(1..count.saturating_add(1)).ok_or_else(short)?.to_vec())
        }
        ("ranger", (4, _)) if (6..=7).contains(&v.len()) => {
            // A smallest range came with Player 3.1.
            let (low, high) = if v.len() == 7 { (v[3], v[4]) } else { (0.0, v[3]) };
            Payload::RangerConfig([v[0], v[1], v[2]], low, high)
        }
        ("ranger", (4, _)) if v.len() >= 10 => {
            let count = (v[9] as usize).saturating_mul(6).saturating_add(10);
            let elements = v.get(10..count).ok_or_else(short)?;
            Payload::RangerMounts(space(&v[..6]), elements.chunks_exact(6).map(space).collect())
        }
        _ => Payload::Other,
    })
}

/// x y heading, or x y z roll pitch yaw.
fn space(v: &[f64]) -> Pose {
    match *v {
        [x, y, _, roll, pitch, turn] => {
            let half = |a: f64| (0.5 * a).sin_cos();
            let ((sr, cr), (sp, cp), (sy, cy)) = (half(roll), half(pitch), half(turn));
            let heading = yaw(
                sr * cp * cy - cr * sp * sy,
                cr * sp * cy + sr * cp * sy,
                cr * cp * sy - sr * sp * cy,
                cr * cp * cy + sr * sp * sy,
            );
            Pose { x, y, heading }
        }
        [x, y, heading] => Pose { x, y, heading },
        _ => Pose::default(),
    }
}

/// Groups of `width` numbers, after their count.
fn counted(v: &[f64], width: usize) -> Result<Vec<&[f64]>, String> {
    let count = *v.first().ok_or("a message without its count")?;
    let rest = v.get(1..).unwrap_or_default();
    if rest.len() as f64 != count * width as f64 {
        return Err(format!("expected {count} times {width} numbers, found {}", rest.len()));
    }
    Ok(rest.chunks_exact(width).collect())
}

/// A laser scan: [scan id,] [pose,] first, last, step [, largest range], count, then range and intensity of each beam.
fn laser(v: &[f64], pose: usize) -> Result<Payload, String> {
    for (at, cap) in [(1 + pose, true), (pose, true), (pose, false)] {
        let count_at = at + 3 + usize::from(cap);
        let Some(count) = v.get(count_at).copied().filter(|n| n.fract() == 0.0 && (1.0..1e6).contains(n)) else {
            continue;
        };
        let readings = v.get(count_at + 1..).unwrap_or_default();
        if readings.len() as f64 != 2.0 * count {
            continue;
        }
        let (first, last, step) = (v[at], v[at + 1], v[at + 2]);
        if !(first.is_finite() && step.is_finite() && step != 0.0) {
            return Err(format!("first bearing {first} or step {step} is no angle"));
        }
        // Old logs write the step with few digits; first and last bearing are more exact.
        let spread = (last - first) / (count - 1.0).max(1.0);
        let step = if (spread - step).abs() < 0.02 * step.abs() { spread } else { step };
        let cap = cap.then(|| v[at + 3]).filter(|cap| *cap > 0.1);
        let layout = ScanLayout { count: count as u32, first, step, cap };
        return Ok(Payload::Laser(layout, None, readings.iter().step_by(2).copied().collect()));
    }
    Err(format!("{} numbers don't fit the count of readings among them", v.len()))
}
