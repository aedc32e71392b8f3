//! The columns of a ROS topic: from the header that `rostopic echo -p` and bag converters write, or, for `ros2 topic echo --csv`, which
//! writes none, from the order of the message's fields.

use crate::log::cells::split_cells;
use crate::log::reading::Pose;
use crate::log::track::yaw;
use crate::log::values::{parse_real, quote};
use std::borrow::Cow;
use std::ops::Range;

/// The columns of a row's time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TimeColumns {
    /// One column, with its units per second; where it is 0, the second column counts.
    One(usize, Option<usize>, f64),
    /// Columns of seconds and nanoseconds.
    Two(usize, usize),
}

/// The columns of a message's data.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Body {
    /// A laser scan: first bearing, step, smallest and largest range, and the ranges.
    Scan([usize; 4], Range<usize>),
    /// A scan with a number of ranges that only its row gives: the first range's column; as many intensities may follow.
    OpenScan([usize; 4], usize),
    /// A range: its field of view, smallest and largest range, range, and kind of radiation.
    Range([usize; 4], Option<usize>),
    /// A pose: x, y and a quaternion.
    Pose([usize; 6]),
}

/// The columns of a topic's rows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TopicLayout {
    pub time: TimeColumns,
    /// The column of the frame's name.
    pub frame: Option<usize>,
    pub(super) body: Body,
    /// Whether the file has a line of names.
    pub header: bool,
    /// Cells of a row; `None`: any number.
    pub width: Option<usize>,
}

/// A column's name without the decoration of the different tools: `%`, `field.`, brackets.
fn plain(name: &str) -> String {
    let name = name.trim().trim_start_matches(['%', '\u{feff}', '#']).trim().trim_matches('"');
    let name = name.strip_prefix("field.").or_else(|| name.strip_prefix('.')).unwrap_or(name);
    name.to_ascii_lowercase().replace(['[', ']'], "")
}

impl TopicLayout {
    /// From the first line of a file; `None`: it is no row of a ROS topic.
    pub fn of(line: &str) -> Option<TopicLayout> {
        let cells = split_cells(line, b',');
        if cells.len() < 5 {
            return None;
        }
        TopicLayout::named(&cells).or_else(|| TopicLayout::bare(&cells))
    }

    fn named(cells: &[Cow<'_, str>]) -> Option<TopicLayout> {
        let names: Vec<String> = cells.iter().map(|cell| plain(cell)).collect();
        let find = |name: &str| names.iter().position(|n| n == name);
        let end = |name: &str| names.iter().position(|n| n.ends_with(name));
        let body = scan_body(&names, &find).or_else(|| {
            let range = find("range").zip(find("field_of_view")).zip(find("min_range").zip(find("max_range")));
            let range = range.map(|((z, fov), (low, high))| Body::Range([fov, low, high, z], find("radiation_type")));
            range.or_else(|| {
                let at = |p: &str, q: &str| {
                    let p = |axis: &str| end(&format!("{p}.{axis}"));
                    let q = |axis: &str| end(&format!("{q}.{axis}"));
                    Some(Body::Pose([p("x")?, p("y")?, q("x")?, q("y")?, q("z")?, q("w")?]))
                };
                at("position", "orientation").or_else(|| at("translation", "rotation"))
            })
        })?;
        let receipt = find("time");
        let nanoseconds = |name: &str| end(name).zip(end(&name.replace("secs", "nsecs")));
        let two = nanoseconds("stamp.secs").or_else(|| end("stamp.sec").zip(end("stamp.nanosec")));
        let time = match (two, end("header.stamp"), receipt) {
            (Some((s, ns)), ..) => TimeColumns::Two(s, ns),
            (None, Some(stamp), receipt) => TimeColumns::One(stamp, receipt, 1e9),
            // A receipt in whole nanoseconds, or in seconds: bagpy's Time.
            (None, None, Some(at)) => TimeColumns::One(at, None, if cells[at].starts_with('%') { 1e9 } else { 1.0 }),
            (None, None, None) => return None,
        };
        Some(TopicLayout { time, frame: end("header.frame_id"), body, header: true, width: Some(cells.len()) })
    }

    /// A row of `ros2 topic echo --csv`: seconds, nanoseconds, the frame's name, then the message's fields.
    fn bare(cells: &[Cow<'_, str>]) -> Option<TopicLayout> {
        let number = |i: usize| cells.get(i).and_then(|cell| parse_real(cell));
        let whole = |i: usize| number(i).is_some_and(|v| v >= 0.0 && v.fract() == 0.0);
        let unnamed = |i: usize| number(i).is_none();
        if !(whole(0) && whole(1) && number(1)? < 1e9 && unnamed(2)) {
            return None;
        }
        let numbers = |range: Range<usize>| range.into_iter().all(|i| number(i).is_some());
        let time = TimeColumns::Two(0, 1);
        let layout = |body, width| Some(TopicLayout { time, frame: Some(2), body, header: false, width });
        let unit = |i: usize| {
            let length: f64 = (i..i + 4).filter_map(number).map(|q| q * q).sum();
            (length - 1.0).abs() < 0.01
        };
        let n = cells.len();
        let beams = || Some(((number(4)? - number(3)?) / number(5)?).round() + 1.0);
        // Pose, Odometry and Transform: a position in space and a quaternion.
        if n >= 11 && unnamed(3) && numbers(4..11) && unit(7) {
            return layout(Body::Pose([4, 5, 7, 8, 9, 10]), Some(n));
        }
        if (n == 10 || n == 46) && numbers(3..10) && unit(6) {
            return layout(Body::Pose([3, 4, 6, 7, 8, 9]), Some(n));
        }
        if n > 11 && numbers(3..n) {
            let ranges = n - 10;
            let fits = beams()
                .is_some_and(|b| [ranges as f64, ranges as f64 / 2.0].iter().any(|found| (found - b).abs() <= 1.0));
            if fits {
                return layout(Body::OpenScan([3, 5, 8, 9], 10), None);
            }
        }
        if (n == 8 || n == 9) && numbers(3..n) && matches!(number(3), Some(0.0 | 1.0)) {
            return layout(Body::Range([4, 5, 6, 7], Some(3)), Some(n));
        }
        None
    }

    /// The time of a row, seconds.
    pub fn time(&self, cells: &[Cow<'_, str>]) -> Result<f64, String> {
        let at = |i: usize| cell(cells, i, "the time");
        let t = match self.time {
            TimeColumns::One(first, second, per) => match (at(first)?, second) {
                (0.0, Some(second)) => at(second)? / per,
                (t, _) => t / per,
            },
            TimeColumns::Two(seconds, nanoseconds) => at(seconds)? + at(nanoseconds)? / 1e9,
        };
        if t.is_finite() { Ok(t) } else { Err(format!("the time is {t}")) }
    }

    /// The pose of a row; `None`: the topic has no poses.
    pub fn pose(&self, cells: &[Cow<'_, str>]) -> Option<Result<Pose, String>> {
        let Body::Pose(at) = &self.body else { return None };
        let read = || {
            let [x, y, qx, qy, qz, qw] = at.map(|i| cell(cells, i, "the pose"));
            let (qx, qy, qz, qw) = (qx?, qy?, qz?, qw?);
            let length = (qx * qx + qy * qy + qz * qz + qw * qw).sqrt();
            if (length - 1.0).abs() > 0.1 {
                return Err(format!("the orientation ({qx}, {qy}, {qz}, {qw}) is no unit quaternion"));
            }
            Ok(Pose { x: x?, y: y?, heading: yaw(qx / length, qy / length, qz / length, qw / length) })
        };
        Some(read())
    }
}

/// The columns of a scan, by their names.
fn scan_body(names: &[String], find: &dyn Fn(&str) -> Option<usize>) -> Option<Body> {
    let head = [find("angle_min")?, find("angle_increment")?, find("range_min")?, find("range_max")?];
    let numbered = |name: &String| {
        let rest = name.strip_prefix("ranges")?;
        rest.trim_start_matches(['_', '.']).parse::<usize>().ok()
    };
    let first = names.iter().position(|name| numbered(name) == Some(0))?;
    let count = names.get(first..)?.iter().enumerate().take_while(|(i, name)| numbered(name) == Some(*i)).count();
    Some(Body::Scan(head, first..first + count))
}

/// The number in cell `i` of a row.
///
/// # Errors
/// A text that names the cell, counted from 1; `what` is the value's name.
pub(super) fn cell(cells: &[Cow<'_, str>], i: usize, what: &str) -> Result<f64, String> {
    let text = cells.get(i).map_or("", |cell| cell);
    parse_real(text).ok_or_else(|| format!("{what} (cell {}) is {}, not a number", i + 1, quote(text)))
}
