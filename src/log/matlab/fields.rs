//! The variables of a MATLAB or Octave file: named by `--fields`, or guessed by their names and sizes.

use super::array::Array;
use super::element::ReadResult;
use crate::log::table::columns::{ColumnRole, scale};
use crate::log::values::quote;
use crate::support::suggest::similar;

/// The keys of `--fields`, and the units of their numbers.
pub(super) const KEYS: [(&str, Option<ColumnRole>); 14] = [
    ("pose", Some(ColumnRole::Ph)),
    ("x", Some(ColumnRole::Px)),
    ("y", Some(ColumnRole::Py)),
    ("heading", Some(ColumnRole::Ph)),
    ("ranges", Some(ColumnRole::Range)),
    ("angles", Some(ColumnRole::Angle)),
    ("first", Some(ColumnRole::Angle)),
    ("step", Some(ColumnRole::Angle)),
    ("fov", Some(ColumnRole::Angle)),
    ("points", Some(ColumnRole::Range)),
    ("t", Some(ColumnRole::T)),
    ("r_max", Some(ColumnRole::Range)),
    ("mount", None),
    ("labels", None),
];

/// Usual names of variables, in lower case without other characters.
const POSES: &[&str] =
    &["pose", "poses", "robotpose", "robotposes", "trajectory", "traj", "odom", "odometry", "path", "state", "states"];
const RANGES: &[&str] = &[
    "ranges",
    "range",
    "scan",
    "scans",
    "laser",
    "lasers",
    "laserscan",
    "laserscans",
    "laserranges",
    "lidar",
    "rangescans",
    "z",
    "measurements",
];
const ANGLES: &[&str] =
    &["angles", "angle", "bearings", "bearing", "scanangles", "laserangles", "anglescan", "beamangles", "thk"];
const TIMES: &[&str] = &["t", "time", "times", "timestamp", "timestamps", "ts", "stamps"];
const HEADINGS: &[&str] = &["h", "th", "theta", "yaw", "heading", "phi"];

/// One item of `--fields`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    pub key: &'static str,
    /// A variable with its fields and a row or column: `laser.pose`, `P(:,1)`; or a number.
    pub path: String,
    /// The factor from its unit to metres, radians or seconds.
    pub scale: f64,
}

/// Parses the text of `--fields`.
pub(super) fn parse(text: &str) -> ReadResult<Vec<Field>> {
    let mut fields: Vec<Field> = Vec::new();
    let mut depth = 0i32;
    let items = text.split(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == ',' && depth <= 0
    });
    let known = KEYS.map(|(name, _)| name);
    for item in items.map(str::trim) {
        let (key, value) = item.split_once('=').ok_or_else(|| format!("{}: write key=variable", quote(item)))?;
        let key = match key.trim() {
            "theta" | "yaw" | "h" => "heading",
            key => key,
        };
        let Some((key, role)) = KEYS.iter().find(|(name, _)| *name == key) else {
            return Err(format!("{} is no key{}", quote(key), similar(key, &known)));
        };
        if fields.iter().any(|field| field.key == *key) {
            return Err(format!("{key} is given twice"));
        }
        let (path, unit) = match value.rfind(':') {
            Some(at) if !value[at..].contains(')') => (&value[..at], Some(value[at + 1..].trim())),
            _ => (value, None),
        };
        let scale = match (unit, role) {
            (None, _) => 1.0,
            (Some(unit), Some(role)) => scale(*role, unit).map_err(|what| format!("{key}: {what}"))?,
            (Some(_), None) => return Err(format!("{key} takes no unit")),
        };
        fields.push(Field { key, path: path.trim().into(), scale });
    }
    let has = |key: &str| fields.iter().any(|field| field.key == key);
    if !(has("pose") || has("x") && has("y") && has("heading")) {
        return Err("name the robot's poses: pose=…, or x=…, y=… and heading=…".into());
    }
    match (has("ranges"), has("points")) {
        (true, true) => Err("either ranges or points, not both".into()),
        (false, false) => {
            Err("name the readings: ranges=… (with angles, or first and step, or fov), or points=…".into())
        }
        (true, false) if has("fov") && (has("first") || has("step") || has("angles")) => {
            Err("fov lays the beams evenly about the axis: leave it out beside angles, first and step".into())
        }
        (true, false) if !(has("angles") || has("fov") || has("first") && has("step")) => {
            Err("ranges need the beams' bearings: angles=…, or first=… and step=…, or fov=180deg".into())
        }
        _ => Ok(fields),
    }
}

/// The variable of a path.
///
/// # Errors
/// A text that names the variable, field, row or column that is missing.
pub(super) fn resolve(variables: &[(String, Array)], path: &str) -> ReadResult<Array> {
    let (names, index) = match path.split_once('(') {
        Some((names, index)) => (names, Some(index.trim_end_matches(')'))),
        None => (path, None),
    };
    let mut parts = names.split('.').map(str::trim);
    let root = parts.next().unwrap_or_default();
    let found = variables.iter().find(|(name, _)| name == root).map(|(_, array)| array);
    let mut array = found.ok_or_else(|| format!("there is no variable {}", quote(root)))?;
    for part in parts {
        let Array::Struct(fields) = array else {
            return Err(format!("{root} is {array}, and has no field {}", quote(part)));
        };
        let inner = fields.iter().find(|(name, _)| name == part).map(|(_, array)| array);
        array = inner.ok_or_else(|| {
            let names: Vec<&str> = fields.iter().map(|(name, _)| name.as_str()).collect();
            format!("{root} has no field {}{}", quote(part), similar(part, &names))
        })?;
    }
    let Some(index) = index else { return Ok(array.clone()) };
    let Array::Numbers { rows, values } = array else {
        return Err(format!("{names} is {array}: it has no rows and columns"));
    };
    let wrong = || format!("({index}) is no row or column: write (:,1) for a column or (1,:) for a row");
    let (row, column) = index.split_once(',').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<usize>().ok().filter(|n| *n > 0).ok_or_else(wrong);
    let columns = values.len() / (*rows).max(1);
    let outside = || format!("{names} is {array}: it has no ({index})");
    match (row.trim(), column.trim()) {
        (":", column) => {
            let at = number(column)?;
            let part = values.get((at - 1) * rows..at * rows).filter(|_| at <= columns).ok_or_else(outside)?;
            Ok(Array::Numbers { rows: *rows, values: part.to_vec() })
        }
        (row, ":") => {
            let at = number(row)?;
            if at > *rows {
                return Err(outside());
            }
            Ok(Array::Numbers { rows: 1, values: values.iter().skip(at - 1).step_by(*rows).copied().collect() })
        }
        _ => Err(wrong()),
    }
}

fn letters(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase()
}

/// All paths, with their arrays.
fn paths(variables: &[(String, Array)]) -> Vec<(String, &Array)> {
    let mut all = Vec::new();
    for (name, array) in variables {
        match array {
            Array::Struct(fields) => all.extend(fields.iter().map(|(field, array)| (format!("{name}.{field}"), array))),
            array => all.push((name.clone(), array)),
        }
    }
    all
}

/// The list of variables for a message.
pub(super) fn list(variables: &[(String, Array)]) -> String {
    const SHOWN: usize = 16;
    let all = paths(variables);
    let shown: Vec<String> = all.iter().take(SHOWN).map(|(name, array)| format!("{}, {array}", quote(name))).collect();
    match all.len() {
        0 => "nothing".into(),
        n if n > SHOWN => format!("{} and {} more", shown.join("; "), n - SHOWN),
        _ => shown.join("; "),
    }
}

/// A `--fields` text guessed from the names, whether it is certain enough to be used, and a note for the user.
pub(super) fn guess(variables: &[(String, Array)]) -> (String, bool, Option<String>) {
    // Other names can't be written in a line of --fields.
    let proper = |path: &str| path.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '.'));
    let struct_with = |names: &[&str]| {
        variables.iter().filter(|(name, _)| proper(name)).find_map(|(name, array)| match array {
            Array::Struct(fields) if names.iter().all(|n| fields.iter().any(|(f, _)| f == n)) => Some((name, fields)),
            _ => None,
        })
    };
    // Freiburg's course: CARMEN's lasers as an array of structs.
    if let Some((name, fields)) = struct_with(&["pose", "ranges", "start_angle", "angular_resolution"]) {
        let more = [("maximum_range", "r_max"), ("timestamp", "t"), ("laser_offset", "mount")];
        let more = more.iter().filter(|(field, _)| fields.iter().any(|(f, _)| f == field));
        let more: String = more.map(|(field, key)| format!(",{key}={name}.{field}")).collect();
        let line = format!(
            "pose={name}.pose,ranges={name}.ranges,first={name}.start_angle,step={name}.angular_resolution{more}"
        );
        return (line, true, None);
    }
    let has = |name: &str| variables.iter().any(|(n, _)| n == name);
    if has("pose") && has("ranges") && has("scanAngles") {
        let t = if has("t") { ",t=t" } else { "" };
        let note = "its angles are read as turning clockwise, as those of Penn's robotics course do (a hit lies at x + r·cos(θ + α), y − \
                    r·sin(θ + α)); --fields pose=pose,ranges=ranges,angles=scanAngles reads them counter-clockwise";
        return (format!("pose=pose:-rad,ranges=ranges,angles=scanAngles:-rad{t}"), true, Some(note.into()));
    }
    let all: Vec<_> = paths(variables).into_iter().filter(|(path, _)| proper(path)).collect();
    let last = |path: &str| letters(path.rsplit('.').next().unwrap_or(path));
    let find = |names: &[&str]| {
        let found: Vec<&(String, &Array)> =
            all.iter().filter(|(path, _)| names.contains(&last(path).as_str())).collect();
        match found[..] {
            [one] => Some(one.0.clone()),
            _ => None,
        }
    };
    let (x, y, heading) = (find(&["x"]), find(&["y"]), find(HEADINGS));
    let pose = find(POSES);
    let readings = find(RANGES);
    let angles = find(ANGLES);
    let points = readings.as_ref().is_some_and(|path| {
        angles.is_none() && all.iter().any(|(p, array)| p == path && matches!(array, Array::Cells(_)))
    });
    let plain = (pose.is_some() || (x.is_some() && y.is_some() && heading.is_some()))
        && readings.is_some()
        && (angles.is_some() || points);
    let mut items = Vec::new();
    match (pose, x, y, heading) {
        (None, Some(x), Some(y), Some(h)) => items.push(format!("x={x},y={y},heading={h}")),
        (pose, ..) => items.push(format!("pose={}", pose.unwrap_or("POSES".into()))),
    }
    if points {
        items.push(format!("points={}", readings.unwrap_or_default()));
    } else {
        items.push(format!("ranges={}", readings.unwrap_or("RANGES".into())));
        items.push(angles.map_or("fov=180deg".into(), |angles| format!("angles={angles}")));
    }
    items.extend(find(TIMES).map(|t| format!("t={t}")));
    (items.join(","), plain, None)
}
