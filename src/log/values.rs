//! Numbers and poses of a log: parsed, checked, and quoted in messages.

use crate::log::reading::Pose;

/// The largest coordinate of a pose, metres. Beyond it rounding errors would be as large as a cell.
const MAX_COORDINATE: f64 = 1e6;
/// The largest heading, radians. A larger one is 1600 turns, or a number of another column.
const MAX_HEADING: f64 = 1e4;

/// Checks that a pose is finite and within bounds.
///
/// # Errors
/// A text that names the value; `what` is whose pose it is.
pub(crate) fn check_pose(what: &str, pose: &Pose) -> Result<(), String> {
    for (name, value) in [("x", pose.x), ("y", pose.y), ("heading", pose.heading)] {
        if !value.is_finite() {
            return Err(format!("{what} {name} is {value}"));
        }
        if name == "heading" && value.abs() > MAX_HEADING {
            return Err(format!("{what} heading is {value} rad, more than 1e4 rad either way"));
        }
        if name != "heading" && value.abs() > MAX_COORDINATE {
            return Err(format!("{what} {name} is {value} m, farther than 1e6 m from the origin"));
        }
    }
    Ok(())
}

/// A part of a log, quoted for a message: at most 40 characters, with control characters escaped.
pub(crate) fn quote(text: &str) -> String {
    let short: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() { format!("'{short}…'") } else { format!("'{short}'") }
}

/// Parses a number of a log.
///
/// # Errors
/// A text that names the field, counted from 1.
pub(crate) fn parse_number(field: usize, text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| {
        let point = text.replace(',', ".");
        match point.parse::<f64>() {
            Ok(_) => format!("field {field} is {}: write {point} with a point", quote(text)),
            Err(_) => format!("field {field} is {}, not a number", quote(text)),
        }
    })
}

/// Parses a number, infinity or not-a-number in the spellings of ROS, YAML, C and Octave.
pub(super) fn parse_real(text: &str) -> Option<f64> {
    let text = text.trim();
    text.parse().ok().or_else(|| match text.to_ascii_lowercase().as_str() {
        ".inf" | "+.inf" | "1.#inf" | "1.#inf00" => Some(f64::INFINITY),
        "-.inf" | "-1.#inf" | "-1.#inf00" => Some(f64::NEG_INFINITY),
        ".nan" | "na" | "1.#qnan" | "-1.#ind" | "-1.#ind00" => Some(f64::NAN),
        _ => None,
    })
}
