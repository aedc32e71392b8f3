//! Numbers and poses of a log: parsed, checked, and quoted in messages.

use crate::log::reading::Pose;

/// Poses further out are taken for damage: float noise would drown a cell there.
const FARTHEST: f64 = 1e6;
/// Headings beyond this are no headings: a robot that turned 1600 times, or a number in another column.
const LARGEST_ANGLE: f64 = 1e4;

/// Refuses a pose that is not finite or absurdly far out; the text names the value.
pub(crate) fn check_pose(what: &str, pose: &Pose) -> Result<(), String> {
    for (name, value) in [("x", pose.x), ("y", pose.y), ("heading", pose.heading)] {
        if !value.is_finite() {
            return Err(format!("{what} {name} is {value}"));
        }
        if name == "heading" && value.abs() > LARGEST_ANGLE {
            return Err(format!("{what} heading is {value} rad, more than 1e4 rad either way"));
        }
        if name != "heading" && value.abs() > FARTHEST {
            return Err(format!("{what} {name} is {value} m, farther than 1e6 m from the origin"));
        }
    }
    Ok(())
}

/// A piece of a log for a message: short, and safe to print.
pub(crate) fn quote(text: &str) -> String {
    let short: String = text.chars().take(40).flat_map(char::escape_debug).collect();
    if text.chars().nth(40).is_some() { format!("'{short}…'") } else { format!("'{short}'") }
}

/// A number of a log; the text names the field.
pub(crate) fn parse_number(field: usize, text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| {
        let point = text.replace(',', ".");
        match point.parse::<f64>() {
            Ok(_) => format!("field {field} is {}: write {point} with a point", quote(text)),
            Err(_) => format!("field {field} is {}, not a number", quote(text)),
        }
    })
}

/// A number as programs write it: also with infinity and not-a-number in the spellings of ROS, YAML, C and Octave.
pub(super) fn parse_real(text: &str) -> Option<f64> {
    let text = text.trim();
    text.parse().ok().or_else(|| match text.to_ascii_lowercase().as_str() {
        ".inf" | "+.inf" | "1.#inf" | "1.#inf00" => Some(f64::INFINITY),
        "-.inf" | "-1.#inf" | "-1.#inf00" => Some(f64::NEG_INFINITY),
        ".nan" | "na" | "1.#qnan" | "-1.#ind" | "-1.#ind00" => Some(f64::NAN),
        _ => None,
    })
}
