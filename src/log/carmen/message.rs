//! One line of a CARMEN log: its laser, beam layout, ranges and poses.

use super::tag::{Family, Tag};
use crate::log::reading::Pose;
use crate::log::values::{check_pose, parse_number, quote};

/// The beam layout of a laser, as far as its messages give it. Each layout is a sensor of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LaserLayout {
    /// The name of its messages.
    pub tag: Tag,
    /// Beams of a scan.
    pub count: u32,
    /// Bearing of the first beam from the laser's heading, and from one beam to the next, radians.
    pub beams: Option<(f64, f64)>,
    /// The maximum range that the message declares, metres.
    pub cap: Option<f64>,
    /// Whether its messages carry a pose.
    pub posed: bool,
}

/// The pose of a scan, as its message gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ScanPose {
    /// The laser's pose and the robot's.
    LaserAndRobot(Pose, Pose),
    /// One pose, and the odometry's heading: `FLASER`, `RLASER`, `LASER_READING`.
    LaserOnly(Pose, Option<f64>),
    /// The odometry messages give it.
    FromOdometry,
}

/// A laser message without its ranges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LaserMessage {
    pub layout: LaserLayout,
    pub place: ScanPose,
    /// Seconds; `None`: it has no time stamp.
    pub t: Option<f64>,
}

/// The content of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CarmenLine<'a> {
    /// A laser message.
    Laser(LaserMessage),
    /// A message with ranges that are not read, by its name.
    Unread(&'a str),
    /// Anything else.
    Other,
}

/// Parses a line. The ranges are written to `ranges`.
///
/// # Errors
/// A text that says why it is a bad line.
pub(super) fn parse<'a>(line: &'a str, ranges: &mut Vec<f64>) -> Result<CarmenLine<'a>, String> {
    let Some(word) = line.split_ascii_whitespace().next() else { return Ok(CarmenLine::Other) };
    let Some(tag) = Tag::of(word) else {
        let name = |b: u8| b.is_ascii_uppercase() || b.is_ascii_digit() || b == b'_';
        return match word {
            _ if word.starts_with('#') => Ok(CarmenLine::Other),
            _ if word.parse::<f64>().is_ok() => {
                Err(format!("begins with the number {}: is a message broken in two?", quote(word)))
            }
            _ if !word.bytes().all(name) => Err(format!("{} is no CARMEN message", quote(word))),
            _ if ["LASER", "SONAR", "VELODYNE"].iter().any(|part| word.contains(part)) => Ok(CarmenLine::Unread(word)),
            _ => Ok(CarmenLine::Other),
        };
    };
    let fields = MessageFields { tag, all: line.split_ascii_whitespace().collect() };
    let message = match tag.family {
        Family::Flat => fields.flat(ranges)?,
        Family::Reading => fields.reading(ranges)?,
        Family::Bare => fields.bare(2, None, ranges)?,
        // Old loggers left the remission mode out.
        Family::Robot | Family::Raw => match fields.configured(8, ranges) {
            Ok(message) => message,
            Err(what) => fields.configured(7, ranges).map_err(|_| what)?,
        },
    };
    if let Some(t) = message.t.filter(|t| !t.is_finite()) {
        return Err(format!("the time stamp is {t}"));
    }
    match &message.place {
        ScanPose::LaserAndRobot(laser, robot) => {
            check_pose("the laser's", laser)?;
            check_pose("the robot's", robot)?;
        }
        ScanPose::LaserOnly(laser, _) => check_pose("the laser's", laser)?,
        ScanPose::FromOdometry => {}
    }
    Ok(CarmenLine::Laser(message))
}

/// The largest span of beams, radians: a full circle and a margin.
const MAX_SPAN: f64 = 6.5;

struct MessageFields<'a> {
    tag: Tag,
    all: Vec<&'a str>,
}

impl MessageFields<'_> {
    fn at(&self, i: usize) -> Result<f64, String> {
        parse_number(i + 1, self.all.get(i).copied().unwrap_or_default())
    }

    fn pose(&self, i: usize) -> Result<Pose, String> {
        Ok(Pose { x: self.at(i)?, y: self.at(i + 1)?, heading: self.at(i + 2)? })
    }

    fn count(&self, i: usize) -> Result<u32, String> {
        match self.all.get(i) {
            Some(field) => field.parse().map_err(|_| format!("field {} is {}, not a count", i + 1, quote(field))),
            None => Err(format!("{} with only {} fields", self.tag, self.all.len())),
        }
    }

    /// The number of beams, two or more.
    fn beams(&self, i: usize) -> Result<u32, String> {
        match self.count(i)? {
            n if n < 2 => Err(format!("{} with {n} beams: their bearings are not defined", self.tag)),
            n => Ok(n),
        }
    }

    /// Reads the ranges.
    fn ranges(&self, first: usize, count: u32, ranges: &mut Vec<f64>) -> Result<(), String> {
        ranges.clear();
        for (i, field) in self.all.iter().enumerate().skip(first).take(count as usize) {
            ranges.push(parse_number(i + 1, field)?);
        }
        Ok(())
    }

    /// Checks the fields after the ranges: at least `least` numbers, and `most` before the host, the first field that is no number.
    fn tail(&self, start: usize, least: usize, most: usize, count: u32) -> Result<usize, String> {
        let found = self.all.len();
        if found < start.saturating_add(least) {
            // The whole message has the host and a second time stamp too.
            return Err(format!("expected {} fields for {count} beams, found {found}", start.saturating_add(most + 2)));
        }
        let tail = self.all.get(start..).unwrap_or_default();
        let odd = tail.iter().position(|field| field.parse::<f64>().is_err()).filter(|i| *i != most);
        if let Some(i) = odd {
            let (at, field) = (start + i + 1, tail.get(i).copied().unwrap_or_default());
            if !field.contains(',') && found < start + most + 2 {
                return Err(format!("expected {} fields for {count} beams, found {found}", start + most + 2));
            }
            if i > most {
                let place = start + most + 1;
                let field = quote(field);
                return Err(format!(
                    "the host {field} is field {at}, not {place}: are there more than {count} ranges?"
                ));
            }
            parse_number(at, field)?;
        }
        Ok(tail.len())
    }

    /// `FLASER n r… x y θ odom_x odom_y odom_θ t host t`; the oldest logs have no poses.
    fn flat(&self, ranges: &mut Vec<f64>) -> Result<LaserMessage, String> {
        let count = self.beams(1)?;
        let start = (count as usize).saturating_add(2);
        let host = self.all.get(start + 1).is_some_and(|f| f.parse::<f64>().is_err() && !f.contains(','));
        if host && self.all.len() <= start + 3 {
            return self.bare(2, None, ranges);
        }
        let tail = self.tail(start, 6, 7, count)?;
        let layout = LaserLayout { tag: self.tag, count, beams: None, cap: None, posed: true };
        let t = if tail > 6 { Some(self.at(start + 6)?) } else { None };
        self.ranges(2, count, ranges)?;
        Ok(LaserMessage { layout, place: ScanPose::LaserOnly(self.pose(start)?, Some(self.at(start + 5)?)), t })
    }

    /// `LASER_READING n r… x y θ t`, of GMapping's logs.
    fn reading(&self, ranges: &mut Vec<f64>) -> Result<LaserMessage, String> {
        let count = self.beams(1)?;
        let start = (count as usize).saturating_add(2);
        let tail = self.tail(start, 3, 4, count)?;
        let layout = LaserLayout { tag: self.tag, count, beams: None, cap: None, posed: true };
        self.ranges(2, count, ranges)?;
        let t = if tail > 3 { Some(self.at(start + 3)?) } else { None };
        Ok(LaserMessage { layout, place: ScanPose::LaserOnly(self.pose(start)?, None), t })
    }

    /// `LASER1 n r… t host t`, without a pose.
    fn bare(&self, first: usize, beams: Option<(f64, f64)>, ranges: &mut Vec<f64>) -> Result<LaserMessage, String> {
        let count = self.beams(first - 1)?;
        let start = (count as usize).saturating_add(first);
        self.tail(start, 1, 1, count)?;
        self.ranges(first, count, ranges)?;
        let layout = LaserLayout { tag: self.tag, count, beams, cap: None, posed: false };
        Ok(LaserMessage { layout, place: ScanPose::FromOdometry, t: Some(self.at(start)?) })
    }

    /// `ROBOTLASER1 type start fov step max accuracy mode n r… m remission… laser x y θ robot x y θ tv rv forward side turn t host t`
    /// and `RAWLASER1`, the same without what stands between the remissions and t. The number of beams is field `at`.
    fn configured(&self, at: usize, ranges: &mut Vec<f64>) -> Result<LaserMessage, String> {
        let count = self.beams(at)?;
        let first = at + 1;
        let end = first.saturating_add(count as usize);
        let missing = |more: usize| {
            let all = end.saturating_add(more);
            Err(format!("expected {all} fields for {count} beams, found {}", self.all.len()))
        };
        let robot = self.tag.family == Family::Robot;
        let between = if robot { 11 } else { 0 };
        if self.all.len() <= end {
            return missing(between + 4);
        }
        let after = end.saturating_add(1).saturating_add(self.count(end)? as usize);
        self.tail(after, between + 1, between + 1, count)?;
        let (start, step) = (self.at(2)?, self.at(4)?);
        if !(start.is_finite() && step.is_finite() && step != 0.0) {
            return Err(format!("start angle {start} or resolution {step} is no angle"));
        }
        if step.abs() * f64::from(count - 1) > MAX_SPAN || start.abs() > MAX_SPAN {
            return Err(format!(
                "{count} beams from {start} on, {step} apart, are more than once around: angles are in radians here"
            ));
        }
        let cap = Some(self.at(5)?).filter(|cap| *cap > 0.0);
        let layout = LaserLayout { tag: self.tag, count, beams: Some((start, step)), cap, posed: robot };
        let place = if robot {
            ScanPose::LaserAndRobot(self.pose(after)?, self.pose(after + 3)?)
        } else {
            ScanPose::FromOdometry
        };
        self.ranges(first, count, ranges)?;
        Ok(LaserMessage { layout, place, t: Some(self.at(after + between)?) })
    }
}
