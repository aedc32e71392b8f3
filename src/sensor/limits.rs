//! The values that a sensor's numbers may take.

/// The largest half width, radians (60°): the integer membership tests of a cone hold up to it.
pub(super) const MAX_HALF_WIDTH: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// A full circle, radians, with a margin for rounding.
pub(super) const FULL_CIRCLE: f64 = 2.0 * std::f64::consts::PI + 1e-9;
/// The largest length of a sensor, metres.
const MAX_LENGTH: f64 = 1e6;

/// Checks one value.
///
/// # Errors
/// A text that says which values the key takes.
pub(super) fn check_limit(key: &str, value: f64) -> Result<(), String> {
    let fine = match key {
        "half_width" | "beta" => (0.0..=MAX_HALF_WIDTH).contains(&value),
        "r_min" | "no_echo_range" => (0.0..=MAX_LENGTH).contains(&value),
        "r_max" | "hit_range" | "epsilon" => value > 0.0 && value <= MAX_LENGTH,
        "step" => value != 0.0 && value.is_finite(),
        "fov" => value > 0.0 && value <= FULL_CIRCLE,
        "first_beam" => value.abs() <= FULL_CIRCLE,
        _ => value.is_finite() && value.abs() <= MAX_LENGTH,
    };
    match (fine, key) {
        (true, _) => Ok(()),
        (_, "half_width" | "beta") => Err("takes 0 to 60deg (1.0472)".into()),
        (_, "r_min" | "no_echo_range") => Err("takes 0 to 1e6 m".into()),
        (_, "r_max" | "hit_range" | "epsilon") => Err("takes more than 0, up to 1e6 m".into()),
        (_, "fov") => Err("takes an angle above 0, up to 360deg (a plain number is in radians: write 180deg)".into()),
        (_, "first_beam") => Err("takes -360deg to 360deg (a plain number is in radians: write -90deg)".into()),
        (_, "step") => Err("takes an angle other than 0".into()),
        _ => Err("takes -1e6 to 1e6".into()),
    }
}
