//! Suggests a `--columns` text for a header of unknown names.

use std::borrow::Cow;

/// Column names of `--columns`, and the names that other programs use for them, without units and numbers.
const GUESSES: &[(&str, &[&str])] = &[
    ("t", &["t", "time", "times", "timestamp", "stamp", "ts", "sec", "secs", "seconds", "elapsed", "epoch"]),
    (
        "x",
        &["x", "posx", "xpos", "positionx", "xposition", "robotx", "xrobot", "rx", "posex", "odomx", "east", "easting"],
    ),
    (
        "y",
        &[
            "y",
            "posy",
            "ypos",
            "positiony",
            "yposition",
            "roboty",
            "yrobot",
            "ry",
            "posey",
            "odomy",
            "north",
            "northing",
        ],
    ),
    (
        "heading",
        &[
            "heading",
            "theta",
            "yaw",
            "th",
            "phi",
            "psi",
            "h",
            "rot",
            "rotation",
            "orientation",
            "posetheta",
            "robottheta",
            "robotyaw",
            "robotheading",
            "odomtheta",
            "thetarobot",
            "hdg",
        ],
    ),
    (
        "range",
        &[
            "range",
            "ranges",
            "dist",
            "distance",
            "r",
            "z",
            "d",
            "depth",
            "measurement",
            "meas",
            "reading",
            "sonar",
            "ultrasonic",
            "ultrasound",
            "us",
            "echo",
            "lidar",
            "laser",
            "tof",
            "ping",
            "beam",
        ],
    ),
    (
        "angle",
        &[
            "angle",
            "bearing",
            "azimuth",
            "alpha",
            "beamangle",
            "scanangle",
            "servo",
            "servoangle",
            "sensorangle",
            "pan",
        ],
    ),
    ("sensor", &["sensor", "sensorid", "sensorname", "channel", "device"]),
    ("scan", &["scan", "scanid", "scannumber", "scanno"]),
    ("label", &["label", "class"]),
];
/// Names of times that include their unit.
const CLOCKS: &[(&str, &str)] = &[
    ("millis", "ms"),
    ("milliseconds", "ms"),
    ("micros", "us"),
    ("microseconds", "us"),
    ("nanos", "ns"),
    ("nanoseconds", "ns"),
];
const UNITS: &[(&str, &str)] = &[
    ("mm", "mm"),
    ("cm", "cm"),
    ("m", "m"),
    ("meters", "m"),
    ("metres", "m"),
    ("deg", "deg"),
    ("degs", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("rad", "rad"),
    ("radians", "rad"),
    ("s", "s"),
    ("sec", "s"),
    ("ms", "ms"),
    ("us", "us"),
    ("ns", "ns"),
];

/// The `--columns` text that fits these names best; `-` for unknown names.
pub(crate) fn columns_for(names: &[Cow<'_, str>]) -> String {
    let own = names.iter().any(|name| name.trim() == "px");
    let mut taken: Vec<&str> = Vec::new();
    let mut items: Vec<(String, usize)> = Vec::new();
    for name in names {
        let item = match guess(name, own) {
            Some((role, _)) if role != "range" && role != "angle" && taken.contains(&role) => "-".into(),
            Some((role, unit)) => {
                taken.push(role);
                unit.map_or(role.to_string(), |unit| format!("{role}:{unit}"))
            }
            None => "-".into(),
        };
        match items.last_mut() {
            Some((last, count)) if *last == item => *count += 1,
            _ => items.push((item, 1)),
        }
    }
    let text = |(item, count): &(String, usize)| if *count == 1 { item.clone() } else { format!("{item}*{count}") };
    items.iter().map(text).collect::<Vec<_>>().join(",")
}

/// The name in `--columns` of a header's name, and its unit.
fn guess(name: &str, own: bool) -> Option<(&'static str, Option<&'static str>)> {
    let lower = name.trim().trim_start_matches(['%', '#']).to_lowercase();
    let mut words: Vec<&str> = lower.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).collect();
    let unit = match words.last() {
        Some(last) if words.len() > 1 => UNITS.iter().find(|(name, _)| name == last).map(|(_, unit)| *unit),
        _ => None,
    };
    if unit.is_some() {
        words.pop();
    }
    let joined = words.concat();
    if let Some((_, unit)) = CLOCKS.iter().find(|(clock, _)| *clock == joined) {
        return Some(("t", Some(unit)));
    }
    if own && let Some(name) = ["px", "py", "ph", "x", "y", "h"].into_iter().find(|name| *name == joined) {
        return Some((name, unit));
    }
    if let Some(robot) = [("px", "x"), ("py", "y"), ("ph", "heading")].into_iter().find(|(name, _)| *name == joined) {
        return Some((robot.1, unit));
    }
    let base = joined.trim_end_matches(|c: char| c.is_ascii_digit());
    let known = |base: &str| GUESSES.iter().find(|(_, names)| names.contains(&base)).map(|(role, _)| *role);
    let role = match known(base) {
        // scan0, scan1, … are the ranges of a scan; x2 is another x.
        Some("scan") if base != joined => "range",
        Some("range") => "range",
        Some(role) if base == joined => role,
        Some(_) => return None,
        None => {
            let starts = ["range", "dist", "sonar", "ultrasonic", "laser", "lidar"];
            starts.iter().any(|start| base.starts_with(start)).then_some("range")?
        }
    };
    // A unit of another quantity is not this column's unit.
    let fits: &[&str] = match role {
        "t" => &["s", "ms", "us", "ns"],
        "heading" | "angle" => &["deg", "rad"],
        "x" | "y" | "range" => &["m", "cm", "mm"],
        _ => &[],
    };
    Some((role, unit.filter(|unit| fits.contains(unit))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_other_programs() {
        for (header, spec_) in [
            ("timestamp,x,y,theta,distance", "t,x,y,heading,range"),
            ("time_ms,pos_x,pos_y,yaw_deg,range_cm", "t:ms,x,y,heading:deg,range:cm"),
            ("Time [s],X (m),Y (m),Heading (deg),Sonar 1 (mm),Sonar 2 (mm)", "t:s,x:m,y:m,heading:deg,range:mm*2"),
            ("id,t,x,y,battery,volts,th,r0,r1,r2", "-,t,x,y,-*2,heading,range*3"),
            ("millis,px,py,ph,bearing,dist", "t:ms,px,py,ph,angle,range"),
            ("scan,sensor,x,y,heading,z", "scan,sensor,x,y,heading,range"),
            ("robot_x,robot_y,robot_theta,dist_left,dist_front", "x,y,heading,range*2"),
        ] {
            let names: Vec<Cow<'_, str>> = header.split(',').map(Cow::Borrowed).collect();
            assert_eq!(columns_for(&names), spec_, "{header}");
        }
    }
}
